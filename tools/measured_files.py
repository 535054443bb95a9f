"""The synthetic measurements of templates, in study/templates/measured: `python tools/measured_files.py` renews them.

They are what the results on the pages start from: kept as files, so that `stickslip new` has nothing to solve and writes the same
numbers on every machine.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.free_decay import free_decay
from stickslip.laboratory.measurement.reconstruction import RigErrors, synthetic_record, true_cycle
from stickslip.laboratory.measurement.records import write_record
from stickslip.model.dampers.between_platforms import in_phase, out_of_phase
from stickslip.model.rigs import blade_and_wedge
from stickslip.model.rigs.laboratory_damper import laboratory_damper
from stickslip.support.files import write_text
from verify.identification import loop_of

FOLDER = Path(__file__).parents[1] / "src" / "stickslip" / "study" / "templates" / "measured"


def loops(folder: Path) -> None:
    """Two loops of the laboratory damper, measured with the errors of a rig."""
    rig, errors = laboratory_damper(37.0), RigErrors()
    systematic = errors.draw(np.random.default_rng(0))
    for seed, (name, motion) in enumerate({"out_of_phase": out_of_phase(30e-6), "in_phase": in_phase(30e-6)}.items()):
        record = synthetic_record(true_cycle(rig, motion), errors, seed=seed, systematic=systematic, cycles=10, name=name)
        write_record(record, folder / f"record_{name}.csv")


def stepped_sines(folder: Path) -> None:
    """Stepped sines of the blade on a wedge at four forces with 1 % noise, amplitude and phase."""
    rng = np.random.default_rng(0)
    frequencies = 350.35 + np.array([-40.0, -30, -22, -15, -10, -6, -4, -2.5, -1.5, -0.7, 0, 0.7, 1.5, 2.5, 4, 6, 10, 15, 20])
    for force in (0.5, 6.0, 15.0, 10.0):
        data = forced_response(blade_and_wedge(pull=60.0), frequencies.tolist(), force, harmonics=9).dataset
        X = data["response"].values[0, :, 0, 1] @ np.array([1.0, 1j]) * (2.0 * np.pi * frequencies) ** 2
        X = X * (1.0 + 0.01 * (rng.normal(size=X.size) + 1j * rng.normal(size=X.size)))
        rows = [f"{f:.6g},{abs(x):.6g},{force:g},{np.angle(x):.6g}" for f, x in zip(frequencies, X, strict=True)]
        text = "\n".join(["frequency [Hz],acceleration [m/s2],force [N],phase [rad]", *rows]) + "\n"
        write_text(folder / f"record_{force:g}_N.csv", text)


def ring_down(folder: Path) -> None:
    """The displacement with 0.2 % noise while the motion decays after the excitation at 15 N has stopped."""
    problem, rng = blade_and_wedge(pull=60.0), np.random.default_rng(1)
    decay = free_decay(problem, 0.5, frequency=333.0, force=15.0, steps=32_000).dataset
    time, motion = decay["time"].values[::8], decay["displacement"].values[0, ::8]
    motion = motion + 2e-3 * np.abs(motion).max() * rng.normal(size=motion.size)
    rows = [f"{t:.6g},{u:.6g}" for t, u in zip(time, motion, strict=True)]
    write_text(folder / "record_ring_down.csv", "\n".join(["time [s],displacement [m]", *rows]) + "\n")


def contact_record(folder: Path) -> None:
    """Twenty cycles of one slider as a rig would record them."""
    generator, cycles, samples = np.random.default_rng(0), 20, 400
    u, force = (np.tile(signal, cycles) for signal in loop_of([1.0], 20e6, 0.4, 100.0, 10e-6, samples))
    time = np.arange(u.size) / (10.0 * samples)
    drift = np.linspace(0.0, 1e-6, u.size)
    u = 1.004 * u + drift + 0.08e-6 * generator.standard_normal(u.size)
    force = 0.995 * force + 0.7 + 0.1 * generator.standard_normal(u.size)
    rows = [f"{t:.6g},{1e6 * x:.6g},{f:.6g}" for t, x, f in zip(time, u, force, strict=True)]
    write_text(folder / "record.csv", "\n".join(["time [s],displacement [um],friction force [N]", *rows]) + "\n")


ALL = (loops, stepped_sines, ring_down, contact_record)

if __name__ == "__main__":
    for write in ALL:
        write(FOLDER)
