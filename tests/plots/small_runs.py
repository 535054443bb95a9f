"""Small runs of the templates, for tests of what every kind of study shows: a new template must say here how it becomes small."""

import re

import pytest
from typer.testing import CliRunner

from stickslip.cli import app
from stickslip.study.templates import write_new

LESS = {
    "beams_with_a_gap": {"modes": "1", "frequency": "[108.0, 112.0]", "force_levels": "[0.001]", "harmonics": "1"},
    "blade_root": {"points": "2", "frequency": "[121.0, 124.0]", "force_levels": "[1.0]", "harmonics": "3", "samples": "64"},
    "bladed_disk": {"points": "2", "frequency": "[1090.0, 1098.0]", "force_levels": "[1.0]", "harmonics": "1"},
    "blisk": {
        "rig": '"lumped_blisk"',
        "contact": None,
        "pull": None,
        "mu": None,
        "frequency": "[147.0, 149.0]",
        "force_levels": "[0.4]",
    },
    "campbell": {"engine_orders": "[3]", "mode": "1", "points": "3", "harmonics": "1", "samples": "64"},
    "contact_law": {"laws": '["jenkins", "dahl"]'},
    "controlled_response": {"harmonics": "1", "samples": "64"},
    "damper_cycle": {"steps": "200"},
    "damper_design": {"search": "false", "designs": "4", "refinements": "2", "samples": "64", "known": None},
    "damper_evolution": {"steps": "200", "friction": "[0.3, 0.9]"},
    "decay_prediction": {"harmonics": "1", "draws": "20"},
    "flutter": {"amplitude": "[1e-5, 1e-3]", "harmonics": "1", "samples": "48"},
    "free_decay": {"harmonics": "1", "samples": "64"},
    "forced_response": {
        "rig": '"three_mass_wedge"',
        "preload_mass": None,
        "frequency": "[210.0, 230.0]",
        "force_levels": "[0.5, 1.0]",
    },
    "identification": {"resamples": "8"},
    "jointed_beams": {"modes": "1", "force_levels": "[0.02]", "harmonics": "1"},
    "limit_cycles": {
        "rig": '"three_mass_wedge"',
        "preload_mass": None,
        "frequency": "[150.0, 190.0]",
        "aerodynamic_damping": "[-0.01, -0.02]",
        "amplitude": "[1e-6, 3e-4]",
        "harmonics": "3",
        "samples": "64",
    },
    "lumped": {"frequency": "[215.0, 230.0]", "force_levels": "[1.0]"},
    "mistuned_population": {"count": "2", "harmonics": "1", "samples": "48"},
    "model": {"modes": "4", "force_levels": "[20.0]", "harmonics": "1"},
    "nonlinear_modes": {
        "rig": '"three_mass_wedge"',
        "preload_mass": None,
        "frequency": "[150.0, 230.0]",
        "amplitude": "[1e-6, 1e-4]",
        "force_levels": "[0.05, 0.1]",
        "harmonics": "3",
        "samples": "64",
    },
    "performance_band": {"points": "2", "cloud": "2", "starts": "0", "harmonics": "1", "samples": "64"},
    "performance_curve": {"points": "6", "harmonics": "1", "samples": "64"},
    "response_bounds": {"points": "3", "cloud": "4", "starts": "1", "harmonics": "3", "samples": "64"},
    "response_identification": {"harmonics": "1", "leave_one_out": "false"},
    "response_prediction": {"harmonics": "1", "draws": "20", "force": "[3.0, 10.0]"},
    "ring_damper": {"frequency": "[575.0, 585.0]", "force_levels": "[1.0]", "harmonics": "3"},
    "run_up": {"duration": "0.2", "steps_per_period": "100"},
    "shrouded_blades": {"frequency": "[260.0, 263.0]", "force_levels": "[20.0]", "harmonics": "3"},
    "speed_sweep": {"speed": "[6500.0, 7200.0]", "engine_orders": "[3]", "harmonics": "1", "samples": "64"},
    "response_samples": {"points": "3", "count": "3", "harmonics": "3", "samples": "64"},
    "sensitivity_indices": {"draws": "8", "harmonics": "1", "samples": "64", "kn": None, "preload": None, "slider_offset": None},
    "strip_damper": {"points": "2", "frequency": "[498.0, 502.0]", "force_levels": "[1.0]", "harmonics": "3", "samples": "64"},
    "stepped_sine": {"count": "9", "dwell": "20", "steps_per_period": "100", "harmonics": "1", "samples": "64"},
    "steady_cycles": {"steps": "200", "count": "3"},
    "two_blades": {"points": "2", "frequency": "[395.0, 410.0]", "force_levels": "[1.0]", "harmonics": "1", "samples": "64"},
}


def small_run(kind, folder):
    """Folder of the results of a template with less to compute, without its figures in files."""
    write_new(kind, folder / "study.toml")
    text = (folder / "study.toml").read_text()
    for key, value in LESS[kind].items():
        text, count = re.subn(rf"(?m)^{key} = .*$", "" if value is None else f"{key} = {value}", text)
        assert count >= 1, key
    (folder / "study.toml").write_text(text)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stickslip.show.plots.paper.write_figure", lambda figure, path, suffix: None)
        options = ["--out", str(folder / "out"), "--workers", "1"]
        result = CliRunner().invoke(app, ["run", str(folder / "study.toml"), *options])
    assert result.exit_code == 0, result.output
    return folder / "out"
