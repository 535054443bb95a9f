"""A measured joint: one set of friction parameters gives the damping of eight measured curves of the Brake-Reuss beam."""

import re
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest
from identification.brake_reuss import (
    ELEMENTS,
    FILE,
    FREE,
    beam,
    by_damping,
    constant_force,
    curves,
    deviations,
    linear_frequency,
    near_resonance,
    one_mode,
    per_force,
)
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app

CURVES = np.array(
    [
        (5.0, 80.369, 0.1522, 0.1483, 80.379, 1.027),
        (20.1, 80.190, 0.1973, 0.1939, 80.260, 1.050),
        (29.8, 80.190, 0.2385, 0.2444, 80.324, 1.018),
        (40.0, 80.129, 0.3025, 0.3029, 80.344, 0.989),
        (50.2, 80.279, 0.3818, 0.3735, 80.583, 0.970),
        (60.2, 80.379, 0.4611, 0.4533, 80.785, 0.968),
        (70.3, 80.468, 0.5555, 0.5435, 80.985, 0.967),
        (80.4, 80.529, 0.6401, 0.6436, 81.167, 0.976),
    ]
)
"""Acceleration [m/s²]; frequency [Hz] and damping ratio [%] of the measured curve, its fit by one mode; damping ratio [%] of the
computed curve by the same fit; linear frequency [Hz] and gain that the identification gives the curve."""
IDENTIFIED = {"damping": 1.434e-3, "slip_force": 47.97, "chi": 0.653}
"""By `test_the_damping_of_all_curves`."""
CHI_INTERVAL = (0.522, 0.785)
LARGEST = 0.0255
"""Largest deviation of a computed damping ratio from the measured one."""
MISFIT = 0.0231
HELD_OUT = 0.0240
"""Largest misfit of a curve, relative to its largest response, and that of a curve predicted by the others."""
BY_DAMPING = 0.0226
CHI_BY_DAMPING = 0.698
"""Largest deviation of a damping ratio, and χ, where the deviations themselves are made small."""
OF_LARGEST = (0.0304, 0.689)
NEAR = (0.0325, 0.718)
"""The same where errors are relative to the largest response of a curve, and so of the points in its half-power band alone."""
WITHOUT = (0.30, 0.414e-2)
"""Largest misfit, and damping ratio at the largest acceleration, where all curves have one linear frequency."""
SETTINGS = {"harmonics": 1, "evaluations": 60}

PAGE = Path(__file__).parents[2] / "docs" / "response_identification.md"

measured = pytest.mark.skipif(FILE is None, reason="the measured curves are not shipped")


def test_the_command_of_the_page_is_the_identification_of_these_tests(tmp_path, monkeypatch):
    """Free parameters, starts and bounds are `FREE`, and each curve has its rows of the file, gain and phase free."""
    rows = [(k, 79.0 + f, 0.1 + 0.01 * f, 5.0 * k, -0.1 * f - 0.1) for k in range(1, 9) for f in range(6)]
    lines = [",".join(f"{value:g}" for value in row) for row in rows]
    (tmp_path / "brake_reuss.csv").write_text(
        "curve,frequency_hz,force_n,acceleration_m_s2,phase_rad\n" + "\n".join(lines) + "\n"
    )
    monkeypatch.chdir(tmp_path)
    runs = []
    monkeypatch.setattr(sys.modules["stickslip.cli.studies"], "carry_out", lambda run, figures: runs.append(run))
    (command,) = re.findall(r"^stickslip (identify-response jointed_mode (?:.*\\\n)*.*)", PAGE.read_text(encoding="utf-8"), re.M)
    shown = CliRunner().invoke(app, shlex.split(command.replace("\\\n", " ")))
    assert shown.exit_code == 0, shown.output
    work = runs[0].jobs[""].plan.works[""]
    wanted = {name: free if isinstance(free, ss.FreeParameter) else ss.FreeParameter(*free) for name, free in FREE.items()}
    assert work.parameters == wanted
    assert (work.harmonics, work.start_states) == (1, "virgin")
    (joint,) = work.problem_of(**{name: free.start for name, free in wanted.items()}).contacts
    assert joint.law.count == ELEMENTS
    assert len(work.tests) == 8
    for k, test in enumerate(work.tests, start=1):
        own = np.array([row[1:] for row in rows if row[0] == k]).T
        found = np.array([test.frequency, test.force, test.amplitude, test.phase])
        assert found == pytest.approx(own)
        assert (test.held, test.free_gain, test.free_phase, test.quantity) == ("response", True, True, "acceleration")
        assert not any(unit.assumed for unit in test.units.values())


def test_phase_resonance_has_the_damping_of_the_table():
    """A test that needs no curves, and another way to ζ: half the loss factor where force and displacement are at 90°."""
    problem = ss.rigs.jointed_mode(**IDENTIFIED)
    found = ss.phase_resonance(problem, ss.hertz(70.0, 90.0), CURVES[:, 0], harmonics=1).dataset
    assert 0.5 * found["loss_factor"].values == pytest.approx(1e-2 * CURVES[:, 2], rel=0.04)
    assert found["frequency"].values[0] - found["frequency"].values[-1] == pytest.approx(0.65, abs=0.2)


def test_full_slip_and_the_power_law():
    """Far from full slip friction adds ζ ~ A^(χ+1), by the closed form of the loop energy."""
    problem = ss.rigs.jointed_mode(**IDENTIFIED)
    data = ss.phase_resonance(problem, ss.hertz(70.0, 90.0), [20.0, 40.0], quantity="acceleration", harmonics=1).dataset
    friction = 0.5 * data["loss_factor"].values - IDENTIFIED["damping"]
    assert np.log2(friction[1] / friction[0]) == pytest.approx(1.0 + IDENTIFIED["chi"], rel=0.02)


@measured
@pytest.mark.nightly
def test_the_damping_of_all_curves():
    """The same fit of one mode to measured and computed curves, at the same points, each at its measured acceleration."""
    found = ss.identify_response(beam, FREE, curves(), tries=4, leave_one_out=True, **SETTINGS)
    data = found.dataset
    for name, value in IDENTIFIED.items():
        assert found.values[name] == pytest.approx(value, rel=5e-3)
    chi = list(found.values).index("chi")
    assert [float(data[end][chi]) for end in ("low", "high")] == pytest.approx(CHI_INTERVAL, abs=2e-3)
    assert float(data["misfit"].max()) == pytest.approx(MISFIT, abs=1e-3)
    assert float(data["held_out"].max()) == pytest.approx(HELD_OUT, abs=1e-3)
    for k, (_, frequency, zeta, computed_zeta, linear, gain) in enumerate(CURVES):
        f = data["frequency"].values[k]
        own, computed = (one_mode(f, per_force(data, which)[k]) for which in ("measured", "computed"))
        assert own[1:3] == pytest.approx([frequency, 1e-2 * zeta], rel=5e-4)
        assert computed[2] == pytest.approx(1e-2 * computed_zeta, rel=5e-3)
        values = [float(data["own_value"].sel(own=name)[k]) for name in ("frequency", "gain")]
        assert values == pytest.approx([linear, gain], rel=1e-3)
    assert np.max(np.abs(deviations(found))) == pytest.approx(LARGEST, abs=1e-3)
    assert np.max(np.abs(deviations(found))) < 0.03
    parameters, ratios = by_damping(found)
    assert np.max(np.abs(ratios - 1.0)) == pytest.approx(BY_DAMPING, abs=1e-3)
    assert parameters["chi"] == pytest.approx(CHI_BY_DAMPING, abs=0.01)
    frequency, acceleration = constant_force(found, 1.0, points=3)[:, 1]
    problem = found.problem(frequency=linear_frequency(data, acceleration))
    forced = ss.forced_response(problem, [frequency], 1.0, harmonics=1).dataset
    assert (2.0 * np.pi * frequency) ** 2 * float(forced["amplitude"][0, 0, 0]) == pytest.approx(acceleration, rel=0.03)


@measured
@pytest.mark.nightly
def test_other_weights_of_the_same_curves():
    """How the points are weighed moves χ inside its interval, and the largest deviation to either side of 3 %."""
    whole = curves(of_largest=True)
    for tests, (largest, chi) in ((whole, OF_LARGEST), ([near_resonance(test) for test in whole], NEAR)):
        found = ss.identify_response(beam, FREE, tests, tries=4, **SETTINGS)
        assert np.max(np.abs(deviations(found))) == pytest.approx(largest, abs=1e-3)
        assert found.values["chi"] == pytest.approx(chi, abs=5e-3)
        assert CHI_INTERVAL[0] < found.values["chi"] < CHI_INTERVAL[1]


@measured
@pytest.mark.nightly
def test_one_linear_frequency_does_not_do():
    """Friction softens; the measured frequency falls and then rises."""
    shared = FREE | {"frequency": (80.3, 79.0, 81.5)}
    found = ss.identify_response(beam, shared, curves(), tries=0, **SETTINGS)
    data = found.dataset
    assert float(data["misfit"].max()) == pytest.approx(WITHOUT[0], abs=0.01)
    last = one_mode(data["frequency"].values[7], per_force(data, "computed")[7])
    assert last[2] == pytest.approx(WITHOUT[1], rel=0.05)
    assert any(note.startswith("slip_force is not determined") for note in found.notes)
