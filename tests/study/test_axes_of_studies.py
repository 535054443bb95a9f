"""Studies along the axes where formulas are easily wrong unseen: complex forces, harmonics above the first, outputs out of phase
with the force, and units of kN, mm, kg and ms, in which even the unit of time is another."""

import numpy as np
import pytest

from stickslip.runs.cases import CheckpointFolder
from stickslip.study import job
from stickslip.study.run import Run

STUDY = """
units = "{units}"
[study]
analysis = "{analysis}"
[structure]
matrices = {{ M = [[0.5, 0.0], [0.0, 0.3]], K = [[{k11}, {k12}], [{k12}, {k22}]] }}
dofs = ["1.x", "2.x"]
[damping]
rayleigh = [{alpha}, {beta}]
[[dashpot]]
between = ["2.x", "ground"]
c = {c}
[[contact]]
name = "slider"
law = "macroslip"
between = ["1.x", "2.x"]
kt = {kt}
mu = 0.5
normal_load = {load}
{excitation}
[sweep]
{sweep}
outputs = ["2.x", "1.x"]
harmonics = 3
samples = 512
{more}
"""
UNITS = {
    "SI": {
        "k11": 9e5, "k12": -3e5, "k22": 4e5, "alpha": 20.0, "beta": 2e-5, "c": 15.0, "kt": 2e5, "load": 40.0,
        "force": 1.0, "acceleration": 1.0, "velocity": 1.0, "length": 1.0,
    },
    "mm-kg-ms": {
        "k11": 0.9, "k12": -0.3, "k22": 0.4, "alpha": 0.02, "beta": 0.02, "c": 15e-3, "kt": 0.2, "load": 0.04,
        "force": 1e-3, "acceleration": 1e-3, "velocity": 1.0, "length": 1e3,
    },
}  # fmt: skip
M = np.diag([0.5, 0.3])
K = np.array([[9e5, -3e5], [-3e5, 4e5]]) + 2e5 * np.array([[1.0, -1.0], [-1.0, 1.0]])
C = 20.0 * M + 2e-5 * np.array([[9e5, -3e5], [-3e5, 4e5]]) + np.diag([0.0, 15.0])
FREQUENCIES = np.array([110.0, 190.0, 260.0])
FORCE = {1: 3.0 - 4.0j, 2: -2.0 + 5.0j}


def forces(units):
    """At the first mass, in both harmonics."""
    scale = UNITS[units]["force"]
    return "".join(
        f'[[force]]\ndirection = "1.x"\namplitude = [{scale * a.real}, {scale * a.imag}]\nharmonic = {h}\n'
        for h, a in FORCE.items()
    )


def computed(units, folder, excitation, analysis="forced_response", sweep="at = [110.0, 190.0, 260.0]", more=""):
    text = STUDY.format(units=units, analysis=analysis, excitation=excitation, sweep=sweep, more=more, **UNITS[units])
    run = Run({"": job(text, folder, "study")}, folder)
    return run.computed(CheckpointFolder(folder / f"kept {units} {hash(text)}", {}), lambda *_: None)[""]


def solved(units, folder, excitation, levels=(1e-3, 20.0)):
    """Stuck at the first level, slipping at the second."""
    return computed(units, folder, excitation, more=f"force_levels = {list(levels)}")


def by_hand(load, harmonics=(1, 2)):
    """Complex motions of both masses (frequency, mass) by harmonic; load gives the force at a harmonic (mass,)."""
    found = {}
    for h in harmonics:
        omega = h * 2.0 * np.pi * FREQUENCIES
        found[h] = np.array([np.linalg.solve(K - w**2 * M + 1j * w * C, load(h)) for w in omega])
    return found


@pytest.mark.parametrize("units", UNITS)
def test_complex_forces_of_two_harmonics(units, tmp_path):
    """While the slider sticks, all harmonics, root mean square and largest value of both outputs are those of linear algebra."""
    data = solved(units, tmp_path, forces(units)).isel(case=0)
    exact = by_hand(lambda h: 1e-3 * FORCE[h] * np.array([1.0, 0.0]))
    response = data["response"].values @ [1.0, 1j]
    time = np.exp(2j * np.pi * np.arange(512) / 512)
    for output, mass in enumerate((1, 0)):
        motion = np.real(sum(x[:, mass, None] * time**h for h, x in exact.items()))
        for h, x in exact.items():
            assert response[:, output, h] == pytest.approx(x[:, mass], rel=1e-9)
        assert data["amplitude"].values[:, output] == pytest.approx(np.abs(exact[1][:, mass]), rel=1e-9)
        assert data["rms"].values[:, output] == pytest.approx(np.sqrt(np.mean(motion**2, axis=1)), rel=1e-9)
        assert data["max_abs"].values[:, output] == pytest.approx(np.abs(motion).max(axis=1), rel=1e-4)


@pytest.mark.parametrize("units", UNITS)
@pytest.mark.parametrize(("given", "order"), [("acceleration", 0), ("velocity", 1), ("displacement", 2)])
def test_a_base_that_moves_with_its_second_harmonic(units, given, order, tmp_path):
    """Its acceleration is (ihω)^order times what is given."""
    value, scale = 0.3 - 0.8j, UNITS[units]["length" if given == "displacement" else given]
    base = f'[base]\ndirection = "x"\n{given} = [{scale * value.real}, {scale * value.imag}]\nharmonic = 2\n'
    data = solved(units, tmp_path, base, (1e-3 if order == 0 else 1e-8,)).isel(case=0)
    level = float(data["force_level"])
    response = data["response"].values @ [1.0, 1j]
    for k, frequency in enumerate(FREQUENCIES):
        w = 4.0 * np.pi * frequency
        acceleration = level * (1j * w) ** order * value
        exact = np.linalg.solve(K - w**2 * M + 1j * w * C, -M @ np.ones(2) * acceleration)
        assert response[k, :, 2] == pytest.approx(exact[::-1], rel=1e-9)
        assert np.abs(response[k, :, 1]).max() <= 1e-9 * np.abs(exact).max()


def test_slipping_motions_and_their_work_do_not_depend_on_the_units(tmp_path):
    """With slip under both harmonics."""
    one, other = (solved(units, tmp_path, forces(units)).isel(case=1) for units in UNITS)
    assert float(one["dissipated"].values.min()) > 0.0
    for name in ("response", "amplitude", "rms", "max_abs", "dissipated", "contact_force", "loss_factor"):
        scale = np.nanmax(np.abs(one[name].values))
        np.testing.assert_allclose(other[name].values, one[name].values, rtol=0.0, atol=1e-8 * scale, err_msg=name)


def test_a_later_force_turns_every_harmonic_by_its_own_angle(tmp_path):
    """By a quarter of a period: harmonic h of all motions and contact forces times exp(−ihπ/2), in slip."""
    scale = UNITS["SI"]["force"]
    turned = {h: a * (-1j) ** h for h, a in FORCE.items()}
    text = "".join(
        f'[[force]]\ndirection = "1.x"\namplitude = [{scale * a.real}, {scale * a.imag}]\nharmonic = {h}\n'
        for h, a in turned.items()
    )
    first, later = (solved("SI", tmp_path, each).isel(case=1) for each in (forces("SI"), text))
    turns = (-1j) ** np.arange(4)
    for name in ("response", "contact_force"):
        one, other = (data[name].values @ [1.0, 1j] for data in (first, later))
        np.testing.assert_allclose(other, one * turns, rtol=0.0, atol=1e-8 * np.nanmax(np.abs(one)))


def test_a_decay_after_an_impact_in_other_units(tmp_path):
    """mm/ms are m/s; times are in s in all units."""
    found = []
    for units, values in UNITS.items():
        more = f'[free_decay]\nduration = 0.05\nvelocity = {{ "1.x" = {0.5 * values["velocity"]} }}\nsteps = 5000\n'
        found.append(computed(units, tmp_path, forces(units), "free_decay", "frequency = [100.0, 150.0]", more))
    for name in ("time", "displacement", "frequency", "damping_ratio"):
        one, other = (data[name].values for data in found)
        np.testing.assert_allclose(other, one, rtol=1e-7, atol=1e-9 * np.nanmax(np.abs(one)), err_msg=name)
