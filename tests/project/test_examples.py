"""Every example runs, and one number of each is pinned. An example keeps its number in a variable that the table names."""

import runpy
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.py"))

# File: variable, expected value, relative tolerance.
PINNED: dict[str, tuple[str, float, float]] = {
    "one_mass_and_a_slider.py": ("smallest_amplitude_per_newton", 1.6017780798e-05, 1e-6),
    "single_blade_rig.py": ("peak_at_80_newton", 528.7, 3e-3),  # an independent script of this project
    "start_states_of_a_wedge.py": ("spread", 6.228618 / 3.494106, 1e-5),  # an independent script of this project
    "bounds_of_a_wedge.py": ("ratio", 6.228618 / 3.494106, 1e-5),  # an independent script of this project
    "bring_your_own_matrices.py": ("best_loss_factor", 0.1115178, 1e-5),
    "microslip_array_loop.py": (
        "energy_in_microslip",
        4 * 1.04 * (0.2 - 1.04 / 9),
        1e-12,
    ),  # one of the five elements slips, by hand
    "hysteresis_loops.py": ("largest_area", 11.39042, 1e-5),
    "read_results.py": ("peak_frequency", 162.98, 2e-4),  # SciPy from event to event
    "resume_a_long_run.py": ("equal", 1.0, 0.0),
    "contact_stiffness_of_a_damper.py": ("normal_stiffness", 6.345e8, 1e-4),  # an independent script of this project
    "bladed_disk.py": ("stuck_frequency_ratio", 1.6522, 1e-3),
    "one_sector_of_a_disk.py": ("mobility_at_4_tenths", 0.2081216, 1e-5),
    "performance_curve_of_one_mass.py": ("lowest", 5.870724, 2e-5),  # an independent script of this project
    "blade_from_calculix.py": ("best_loss_factor", 0.0796, 1e-2),
    "deformed_shape_of_a_blade.py": ("slipping", 0.3395, 1e-2),  # the first bending mode of a clamped beam at half its length
    "own_blades_own_damper.py": ("frequency_at_5_newton", 620.854, 1e-4),
    "damper_flung_by_the_rotation.py": ("pull", 1338.1, 1e-4),  # m Ω² r, m = ρ 30 (24 − 6/tan 35°) 6 mm³, r = 352 mm
    "jointed_beams.py": ("stuck_frequency", 125.11, 1e-3),  # the whole meshes, tests/study/test_worked_beams.py
    "dry_and_oiled_dampers.py": ("oiled", 0.25893, 2e-3),
    "stress_of_a_blade.py": ("largest", 0.7869, 1e-3),
    "own_bladed_disk.py": ("margin", 3.09, 1e-2),  # its frequencies and stress: tests/readers/test_wheel.py
    "fatigue_margin.py": ("margin", 354.0, 2e-2),
    "duffing_oscillator.py": ("peak", 1.7209689, 1e-6),  # closed form of one harmonic
    "identify_from_responses.py": ("kt", 0.5, 5e-3),  # the truth that was put in
    "predict_a_decay.py": ("damping", 3.8524e-3, 0.02),  # of a half cycle at 0.2 mm, in time
    "predict_an_unmeasured_response.py": ("peak", 3.3987, 3e-2),  # the peak of the truth at 0.6 N
    "acceleration_held.py": ("top", 1.0, 1e-4),  # the acceleration that was held
    "design_of_two_dampers.py": ("as_built", 6.2376e-6, 5e-3),
    "cycle_of_a_damper.py": ("energy", 1516.8, 1e-3),  # an independent script of this project
    "friction_over_the_load.py": ("largest_load", 65.2427, 1e-6),  # balance of forces with the coefficient of that load
    "mistuned_disks.py": ("amplification", 1.17286, 1e-3),
    "band_of_a_performance_curve.py": ("widest", 1.1262, 2e-3),
    "which_parameter_matters.py": ("amplitude_at_the_middle", 4.6192e-5, 2e-3),
    "slopes_of_a_response.py": ("by_friction", -0.0844712117, 1e-6),  # differences of solved responses
    "identify_contact_parameters.py": ("friction_right", 0.45, 0.05),  # the truth that was put in
    "law_of_a_contact.py": ("friction", 0.4727, 5e-3),  # an independent evaluation of the record
    "decay_after_an_impact.py": ("largest_damping", 6.24, 1e-2),
    "stepped_sine_with_dwell.py": ("peak", 3.813, 1e-3),  # 20 000 steps a period of the semi-implicit Euler method
    "measured_decay.py": ("stuck_frequency", 212.28, 1e-3),  # √(k + kt)/m, closed form
    "check_a_point_in_time.py": ("amplitude_in_time", 3.511226, 1e-5),
    "nonlinear_mode_of_a_blade.py": ("peak_at_80_newton", 5.162, 3e-2),  # the sweep of docs/single_blade.md
    "blade_over_the_speed.py": ("resonance_speed", 7608.3, 1e-4),
    "run_up_in_time.py": ("slow_over_quasi_steady", 1.0, 1e-2),  # a slow run-up is quasi-steady
    "shrouded_blades.py": ("frequency", 259.7, 2e-3),
    "blade_root.py": ("loss_factor", 0.0268, 2e-2),
    "ring_damper_of_a_seal.py": ("lowest", 0.0513, 2e-2),
    "strip_damper.py": ("amplitude", 7.5e-5, 1e-2),
    "flutter_held_by_friction.py": ("least_damping", -0.0077320294, 1e-6),  # an independent script of this project
    "stability_of_a_mass_at_a_stop.py": ("upper_fold", 1.2524, 2e-3),
    "isolated_response_of_an_absorber.py": ("times_as_high", 2.43, 1e-2),
    "branch_of_two_masses.py": ("one_sided", 17.98, 1e-2),
    "damper_in_motion.py": ("carried", 60.0, 1e-3),  # balance of the damper over a period
    "curve_on_a_grid.py": ("amplitude", 1.269918e-04, 1e-3),  # solved at this frequency
}


SLOW = {
    *("design_of_two_dampers.py", "jointed_beams.py", "run_up_in_time.py", "own_blades_own_damper.py", "strip_damper.py"),
    "damper_flung_by_the_rotation.py",
    *("flutter_held_by_friction.py", "shrouded_blades.py", "one_sector_of_a_disk.py", "law_of_a_contact.py", "mistuned_disks.py"),
    *("identify_contact_parameters.py", "check_a_point_in_time.py", "bounds_of_a_wedge.py", "dry_and_oiled_dampers.py"),
    *("isolated_response_of_an_absorber.py", "nonlinear_mode_of_a_blade.py", "acceleration_held.py", "blade_root.py"),
    *(
        "own_bladed_disk.py",
        "predict_an_unmeasured_response.py",
        "predict_a_decay.py",
        "fatigue_margin.py",
        "identify_from_responses.py",
    ),
    *("band_of_a_performance_curve.py", "stress_of_a_blade.py", "single_blade_rig.py", "performance_curve_of_one_mass.py"),
    *("stepped_sine_with_dwell.py", "branch_of_two_masses.py", "decay_after_an_impact.py"),
}
"""More than 1.5 s of processor time."""


@pytest.mark.parametrize(
    "path",
    [pytest.param(path, marks=[pytest.mark.slow] if path.name in SLOW else [], id=path.stem) for path in EXAMPLES],
)
def test_example(path, monkeypatch, tmp_path):
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.chdir(tmp_path)
    variable, expected, tolerance = PINNED[path.name]
    assert float(runpy.run_path(str(path), run_name="__main__")[variable]) == pytest.approx(expected, rel=tolerance)


def test_no_pinned_number_is_left_over():
    assert set(PINNED) == {path.name for path in EXAMPLES}


def test_the_documentation_shows_every_example():
    shown = (Path(__file__).parents[2] / "docs" / "examples.md").read_text()
    assert [path.name for path in EXAMPLES if f"../examples/{path.name}" not in shown] == []


def test_the_page_of_examples_shows_what_each_prints_and_draws():
    """`make gallery` renews both; pictures are there for all that make a figure."""
    docs = EXAMPLES[0].parents[1] / "docs"
    page = (docs / "examples.md").read_text()
    for path in EXAMPLES:
        assert f"../examples/{path.name}" in page
        assert (docs / "gallery" / f"{path.stem}.txt").read_text().strip(), f"make gallery: {path.stem}"
        assert f"gallery/{path.stem}.txt" in page
        picture = docs / "gallery" / f"{path.stem}.png"
        assert picture.exists() == (f"gallery/{path.stem}.png" in page)
        assert picture.exists() or "plot(" not in path.read_text(), f"make gallery: {path.stem}"
