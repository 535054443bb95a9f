"""Stress asked for in a study: results, report, figure, tables and console, on a cantilever of finite elements."""

import re

import numpy as np
import pandas as pd
import pytest
from structure.cantilever import cantilever_rig, cantilever_stress, resonant_stress
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app
from stickslip.model import rigs
from stickslip.results.files import open_results
from stickslip.study import job

PLACE = (0.01, 0.1, 0.0)
STUDY = """
[study]
analysis = "forced_response"
[structure]
rig = "cantilever"
parameters = { push = 50.0 }
[stress]
places = { "half way" = [0.01, 0.1, 0.0], "near the root" = [-0.01, 0.06, 0.0] }
[sweep]
frequency = [350.0, 480.0]
force_levels = [5.0, 50.0]
harmonics = 3
"""


@pytest.fixture(autouse=True)
def rig(monkeypatch):
    monkeypatch.setitem(rigs.RIGS, "cantilever", cantilever_rig)
    monkeypatch.setitem(rigs.STRESS, "cantilever", cantilever_stress)


@pytest.mark.slow
def test_a_run_with_stress(tmp_path):
    (tmp_path / "beam.toml").write_text(STUDY)
    result = CliRunner().invoke(
        app, ["run", str(tmp_path / "beam.toml"), "--out", str(tmp_path / "out"), "--workers", "1", "--figures"]
    )
    assert result.exit_code == 0, result.output
    data = open_results(tmp_path / "out" / "results.nc")
    top = int(np.nanargmax(data.amplitude.values[1, :, 0]))
    beam = abs(resonant_stress(float(data.amplitude[1, top, 0]), PLACE))
    found = float(data.stress_amplitude.sel(component="yy", place="half way")[1, top])
    assert found == pytest.approx(beam, rel=0.02)
    assert data.stress_von_mises.attrs["units"] == "Pa"
    largest = float(np.nanmax(data.stress_von_mises.sel(place="near the root")[1]))
    assert f"{largest / 1e6:.4g} MPa at" in result.output
    assert "near the root" in result.output
    for figure in ("stress.png", "stress.svg"):
        assert (tmp_path / "out" / "figures" / figure).stat().st_size > 5_000
    page = (tmp_path / "out" / "report.html").read_text()
    rows = re.search(r'<table id="stress-0".*?</table>', page, re.DOTALL)[0]
    assert f'data-value="{largest!r}"' in rows
    exported = CliRunner().invoke(app, ["export", str(tmp_path / "out"), "--out", str(tmp_path / "t.csv")])
    assert exported.exit_code == 0, exported.output
    table = pd.read_csv(tmp_path / "t_stress.csv")
    assert table["von Mises [Pa]"].max() == pytest.approx(largest, rel=1e-12)
    assert set(table["component"]) == {"yy"}


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            'rig = "cantilever"\nparameters = { push = 50.0 }',
            'rig = "single_mass"',
            "[stress] must go with a rig whose finite elements",
        ),
        ("[0.01, 0.1, 0.0]", "[0.01, 0.3, 0.0]", "must lie in the body, but is [0.01, 0.3, 0.0]"),
        ("[0.01, 0.1, 0.0]", "[0.01, 0.1]", "[stress]: places, half way must have 3"),
        (
            'places = { "half way" = [0.01, 0.1, 0.0], "near the root" = [-0.01, 0.06, 0.0] }',
            "places = {}",
            "[stress]: places must",
        ),
        ('analysis = "forced_response"', 'analysis = "response_bounds"', "[stress] needs analysis"),
    ],
)
def test_faults_are_named(tmp_path, old, new, said):
    assert old in STUDY
    with pytest.raises(ss.InputError) as raised:
        job(STUDY.replace(old, new, 1), tmp_path, "study")
    assert said in str(raised.value)


def test_the_recovery_takes_the_parameters_of_the_rig(tmp_path, monkeypatch):
    taken = {}

    def recovery(places, *, push):
        taken["push"] = push
        return cantilever_stress(places)

    monkeypatch.setitem(rigs.STRESS, "cantilever", recovery)
    job(STUDY, tmp_path, "study")
    assert taken == {"push": 50.0}
