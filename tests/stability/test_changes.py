"""Where stability changes and how, against SciPy's variational equation: folds, branch point, period doubling, Neimark-Sacker."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve
from stability.test_tuned_disks import DAMPING, ring

import stickslip as ss

FOLD, BRANCH_POINT, PERIOD_DOUBLING, NEIMARK_SACKER = 1, 2, 3, 4


@dataclass
class Masses:
    """q̈ + c q̇ + K q + k3 q³ = static + force cos(ωt − phases)."""

    K: np.ndarray
    k3: float
    c: float
    force: np.ndarray
    phases: np.ndarray
    static: float = 0.0

    def travel(self, omega, x):
        """The state a period later and the period map."""
        n = self.phases.size

        def rate(t, y):
            q, v, dq, dv = y[:n], y[n : 2 * n], *y[2 * n :].reshape(2, n, 2 * n)
            load = self.static + self.force * np.cos(omega * t - self.phases)
            tangent = -self.c * dv - (self.K + np.diag(3.0 * self.k3 * q**2)) @ dq
            return np.concatenate([v, load - self.c * v - self.K @ q - self.k3 * q**3, dv.ravel(), tangent.ravel()])

        begin = np.concatenate([x, np.eye(2 * n).ravel()])
        end = solve_ivp(rate, (0.0, 2.0 * np.pi / omega), begin, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
        return end[: 2 * n], end[2 * n :].reshape(2 * n, 2 * n)

    def excess(self, omega, x):
        """Size of the largest multiplier of the periodic motion near x, less 1."""
        for _ in range(6):
            end, derivative = self.travel(omega, x)
            if np.abs(end - x).max() < 1e-9:
                break
            x = x + np.linalg.lstsq(np.eye(x.size) - derivative, end - x, rcond=1e-6)[0]
        return np.abs(np.linalg.eigvals(derivative)).max() - 1.0


def state(dataset, frequency, turn=0.0, sectors=1):
    """q and q̇ at t = 0 of the solved point nearest to a frequency; sector j late by the angle j · turn."""
    point = int(np.argmin(np.abs(dataset.frequency.values[0] - frequency)))
    X, omega = dataset.response.values[0, point, 0] @ [1.0, 1.0j], 2.0 * np.pi * dataset.frequency.values[0, point]
    order = np.arange(X.size)
    waves = np.exp(-1j * turn * np.outer(np.arange(sectors), order)) * X
    return np.concatenate([waves.sum(1).real, (1j * omega * order * waves).sum(1).real])


def located(masses, dataset, change=0, turn=0.0, sectors=1):
    """Frequency and kind of a change, and the frequency by SciPy."""
    found = float(dataset.stability_change_frequency.values[0, change])
    start = state(dataset, found, turn, sectors)
    exact = brentq(lambda f: masses.excess(2.0 * np.pi * f, start), 0.998 * found, 1.002 * found, xtol=1e-7)
    return found, exact, int(dataset.stability_change.values[0, change])


def duffing(force, static, damping):
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=damping * np.eye(1))
    spring = ss.Contact("spring", ss.CubicSpring(0.5), (ss.between("1.x", "ground"),))
    forces = (ss.Force("1.x", force), ss.Force("1.x", static=static)) if static else (ss.Force("1.x", force),)
    problem = ss.Problem(structure, (spring,), forces, ("1.x",), "Duffing")
    return problem, Masses(np.eye(1), 0.5, damping, np.array([force]), np.zeros(1), static)


def test_period_doubling_of_a_loaded_duffing_oscillator():
    """q̈ + 0.05 q̇ + q + q³/2 = 2 + 3 cos ωt at about twice its natural frequency."""
    problem, masses = duffing(3.0, 2.0, 0.05)
    dataset = ss.forced_response(problem, ss.Band(0.45, 0.9), harmonics=9, isolated=False).with_stability().dataset
    for change in (0, 1):
        found, exact, kind = located(masses, dataset, change)
        assert kind == PERIOD_DOUBLING
        assert found == pytest.approx(exact, rel=1e-5)


def test_folds_of_a_duffing_oscillator():
    """Where the period map has the eigenvalue 1."""
    problem, masses = duffing(1.0, 0.0, 0.1)
    dataset = ss.forced_response(problem, ss.Band(0.1, 0.5), harmonics=15, isolated=False).with_stability().dataset
    assert dataset.stability_change.values[0].tolist() == [FOLD, FOLD]
    for found in dataset.stability_change_frequency.values[0]:

        def missed(x):
            end, derivative = masses.travel(2.0 * np.pi * x[2], x[:2])
            return [*(end - x[:2]), np.linalg.det(derivative - np.eye(2))]

        exact = fsolve(missed, [*state(dataset, found), found], xtol=1e-10)[2]
        assert found == pytest.approx(exact, rel=1e-5)


def ring_of_masses(coupling, engine_order):
    """The ring of cubic springs, its response, and its masses for SciPy."""
    spring = ss.Contact("spring", ss.CubicSpring(0.3), (ss.between("b.x", "ground"),))
    problem = ring(spring, coupling, engine_order)
    turned = np.roll(np.eye(5), 1, 0) + np.roll(np.eye(5), -1, 0)
    K = (1.0 + 2.0 * coupling) * np.eye(5) - coupling * turned
    phases = 2.0 * np.pi * engine_order * np.arange(5) / 5
    dataset = ss.forced_response(problem, ss.Band(0.13, 0.24), harmonics=9, isolated=False).with_stability().dataset
    return dataset, Masses(K, 0.3, DAMPING, np.full(5, 0.15), phases)


def test_a_symmetric_disk_that_loses_its_symmetry_at_a_branch_point():
    """All five masses alike under one force: at a branch point they cease to be, by a disturbance of another nodal diameter."""
    dataset, masses = ring_of_masses(-0.05, 0)
    found, exact, kind = located(masses, dataset, 0, 0.0, 5)
    assert kind == BRANCH_POINT
    assert found == pytest.approx(exact, rel=1e-5)


def test_a_travelling_wave_that_a_pair_of_multipliers_makes_unstable():
    dataset, masses = ring_of_masses(0.1, 2)
    found, exact, kind = located(masses, dataset, 0, 2.0 * np.pi * 2 / 5, 5)
    assert kind == NEIMARK_SACKER
    assert found == pytest.approx(exact, rel=1e-5)
