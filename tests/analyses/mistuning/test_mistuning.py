"""Mistuned disks: without deviation the tuned disk, closed forms of the blades, populations that do not depend on their order."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.stats import kstest, norm

import stickslip as ss
from stickslip.analyses.mistuning.disk import blade_dofs
from stickslip.analyses.mistuning.work import PopulationWork, quantile_interval
from stickslip.model.rigs import lumped_blisk
from stickslip.model.structure.matrices import ModalDamping
from stickslip.results.files import open_results, save, stamped
from stickslip.show.report.markup import presentation_of
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.receptance import REAL_MODE
from stickslip.solve.continuation.sweep import swept_curve
from stickslip.study import read
from stickslip.study.templates import write_new
from stickslip.support.checks import InputError

SIX = lumped_blisk("W", sectors=6)
AT = [float(SIX.frequencies(stuck=True)[0]) - 0.1]
FINE = {"harmonics": 3, "samples": 96}


def test_without_deviation_it_is_the_tuned_disk():
    found = ss.mistuned_response(SIX, AT, ss.Mistuning(), force=0.4, **FINE).dataset
    ratio = found.amplitude.values[0] / found.tuned_amplitude.values[:, None]
    assert np.abs(ratio - 1.0).max() < 1e-10
    assert float(found.amplification[0]) == pytest.approx(1.0, abs=1e-10)


def test_a_hardly_mistuned_disk_is_nearly_the_tuned_one():
    """The deviation takes the disk off the path of nodal diameters: all sectors are solved together."""
    tiny = 1e-9 * np.arange(6)
    found = ss.mistuned_response(
        SIX, AT, ss.Mistuning(blade=tiny, kt=tiny, kn=tiny, mu=tiny, pull=tiny), force=0.4, **FINE
    ).dataset
    ratio = found.amplitude.values[0] / found.tuned_amplitude.values[:, None]
    assert 0.0 < np.abs(ratio - 1.0).max() < 1e-5


def test_a_blade_held_at_its_platform_has_its_frequency_scaled():
    """k (1 + δ)² between platform and tip and nothing else: the lumped blade is one spring."""
    deviation = np.linspace(-0.05, 0.05, 6)
    full, detuned = SIX.full(), ss.mistuned_disk(SIX, ss.Mistuning(blade=deviation))
    change = detuned.structure.K - full.structure.K
    expected = np.zeros_like(change)
    for sector, each in enumerate(deviation):
        p, t = (full.structure.index(f"{sector + 1}/{node}.t") for node in ("platform", "tip"))
        expected[np.ix_([p, t], [p, t])] = 5.5e5 * ((1.0 + each) ** 2 - 1.0) * np.array([[1.0, -1.0], [-1.0, 1.0]])
    assert np.abs(change - expected).max() < 1e-9 * 5.5e5
    assert blade_dofs(SIX) == ["tip.t"]


def test_a_blade_of_several_coordinates_has_its_frequencies_scaled():
    """Tip and platform together, held where they join the damper and the neighbours: each blade's frequencies times 1 + δ."""
    deviation, names = np.linspace(-0.05, 0.05, 6), ("tip.t", "platform.t")
    full, detuned = SIX.full(), ss.mistuned_disk(SIX, ss.Mistuning(blade=deviation), names)
    for sector, each in enumerate(deviation):
        own = [full.structure.index(f"{sector + 1}/{name}") for name in names]
        tuned, scaled = (
            np.sqrt(eigh(p.structure.K[np.ix_(own, own)], p.structure.M[np.ix_(own, own)])[0]) for p in (full, detuned)
        )
        assert scaled == pytest.approx((1.0 + each) * tuned, rel=1e-9)


def test_deviations_on_top_of_others_multiply():
    base, more = ss.Mistuning(kt=0.5, mu=-0.2, missing=[2]).of(6), ss.Mistuning(kt=0.2, mu=0.5, missing=[5]).of(6)
    both = more.on_top_of(base)
    assert both.deviation("kt") == pytest.approx(1.5 * 1.2 - 1.0)
    assert both.deviation("mu") == pytest.approx(0.8 * 1.5 - 1.0)
    assert both.missing == (2, 5)


def test_deviations_of_contacts_are_lognormal():
    """Their logarithms are normal with the given standard deviation, so that none turns negative; 6000 of them, by both ways."""
    for sampling in ("random", "sobol"):
        scatter = ss.Scatter(kt=0.6, sampling=sampling)
        drawn = np.concatenate([scatter.draw(60, 2, sample).deviation("kt") for sample in range(100)])
        assert drawn.min() > -1.0
        assert kstest(np.log1p(drawn) / 0.6, norm.cdf).pvalue > 1e-3


def test_contacts_and_pull_are_those_of_their_sector():
    changed = ss.mistuned_disk(SIX, ss.Mistuning(kt=[0.1, 0, 0, 0, 0, 0], mu=0.5, pull=[0, 0, 0, 0, 0, -0.2]))
    assert [c.law.kt for c in changed.contacts[:4]] == pytest.approx([1.87e7, 1.87e7, 1.7e7, 1.7e7])
    assert {round(c.law.mu, 12) for c in changed.contacts} == {0.9}
    assert [f.static for f in changed.forces if f.static] == pytest.approx([147.0] * 5 + [117.6])


def test_all_dampers_missing_is_the_free_disk():
    bare = ss.mistuned_disk(SIX, ss.Mistuning(missing=range(1, 7)))
    assert bare.contacts == ()
    modes = SIX.modes(2, stuck=False).frequencies[2:]
    assert all(np.abs(bare.frequencies(stuck=True) - frequency).min() < 1e-6 for frequency in modes)


def test_a_disk_without_any_damper_is_linear():
    """Its response against one solution of a sector's own matrices; the highest value at an end of the band is said so."""
    found = ss.mistuned_response(SIX, [AT[0] - 0.2, AT[0]], ss.Mistuning(missing=range(1, 7)), force=0.4, **FINE).dataset
    bare, C = SIX.disk.at(2), SIX.systems.matrices(2).C
    for frequency, amplitude in zip(found.frequency.values[0], found.amplitude.values[0], strict=True):
        omega = 2.0 * np.pi * frequency
        X = np.linalg.solve((bare.K - omega**2 * bare.M + 1j * omega * C)[:3, :3], [0.0, 0.0, 0.4])
        assert amplitude == pytest.approx(abs(X[2]), rel=1e-9)
    sentence = presentation_of(stamped(found)).sentences(found)[0]
    assert sentence.endswith("(the edge of the band: a peak may lie beyond), no dampers")


def test_one_missing_damper_is_felt_by_its_neighbours():
    found = ss.mistuned_response(SIX, AT, ss.Mistuning(missing=[3]), force=0.1, **FINE).dataset
    assert found.sample_message.values[0] == "Converged."
    assert found.damper_missing.values[0].tolist() == [0, 0, 1, 0, 0, 0]
    assert np.ptp(found.blade_peak.values) > 0.1 * float(found.tuned_peak)


def test_samples_depend_on_seed_and_number_alone():
    scatter = ss.Scatter(blade=0.003, kt=0.1, missing=0.1)
    few, many = (ss.mistuned_population(SIX, AT, count, scatter, seed=3, **FINE).dataset for count in (1, 2))
    assert np.array_equal(few.amplitude[0], many.amplitude[0])
    assert many.attrs["whitehead"] == pytest.approx(0.5 * (1.0 + np.sqrt(6.0)), rel=1e-12)  # Whitehead's limit of six sectors
    assert not np.array_equal(many.blade_deviation[0], many.blade_deviation[1])
    other = ss.Scatter(blade=0.003, mu=0.1).draw(6, 3, 0)
    assert other.deviation("blade") == pytest.approx(many.blade_deviation.values[0], abs=1e-15)


def test_a_sample_that_fails_is_marked_and_the_rest_goes_on(tmp_path):
    """A scatter of 90 % draws blades of negative frequency sooner or later."""
    found = ss.mistuned_population(SIX, AT, 4, ss.Scatter(blade=0.9), seed=1, **FINE).dataset
    failed = found.worst_blade.values == 0
    assert 0 < failed.sum() < 4
    assert np.isnan(found.amplification.values[failed]).all()
    assert np.isfinite(found.amplification.values[~failed]).all()
    dataset = open_results(save(stamped(found), tmp_path / "results.nc"))
    report = presentation_of(dataset)
    assert "failed, the first is" in report.failures(dataset)[0]
    samples = report.tables(dataset)["samples"]
    assert len(samples) == 4
    assert np.array_equal(samples["worst blade"].isna(), failed)
    assert samples["busiest damper"].isna()[failed].all()
    assert all(draw(dataset).plot().axes for draw in report.figures(dataset).values())


def test_a_study(tmp_path):
    write_new("mistuned_population", tmp_path / "study.toml")
    work = read(tmp_path / "study.toml").plan.works[""]
    assert (work.count, work.scatter.blade, work.blade_dofs) == (20, 0.003, ["tip.t"])
    assert len(set(work.names)) == 21


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        (
            "# missing = [3]",
            "blade = [0.01, -0.01]",
            r"^Line 28, \[mistuned_population\]: blade must hold one number for each of the 24 sectors, but holds 2",
        ),
        ("# missing = [3]", "kt = []", "kt must hold one number for each of the 24 sectors, but holds 0"),
        ("# missing = [3]", "missing = [25]", r"^Line 28, \[mistuned_population\]: missing must hold sectors from 1 to 24"),
        ("blade_scatter = 0.003", "blade_scatter = 0.25", "blade_scatter must be below 0.25"),
        ("blade_scatter = 0.003", "blade_scatter = -0.1", "blade_scatter must be at least 0"),
        ("# missing = [3]", "blade = 1.0", "blade must be below 1"),
        ("# missing = [3]", "kt = -1.0", "kt must be above -1"),
        ("# missing = [3]", 'blade_nodes = ["tipp"]', "Did you mean 'tip'"),
        ("# missing = [3]", 'blade_nodes = ["damper"]', "must name what stiffness holds"),
        ("[0.4]", "[0.4, 0.8]", "one force level"),
        ("lumped_blisk", "single_mass", "tuned disk"),
    ],
)
def test_faults_of_a_study_are_said(tmp_path, before, after, words):
    path = write_new("mistuned_population", tmp_path / "study.toml")[0]
    text = path.read_text().replace("engine_order = 2", "" if after == "single_mass" else "engine_order = 2")
    path.write_text(text.replace(before, after, 1))
    with pytest.raises(InputError, match=words):
        read(path)


def test_a_population_without_deviations_is_refused_or_said(tmp_path):
    """Zero is the end of a scan; nothing at all is a key forgotten."""
    path = write_new("mistuned_population", tmp_path / "study.toml")[0]
    text = path.read_text()
    path.write_text(text.replace("blade_scatter", "#").replace("missing_probability", "#"))
    with pytest.raises(
        InputError, match=r"^Line 20, \[mistuned_population\]: a deviation must be given, such as blade_scatter = 0.003"
    ):
        read(path)
    path.write_text(text.replace("blade_scatter = 0.003", "blade_scatter = 0.0"))
    assert read(path).plan.summary.endswith(", all as the tuned one, since every deviation is zero")
    path.write_text(text.replace("blade_scatter = 0.003", "blade = 0.01"))
    assert read(path).plan.summary.endswith("24 sectors, all alike")
    path.write_text(text)
    assert read(path).plan.summary.endswith("24 sectors")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: ss.Mistuning(blade=-1.0).of(6), "must be above -1"),
        (lambda: ss.Scatter(kt=-0.1), "must lie between 0 and 1"),
        (lambda: ss.Scatter(sampling="sobel"), "Did you mean 'sobol'"),
        (lambda: ss.mistuned_population(SIX, AT, 0, ss.Scatter()), "count must be"),
        (lambda: ss.mistuned_population(SIX, AT, 1, ss.Scatter(), seed=2**63), "seed must be at most"),
        (lambda: ss.mistuned_population(SIX, AT, 1, ss.Scatter(), output="a", **FINE), "output must be"),
        (lambda: ss.mistuned_population(SIX, AT, 1, 0.003), "scatter must be a Scatter"),
        (lambda: ss.mistuned_population(SIX, AT, 1, ss.Scatter(), 0.003), "mistuning must be a Mistuning"),
        (lambda: ss.mistuned_response(SIX, AT, ss.Mistuning(), harmonics="auto"), "harmonics must be a whole number"),
        (lambda: ss.mistuned_response(SIX, AT, ss.Mistuning(), blade=3), "blade must be a tuple or list"),
        (lambda: ss.Mistuning(blade="a"), "Mistuning, blade must hold numbers"),
        (lambda: ss.Mistuning(kt=[[1]]), "Mistuning, kt must have one axis"),
        (lambda: ss.Mistuning(missing=3), "Mistuning, missing must be a tuple or list"),
        (lambda: ss.Mistuning(missing=["a"]).of(6), "Mistuning, missing must be a whole number"),
        (lambda: ss.Mistuning(missing=[1.5]).of(6), "Mistuning, missing must be a whole number"),
        (lambda: ss.Mistuning(missing=[3, 3]).of(6), "Mistuning, missing must be unique"),
        (lambda: ss.Scatter(blade="a"), "Scatter, blade must be a number"),
        (lambda: ss.mistuned_population(SIX.full(), AT, 1, ss.Scatter(), **FINE), "must be a tuned one"),
        (lambda: ss.mistuned_population(SIX, AT, 1, ss.Scatter(), force=[1.0, 2.0], **FINE), "force must be one level"),
    ],
)
def test_wrong_input(make, words):
    with pytest.raises(InputError, match=words):
        make()


def test_a_sobol_sequence_spreads_the_samples_evenly():
    """64 points: one in each 64th of every deviation; point k depends on seed and k alone."""
    scatter = ss.Scatter(blade=0.1, mu=0.2, missing=0.25, sampling="sobol")
    drawn = [scatter.draw(6, 5, sample) for sample in range(64)]
    shares = norm.cdf(np.array([draw.deviation("blade") / 0.1 for draw in drawn]))
    assert np.array_equal(np.sort((64 * shares).astype(int), axis=0), np.repeat(np.arange(64)[:, None], 6, axis=1))
    assert sum(len(draw.missing) for draw in drawn) == 64 * 6 / 4
    assert norm.cdf(np.log1p(drawn[9].deviation("mu")) / 0.2).max() < 1.0
    assert not np.array_equal(drawn[0].deviation("blade"), scatter.draw(6, 6, 0).deviation("blade"))


def test_which_damper_works_most():
    """At a tuned disk all work alike, as that of the one sector; a missing damper does none."""
    tuned = ss.mistuned_response(SIX, AT, ss.Mistuning(), force=0.4, **FINE).dataset
    assert tuned.damper_work.values[0] == pytest.approx(float(tuned.tuned_damper_work), rel=1e-8)
    assert float(tuned.tuned_damper_work) > 1e-7
    whole = ss.forced_response(SIX.full(), AT, 0.4, **FINE).dataset.dissipated.values[0, 0]
    assert tuned.damper_work.values.sum() == pytest.approx(np.nansum(whole), rel=1e-6)
    lost = ss.mistuned_response(SIX, AT, ss.Mistuning(missing=[3]), force=0.4, **FINE).dataset
    assert lost.damper_work.values[0, 2] == 0.0
    assert int(lost.busiest_damper[0]) == int(lost.damper_work.values[0].argmax()) + 1
    stuck = ss.mistuned_response(SIX, AT, ss.Mistuning(), force=1e-4, **FINE).dataset
    assert int(stuck.busiest_damper[0]) == 0


def test_a_symmetric_disk_goes_straight_on_where_another_branch_crosses():
    """At 1.6 N a branch without the symmetry crosses at 151.17 Hz and turns the determinant's sign; the curve goes on."""
    ends = (2.0 * np.pi * 144.5, 2.0 * np.pi * 160.5)
    one, whole = (swept_curve(HarmonicBalance(disk, 3, 96), 1.6, ends) for disk in (SIX, SIX.full([1])))
    assert len(whole) < 2 * len(one)
    found = [max(np.hypot(*point.evaluation.w[-1][1:3]) for point in curve) for curve in (one, whole)]
    assert found[1] == pytest.approx(found[0], rel=0.01)


def test_one_damping_ratio_is_that_of_the_mistuned_modes():
    """They decouple, with springs on the mean too; the tuned disk's matrix says the same but for the size of the deviations."""
    disk = lumped_blisk("R", sectors=6)
    disk = disk.with_structure(disk.structure.with_damping(ModalDamping(1e-3)))
    detuned = ss.mistuned_disk(disk, ss.Mistuning(blade=np.linspace(-0.003, 0.003, 6), missing=[2]))
    assert set(HarmonicBalance(detuned, 1, 24).linear.modes.kind) == {REAL_MODE}
    detuned = ss.mistuned_disk(disk, ss.Mistuning(blade=np.linspace(-0.003, 0.003, 6)))
    copied = detuned.with_damping(disk.full().structure.C)
    at = 2.0 * np.pi * float(disk.frequencies(stuck=True)[0])
    own, other = (each.evaluate(each.stuck_point(at, 1e-6)).w for each in (HarmonicBalance(d, 1, 24) for d in (detuned, copied)))
    assert 0.0 < np.abs(own - other)[:, 1:].max() < 0.01 * np.abs(own[:, 1:]).max()
    assert ss.mistuned_disk(disk, ss.Mistuning(pull=0.1)).structure.C is not None


def test_a_disk_is_run_in():
    """Where all slips, the start is forgotten; run in again nothing moves; where nothing slips, nothing has moved at all."""
    band = ss.hertz(AT[0] - 2.0, AT[0] + 2.0)
    used = ss.run_in(SIX, band, 0.4, 3, 48)
    again = ss.run_in(used, band, 0.4, 3, 48)
    moved, after = (np.array([c.starts[0].value[0] for c in disk.contacts]) for disk in (used, again))
    assert np.abs(moved).min() > 1e-8
    response = ss.forced_response(SIX, band, 0.4, 3, 48)
    cycle = response.cycle(0, int(np.nanargmax(response.dataset.amplitude.values[0, :, 0])))
    stiffness = np.array([c.law.kt for c in SIX.contacts])
    means = cycle.displacement[::2].mean(axis=1) - cycle.force[::2].mean(axis=1) / stiffness  # s̄ = ū − T̄/kt
    assert moved == pytest.approx(means, rel=0.1)  # at the highest points of two curves
    assert np.abs(after - moved).max() < 1e-4 * np.abs(moved).max()
    peaks = [ss.forced_response(disk, band, 0.4, 3, 48).dataset.peak_amplitude.max() for disk in (SIX, used)]
    assert float(peaks[1]) == pytest.approx(float(peaks[0]), rel=1e-6)
    assert all(abs(c.starts[0].value[0]) < 1e-15 for c in ss.run_in(SIX, band, 1e-3, **FINE).contacts)


def test_a_population_of_run_in_disks():
    asked = (1, ss.Scatter(blade=0.003), None, 0.4, 1, 24)
    found = ss.mistuned_population(SIX, AT, *asked, run_in=True).dataset
    expected = ss.mistuned_population(ss.run_in(SIX, AT, 0.4, 1, 24), AT, *asked).dataset
    assert np.array_equal(found.amplitude, expected.amplitude)
    plain, used = (PopulationWork(SIX, AT, *asked, run_in=run_in) for run_in in (False, True))
    assert plain.names != used.names


def test_maxima_of_blades_are_those_of_the_quantity():
    """Against the forced response of the same disk: the highest peak of each blade, by rms of the velocity per force level."""
    band, mistuning = ss.hertz(AT[0] - 2.0, AT[0] + 2.0), ss.Mistuning(blade=np.linspace(-0.004, 0.004, 6))
    asked = {"quantity": "mobility", "measure": "rms"}
    found = ss.mistuned_response(SIX, band, mistuning, 0.4, 3, 48, peak_tolerance=1e-7, **asked).dataset
    peaks = ss.forced_response(ss.mistuned_disk(SIX, mistuning), band, 0.4, 3, 48, **asked).peaks()
    highest = peaks.groupby("output").rms.max().to_numpy()
    assert np.sort(found.blade_peak.values[0]) == pytest.approx(np.sort(highest), rel=1e-5)
    assert found.blade_peak.attrs["units"] == "m/(s N)"
    assert float(found.tuned_peak) == pytest.approx(ss.forced_response(SIX, band, 0.4, 3, 48, **asked).peaks().rms[0], rel=1e-6)


def test_a_deviation_meets_a_law_that_has_it():
    """A slider under a constant load has no normal stiffness."""
    disk = ss.rigs.lumped_blisk("W", sectors=6)
    contacts = tuple(replace(each, law=ss.Macroslip(kt=1e3, mu=0.3, normal_load=1.0), normal=None) for each in disk.contacts)
    with pytest.raises(ss.InputError, match="kn must meet a contact law that has it"):
        ss.mistuned_disk(replace(disk, contacts=contacts), ss.Mistuning(kn=0.1))
    with pytest.raises(ss.InputError, match="kn must meet a contact law that has it"):
        PopulationWork(replace(disk, contacts=contacts), ss.hertz(140.0, 156.0), 1, ss.Scatter(kn=0.1))
    still = replace(disk, forces=tuple(replace(each, static=0.0) for each in disk.forces))
    for scatter, words in ((ss.Scatter(pull=0.1), "pull must meet a static load"), (ss.Scatter(missing=0.1), "")):
        if words:
            with pytest.raises(ss.InputError, match=words):
                PopulationWork(still, ss.hertz(140.0, 156.0), 1, scatter)
        PopulationWork(disk, ss.hertz(140.0, 156.0), 1, scatter)
    held = replace(still, contacts=contacts)
    assert PopulationWork(held, ss.hertz(140.0, 156.0), 1, ss.Scatter(pull=0.1)).scatter.names == ["pull"]


def test_the_interval_of_a_quantile_is_the_tabulated_one_and_holds_it():
    """Of 20 samples the 6th and the 15th enclose the median with 95.9 % (Conover's tables); 20 tell no upper end of 95 %."""
    values = np.arange(1.0, 21.0)[::-1]
    assert quantile_interval(values, 0.5) == (6.0, 15.0)
    assert quantile_interval(values, 0.95) == (17.0, np.inf)
    assert quantile_interval(values, 0.05) == (-np.inf, 4.0)
    drawn = np.random.default_rng(6).gumbel(size=(2000, 150))
    for share in (0.05, 0.5, 0.95):
        true = -np.log(-np.log(share))
        ends = np.array([quantile_interval(each, share) for each in drawn])
        missed = np.mean(ends[:, 0] > true), np.mean(ends[:, 1] < true)
        assert max(missed) < 0.035
        assert sum(missed) > 0.02
