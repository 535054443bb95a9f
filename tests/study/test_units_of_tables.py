"""Numbers of the tables of an analysis are in the units of the study: what is computed is the same in every system."""

import numpy as np
import pytest

from stickslip import study
from stickslip.study.analysis import KINDS

SYSTEMS = {"m-kg-s": (1.0, 1.0, 1.0), "mm-t-s": (1e3, 1.0, 1e-3), "kN": (1.0, 1e-3, 1.0)}
"""How many units of length, force and mass one metre, newton and kilogram are."""


def work(folder, system, analysis, table):
    """The plan of one mass of 1 kg on 1 N/m with a slider of 1 N/m and 2 N, pulled by 5 N."""
    metre, newton, kilogram = SYSTEMS[system]
    stiffness = newton / metre
    levels = "" if "force_levels" in KINDS[analysis].without else "force_levels = [0.5]\n"
    np.savez(folder / f"{system}.npz", M=[[kilogram]], K=[[stiffness]])
    units = 'units = { force = "kN" }' if system == "kN" else f'units = "{system}"' if system != "m-kg-s" else ""
    text = f"""
{units}
[study]
title = "a"
analysis = "{analysis}"
[structure]
matrices = "{system}.npz"
dofs = ["1.x"]
[damping]
modal = 0.01
[[contact]]
law = "macroslip"
between = ["1.x", "ground"]
kt = {stiffness}
mu = 0.5
normal_load = {2.0 * newton}
[[force]]
direction = "1.x"
amplitude = {newton}
static = {5.0 * newton}
[sweep]
frequency = [0.05, 0.3]
{levels}harmonics = 3
samples = 64
outputs = ["1.x"]
{table(metre, newton)}
"""
    return study.job(text, folder, "a").plan


def modes(name):
    return lambda metre, newton: f"[{name}]\nmode = 1\namplitude = [{0.01 * metre}, {2.0 * metre}]"


def ratios(name):
    return lambda metre, newton: f"[{name}]\nforce_ratio = [1.0, 10.0]\npoints = 3\npull = {7.0 * newton}"


@pytest.mark.parametrize("system", ["mm-t-s", "kN"])
@pytest.mark.parametrize("analysis", ["nonlinear_modes", "limit_cycles"])
def test_ends_of_a_nonlinear_mode(tmp_path, system, analysis):
    plans = [work(tmp_path, each, analysis, modes(analysis)) for each in ("m-kg-s", system)]
    works = [plan.works[""] for plan in plans]
    assert works[0].amplitude == (0.01, 2.0)
    assert works[1].amplitude == pytest.approx((0.01, 2.0))


@pytest.mark.parametrize("system", ["mm-t-s", "kN"])
def test_ends_of_the_mode_of_isolated_curves(tmp_path, system):
    plans = [work(tmp_path, each, "forced_response", modes("isolated")) for each in ("m-kg-s", system)]
    assert [plan.further.isolated.ends for plan in plans] == [(0.01, 2.0), pytest.approx((0.01, 2.0))]


@pytest.mark.parametrize("system", ["mm-t-s", "kN"])
def test_the_pull_of_a_performance_curve(tmp_path, system):
    pulls = [work(tmp_path, each, "performance_curve", ratios("performance_curve")).works[""].pull for each in ("m-kg-s", system)]
    assert pulls == [7.0, pytest.approx(7.0)]


@pytest.mark.parametrize("system", ["mm-t-s", "kN"])
def test_the_pull_of_a_performance_band(tmp_path, system):
    levels = [
        work(tmp_path, each, "performance_band", ratios("performance_band")).works[""].levels for each in ("m-kg-s", system)
    ]
    assert levels[1] == pytest.approx(levels[0])
    assert max(levels[0]) == pytest.approx(7.0)


IN_MILLISECONDS = """
units = {{ length = "mm", time = "ms" }}
[study]
analysis = "{analysis}"
[structure]
matrices = {{ M = [[1.0]], K = [[1e-3]] }}
dofs = ["1.x"]
[damping]
modal = 0.01
{table}
[sweep]
frequency = [0.1, 0.2]
outputs = ["1.x"]
"""


@pytest.mark.parametrize(("quantity", "unit"), [("displacement", 1e-3), ("velocity", 1.0), ("acceleration", 1e3)])
def test_motions_of_a_base_and_held_ones_have_the_same_units(tmp_path, quantity, unit):
    """2 mm, 2 mm/ms and 2 mm/ms²."""
    base = f'[base]\ndirection = "x"\n{quantity} = 2.0'
    held = f'[[force]]\ndirection = "1.x"\namplitude = 1.0\n[controlled_response]\nquantity = "{quantity}"\namplitude = [2.0]'
    (moved,) = job_of("forced_response", base, tmp_path).sweep.problem.forces
    assert abs(moved.amplitudes[1]) == pytest.approx(2.0 * unit)
    assert job_of("controlled_response", held, tmp_path).plan.works[""].amplitudes == pytest.approx([2.0 * unit])


def job_of(analysis, table, folder):
    return study.job(IN_MILLISECONDS.format(analysis=analysis, table=table), folder, "a")


def test_rotations_of_a_decay_are_in_radians_whatever_the_length(tmp_path):
    text = """
[study]
analysis = "free_decay"

[units]
length = "mm"

[structure]
dofs = ["tip.y", "tip.rz"]
matrices = { M = [[0.4, 0.0], [0.0, 1e-3]], K = [[500.0, 0.0], [0.0, 1e6]] }

[damping]
modal = 0.01

[[force]]
direction = "tip.y"
amplitude = 1.0

[sweep]
frequency = [150.0, 260.0]
outputs = ["tip.y"]

[free_decay]
duration = 0.1
displacement = { "tip.y" = 2.0, "tip.rz" = 0.01 }
velocity = { "tip.y" = 500.0, "tip.rz" = 3.0 }
"""
    decay = study.job(text, tmp_path, "study").plan.works[""]
    assert decay.displacement == {"tip.y": pytest.approx(2e-3), "tip.rz": 0.01}
    assert decay.velocity == {"tip.y": pytest.approx(0.5), "tip.rz": 3.0}
