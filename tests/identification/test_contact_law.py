"""Contact law from records: kt, mu and the law are those that were put in, intervals cover them, and a measured record."""

import gzip
import re
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from stickslip.laboratory.identification.contact_law.fit import array_weights, fitted, half_ellipse, judged
from stickslip.laboratory.measurement.contact_cycles import contact_cycles
from stickslip.show.plots.identification import over_cycles
from stickslip.show.report.identification import law_tables as tables
from stickslip.support.checks import InputError
from verify.identification import loop_of

KT, MU, N = 20e6, 0.4, 100.0
WEIGHTS = {"jenkins": np.ones(1), "iwan": half_ellipse(400), "array": array_weights(np.array([0.8]))}
TRIBOMETER = Path(__file__).parents[1] / "data" / "tribometer" / "test_data_2.txt.gz"


def record(law="jenkins", seed=0, amplitude=8e-6, cycles=10, kt=KT, mu=MU, noise=(0.08e-6, 0.2), gain=0.01, zero=0.8):
    """Cycles at 10 Hz, 400 samples each, with drift, gain errors, the zero of the cell and noise of displacement [m] and
    force [N]. mu: a number, or one for each cycle."""
    generator = np.random.default_rng(seed)
    loops = [loop_of(WEIGHTS[law], kt, one, N, amplitude) for one in np.broadcast_to(mu, cycles)]
    u, force = (np.concatenate(signals) for signals in zip(*loops, strict=True))
    gains = 1.0 + gain * generator.standard_normal(3)
    u = gains[0] * u + 0.5e-6 * np.linspace(0.0, 1.0, u.size) + noise[0] * generator.standard_normal(u.size)
    force = gains[1] * force + zero * generator.standard_normal() + noise[1] * generator.standard_normal(u.size)
    return ss.ContactRecord(u, force, gains[2] * N, np.arange(u.size) / 4000.0)


@pytest.mark.parametrize("law", WEIGHTS)
def test_the_law_and_its_parameters_are_found(law):
    """From records at three amplitudes with 1 % gains; held-out loops prefer the law that made them."""
    records = [record(law, seed, amplitude, cycles=4) for seed, amplitude in enumerate((2e-6, 5e-6, 12e-6))]
    found = ss.contact_law(records)
    assert found.best == law
    assert found.kt == pytest.approx(KT, rel=0.03)
    assert found.mu == pytest.approx(MU, rel=0.03)
    assert len(found.loops) == 6
    assert found.fits[law].held_out < 0.02


@pytest.mark.slow
def test_95_percent_intervals_cover_the_truth_and_are_no_wider_than_they_need_to_be():
    """Forty records with gains of 1 %: at least 34 of 40 are a matter of one in a thousand if the intervals are right."""
    fits = [ss.contact_law(record(seed=seed, cycles=3), laws="jenkins").fits["jenkins"] for seed in range(40)]
    for name, truth in (("kt", KT), ("mu", MU)):
        inside = [low < truth < high for low, high in (getattr(fit, f"{name}_interval") for fit in fits)]
        assert sum(inside) >= 34, name
        spread = np.std([np.log(getattr(fit, name)) for fit in fits])
        claimed = np.median([fit.errors[name == "mu"] for fit in fits])
        assert 0.7 < claimed / spread < 1.5


@pytest.mark.nightly
@pytest.mark.parametrize("noise", [0.08e-6, 0.4e-6])
def test_intervals_of_noise_alone_are_right_too(noise):
    """Without gain errors, and none stated: noise of 1 or 5 % of the amplitude on every sample; at most 0.3 % of bias."""
    none = ss.LoopErrors(force_gain=0.0, displacement_gain=0.0, normal_gain=0.0)
    records = [record(seed=seed, cycles=4, gain=0.0, noise=(noise, 0.4)) for seed in range(40)]
    fits = [ss.contact_law(one, laws="jenkins", errors=none).fits["jenkins"] for one in records]
    for name, truth in (("kt", KT), ("mu", MU)):
        logs = np.log([getattr(fit, name) / truth for fit in fits])
        claimed = np.median([fit.errors[name == "mu"] for fit in fits])
        assert abs(np.mean(logs)) < 3e-3
        assert 0.6 < claimed / np.std(logs) < 1.6, name
        assert np.mean(np.abs(logs) < 1.96 * np.array([fit.errors[name == "mu"] for fit in fits])) >= 0.85


def test_a_law_that_does_not_fit_has_wider_intervals():
    """One slider fitted to an array: scatter between parts of the loop enters, white noise alone would not see it."""
    right, wrong = (
        ss.contact_law(record(law, cycles=3, gain=0.0), laws="jenkins").fits["jenkins"] for law in ("jenkins", "array")
    )
    assert wrong.misfit > 3.0 * right.misfit
    assert wrong.errors[0] > 1.1 * right.errors[0]


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("samples", "noise"),
    [
        (60, 0.05),
        (100, 0.1),
        (200, 0.2),
        (400, 0.2),
    ],
)
def test_few_samples_of_a_cycle_and_much_noise(samples, noise):
    """Noise of both signals relative to their amplitudes; with 48 harmonics of 100 samples kt came out 20 % too low."""
    found = []
    for seed in range(8):
        generator = np.random.default_rng(seed)
        u, force = (np.tile(one, 4000 // samples) for one in loop_of(np.ones(1), KT, MU, N, 10e-6, samples))
        u = u + noise * 10e-6 * generator.standard_normal(u.size)
        force = force + noise * MU * N * generator.standard_normal(u.size)
        fit = ss.contact_law(ss.ContactRecord(u, force, N), laws="jenkins").fits["jenkins"]
        found.append([fit.kt / KT, fit.mu / MU])
    assert np.mean(found, axis=0) == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("noise", [0.05, 0.02])
def test_noise_of_the_displacement_does_not_bias_the_answer(noise):
    """Raw loops with so much of the amplitude have a softer kt; averaged ones stay within 1.5 %, a single smoothed one 3 %."""
    one = record(gain=0.0, noise=(noise * 8e-6, 0.2), cycles=20)
    found = ss.contact_law(one, laws="jenkins")
    assert found.kt == pytest.approx(KT, rel=0.015)
    assert found.mu == pytest.approx(MU, rel=0.015)
    loop = ss.ContactLoop(one.displacement[:400], one.force[:400], N)
    assert np.exp(fitted((loop,), "jenkins").x[0]) < KT * (1.0 - noise)
    assert ss.contact_law(loop, laws="jenkins").kt == pytest.approx(KT, rel=0.03)


TOO_LOW = 0.065
"""By which kt is too low where the force lags by half a per cent of a period."""


@pytest.mark.parametrize("lag", [-8, 2, 4])
def test_a_force_that_lags_is_named_and_taken_away(lag):
    """By so many of 400 samples a cycle; kt is right with the lag that the warning states."""
    one = record(gain=0.0, zero=0.0)
    late = ss.ContactRecord(one.displacement, np.roll(one.force, lag), N, one.time)
    found = ss.contact_law(late, laws="jenkins")
    assert np.sign(KT - found.kt) == np.sign(lag)
    if lag == 2:
        assert found.kt == pytest.approx((1.0 - TOO_LOW) * KT, rel=0.005)
    (warning,) = [one for one in found.warnings if "too late" in one or "too early" in one]
    assert "A force that is saturated looks the same. Record both with one filter, or give lag = " in warning
    estimate = float(warning.split("lag = ")[1].rstrip("."))
    assert estimate == pytest.approx(lag / 400, abs=2e-4)
    again = ss.contact_law(late, laws="jenkins", lag=estimate)
    assert again.kt == pytest.approx(KT, rel=0.005)
    assert not any("too late" in one or "too early" in one for one in again.warnings)
    assert any("of a period earlier than recorded" in note for note in again.removed)


@pytest.mark.slow
def test_laws_of_other_shapes_are_not_taken_for_a_lag():
    for law in WEIGHTS:
        for fitted_law in ("jenkins", "iwan", "array"):
            warned = ss.contact_law(record(law, cycles=4, gain=0.0), laws=fitted_law).warnings
            assert not any("of a period too" in one for one in warned), (law, fitted_law)


def test_the_rig_in_series_is_corrected_and_its_error_enters():
    """A contact of 17 N/µm behind a rig of 30 N/µm looks like 10.85; 1/17 = 1/10.85 - 1/30."""
    both = 1.0 / (1.0 / 17e6 + 1.0 / 30e6)
    assert both == pytest.approx(10.85e6, rel=1e-3)
    one = record(kt=both, gain=0.0, amplitude=20e-6)
    as_measured = ss.contact_law(one, laws="jenkins")
    assert as_measured.kt == pytest.approx(both, rel=0.01)
    assert "kt is likely the rig's" in " ".join(as_measured.warnings)
    corrected = ss.contact_law(one, laws="jenkins", rig_stiffness=30e6)
    assert corrected.kt == pytest.approx(17e6, rel=0.015)
    assert corrected.mu == pytest.approx(as_measured.mu, rel=1e-3)
    assert "10.8" in " ".join(corrected.removed)
    assert not corrected.warnings
    exact = ss.contact_law(one, laws="jenkins", rig_stiffness=30e6, errors=ss.LoopErrors(rig_stiffness=0.0))
    share = corrected.kt / 30e6
    gained = corrected.fits["jenkins"].errors[0] ** 2 - exact.fits["jenkins"].errors[0] ** 2
    assert gained == pytest.approx((0.05 * share) ** 2, rel=1e-6)
    known = ss.contact_law(one, laws="jenkins", rig_stiffness=30e6, errors=ss.LoopErrors(0.0, 0.0, 0.0))
    steps = [np.log(1.0 / (1.0 / (factor * both) - 1.0 / 30e6)) for factor in (0.999, 1.001)]  # of kt by that of both together
    by_gains = corrected.fits["jenkins"].errors[0] ** 2 - known.fits["jenkins"].errors[0] ** 2
    assert by_gains == pytest.approx(0.01**2 * 2.0 * ((steps[1] - steps[0]) / 2e-3) ** 2, rel=0.02)
    by_gains = corrected.fits["jenkins"].errors[1] ** 2 - known.fits["jenkins"].errors[1] ** 2
    assert by_gains == pytest.approx(2.0 * 0.01**2, rel=1e-6)
    with pytest.raises(InputError, match=r"rig_stiffness must be above .*, the stiffness of rig and contact together.*unit"):
        ss.contact_law(one, laws="jenkins", rig_stiffness=10e6)


def test_the_zero_of_the_load_cell_enters_the_interval_of_friction():
    one = record(gain=0.0, cycles=3)
    plain, with_zero = (
        ss.contact_law(one, laws="jenkins", errors=ss.LoopErrors(normal_zero=zero)).fits["jenkins"] for zero in (0.0, 3.0)
    )
    assert with_zero.errors[1] ** 2 - plain.errors[1] ** 2 == pytest.approx(0.03**2, rel=0.05)
    assert with_zero.errors[0] == plain.errors[0]


def test_friction_and_energy_over_the_cycles():
    """Friction that grows from 0.3 to 0.5 is followed cycle by cycle, and a warning says that one value is a mean."""
    truth = np.linspace(0.3, 0.5, 25)
    found = ss.contact_law(record(cycles=25, mu=truth, gain=0.0, amplitude=15e-6), laws="jenkins")
    data = found.dataset
    followed = np.interp(data["cycle_number"], np.arange(1, 25), 0.5 * (truth[:-1] + truth[1:]))
    assert data["cycle_mu"].values == pytest.approx(followed, rel=0.02)
    assert data["plateau"].values == pytest.approx(followed, rel=0.03)
    energy = 4.0 * followed * N * (15e-6 - followed * N / KT)
    assert data["energy_measured"].values == pytest.approx(energy, rel=0.02)
    assert data["energy_fitted"].values == pytest.approx(energy, rel=0.02)
    (warning,) = (one for one in found.warnings if one.startswith("mu changes"))
    numbers, values = data["cycle_number"].values, data["cycle_mu"].values
    first, last = (
        f"{values[part].mean():.4g} (mean of cycles {numbers[part][0]} to {numbers[part][-1]})"
        for part in (slice(2), slice(-2, None))
    )
    assert warning == f"mu changes from {first} to {last}: one value for all is a mean."
    assert np.all(data["cycle_mu_error"] < 0.02)


@pytest.mark.nightly
@pytest.mark.parametrize("law", ["jenkins", "iwan"])
def test_wear_does_not_hide_the_law(law):
    """Friction that grows: one value misses the loops by more than laws differ, and the right law is found all the same."""
    found = ss.contact_law(record(law, cycles=25, mu=np.linspace(0.3, 0.5, 25), gain=0.0))
    assert found.best == law
    assert found.fits[law].misfit > 0.08
    assert found.fits[law].held_out < 0.02
    assert "laws are compared with the load of each loop scaled" in " ".join(found.warnings)


@pytest.mark.nightly
def test_many_cycles_are_averaged_over_neighbours():
    found = ss.contact_law(record(cycles=450, gain=0.0), laws="jenkins")
    assert found.dataset.sizes["cycle"] == 200
    assert found.dataset["cycle_number"].values[-1] >= 448
    assert found.mu == pytest.approx(MU, rel=0.01)


def test_little_motion_and_a_poor_fit_are_said():
    small = ss.contact_law(record("iwan", amplitude=1e-6, cycles=4, zero=0.0), laws="iwan")
    assert "The contact hardly slips" in " ".join(small.warnings)
    assert str(small).splitlines()[0] == "Law of a contact"  # once: name of the analysis and title of the result are the same


@pytest.mark.parametrize(("amplitude", "slips"), [(0.5, False), (0.95, False), (3.0, True)])
def test_friction_of_a_contact_that_hardly_slips_is_a_lower_bound(amplitude, slips):
    """Amplitudes below and beyond the elastic travel mu N/kt of the slider."""
    found = ss.contact_law(record(amplitude=amplitude * MU * N / KT, gain=0.0, zero=0.0, noise=(0.0, 0.0)), laws="jenkins")
    assert any("mu is a lower bound" in warning for warning in found.warnings) != slips
    assert found.mu <= 1.01 * MU
    if not slips:
        carried = min(amplitude, 1.0) * MU
        (least,) = {float(one) for one in re.findall(r"mu ≥ ([\d.]+)", str(found))}
        assert least == pytest.approx(carried, rel=0.01)
        assert "mu = " not in str(found)
    assert ("the contact hardly slips" in str(found)) != slips


@pytest.mark.parametrize("law", ["jenkins", "dahl"])
def test_a_lower_bound_of_mu_is_nowhere_shown_as_a_value(law):
    """Stuck over 20 µm: the largest friction force tells whose kt it is, and cycles, table and figure have no mu."""
    kt = 1e6
    found = ss.contact_law(record(amplitude=0.5 * MU * N / kt, kt=kt, gain=0.0, zero=0.0, noise=(0.0, 0.0)), laws=law)
    (warning,) = (one for one in found.warnings if "kt is likely the rig's" in one)
    assert "the contact yields elastically by F/kt = 20" in warning
    data = found.dataset
    assert np.all(np.isnan(data["cycle_mu"]))
    assert ": kt " in next(line for line in str(found).splitlines() if line.startswith("from cycle"))
    laws, cycles = tables(data).values()
    assert laws["mu, at least"].tolist() == pytest.approx([0.5 * MU], rel=0.01)
    assert not any(str(title).startswith("mu") for title in [*laws.columns.drop("mu, at least"), *cycles.columns])
    assert len(over_cycles(data).panels[1].layers) == 1


def test_the_unit_of_a_rig_and_swapped_columns_are_suspected():
    one = record(cycles=3)
    for rig, said in ((30.0 * KT, False), (1e6 * KT, True)):
        found = ss.contact_law(one, laws="jenkins", rig_stiffness=rig)
        assert any("and corrects nothing" in note for note in found.warnings) == said
    u, force = loop_of(WEIGHTS["jenkins"], KT, MU, N, 8e-6)
    with pytest.raises(InputError, match="are the columns of displacement and force swapped"):
        ss.ContactLoop(1e-6 * force, 1e6 * u, N)


def test_wrong_arguments_are_refused():
    one = record(cycles=3)
    for arguments, words in (
        ({"laws": ["Jenkins"]}, "law must be a known one.*jenkins"),
        ({"laws": []}, "laws must be at least one"),
        ({"rig_stiffness": -1.0}, "rig_stiffness must be positive"),
        ({"harmonics": 2}, "harmonics must be at least 5"),
        ({"lag": 0.2}, "lag must be between -0.05 and 0.05 of a period"),
        ({"lag": "late"}, "lag must be a number"),
    ):
        with pytest.raises(InputError, match=words):
            ss.contact_law(one, **arguments)
    single = ss.ContactRecord(one.displacement[:400], one.force[:400], N)
    with pytest.raises(InputError, match=r"loops must be at least two.*--law jenkins"):
        ss.contact_law(single)
    assert ss.contact_law(single, laws="jenkins").kt == pytest.approx(KT, rel=0.05)
    with pytest.raises(InputError, match="several kinds"):
        ss.contact_law([one, contact_cycles(one)])
    with pytest.raises(InputError, match="force_gain must not be negative"):
        ss.LoopErrors(force_gain=-1.0)


@pytest.fixture(scope="module")
def tribometer(tmp_path_factory):
    """A measured record: reciprocating test of J. Christopherson, FrictionModels.jl, test_data_2.txt."""
    path = tmp_path_factory.mktemp("tribometer") / "record.txt"
    path.write_bytes(gzip.decompress(TRIBOMETER.read_bytes()))
    return ss.contact_law(path, normal_load=5.0)


@pytest.mark.nightly
def test_the_measured_record(tribometer):
    """An independent trial found 49 cycles of 4.0000 s, kt 0.0406 N/µm, mu 0.4727 and 0.466 in the first cycle."""
    data = tribometer.dataset
    assert "49 cycles of 4 s, amplitude 114 um, normal load 5 N" in repr(tribometer)
    fit = tribometer.fits["jenkins"]
    assert fit.kt == pytest.approx(0.0406e6, rel=0.002)
    assert fit.mu == pytest.approx(0.4727, rel=0.003)
    assert fit.mu == pytest.approx(0.4737, abs=2e-4)
    assert float(data["cycle_mu"][0]) == pytest.approx(0.466, abs=0.002)
    assert tribometer.best == "jenkins"
    assert fit.misfit == pytest.approx(0.0464, abs=0.001)
    assert fit.held_out == pytest.approx(0.0474, abs=0.001)
    assert tribometer.fits["dahl"].held_out > 0.1
    assert fit.mu_interval == pytest.approx((0.460, 0.488), abs=0.002)
    assert float(data["cycle_mu"][-1]) == pytest.approx(0.4875, abs=0.002)
    assert data["plateau"].values[[0, -1]] == pytest.approx([0.467, 0.492], abs=0.001)
    assert float(data["energy_measured"].mean()) == pytest.approx(0.516e-3, rel=0.005)
    assert float(data["energy_fitted"].mean()) == pytest.approx(0.528e-3, rel=0.005)


@pytest.mark.nightly
def test_the_measured_record_says_what_to_check(tribometer):
    shown = repr(tribometer)
    assert len(shown.splitlines()) <= 8
    assert "The sign of the force is turned" in shown
    travel = tribometer.mu * 5.0 / tribometer.kt
    assert travel == pytest.approx(58.3e-6, rel=2e-3)
    assert f"kt is likely the rig's: the contact would yield elastically by mu N/kt = {1e6 * travel:.1f} um" in shown
    assert "3379 of 42579 samples lie outside whole cycles" in shown


@pytest.mark.nightly
def test_the_virgin_first_stroke_explains_the_other_misfit(tribometer, tmp_path):
    """Cycles cut from the start of motion on have the first stroke in them: the misfit of ten mean loops is then 5.2 %."""
    path = tmp_path / "record.txt"
    path.write_bytes(gzip.decompress(TRIBOMETER.read_bytes()))
    (raw,) = ss.read_contact_records(path, normal_load=5.0)
    grid = 8.8 + 0.01 * np.arange(49 * 400)
    u, force = (np.interp(grid, raw.time, signal).reshape(49, 400) for signal in (raw.displacement, -raw.force))
    parts = np.array_split(np.arange(49), 10)
    middle = 0.5 * (u.max() + u.min())
    loops = [ss.ContactLoop(u[part].mean(axis=0) - middle, force[part].mean(axis=0), 5.0) for part in parts]
    theta, _, misfit, _ = judged(loops, "jenkins", loops)  # as they are, without smoothing
    assert np.exp(theta[1]) == pytest.approx(0.4728, abs=2e-4)
    assert misfit == pytest.approx(0.052, abs=0.001)


@pytest.mark.nightly
def test_figures_are_drawn(tribometer):
    for name in ("", "cycles", "laws"):
        figure = tribometer.plot(name)
        figure.draw_without_rendering()
        assert all(axes.has_data() for axes in figure.axes)
