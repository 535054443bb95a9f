"""Bladed disks: the lumped disk sector by sector, contact stiffness from geometry, the finite-element disk beside the paper."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.mistuning.disk import Scatter
from stickslip.analyses.mistuning.work import mistuned_population
from stickslip.model.contact.stiffness import NORMAL_STIFFNESS, LineContact, static_normal_load
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.problem import Problem
from stickslip.model.rigs import lumped_blisk, octopus_blisk
from stickslip.model.rigs.octopus_blisk import BliskSector
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.continuation.continuation import first_point
from stickslip.support.units import hertz
from verify.row import INDEPENDENT, Row, absolute, at_most, relative

TITLE = "Bladed disks"
ABOUT = (
    "24 sectors, engine order 2. The lumped disk against an independent script and against all of its sectors; the meshed "
    "disk beside *On the choice of contact parameters for the forced response calculation of a bladed disk with underplatform "
    "dampers*, whose geometry is not published: the stuck 144.9 Hz and the damping were fitted, the rest is predicted."
)
PAPER = "published"


ON_PAGE = "docs/disks.md"
LINE = LineContact(27.6e-3, 5e-3)
"""The cylinder of the paper on its platform."""
LEVELS = {"0.1": 0.1, "1": 1.0, "10": 10.0}
"""k_ty over k_tx."""


def rows() -> Iterator[Row]:
    yield from stiffness()
    yield from lumped()
    yield from lumped_peaks()
    yield from one_against_all()
    yield from mistuned()
    yield from meshed()
    yield from predicted()
    yield from axial_stiffness()
    yield from responses()
    yield from rotating()


def one_seed() -> Iterator[Row]:
    """What takes least: stiffness from geometry, the lumped disk, the fitted frequencies of the meshed one."""
    for part in (stiffness, lumped, lumped_peaks, one_against_all, meshed):
        yield from part()


def on_page(name: str, value: float, written: float, digits: int) -> Row:
    """A number of docs/disks.md with so many digits behind the point; one unit of the last one is allowed."""
    return absolute(name, value, written, 10.0**-digits, ON_PAGE)


def stiffness() -> Iterator[Row]:
    """A cylinder of 27.6 mm and 5 mm at F_C/(2 cos α), and what choices lead to the published tangential stiffness."""
    for (name, formula), value in zip(NORMAL_STIFFNESS.items(), (6.544e8, 6.345e8, 6.063e8), strict=True):
        yield relative(f"k_n at 103.9 N, {name}, N/m", formula(LINE, 103.9), value, 1e-4, INDEPENDENT)
    for angle, load, brandlein, written in (
        (20.0, 78.2, 6.211e8, (5.960, 5.625, 5.671, 4.327, 6.049)),
        (30.0, 84.9, 6.249e8, (5.990, 5.651, 5.697, 4.349, 6.077)),
        (45.0, 103.9, 6.345e8, (6.063, 5.717, 5.764, 4.404, 6.145)),
    ):
        N = static_normal_load(147.0, angle)
        yield on_page(f"F_C/(2 cos {angle:g}°) of 147 N, N", N, load, 1)
        yield relative(f"{angle:g}°: k_n after Brändlein, N/m", NORMAL_STIFFNESS["Brändlein"](LINE, N), brandlein, 1e-3, ON_PAGE)
        across, along = LINE.tangential_stiffness(N)
        values = {
            "k_n = dN/dδ after Allara": LINE.normal_stiffness(N),
            "N/δ after Allara": N / LINE.approach(N),
            "k_tx of the half-space": across,
            "k_ty of the half-space": along,
            "k_ty of a flat punch along its length": middle(LINE, N, "even", punch=True)[1],
        }
        for (name, value), reference in zip(values.items(), written, strict=True):
            yield relative(f"{angle:g}°: {name}, N/m", value, reference * 1e8, 1e-3, ON_PAGE)
    for punch, along, table in (
        (False, "even", {"rigid": (5.697, 4.349), "Hertz": (5.390, 4.095), "even": (5.505, 4.189)}),
        (True, "a flat punch", {"rigid": (8.294, 6.290), "Hertz": (7.879, 5.950), "even": (8.034, 6.077)}),
    ):
        for across, pair in table.items():
            found = middle(LINE, static_normal_load(147.0, 30.0), across, punch=punch)
            for name, value, reference in zip(("k_tx", "k_ty"), found, pair, strict=True):
                yield relative(f"Line at 30°, {along} along, {across} across: {name}, N/m", value, reference * 1e8, 1e-3, ON_PAGE)


ACROSS = {"rigid": np.log(2.0), "Hertz": np.log(2.0) + 0.5, "even": 1.0}
"""Tractions across a line by the mean of ln(b/|x|) under them: 1/√(b² − x²), √(b² − x²), constant."""


def middle(line: LineContact, load: float, across: str, *, punch: bool) -> tuple[float, float]:
    """k_tx, k_ty by the motion in the middle of the line after Cerruti, both bodies: c π G L/((1 − ν) A + ν), c π G L/(A − ν).

    The traction is even along the line, A = ln(L/b) + m, c = 1/2, or that of a flat punch as long as the line,
    q ~ 1/√(L²/4 − y²), A = ln(2L/b) + m, c = π/4; m: mean of ln(b/|x|) across it.
    """
    length, width, ratio = line.length, float(line.half_width(load)), line.poisson
    A = np.log((2.0 if punch else 1.0) * length / width) + ACROSS[across]
    factor = (0.25 * np.pi if punch else 0.5) * np.pi * line.shear_modulus * length
    return float(factor / ((1.0 - ratio) * A + ratio)), float(factor / (A - ratio))


def lumped() -> Iterator[Row]:
    wedge, roller = lumped_blisk("W"), lumped_blisk("R")
    for mode, frequency in enumerate((148.6080699, 377.91876149, 508.63701605)):
        yield absolute(
            f"Case W, stuck frequency {mode + 1}, Hz", wedge.frequencies(stuck=True)[mode], frequency, 1e-7, INDEPENDENT
        )
    for mode, frequency in enumerate((131.92083361, 258.14530402, 496.62061886)):
        yield absolute(f"Free frequency {mode + 1}, Hz", wedge.frequencies(stuck=False)[2 + mode], frequency, 1e-8, INDEPENDENT)
    yield absolute("Case R, stuck frequency, Hz", roller.frequencies(stuck=True)[0], 145.517857, 1e-6, INDEPENDENT)
    balance, evaluation = solved(wedge, 148.0, 1e-6)
    static = balance.carried_forces(evaluation)[:, 0]
    yield absolute("Case W, static normal load, N", static[1], 101.21353788, 1e-6, INDEPENDENT)
    yield absolute("Case W, static tangential load, N", static[0], 2.73115896, 1e-6, INDEPENDENT)
    for case, force, frequency, value in (
        ("W", 0.1, 148.60807, 0.589501),
        ("W", 0.4, 148.5656, 0.209084),
        ("R", 0.1, 145.517857, 0.5893424),
        ("R", 0.2, 145.517857, 0.5893424),
    ):
        found = mobility(lumped_blisk(case), frequency, force)
        yield relative(f"Case {case}, mobility at {force:g} N, m/s/N", found, value, 1e-5, INDEPENDENT)


def lumped_peaks() -> Iterator[Row]:
    """The highest mobility and the highest receptance lie at frequencies of their own; loads carried at the peak."""
    written = {"W": (0.209084, 148.5656, 224.013, 148.5245), "R": (0.431957, 145.5305, 472.449, 145.4958)}
    for case, (mobility_peak, its_frequency, receptance, frequency) in written.items():
        for quantity, value, at, unit in (
            ("mobility", mobility_peak, its_frequency, "m/s/N"),
            ("receptance", receptance * 1e-6, frequency, "m/N"),
        ):
            highest = peak(lumped_blisk(case), (145.0, 149.0), 0.4, 5, quantity, 384)
            yield relative(f"Case {case}, highest {quantity} at 0.4 N, {unit}", highest.value, value, 1e-5, ON_PAGE)
            yield on_page(f"Case {case}, frequency of the highest {quantity} at 0.4 N, Hz", highest.frequency, at, 3)
    for force, load in ((0.1, 101.2), (0.2, 131.9), (0.4, 163.0), (1.6, 163.0)):
        mean = peak(lumped_blisk("R"), (144.0, 147.0), force, 3, "displacement").mean_load
        yield absolute(f"Case R, mean normal load at {force:g} N, N", mean, load, 0.1 if force < 0.3 else 1.0, ON_PAGE)
        if force == 0.4:
            yield on_page("Case R, mean normal load at 0.4 N over F_C/(2 cos α), less 1", mean / 103.945 - 1.0, 0.57, 2)


def one_against_all() -> Iterator[Row]:
    for case, frequency, bound in (("W", 148.5, 1e-10), ("R", 145.4, 1e-9)):
        disk = lumped_blisk(case)
        whole = disk.full(reported=[1])
        for harmonics in (3, 5):
            for force in (0.4, 1.6):
                one, every = (output(d, frequency, force, harmonics) for d in (disk, whole))
                error = np.abs(one - every).max() / np.abs(one[1:]).max()
                name = f"Case {case}, one sector against 24, H = {harmonics}, {force:g} N"
                yield at_most(name, error, bound, "all sectors solved together")


def mistuned() -> Iterator[Row]:
    """Small populations, and how evenly two ways of drawing them spread the deviations."""
    for sampling, written in (("random", (0.13, 0.07)), ("sobol", (0.008, 0.04))):
        scatter = Scatter(blade=0.1, sampling=sampling)
        drawn = [np.array([scatter.draw(24, seed, k).deviation("blade") for k in range(64)]) / 0.1 for seed in range(20)]
        off = float(np.sqrt(np.mean([np.mean(x.mean(axis=0) ** 2) for x in drawn])))
        largest = float(np.std([x.max(axis=1).mean() for x in drawn]))
        yield relative(
            f"64 disks, {sampling}: mean deviation of a blade is off by, standard deviations", off, written[0], 0.05, ON_PAGE
        )
        yield relative(
            f"64 disks, {sampling}: mean of the largest of 24 is off by, standard deviations", largest, written[1], 0.1, ON_PAGE
        )
    many = mistuned_population(
        lumped_blisk("W"), hertz(140.0, 156.0), 12, Scatter(blade=0.003), force=0.4, harmonics=3, samples=96
    ).dataset
    amplification = many.amplification.values
    yield on_page("12 lumped disks of 0.3 % blade scatter, amplification, mean", amplification.mean(), 1.18, 2)
    yield on_page("12 lumped disks of 0.3 % blade scatter, amplification, largest", amplification.max(), 1.31, 2)
    asked = {"force": 0.3, "harmonics": 1, "samples": 96, "peak_tolerance": 1e-3, "run_in": True, "quantity": "mobility"}
    few = mistuned_population(octopus_blisk(), hertz(142.0, 148.0), 2, Scatter(blade=0.01), **asked).dataset
    for sample, (highest, ratio) in enumerate(((0.0851, 1.003), (0.0854, 1.006))):
        name = f"Finite elements, mistuned by 1 %, disk {sample + 1}, 0.3 N"
        yield on_page(f"{name}, highest mobility of all blades, m/s/N", few.blade_peak.values[sample].max(), highest, 4)
        yield on_page(f"{name}, amplification", few.amplification.values[sample], ratio, 3)


def meshed() -> Iterator[Row]:
    stuck = {factor: octopus_blisk(kty=factor * 1.7e7).frequencies(stuck=True)[0] for factor in (0.1, 1.0, 10.0)}
    for factor, published, tolerance in ((0.1, 143.8, 1.5e-2), (1.0, 144.9, 1e-3), (10.0, 150.3, 1.5e-2)):
        yield relative(f"Finite elements, stuck, k_ty = {factor:g} k_tx, Hz", stuck[factor], published, tolerance, PAPER)
    analytic = octopus_blisk("analytic").frequencies(stuck=True)[0]
    yield at_most("Measured over analytic stuck frequency (published: below 1/1.5)", stuck[1.0] / analytic, 1.0 / 1.5, PAPER)
    formulas = [octopus_blisk(normal_stiffness=name).frequencies(stuck=True)[0] for name in NORMAL_STIFFNESS]
    yield at_most("Spread over three formulas of k_n, relative (published: below 1.5 %)", np.ptp(formulas) / 144.9, 1.5e-2, PAPER)
    disk = octopus_blisk()
    yield relative("Mobility of the stuck peak, m/s/N (fitted)", mobility(disk, stuck[1.0], 1e-6, 1), 0.531, 5e-3, PAPER)
    q = [
        {"x": 1.0, "y": -1.0j}.get(dof[-1], 0.0) if "mode" not in dof and ".r" not in dof else 0.0 for dof in disk.structure.dofs
    ]
    moved = float(np.abs(disk.systems.relative_rows(1) @ np.array(q)).max())
    yield at_most("Relative motion at the dampers under a rigid translation, relative", moved, 1e-12, "closed form")


def predicted() -> Iterator[Row]:
    """What the fitted disk says beside the paper, stuck and without dampers."""
    base, analytic = octopus_blisk(), octopus_blisk("analytic")
    spread = [float(formula(LINE, static_normal_load(147.0, 20.0))) for formula in NORMAL_STIFFNESS.values()]
    yield on_page(
        "Three formulas of k_n at 20°: largest over smallest, less 1, %", 100.0 * (max(spread) / min(spread) - 1.0), 6.7, 1
    )
    unknowns = BliskSector().sector().solid.K.shape[0]
    yield on_page("Finite elements, unknowns a sector", unknowns, 4428, 0)
    whole = base.full()
    yield on_page("Finite elements, unknowns of the reduced whole disk", len(whole.structure.dofs), 1416, 0)
    yield on_page("Finite elements, contact points of the whole disk", len(whole.contacts), 240, 0)
    fine = octopus_blisk(modes=60).frequencies(stuck=True)[0]
    stuck, high = base.frequencies(stuck=True)[0], analytic.frequencies(stuck=True)[0]
    yield at_most("Finite elements, 20 against 60 fixed-interface modes, relative", stuck / fine - 1.0, 1e-6, "60 modes")
    yield on_page("Finite elements, stuck, analytic set, Hz", high, 239.4, 1)
    yield on_page("Finite elements, stuck, analytic set over measured set, less 1", high / stuck - 1.0, 0.65, 2)
    yield on_page("Finite elements, without dampers, Hz", base.modes(2, stuck=False).frequencies[6], 126.74, 2)
    for name, changed, written in (
        ("k_tx of the analytic set alone", octopus_blisk(ktx=5.71e8), 230.8),
        ("k_ty of the analytic set alone", octopus_blisk(kty=6.07e8), 149.9),
        ("platform angle 10°", octopus_blisk(platform_angle=10.0), 143.7),
    ):
        yield on_page(f"Finite elements, stuck, {name}, Hz", changed.frequencies(stuck=True)[0], written, 1)
    for stagger, softer, stiffer in ((15.0, -0.7, 1.3), (25.0, -1.7, 2.8), (30.8, -2.4, 3.7)):
        soft, middle, stiff = (octopus_blisk(stagger=stagger, kty=f * 1.7e7).frequencies(stuck=True)[0] for f in LEVELS.values())
        yield on_page(f"Stagger {stagger:g}°: shift for k_ty = 0.1 k_tx, %", 100.0 * (soft / middle - 1.0), softer, 1)
        yield on_page(f"Stagger {stagger:g}°: shift for k_ty = 10 k_tx, %", 100.0 * (stiff / middle - 1.0), stiffer, 1)
    for whose, frequencies, written in (
        ("published", (143.8, 144.9, 150.3), 9.9),
        ("this disk", tuple(octopus_blisk(kty=f * 1.7e7).frequencies(stuck=True)[0] for f in LEVELS.values()), 1.9),
    ):
        yield on_page(f"Elastic seat in series with k_ty over k_tx, {whose}", seat(*frequencies), written, 1)
    for angle, force, load, ratio in ((10.0, 0.2, 76.3, 0.08), (20.0, 0.2, 80.0, 0.19), (20.0, 0.4, 80.3, 0.20)):
        found = near_stuck(octopus_blisk(platform_angle=angle), force, 3)
        name = f"platform angle {angle:g}°, {force:g} N"
        yield on_page(f"Mean normal load, {name}, N", found.mean_load, load, 1)
        yield on_page(f"First harmonic of N over the mean, {name}", found.load / found.mean_load, ratio, 2)


def axial_stiffness() -> Iterator[Row]:
    """k_ty stuck and in slip: frequency and height of the mobility's peak for 0.1, 1 and 10 k_tx."""
    disks = {name: octopus_blisk(kty=factor * 1.7e7) for name, factor in LEVELS.items()}
    stuck = [disk.frequencies(stuck=True) for disk in disks.values()]
    high = [mobility(disk, each[0], 1e-6, 1) for disk, each in zip(disks.values(), stuck, strict=True)]
    for name, value, written in zip(LEVELS, high, (0.526, 0.531, 0.537), strict=True):
        yield on_page(f"Stuck mobility, k_ty = {name} k_tx, m/s/N", value, written, 3)
    seen = [across_the_section(disk) for disk in disks.values()]
    turned = [direction(disk) for disk in disks.values()]
    for name, value, angle, written in zip(LEVELS, seen, turned, ((0.538, 32.3), (0.531, 31.4), (0.520, 29.7)), strict=True):
        yield on_page(f"Mobility across the section, k_ty = {name} k_tx, scaled to 0.531", 0.531 * value / seen[1], written[0], 3)
        yield on_page(f"Motion off the tangent, k_ty = {name} k_tx, degrees", angle, written[1], 1)
    for mode, written in enumerate((4.6, 2.9, 0.0, 68.2)):
        yield on_page(
            f"Stuck mode {mode + 1}: 10 k_tx over 0.1 k_tx, less 1, %",
            100.0 * (stuck[2][mode] / stuck[0][mode] - 1.0),
            written,
            1,
        )
    yield on_page("Stuck mobility: 10 k_tx over 0.1 k_tx, less 1, %", 100.0 * (high[2] / high[0] - 1.0), 2.1, 1)
    yield on_page("Table 1 of the paper: frequency, largest over smallest, less 1, %", 100.0 * (150.3 / 143.8 - 1.0), 4.5, 1)
    yield on_page("Table 1 of the paper: mobility, largest over smallest, less 1, %", 100.0 * (0.548 / 0.528 - 1.0), 3.8, 1)
    for force, harmonics, frequency, height in SLIP:
        found = [near_stuck(disk, force, harmonics) for disk in disks.values()]
        name = f"Slip at {force:g} N: 10 k_tx over 0.1 k_tx, less 1"
        yield on_page(f"{name}, frequency, %", 100.0 * (found[2].frequency / found[0].frequency - 1.0), frequency, 1)
        yield on_page(f"{name}, mobility, %", 100.0 * (found[2].value / found[0].value - 1.0), height, 1)
        if force < 0.5:
            for factor, one in zip(LEVELS, found, strict=True):
                yield at_most(
                    f"Slip at {force:g} N, k_ty = {factor} k_tx: share of the period in slip along the axis",
                    one.axial,
                    0.0,
                    ON_PAGE,
                )
                yield at_most(
                    f"Slip at {force:g} N, k_ty = {factor} k_tx: share of the period in slip across it", one.across, 0.13, ON_PAGE
                )
                yield at_most(
                    f"Slip at {force:g} N, k_ty = {factor} k_tx: stuck frequency over the peak's, less 1",
                    disks[factor].frequencies(stuck=True)[0] / one.frequency - 1.0,
                    0.003,
                    ON_PAGE,
                )


def responses() -> Iterator[Row]:
    """Figures 8 and 11 to 14: the highest mobility with both sets."""
    for kind, table in CURVES.items():
        disk = octopus_blisk(kind)
        for (force, harmonics), (frequency, height) in table.items():
            highest = near_stuck(disk, force, harmonics)
            yield on_page(f"{kind} set, {force:g} N, H = {harmonics}: highest mobility, m/s/N", highest.value, height, 4)
            yield on_page(f"{kind} set, {force:g} N, H = {harmonics}: its frequency, Hz", highest.frequency, frequency, 1)


CURVES = {
    "measured": {
        (0.2, 1): (144.8, 0.1248),
        (0.2, 3): (144.8, 0.1237),
        (0.2, 5): (144.8, 0.1230),
        (0.3, 1): (144.8, 0.0849),
        (0.3, 3): (144.8, 0.0840),
        (0.3, 5): (144.8, 0.0832),
        (0.4, 1): (144.7, 0.0645),
        (0.4, 3): (144.7, 0.0637),
        (0.4, 5): (144.7, 0.0632),
    },
    "analytic": {
        (0.2, 1): (239.2, 0.0198),
        (0.2, 3): (239.2, 0.0192),
        (0.2, 5): (239.3, 0.0189),
        (0.3, 1): (239.0, 0.0136),
        (0.3, 3): (239.2, 0.0130),
        (0.3, 5): (239.2, 0.0127),
        (0.4, 1): (238.7, 0.0104),
        (0.4, 3): (239.0, 0.0099),
        (0.4, 5): (239.2, 0.0096),
    },
}
"""Frequency [Hz] and highest mobility [m/s/N] by force [N] and harmonics."""
SLIP = ((0.2, 3, 4.6, -8.0), (0.3, 3, 4.6, -7.5), (0.4, 3, 4.6, -6.7), (0.8, 1, 4.6, -6.8))
"""Force [N], harmonics, change of frequency and of height of the highest mobility [%]."""


def rotating() -> Iterator[Row]:
    written = {0: (126.74, 144.90), 25: (128.91, 146.86), 50: (135.18, 152.56), 75: (144.87, 161.45), 100: (157.16, 172.88)}
    for turns, (free, stuck) in written.items():
        disk = octopus_blisk(rotation=float(turns))
        yield on_page(f"{turns} turns a second, without dampers, Hz", disk.modes(2, stuck=False).frequencies[6], free, 2)
        yield on_page(f"{turns} turns a second, stuck, Hz", disk.frequencies(stuck=True)[0], stuck, 2)


@dataclass(frozen=True)
class Peak:
    """The highest point of a curve: frequency [Hz], value, the shares of the period that its contacts slip, and the normal load
    of the first of two lines: mean and first harmonic [N].
    """

    frequency: float
    value: float
    across: float
    axial: float
    mean_load: float
    load: float


def peak(
    disk: TunedDisk, band: tuple[float, float], force: float, harmonics: int, quantity: str = "mobility", samples: int = 96
) -> Peak:
    """The highest peak of the first output's first harmonic."""
    found = forced_response(disk, hertz(*band), force, harmonics, samples, quantity=quantity).dataset
    highest = int(np.nanargmax(found.peak_amplitude.values[0, :, 0]))
    frequency = float(found.peak_frequency[0, highest, 0])
    nearest = int(np.nanargmin(np.abs(found.frequency.values[0] - frequency)))
    shares, forces = found.share_slip.values[0, nearest], found.contact_force.values[0, nearest]
    axial = float(shares[:, 1].max()) if shares.shape[1] == 3 else 0.0
    line = forces[: len(forces) // 2, -1].sum(axis=0)
    value = float(found.peak_amplitude[0, highest, 0])
    return Peak(frequency, value, float(shares[:, 0].mean()), axial, float(line[0, 0]), float(np.hypot(*line[1])))


def near_stuck(disk: TunedDisk, force: float, harmonics: int) -> Peak:
    """The highest mobility, 4 Hz below to 1.5 Hz above the first stuck frequency."""
    stuck = float(disk.frequencies(stuck=True)[0])
    return peak(disk, (stuck - 4.0, stuck + 1.5), force, harmonics)


def seat(soft: float, middle: float, stiff: float) -> float:
    """k*/k_tx of f² = f₀² + Δ k_ty/(k_ty + k*) through the frequencies for k_ty = 0.1, 1 and 10 k_tx."""
    wanted = (stiff**2 - middle**2) / (middle**2 - soft**2)

    def excess(k: float) -> float:
        share = [f / (f + k) for f in LEVELS.values()]
        return (share[2] - share[1]) / (share[1] - share[0]) - wanted

    return float(brentq(excess, 1e-2, 1e3))


def solved(problem: Problem, frequency: float, force: float, harmonics: int = 5) -> tuple[HarmonicBalance, Evaluation]:
    """The balance and the solution at one frequency, 384 samples."""
    balance = HarmonicBalance(problem, harmonics, 384)
    return balance, first_point(balance, 2.0 * np.pi * frequency, force).evaluation


def output(problem: Problem, frequency: float, force: float, harmonics: int) -> np.ndarray:
    """Harmonics of the first output, in real storage."""
    balance, evaluation = solved(problem, frequency, force, harmonics)
    return np.asarray(evaluation.w[balance.rows])


def mobility(problem: TunedDisk, frequency: float, force: float, harmonics: int = 5) -> float:
    """|X_1| ω/F of the first output."""
    row = output(problem, frequency, force, harmonics)
    return float(np.hypot(row[1], row[2]) * 2.0 * np.pi * frequency / force)


def tip_motion(disk: TunedDisk) -> np.ndarray:
    """First stuck mode at the tip, real and imaginary part in rows."""
    names, shape = disk.structure.dofs, disk.modes(disk.engine_order).shapes[:, 0]
    tip = shape[[names.index(f"tip.{axis}") for axis in "xyz"]]
    return np.stack([tip.real, tip.imag])


def direction(disk: TunedDisk) -> float:
    """Angle between the motion of the tip in the first stuck mode and the tangent, seen along the radius, degrees."""
    along = np.linalg.svd(tip_motion(disk))[2][0]
    return float(np.degrees(np.arctan2(abs(along[2]), abs(along[1]))))


def across_the_section(disk: TunedDisk) -> float:
    """|φ·e|²/(2ζω φᴴMφ) of the first stuck mode at the tip, m/s/N with ζ = 1: e the direction of its motion there."""
    modes = disk.modes(disk.engine_order)
    shape, M = modes.shapes[:, 0], disk.systems.matrices(disk.engine_order).M
    square = np.linalg.svd(tip_motion(disk), compute_uv=False)[0] ** 2
    return float(square / (4.0 * np.pi * modes.frequencies[0] * (shape.conj() @ M @ shape).real))
