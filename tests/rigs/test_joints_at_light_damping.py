"""Joints on lightly damped structures, stuck and in full slip, against linear solutions with NumPy alone."""

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import minimize_scalar

import stickslip as ss
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.rigs import blade_root, ring_damper, shrouded_blades, strip_damper

RIGS = {
    "ring": (lambda z: ring_damper(damping=z), ss.hertz(545.0, 590.0), 1e-4),
    "ring with its pressure": (lambda z: ring_damper(damping=z, kn=5e10), ss.hertz(545.0, 590.0), 1e-4),
    "strip": (lambda z: strip_damper(damping=z, points=4), ss.hertz(484.0, 503.0), 1e-4),
    "shrouds": (lambda z: shrouded_blades(damping=z), ss.hertz(250.0, 266.0), 1e-2),
    "root": (lambda z: blade_root(damping=z), ss.hertz(110.0, 126.0), 1e-5),
}


class Linear:
    """Matrices of one sector in its travelling wave, or of all, with the contacts stuck or free along their planes."""

    def __init__(self, problem: ss.Problem, damping: float, stuck: bool):
        structure = problem.structure
        disk = isinstance(problem, TunedDisk)
        n = problem.engine_order if disk else 0
        self.M, self.K, C = structure.at(n) if disk else (structure.M, structure.K, problem.C)
        phase = np.exp(-2j * np.pi * n / problem.sectors) if disk else 1.0
        self.row = lambda direction: structure.phased_row(direction, phase) if disk else structure.rows([direction])[0]
        if C is None:  # shrouds: the ratio of every mode of a blade alone
            squares, shapes = eigh(self.K, self.M)
            C = (self.M @ shapes * (2.0 * damping * np.sqrt(squares))) @ (self.M @ shapes).conj().T
        self.C = C
        for contact in problem.contacts:
            for direction in contact.tangential if stuck else ():
                self.K = self.K + contact.law.kt * np.outer(self.row(direction).conj(), self.row(direction))
            if contact.normal is not None:
                self.K = self.K + contact.law.kn * np.outer(self.row(contact.normal).conj(), self.row(contact.normal))
        self.load = sum(self.row(force.coefficients).conj() * force.amplitudes.get(1, 0.0) for force in problem.forces)
        self.output = self.row(ss.Output.of(problem.outputs[0]).direction)

    def motion(self, frequency: float):
        omega = 2.0 * np.pi * frequency
        return np.linalg.solve(self.K - omega**2 * self.M + 1j * omega * self.C, self.load)

    def peak(self, near: float) -> tuple[float, float]:
        """Frequency and height of the peak at the natural frequency nearest to one."""
        natural = np.sqrt(np.abs(eigh(self.K, self.M, eigvals_only=True))) / (2.0 * np.pi)
        at = natural[np.argmin(np.abs(natural - near))]
        found = minimize_scalar(
            lambda frequency: -abs(self.output @ self.motion(frequency)),
            bounds=(at * (1 - 1e-4), at * (1 + 1e-4)),
            method="bounded",
            options={"xatol": 1e-10 * at},
        )
        return float(found.x), -float(found.fun)


@pytest.mark.parametrize("damping", [1e-4, 1e-5])
@pytest.mark.parametrize("name", RIGS)
def test_stuck_joints_have_the_peak_of_the_stuck_structure(name: str, damping: float):
    make, band, force = RIGS[name]
    rig = make(damping)
    response = ss.forced_response(rig, band, force=force, harmonics=3, samples=128)
    peak = response.peaks().iloc[0]
    frequency, height = Linear(rig, damping, stuck=True).peak(peak.frequency)
    assert float(response.dataset.share_slip.max()) == 0.0
    assert peak.frequency == pytest.approx(frequency, rel=1e-3 * damping)
    assert peak.amplitude == pytest.approx(force * height, rel=1e-5)


def lost(name: str, rig: TunedDisk, free: Linear, frequency: float) -> float:
    """The force that friction takes from the excitation: W/(π |f·x|) for W = 4 L s a cycle, s and x of the free resonance.

    The light strip is carried midway between its platforms, so that each slips by half of their relative motion.
    """
    x = free.motion(frequency)
    contact = rig.contacts[0]
    if name == "ring":
        limit, slip = contact.law.mu * contact.law.normal_load, abs(free.row(contact.tangential[0]) @ x)
    else:
        limit, slip = 0.5 * 0.3 * 600.0, abs(free.row({"next/platform.t": 1.0, "platform.t": -1.0}) @ x)
    return float(4.0 * limit * slip / (np.pi * abs(free.load.conj() @ x)))


@pytest.mark.parametrize(
    ("name", "near", "force", "damping"),
    [
        *(("ring", 552.65, force, damping) for force in (300.0, 3000.0) for damping in (1e-3, 1e-4, 1e-5)),
        *(("strip", 489.24, 30.0, damping) for damping in (1e-3, 1e-4)),
    ],
)
def test_slipping_joints_lower_the_free_peak_by_their_friction(name: str, near: float, force: float, damping: float):
    make, band, _ = RIGS[name]
    rig = make(damping)
    free = Linear(rig, damping, stuck=False)
    frequency, height = free.peak(near)
    peak = ss.forced_response(rig, band, force=force, harmonics=3, samples=128).peaks().iloc[0]
    assert peak.frequency == pytest.approx(frequency, rel=1e-4)
    assert peak.amplitude / force / height == pytest.approx(1.0 - lost(name, rig, free, frequency) / force, rel=2e-3)


@pytest.mark.slow
def test_friction_that_caps_the_peak_may_put_it_above_the_stuck_frequency():
    """Shrouds at light slip: friction cuts off the stuck resonance between its flanks, on a plateau that rises to the right. The
    contact is softer than stuck there too, and the peak lies below the stuck response."""
    rig = shrouded_blades(damping=1e-4)
    stuck = Linear(rig, 1e-4, stuck=True)
    frequency, _ = stuck.peak(261.0)
    response = ss.forced_response(rig, ss.hertz(260.2, 262.0), force=20.0, harmonics=9, samples=256)
    peak = response.peaks().iloc[0]
    assert 1.001 * frequency < peak.frequency < 1.003 * frequency
    assert peak.amplitude < 20.0 * abs(stuck.output @ stuck.motion(peak.frequency))
    cycle = response.cycle(0, response.peak_point())
    u, T = (np.fft.rfft(rows, axis=1)[0, 1] for rows in (cycle.displacement, cycle.force))
    assert 0.9 < (T / u).real / 1.6e7 < 1.0
    assert (T / u).imag > 0.0
