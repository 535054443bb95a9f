"""Files that accompany some templates; each function returns the inserted values and the files."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.free_decay import free_decay
from stickslip.laboratory.measurement.reconstruction import RigErrors, loop_of, synthetic_record, true_cycle
from stickslip.laboratory.measurement.records import write_record
from stickslip.model.dampers.between_platforms import in_phase, out_of_phase
from stickslip.model.rigs import blade_and_wedge, three_mass_wedge
from stickslip.model.rigs.laboratory_damper import laboratory_damper
from stickslip.support.files import write_arrays, write_text


def wedge_matrices(study: Path) -> tuple[dict[str, str], list[Path]]:
    """M, K and C of the three-mass wedge."""
    structure, file = three_mass_wedge().structure, study.with_suffix(".npz")
    write_arrays(file, {"M": structure.M, "K": structure.K, "C": np.asarray(structure.C)})
    return {"matrices": file.name}, [file]


def synthetic_loops(study: Path) -> tuple[dict[str, str], list[Path]]:
    """Two loops of the laboratory damper, measured with the errors of a rig."""
    rig, errors = laboratory_damper(37.0), RigErrors()
    systematic, loops = errors.draw(np.random.default_rng(0)), []
    for seed, (name, motion) in enumerate({"out_of_phase": out_of_phase(30e-6), "in_phase": in_phase(30e-6)}.items()):
        record = synthetic_record(true_cycle(rig, motion), errors, seed=seed, systematic=systematic, cycles=10, name=name)
        loops.append(write_record(record, study.with_name(f"{study.stem}_{name}.csv")))
    return {"loops": json.dumps([loop.name for loop in loops], ensure_ascii=False)}, loops


def synthetic_responses(study: Path) -> tuple[dict[str, str], list[Path]]:
    """Three stepped sines of the blade on a wedge with 1 % noise, amplitude and phase."""
    files = _stepped_sines(study, (0.5, 6.0, 15.0))
    return {"files": json.dumps([file.name for file in files], ensure_ascii=False)}, files


def synthetic_responses_to_predict(study: Path) -> tuple[dict[str, str], list[Path]]:
    """The same, and one at another force, which they predict."""
    *files, other = _stepped_sines(study, (0.5, 6.0, 15.0, 10.0))
    words = {"files": json.dumps([file.name for file in files], ensure_ascii=False)}
    return words | {"compared": json.dumps([other.name], ensure_ascii=False)}, [*files, other]


def synthetic_responses_and_a_decay(study: Path) -> tuple[dict[str, str], list[Path]]:
    """The same three, and the displacement with 0.2 % noise while the motion decays after the excitation at 15 N has stopped."""
    files = _stepped_sines(study, (0.5, 6.0, 15.0))
    problem, rng = blade_and_wedge(pull=60.0), np.random.default_rng(1)
    decay = free_decay(problem, 0.5, frequency=333.0, force=15.0, steps=32_000).dataset
    time, motion = decay["time"].values[::8], decay["displacement"].values[0, ::8]
    motion = motion + 2e-3 * np.abs(motion).max() * rng.normal(size=motion.size)
    rows = [f"{t:.6g},{u:.6g}" for t, u in zip(time, motion, strict=True)]
    ring_down = study.with_name(f"{study.stem}_ring_down.csv")
    write_text(ring_down, "\n".join(["time [s],displacement [m]", *rows]) + "\n")
    words = {"files": json.dumps([file.name for file in files], ensure_ascii=False)}
    return words | {"compared": json.dumps([ring_down.name], ensure_ascii=False)}, [*files, ring_down]


def _stepped_sines(study: Path, forces: Sequence[float]) -> list[Path]:
    """A file of a stepped sine of the blade on a wedge for each force, with 1 % noise."""
    rng, files = np.random.default_rng(0), []
    frequencies = 350.35 + np.array([-40.0, -30, -22, -15, -10, -6, -4, -2.5, -1.5, -0.7, 0, 0.7, 1.5, 2.5, 4, 6, 10, 15, 20])
    for force in forces:
        data = forced_response(blade_and_wedge(pull=60.0), frequencies.tolist(), force, harmonics=9).dataset
        X = data["response"].values[0, :, 0, 1] @ np.array([1.0, 1j]) * (2.0 * np.pi * frequencies) ** 2
        X = X * (1.0 + 0.01 * (rng.normal(size=X.size) + 1j * rng.normal(size=X.size)))
        rows = [f"{f:.6g},{abs(x):.6g},{force:g},{np.angle(x):.6g}" for f, x in zip(frequencies, X, strict=True)]
        text = "\n".join(["frequency [Hz],acceleration [m/s2],force [N],phase [rad]", *rows]) + "\n"
        files.append(write_text(study.with_name(f"{study.stem}_{force:g}_N.csv"), text))
    return files


def synthetic_contact_record(study: Path) -> tuple[dict[str, str], list[Path]]:
    """Twenty cycles of one slider as a rig would record them."""
    generator, cycles, samples = np.random.default_rng(0), 20, 400
    u, force = (np.tile(signal, cycles) for signal in loop_of([1.0], 20e6, 0.4, 100.0, 10e-6, samples))
    time = np.arange(u.size) / (10.0 * samples)
    drift = np.linspace(0.0, 1e-6, u.size)
    u = 1.004 * u + drift + 0.08e-6 * generator.standard_normal(u.size)
    force = 0.995 * force + 0.7 + 0.1 * generator.standard_normal(u.size)
    rows = [f"{t:.6g},{1e6 * x:.6g},{f:.6g}" for t, x, f in zip(time, u, force, strict=True)]
    file = write_text(
        study.with_name(f"{study.stem}.csv"), "\n".join(["time [s],displacement [um],friction force [N]", *rows]) + "\n"
    )
    return {"files": json.dumps([file.name], ensure_ascii=False)}, [file]
