"""Fatigue margins of a cantilever that rubs: against its stress over time, beam theory, and in a study."""

import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from each import each
from structure.cantilever import cantilever_rig, cantilever_stress, resonant_stress
from typer.testing import CliRunner

import stickslip as ss
from stickslip.analyses.stress import EQUIVALENTS, margins, smallest_margin, with_fatigue
from stickslip.cli import app
from stickslip.model import rigs
from stickslip.model.structure.stress import COMPONENTS, TENSOR, critical_plane, normal_rows, principal_size, von_mises
from stickslip.show import report
from stickslip.show.plots.response_curves import haigh_diagram
from stickslip.show.report.stress import fatigue_headline, fatigue_table
from stickslip.support.checks import InputError

PLACES = {"half way": (0.01, 0.1, 0.0), "root/1": (-0.01, 0.06, 0.0), "root/2": (0.01, 0.06, 0.0)}
LIMIT = ss.FatigueLimit(fatigue_strength=400e6, ultimate_strength=1000e6)


@pytest.fixture(scope="module")
def stressed():
    response = ss.forced_response(cantilever_rig(push=50.0), [410.0, 417.0, 425.0], [5.0, 50.0], harmonics=3)
    return response.with_stress(cantilever_stress(PLACES))


def test_margins_are_those_of_the_stress_over_time(stressed):
    dataset = stressed.with_fatigue(LIMIT, {"root": 250e6}).dataset
    for margin in margins(dataset):
        recovery = cantilever_stress(PLACES)
        parts = stressed.stress(margin.case, margin.point, recovery)["stress"].sel(place=margin.place).values
        harmonics = parts[..., 0] + 1j * parts[..., 1]
        phase = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 4096, endpoint=False)[:, None] * np.arange(harmonics.shape[1]))
        over_time = (phase[:, None, :] * harmonics).real.sum(axis=-1)
        mean = float(over_time.mean(axis=0)[:3].sum()) + (250e6 if margin.place.startswith("root") else 0.0)
        alternating = float(von_mises(over_time - over_time.mean(axis=0)).max())
        assert margin.alternating == pytest.approx(alternating, rel=2e-3)
        assert margin.mean == pytest.approx(mean, rel=1e-9)
        assert margin.size == pytest.approx(400e6 * (1.0 - max(mean, 0.0) / 1000e6) / alternating, rel=2e-3)


def test_bending_has_the_margin_of_beam_theory(stressed):
    dataset = stressed.with_fatigue(LIMIT).dataset
    margin = next(found for found in margins(dataset) if found.case == 1 and found.place == "half way")
    beam = abs(resonant_stress(float(dataset["amplitude"][1, margin.point, 0]), PLACES["half way"]))
    assert margin.size == pytest.approx(400e6 * (1.0 - max(margin.mean, 0.0) / 1000e6) / beam, rel=0.02)
    assert dataset["component"].values.tolist() == list(COMPONENTS)


def test_the_margin_without_contacts_is_that_of_the_same_body_solved_without_them():
    """A contact that moves the resonance from 415 Hz: the free body, solved at its own resonance, per force level."""
    rig = cantilever_rig(push=50.0)
    recovery = cantilever_stress(PLACES)
    response = ss.forced_response(rig, ss.hertz(380.0, 450.0), [5.0, 50.0], harmonics=1).with_stress(recovery)
    (own,) = {float(f) for f in response.dataset["frequency_without_contacts"].values}
    assert own == pytest.approx(float(replace(rig, contacts=()).frequencies(stuck=False)[0]), rel=1e-9)
    bare = replace(rig, contacts=(), structure=replace(rig.structure, C=rig.C, damping=None))
    free = ss.forced_response(bare, [own], [5.0, 50.0], harmonics=1).with_stress(recovery)
    stress = free.dataset["stress_alternating"].values[:, 0]
    np.testing.assert_allclose(np.outer([5.0, 50.0], response.dataset["stress_without_contacts"]), stress, rtol=1e-4)
    on_plane = margins(response.with_fatigue(LIMIT, equivalent="principal").dataset)
    principal = free.dataset["stress_principal"].values[:, 0].ravel()
    assert [margin.without_contacts for margin in on_plane] == pytest.approx(principal, rel=1e-4)
    found = list(margins(response.with_fatigue(LIMIT).dataset))
    assert [margin.size_without_contacts * margin.without_contacts for margin in found] == pytest.approx(
        [m.allowed for m in found]
    )
    assert all(margin.size > margin.size_without_contacts for margin in found if margin.case == 0)


def harmonic_stress(vibration, mean):
    """A result with the stress vibration · cos ωt + mean at one place, tensors of six components in Pa."""
    instants = np.cos(2.0 * np.pi * np.arange(64) / 64)[:, None] * np.asarray(vibration, dtype=float)
    amplitude, middle = critical_plane(instants, np.asarray(mean, dtype=float))
    dims = ("case", "point", "place")
    values = {
        "stress_von_mises": von_mises(instants + mean).max(),
        "stress_alternating": von_mises(instants).max(),
        "stress_principal": amplitude,
        "stress_principal_mean": middle,
    }
    data = xr.Dataset({name: (dims, np.full((1, 1, 1), size)) for name, size in values.items()})
    means = np.asarray(mean, dtype=float).reshape(1, 1, 1, 6)
    data = data.assign(stress_mean=((*dims, "component"), means), frequency=(("case", "point"), [[100.0]]))
    return data.assign_coords(place=["root"], component=list(COMPONENTS), force_level=("case", [1.0]))


@each(
    ("vibration", "mean", "equivalent", "amplitude", "middle"),
    [
        # tension, then tension under pressure: the sign of the mean is kept
        *(([80e6, 0, 0, 0, 0, 0], [200e6, 0, 0, 0, 0, 0], kind, 80e6, 200e6) for kind in EQUIVALENTS),
        *(([80e6, 0, 0, 0, 0, 0], [-200e6, 0, 0, 0, 0, 0], kind, 80e6, -200e6) for kind in EQUIVALENTS),
        # torsion under tension: principal axes of the vibration at 45 degrees
        ([0, 0, 0, 50e6, 0, 0], [200e6, 0, 0, 0, 0, 0], "sines", np.sqrt(3.0) * 50e6, 200e6),
        ([0, 0, 0, 50e6, 0, 0], [200e6, 0, 0, 0, 0, 0], "von_mises", np.sqrt(3.0) * 50e6, 200e6),
        ([0, 0, 0, 50e6, 0, 0], [200e6, 0, 0, 0, 0, 0], "principal", 50e6, 100e6),
        # torsion under torsion: the plane in tension counts
        ([0, 0, 0, 50e6, 0, 0], [0, 0, 0, 90e6, 0, 0], "sines", np.sqrt(3.0) * 50e6, 0.0),
        ([0, 0, 0, 50e6, 0, 0], [0, 0, 0, 90e6, 0, 0], "von_mises", np.sqrt(3.0) * 50e6, np.sqrt(3.0) * 90e6),
        ([0, 0, 0, 50e6, 0, 0], [0, 0, 0, 90e6, 0, 0], "principal", 50e6, 90e6),
        # tension in two directions, 120 and 60 MPa, under 30 and 70 MPa
        ([120e6, 60e6, 0, 0, 0, 0], [30e6, 70e6, 0, 0, 0, 0], "sines", np.sqrt(10800.0) * 1e6, 100e6),
        ([120e6, 60e6, 0, 0, 0, 0], [30e6, 70e6, 0, 0, 0, 0], "von_mises", np.sqrt(10800.0) * 1e6, np.sqrt(3700.0) * 1e6),
        ([120e6, 60e6, 0, 0, 0, 0], [30e6, 70e6, 0, 0, 0, 0], "principal", 120e6, 30e6),
    ],
)
def test_equivalent_stresses_are_those_by_hand(vibration, mean, equivalent, amplitude, middle):
    (found,) = margins(with_fatigue(harmonic_stress(vibration, mean), LIMIT, {"root": 10e6}, equivalent))
    assert found.alternating == pytest.approx(amplitude, rel=1e-9)
    assert found.mean == pytest.approx(middle + 10e6, rel=1e-9)
    assert found.size == pytest.approx(400e6 * (1.0 - max(middle + 10e6, 0.0) / 1000e6) / amplitude, rel=1e-9)


def test_the_critical_plane_is_the_largest_of_all_planes():
    """Against 20 000 planes, where components are out of phase and have two harmonics, so that no instant gives the plane."""
    random, turns = np.random.default_rng(7), 2.0 * np.pi * np.arange(64) / 64
    across = random.standard_normal((20_000, 3))
    planes = normal_rows(across / np.linalg.norm(across, axis=1)[:, None])
    for _ in range(5):
        waves = [wave(h * turns)[:, None] * random.standard_normal(6) for h in (1, 2) for wave in (np.cos, np.sin)]
        vibration, mean = 1e7 * sum(waves), 1e7 * random.standard_normal(6)
        amplitude, middle = critical_plane(vibration, mean)
        over_time = vibration @ planes.T
        best = int(np.argmax(np.ptp(over_time, axis=0)))
        assert 0.5 * np.ptp(over_time[:, best]) <= amplitude * (1.0 + 1e-12)
        assert 0.5 * np.ptp(over_time[:, best]) == pytest.approx(amplitude, rel=2e-3)
        by_planes = 0.5 * (over_time[:, best].max() + over_time[:, best].min()) + planes[best] @ mean
        assert by_planes == pytest.approx(middle, abs=0.05 * np.abs(mean).max())


def test_of_equal_planes_that_of_the_largest_mean_counts():
    vibration = 5e6 * np.cos(2.0 * np.pi * np.arange(64) / 64)[:, None] * np.array([1.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    shear = np.array([0.0, 0.0, 0.0, 3e6, 0.0, 0.0])
    assert critical_plane(vibration, shear) == pytest.approx((5e6, 3e6))
    assert critical_plane(0.0 * vibration, shear) == pytest.approx((0.0, 3e6))


def test_largest_principal_stresses_are_eigenvalues():
    stress = np.random.default_rng(0).standard_normal((200, 6)) * 10.0 ** np.random.default_rng(1).uniform(-3, 8, (200, 1))
    stress[0] = 0.0
    stress[1] = [-5.0, -5.0, -5.0, 0.0, 0.0, 0.0]
    tensors = stress[:, TENSOR].reshape(-1, 3, 3)
    np.testing.assert_allclose(principal_size(stress), np.abs(np.linalg.eigvalsh(tensors)).max(axis=1), rtol=1e-9)


def test_the_principal_stress_of_bending_is_its_normal_stress(stressed):
    """Half way up a cantilever both amplitudes are |σ_yy|, its mean too."""
    data = stressed.dataset.sel(place="half way").isel(case=1)
    bending, mean = (data[name].sel(component="yy").values for name in ("stress_amplitude", "stress_mean"))
    np.testing.assert_allclose(data["stress_principal"], bending, rtol=0.02)
    np.testing.assert_allclose(data["stress_principal_mean"], mean, atol=0.02 * np.abs(bending).max())


def test_the_report_says_which_stress_is_compared(stressed, tmp_path):
    page = report.write(stressed.with_fatigue(LIMIT, equivalent="principal").dataset, tmp_path / "report.html").read_text()
    assert "on the plane where its amplitude is largest" in page


def test_the_smallest_margin_opens_the_report(stressed, tmp_path):
    response = stressed.with_fatigue(ss.FatigueLimit(fatigue_strength=1e3, ultimate_strength=1000e6))
    worst = smallest_margin(response.dataset)
    assert worst.size == min(margin.size for margin in margins(response.dataset)) < 1.0
    headline = fatigue_headline(response.dataset)
    assert headline.startswith("Smallest fatigue margin")
    assert worst.place in headline
    assert "The material does not withstand it." in headline
    assert headline.replace("\xa0", " ") in str(response).replace("\xa0", " ")
    page = report.write(response.dataset, tmp_path / "report.html").read_text()
    assert page.index(headline[:23]) < page.index('<table id="answer-')
    assert '<table id="fatigue-0"' in page
    table = fatigue_table(response.dataset)
    assert table["margin"].min() == worst.size
    assert table["allowed amplitude [m]"].to_numpy() == pytest.approx(
        table["margin"].to_numpy() * [float(response.dataset["amplitude"][m.case, m.point, 0]) for m in margins(response.dataset)]
    )


def test_the_diagram_has_the_limit_and_each_place(stressed):
    chart = haigh_diagram(stressed.with_fatigue(LIMIT).dataset)
    limit, *levels = chart.panels[0].layers
    assert np.interp(250.0, limit.x, limit.y) == pytest.approx(300.0, rel=1e-6)
    assert [len(level.x) for level in levels] == [3, 3]


def test_what_has_no_stress_has_no_margin(stressed):
    with pytest.raises(InputError, match="needs stress along the curves"):
        ss.forced_response(ss.rigs.single_mass(), [0.2], 1.0).with_fatigue(LIMIT)
    with pytest.raises(InputError, match="must name places of stress"):
        stressed.with_fatigue(LIMIT, {"rot": 1.0})


STUDY = """
[study]
analysis = "forced_response"
[structure]
rig = "cantilever"
parameters = { push = 50.0 }
[stress]
places = { "half way" = [0.01, 0.1, 0.0] }
[fatigue]
FATIGUE
[sweep]
at = [417.0]
force_levels = [5.0]
harmonics = 3
"""


@pytest.fixture
def rig(monkeypatch):
    monkeypatch.setitem(rigs.RIGS, "cantilever", cantilever_rig)
    monkeypatch.setitem(rigs.STRESS, "cantilever", cantilever_stress)


def test_a_study_says_the_margin(rig, tmp_path):
    table = 'fatigue_strength = 400e6\nultimate_strength = 1000e6\nmean = { "half way" = 500e6 }'
    (tmp_path / "beam.toml").write_text(STUDY.replace("FATIGUE", table))
    result = CliRunner().invoke(app, ["run", str(tmp_path / "beam.toml"), "--out", str(tmp_path / "out"), "--workers", "1"])
    assert result.exit_code == 0, result.output
    assert "Smallest fatigue margin" in result.output
    (mean,) = re.findall(r"at a mean of (\d+)\sMPa", result.output)
    assert float(mean) == pytest.approx(500.0, rel=0.1)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("fatigue_strength = 400e6", 'ultimate_strength must go with criterion = "goodman"'),
        ("ultimate_strength = 400e6", "fatigue_strength"),
        ('fatigue_strength = 4e8\nultimate_strength = 9e8\nmean = { "half" = 1.0 }', "must name places of stress"),
        ("fatigue_strength = 4e8\nultimate_strength = 9e8\ncriterion = 'smith'", "criterion"),
    ],
)
def test_faults_of_the_table_are_named(rig, tmp_path, table, words):
    (tmp_path / "beam.toml").write_text(STUDY.replace("FATIGUE", table))
    result = CliRunner().invoke(app, ["check", str(tmp_path / "beam.toml")])
    assert result.exit_code == 2, result.output
    assert words in result.output
    assert "fatigue" in result.output


def test_the_table_needs_places_of_stress(tmp_path):
    text = STUDY.replace('[stress]\nplaces = { "half way" = [0.01, 0.1, 0.0] }', "").replace("cantilever", "single_mass")
    text = text.replace("parameters = { push = 50.0 }", "").replace("at = [417.0]", "at = [0.2]")
    (tmp_path / "mass.toml").write_text(text.replace("FATIGUE", "fatigue_strength = 4e8\nultimate_strength = 9e8"))
    result = CliRunner().invoke(app, ["check", str(tmp_path / "mass.toml")])
    assert result.exit_code == 2
    assert "[fatigue] must go with places of stress" in result.output
