"""Contact law, stiffness and friction from the measured loops of one contact: over all loops, and cycle by cycle.

What a contact law from loops is given as: the result, its dataset, and the answer in sentences.

What to check before a contact law from loops is used: little slip, a poor fit, a lag, whose stiffness it is, wear.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.analyses.settings import takes
from stickslip.laboratory.identification.contact_law import fit
from stickslip.laboratory.identification.contact_law.fit import ContactLoop, force_lag, force_of, interval, work_along
from stickslip.laboratory.identification.least_squares import CERTAINTY, CLOSE
from stickslip.laboratory.measurement.contact_cycles import ContactCycles, contact_cycles, smoothed_motion
from stickslip.laboratory.measurement.contact_record import ContactRecord, read_contact_records
from stickslip.laboratory.measurement.cycles import synthesis
from stickslip.model.contact.law import LoadDependentFriction
from stickslip.results.schema import Result, named, stacked, tabulated
from stickslip.runs.cases import Arrays
from stickslip.support.checks import Array, Index, InputError, counted, fault, finite, nearest, positive, rounded, vector
from stickslip.support.late import xr

PLATEAU = 0.1
"""Share of a cycle that lies above the plateau of the force, and below the other one: smoothing overshoots at their corners."""


@dataclass(frozen=True)
class LawFit:
    """One law fitted to all loops: kt [N/m], mu, shape parameters; standard errors of kt and mu (relative) and of the shape;
    misfit and error on loops held out, both relative to the rms of the forces.

    The errors hold the scatter and misfit of the loops and the gains and zeros of `LoopErrors`.
    """

    law: str
    kt: float
    mu: float
    shape: tuple[float, ...]
    errors: tuple[float, ...]
    misfit: float
    held_out: float

    @property
    def theta(self) -> Array:
        """The parameters (ln kt, ln mu, shape)."""
        return np.array([np.log(self.kt), np.log(self.mu), *self.shape])

    @property
    def kt_interval(self) -> tuple[float, float]:
        """95 % interval of kt [N/m]."""
        return interval(self.kt, self.errors[0])

    @property
    def mu_interval(self) -> tuple[float, float]:
        """95 % interval of mu."""
        return interval(self.mu, self.errors[1])


@dataclass(frozen=True, eq=False, repr=False)
class ContactLaw(Result):
    """best: the law that is chosen; fits {law: `LawFit`} of all; loops: what they were fitted to, after all corrections; removed:
    what was taken from the records on the way; warnings: what to check. One sentence each.

    `dataset` holds, SI: of each law `kt`, `kt_interval`, `mu`, `mu_interval`, `misfit`, `held_out`; of each cycle
    `cycle_number`, `cycle_kt`, `cycle_mu`, their `_error` (one standard deviation, scatter and misfit alone), `plateau` (half the
    distance of the 10 and 90 % quantiles of the force, over the normal load), `energy_measured` and `energy_fitted`; of each
    loop `displacement`, `force_measured` and `force_fitted` of the chosen law.
    """

    best: str
    fits: Mapping[str, LawFit]
    loops: tuple[ContactLoop, ...]
    removed: tuple[str, ...]
    warnings: tuple[str, ...]
    dataset: xr.Dataset

    @property
    def kt(self) -> float:
        """Tangential stiffness of the chosen law [N/m]."""
        return self.fits[self.best].kt

    @property
    def mu(self) -> float:
        """Friction coefficient of the chosen law."""
        return self.fits[self.best].mu

    @property
    def friction(self) -> LoadDependentFriction:
        """Coefficient over the normal load, of the chosen law; needs `friction_over`."""
        if "friction" not in self.dataset:
            raise fault("friction over the load", "must have been asked for", "without friction_over")
        return LoadDependentFriction(*(tuple(self.dataset[name].values.tolist()) for name in ("friction_load", "friction")))


def contact_law_dataset(
    work: ContactLawWork, fits: Mapping[str, LawFit], best: str, cycles: tuple[Array, Array], least_mu: float | None
) -> xr.Dataset:
    """The labelled result; see `ContactLaw`. cycles: parameters and errors of each; least_mu: where mu is only bounded."""
    (theta, errors), single = cycles, work.single
    ends = [np.quantile(np.asarray(loop.force), (PLATEAU, 1.0 - PLATEAU)) for loop in single]
    plateau = [0.5 * float(high - low) / loop.load for (low, high), loop in zip(ends, single, strict=True)]
    fitted = [force_of(loop, best, row[np.isfinite(row)]) for loop, row in zip(single, theta, strict=True)]
    fitted_energy = [work_along(np.asarray(loop.displacement), force) for loop, force in zip(single, fitted, strict=True)]
    cycle_kt, cycle_mu = np.exp(theta[:, 0]), np.exp(theta[:, 1]) * (1.0 if least_mu is None else np.nan)
    forces = [np.asarray(loop.force) for loop in work.loops]
    of_laws = ("kt", "kt_interval", "mu", "mu_interval", "misfit", "held_out")
    variables: dict[str, Any] = {key: [getattr(fit, key) for fit in fits.values()] for key in of_laws}
    variables |= {
        "cycle_number": work.numbers,
        "cycle_kt": cycle_kt,
        "cycle_kt_error": cycle_kt * errors[:, 0],
        "cycle_mu": cycle_mu,
        "cycle_mu_error": cycle_mu * errors[:, 1],
        "plateau": plateau,
        "energy_measured": [one.energy for one in single],
        "energy_fitted": fitted_energy,
        "displacement": stacked([loop.displacement for loop in work.loops]),
        "force_measured": stacked([one - one.mean() for one in forces]),
        "force_fitted": stacked([force_of(loop, best, fits[best].theta) for loop in work.loops]),
    }
    if any(fit.shape for fit in fits.values()):
        variables["spread"] = [fit.shape[0] if fit.shape else np.nan for fit in fits.values()]
    coords = {"law": list(fits), "bound": ["low", "high"], "loop": [loop.name for loop in work.loops]}
    about = {"title": "Law of a contact", "best": best, "summary": work.summary, "removed": "\n".join(work.removed)}
    return tabulated("contact_law", variables, coords, about | ({} if least_mu is None else {"least_mu": least_mu}))


def with_friction(dataset: xr.Dataset, friction: Array, exponent: Array) -> xr.Dataset:
    """The dataset with coefficients over the load: load, value and relative error (3, loads); exponent and its error (2,)."""
    load, mu, errors = friction
    bounds = np.array([interval(value, error) for value, error in zip(mu, errors, strict=True)])
    words = "friction coefficient over the normal load"
    exponents = [exponent[0] + side * CERTAINTY * exponent[1] for side in (-1.0, 1.0)]
    return dataset.assign(
        friction=named("friction_load", mu, words),
        friction_interval=named(("friction_load", "bound"), bounds, f"95 % interval of the {words}"),
        exponent=named((), exponent[0], "exponent of the power of the load that friction follows best"),
        exponent_interval=named("bound", exponents, "95 % interval of the exponent"),
    ).assign_coords(friction_load=named("friction_load", load, "normal load", "N"))


def sentences(dataset: xr.Dataset) -> list[str]:
    """The answer in a few lines: parameters, energy, cycles, other laws, what was removed, warnings."""
    best = str(dataset.attrs["best"])
    own = dataset.sel(law=best)
    kt, mu = 1e-6 * float(own["kt"]), float(own["mu"])
    low, high = 1e-6 * own["kt_interval"].values
    measured, fit = (float(dataset[name].mean()) for name in ("energy_measured", "energy_fitted"))
    unit, factor = ("mJ", 1e3) if measured >= 1e-4 else ("uJ", 1e6)
    energies = f"{factor * measured:.4g} {unit} measured, {factor * fit:.4g} {unit} fitted, in the mean"
    lines = [
        f"{best}: kt = {kt:.4g} N/µm, 95 % between {low:.4g} and {high:.4g}; "
        + (
            f"mu ≥ {float(dataset.attrs['least_mu']):.4g}, the contact hardly slips"
            if "least_mu" in dataset.attrs
            else f"mu = {mu:.4g}, 95 % between {float(own['mu_interval'][0]):.4g} and {float(own['mu_interval'][1]):.4g}"
        ),
        f"misfit {_misfits(own)}; energy per cycle {energies}",
        str(dataset.attrs["summary"]),
    ]
    if "friction" in dataset:
        pairs = zip(dataset["friction"].values, dataset["friction_load"].values, strict=True)
        low, high = dataset["exponent_interval"].values
        coefficients = ", ".join(f"{value:.4g} at {load:.4g} N" for value, load in pairs)
        lines.append(
            f"mu over the normal load: {coefficients}; about as N to the {float(dataset['exponent']):.3g}, "
            f"95 % {low:.3g} to {high:.3g}"
        )
    others = [law for law in dataset["law"].values if law != best]
    if others:
        listed = (f"{law} {_misfits(dataset.sel(law=law))}" for law in others)
        lines.append(f"other laws, misfit: {'; '.join(listed)}")
    if dataset.sizes["cycle"] > 1:
        lines.append(_over_cycles(dataset))
    removed = str(dataset.attrs["removed"]).splitlines()
    lines += [" ".join(removed)] if removed else []
    return [*lines, *(f"Warning: {line}" for line in str(dataset.attrs["warnings"]).splitlines())]


def _misfits(own: xr.Dataset) -> str:
    held_out = float(own["held_out"])
    without = "" if np.isnan(held_out) else f" ({100.0 * held_out:.1f} % on loops held out)"
    return f"{100.0 * float(own['misfit']):.1f} %{without}"


def _over_cycles(dataset: xr.Dataset) -> str:
    """Friction and stiffness in the first and the last cycle."""
    ends = dataset.isel(cycle=[0, -1])
    first, last = (int(number) for number in ends["cycle_number"].values)
    mu, kt, plateau = (ends[name].values * factor for name, factor in (("cycle_mu", 1.0), ("cycle_kt", 1e-6), ("plateau", 1.0)))
    friction = "" if "least_mu" in dataset.attrs else f"mu {mu[0]:.4g} to {mu[1]:.4g}, "
    return (
        f"from cycle {first} to {last} ({counted(dataset.sizes['cycle'], 'fit')}): {friction}"
        f"kt {kt[0]:.4g} to {kt[1]:.4g} N/µm, plateau over load {plateau[0]:.4g} to {plateau[1]:.4g}"
    )


TRAVEL = 3e-6
"""Elastic travel mu N/kt [m] from which kt is likely the rig's. In Hertzian contact it is at most the approach of the bodies, in
rough contact about the height of the roughness: about 1 µm or less for metals."""

SLIPS = 0.1
"""Energy of a loop over that of slip all the way below which mu is a lower bound."""

POOR, WIDE = 0.1, 0.2
"""Misfit from which a law is called poor; relative half width of an interval from which a parameter is hardly known."""

LOADS_APART = 1.5
"""Ratio of the largest to the smallest normal load from which kt at both is compared."""

LAGS = 0.35
"""Sum of squares of the residuals with a lag over that without below which a lag is named. A law that lacks the shape of the
loops leaves 0.4 or more; a lag of 0.5 % of the period, which moves kt by 7 %, 0.25 with noise of 5 % of the amplitude."""

CHANGE = 0.1
"""Relative change of mu or kt over the cycles from which one value for all is a mean."""


def share_in_slip(loop: ContactLoop, mu: float) -> float:
    """Energy of a loop over 4 mu N A, that of a contact which slips all the way."""
    return loop.energy / (4.0 * mu * loop.load * loop.amplitude)


def least_friction(work: ContactLawWork, mu: float) -> float | None:
    """Where no loop shows the friction coefficient, its lower bound: the largest friction force over the normal load."""
    if max(share_in_slip(loop, mu) for loop in work.loops) >= SLIPS:
        return None
    return max(loop.friction / loop.load for loop in work.loops)


def warnings_about(work: ContactLawWork, fit: LawFit, dataset: xr.Dataset) -> list[str]:
    """What to check before the result is used."""
    found, least = [], dataset.attrs.get("least_mu")
    bounded = least is not None
    if bounded:
        slipping = max(share_in_slip(loop, fit.mu) for loop in work.loops)
        found.append(
            f"The contact hardly slips: no loop dissipates more than {max(slipping, 0.0):.0%} of what mu N would. "
            f"mu is a lower bound then, whatever its interval: mu ≥ {least:.4g}, the largest friction force over "
            "the normal load. Measure with larger amplitudes or a smaller normal load."
        )
    if fit.misfit > POOR:
        found.append(f"The {fit.law} law misses the loops by {fit.misfit:.0%} of their rms force.")
    found += _lagging(work, fit)
    travel = (fit.mu if least is None else float(least)) * np.mean([loop.load for loop in work.loops]) / fit.kt
    if travel > TRAVEL and work.rig_stiffness is None:
        how = "yields elastically by F/kt" if bounded else "would yield elastically by mu N/kt"
        how += f" = {1e6 * travel:.3g} um{' at the largest friction force' if bounded else ''}"
        found.append(
            f"kt is likely the rig's: the contact {how}, contacts of metals "
            f"yield by about 1 um or less. Measure the displacement nearer to the contact, or give the rig's stiffness "
            f"(rig_stiffness, measured with the contact locked). mu and the energy in gross slip hardly depend on it."
        )
    motion = 2.0 * max(loop.amplitude for loop in work.loops)
    harmonics = work.loops[0].harmonics
    if harmonics is not None and 2.0 * harmonics * travel < motion:
        found.append(
            f"The contact sticks over {2e6 * travel:.3g} um of {1e6 * motion:.3g} um: {harmonics} harmonics hardly resolve kt. "
            "Smaller amplitudes show it better."
        )
    for name, (low, high), value in (("kt", fit.kt_interval, fit.kt), ("mu", fit.mu_interval, fit.mu)):
        if name == "mu" and bounded:
            continue
        if high - low > 2.0 * WIDE * value:
            found.append(f"{name} is hardly known: its 95 % interval is {0.5 * (high - low) / value:.0%} wide to either side.")
    found += _over_loads(work, dataset["cycle_kt"].values)
    if len(work.single) > 2:
        loads = [loop.load for loop in work.single]
        apart = max(loads) > LOADS_APART * min(loads)
        for name, values in (("mu", dataset["cycle_mu"].values), ("kt", dataset["cycle_kt"].values)):
            if name == "mu" and work.friction_over is not None:
                continue
            part = max(len(values) // 10, 1)
            first, last = float(np.mean(values[:part])), float(np.mean(values[-part:]))
            if abs(last - first) > CHANGE * first:
                unit, factor = ("", 1.0) if name == "mu" else (" N/µm", 1e-6)
                found.append(
                    f"{name} changes from {factor * first:.4g} ({_which(work.numbers[:part])}) to {factor * last:.4g}{unit} "
                    f"({_which(work.numbers[-part:])}): one value for all is a mean."
                    + (" The loads differ: friction_over finds mu over the load." if name == "mu" and apart else "")
                )
    if work.compared is not work.loops:
        found.append("Friction changes between loops: laws are compared with the load of each loop scaled to its plateau.")
    return found


def _which(numbers: Index) -> str:
    """The cycles of a mean, in words."""
    first, last = int(numbers[0]), int(numbers[-1])
    return f"cycle {first}" if first == last else f"mean of cycles {first} to {last}"


def _lagging(work: ContactLawWork, fit: LawFit) -> list[str]:
    """Whether the force comes later than a contact lets it, and what kt would be without."""
    shown = force_lag(work.loops, fit.law, fit.theta)
    if shown.left > LAGS:
        return []
    late = "late" if shown.lag > 0.0 else "early"
    return [
        f"The force comes {abs(shown.lag):.2%} of a period too {late} for a contact, which sticks at each reversal: with it in "
        f"time the {fit.law} law has kt = {1e-6 * shown.kt:.4g} N/µm. A force that is saturated looks "
        f"the same. Record both with one filter, or give lag = {shown.lag:.4f}."
    ]


def _over_loads(work: ContactLawWork, kt: Array) -> list[str]:
    """What kt at different normal loads says about whose it is: a contact's grows with the load, a rig's does not."""
    loads = np.array([loop.load for loop in work.single])
    if loads.max() < LOADS_APART * loads.min():
        return []
    middle = np.sqrt(loads.min() * loads.max())
    low, high = (float(np.median(kt[side])) for side in (loads < middle, loads >= middle))
    about = f"kt is {rounded(1e-6 * low, 3)} N/µm around {rounded(float(np.median(loads[loads < middle])), 4)} N and "
    about += f"{rounded(1e-6 * high, 3)} N/µm around {np.median(loads[loads >= middle]):.4g} N"
    if abs(high - low) < CHANGE * low and work.rig_stiffness is None:
        return [f"kt is likely the rig's: {about}; that of a contact grows with the normal load."]
    return [f"One kt for all loads is a mean: {about}. Fit each load by itself."] if abs(high - low) >= CHANGE * low else []


EXACT = 3e-3
"""Held-out errors below this are those of smoothing and sampling, and do not distinguish laws."""

SAMPLES = 400
"""Of a smoothed loop, at least."""

MEAN_LOOPS = 6
"""Loops to which many cycles are averaged before the fit: enough to hold out one, few enough to average noise."""

SAME_LEVEL = 1.2
"""Ratio of amplitudes or normal loads up to which cycles are averaged."""

WEAR = 0.05
"""Range of the plateaux of like loops, relative to their mean, from which laws are compared with wear made up for."""

MOST_CYCLES = 200
"""Cycles that are fitted one by one; more are averaged in groups of neighbours."""

SOFTEST_RIG = 1.05
"""A rig must be stiffer than rig and contact together, at least by this factor: nearer, their difference is noise."""

STIFFEST_RIG = 1e3
"""A rig this many times as stiff as the loops moves kt by less than a thousandth: its unit is likely another one."""

Source = str | Path | ContactRecord | fit.ContactLoop | ContactCycles
"""What loops come from."""


@dataclass(frozen=True, eq=False)
class ContactLawWork:
    """The fits of a contact law as work of one case. loops: for the fit of all laws; single: for the chosen law cycle by cycle,
    with the number of each cycle."""

    loops: tuple[fit.ContactLoop, ...]
    _: KW_ONLY
    single: tuple[fit.ContactLoop, ...]
    numbers: Index
    laws: tuple[str, ...]
    rig_stiffness: float | None
    errors: fit.LoopErrors
    removed: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    summary: str = ""
    friction_over: tuple[float, ...] | None = None
    words: Sequence[str] = ("contact law",)

    @property
    def names(self) -> Sequence[str]:
        """Equal names mean equal results."""
        data = b"".join(
            np.asarray(part).tobytes() for loop in self.single for part in (loop.displacement, loop.force, loop.normal)
        )
        settings = (self.laws, self.rig_stiffness, self.errors, *([] if self.friction_over is None else [self.friction_over]))
        return (f"contact law {sha256(data + repr(settings).encode()).hexdigest()[:12]}",)

    @property
    def load(self) -> float:
        """Mean normal load [N]."""
        return float(np.mean([loop.load for loop in self.loops]))

    def changed(self, change: Callable[[fit.ContactLoop], fit.ContactLoop], said: str, *notes: str) -> ContactLawWork:
        """A copy with every loop changed, and what is said of it."""
        loops, single = (tuple(map(change, several)) for several in (self.loops, self.single))
        return replace(self, loops=loops, single=single, removed=(*self.removed, said), notes=(*self.notes, *notes))

    def in_time(self, lag: float) -> ContactLawWork:
        """A copy whose forces are earlier by a share of the period."""
        if abs(lag) > fit.LONGEST:
            raise fault("lag", f"must be between {-fit.LONGEST:g} and {fit.LONGEST:g} of a period", lag)
        if lag == 0.0:
            return self
        said = f"The force is taken {lag:.2%} of a period earlier than recorded."
        return self.changed(lambda loop: replace(loop, force=fit.advanced(np.asarray(loop.force), lag)), said)

    def with_friction(self, load: Array, friction: Array) -> ContactLawWork:
        """A copy whose loops have the loads under which the coefficient of the mean load gives the same friction."""
        mean = float(np.interp(self.load, load, load * friction)) / self.load
        return replace(self, loops=tuple(fit.under_friction(loop, load, friction / mean) for loop in self.loops))

    def corrected(self) -> ContactLawWork:
        """A copy whose displacements are those of the contact alone, u − F/k_rig, without what the rig yields."""
        rig = self.rig_stiffness
        if rig is None:
            return self
        together = float(np.exp(fit.fitted(self.loops, "jenkins").x[0]))
        if rig < SOFTEST_RIG * together:
            rule = f"must be above {together:.4g} N/m ({1e-6 * together:.4g} N/µm), the stiffness of rig and contact together"
            remedy = "Is its unit N/m (N/µm with --rig-stiffness), and is it of the place where the displacement was measured?"
            raise fault("rig_stiffness", rule, rig, remedy)
        said = f"The displacement is corrected by force over the rig's stiffness, {1e-6 * rig:.4g} N/µm; "
        said += f"without it the jenkins law has kt = {1e-6 * together:.4g} N/µm."
        notes = []
        if rig > STIFFEST_RIG * together:
            how = f"The rig's stiffness, {rig:.4g} N/m ({1e-6 * rig:.4g} N/µm), is {rig / together:.2g} times that of the loops"
            notes.append(f"{how} and corrects nothing. Is its unit N/m (N/µm with --rig-stiffness)?")

        def without_rig(loop: fit.ContactLoop) -> fit.ContactLoop:
            force = np.asarray(loop.force)
            return replace(loop, displacement=np.asarray(loop.displacement) - (force - force.mean()) / rig)

        return self.changed(without_rig, said, *notes)

    @cached_property
    def compared(self) -> tuple[fit.ContactLoop, ...]:
        """The loops on which laws are compared: where friction changes from one loop to another of like amplitude and load, with
        the load of each scaled to its plateau. Else wear would hide the shape of the law, by which laws differ."""
        ratio, amplitude, load = np.array([(loop.friction / loop.load, loop.amplitude, loop.load) for loop in self.loops]).T
        kinds = _kinds(amplitude, load)
        scale = ratio / np.array([np.mean(ratio[kinds == kind]) for kind in kinds])
        if np.ptp(scale) < WEAR:
            return self.loops
        return tuple(replace(loop, normal=np.asarray(loop.normal) * s) for loop, s in zip(self.loops, scale, strict=True))

    def prepare(self) -> None:
        """Compile the laws."""
        for law in self.laws:
            fit.force_of(self.loops[0], law, np.array([np.log(1e6), np.log(0.3), *[0.5] * fit.LAWS[law][1]]))

    def solve(self, case: int, report: Callable[[float], object]) -> Arrays:
        """Of all laws: parameters and errors (laws, 3), misfit and held-out error (laws, 2); parameters and errors of the chosen
        law cycle by cycle (cycles, 3). With `friction_over` laws are compared at the coefficients of a first fit, their mu being
        that of the mean load; then come load, coefficient, error (3, loads), exponent and its error (2,) by the chosen law."""
        loops, compared = self.loops, self.compared
        if self.friction_over is not None:
            first = fit.friction_over_load(self.loops, self.laws[0], np.array(self.friction_over), self.errors)
            work = self.with_friction(first.load, first.friction)
            loops, compared = work.loops, work.compared
        theta, errors, misfits = (np.full((len(self.laws), count), np.nan) for count in (3, 3, 2))
        for place, law in enumerate(self.laws):
            found, error, *misfits[place] = fit.judged(loops, law, compared)
            theta[place, : found.size], errors[place, : error.size] = found, error
            report(0.8 * (place + 1) / len(self.laws))
        best = self._best(misfits[:, 1])
        start = theta[self.laws.index(best), : 2 + fit.LAWS[best][1]]
        own, own_errors = (np.full((len(self.single), 3), np.nan) for _ in range(2))
        for place, loop in enumerate(self.single):
            one = fit.fitted((loop,), best, start)
            own[place, : start.size], own_errors[place, : start.size] = one.x, fit.standard_errors(one, (loop,), best)
            report(0.8 + 0.2 * (place + 1) / len(self.single))
        arrays = {"theta": theta, "errors": errors, "misfits": misfits, "cycle_theta": own, "cycle_errors": own_errors}
        if self.friction_over is not None:
            load, friction, error, *power = fit.friction_over_load(self.loops, best, np.array(self.friction_over), self.errors)
            arrays |= {"friction": np.stack([load, friction, error]), "exponent": np.array(power)}
        return arrays

    def _best(self, held_out: Array) -> str:
        """The simplest law that loops held out do not contradict."""
        errors = dict(zip(self.laws, held_out, strict=True))
        smallest = max(min(errors.values()), EXACT)
        return next(law for law in fit.LAWS if law in errors and not errors[law] > CLOSE * smallest)

    def contact_law(self, arrays: Arrays | None = None) -> ContactLaw:
        """The result, from the arrays of `solve` if they are there."""
        found = {key: np.asarray(value) for key, value in (arrays or self.solve(0, lambda share: None)).items()}
        fits = {}
        for place, law in enumerate(self.laws):
            theta, error = (found[key][place, : 2 + fit.LAWS[law][1]] for key in ("theta", "errors"))
            kt, mu = map(float, np.exp(theta[:2]))
            whole = self.errors.added_to(error, kt, self.load, self.rig_stiffness)
            fits[law] = LawFit(
                law, kt, mu, (*map(float, theta[2:]),), (*map(float, whole),), *map(float, found["misfits"][place])
            )
        best = self._best(found["misfits"][:, 1])
        work = self if self.friction_over is None else self.with_friction(*found["friction"][:2])
        least = least_friction(work, fits[best].mu)
        dataset = contact_law_dataset(work, fits, best, (found["cycle_theta"], found["cycle_errors"]), least)
        if self.friction_over is not None:
            dataset = with_friction(dataset, found["friction"], found["exponent"])
        said = (*self.notes, *warnings_about(work, fits[best], dataset))
        return ContactLaw(best, fits, self.loops, self.removed, said, dataset.assign_attrs(warnings="\n".join(said)))


def contact_law_work(
    loops: Source | Sequence[Source],
    normal_load: float | None = None,
    *,
    laws: Sequence[str] = fit.FITTED,
    rig_stiffness: float | None = None,
    errors: fit.LoopErrors | None = None,
    harmonics: int | None = None,
    columns: Mapping[str, str | int] | None = None,
    units: Mapping[str, str] | None = None,
    lag: float = 0.0,
    friction_over: Sequence[float] | None = None,
) -> ContactLawWork:
    """The work for the arguments of `contact_law`, checked."""
    laws = (laws,) if isinstance(laws, str) else tuple(laws)
    for law in laws:
        if law not in fit.LAWS:
            raise fault("law", "must be a known one", law, nearest(law, fit.LAWS))
    if not laws or len(set(laws)) < len(laws):
        raise fault("laws", "must be at least one, each once", list(laws))
    rig = None if rig_stiffness is None else positive("rig_stiffness", rig_stiffness)
    several = [loops] if isinstance(loops, Source) else list(loops)
    if not several:
        raise fault("loops", "must be at least one", 0)
    removed: tuple[str, ...] = ("Noise of the displacement is removed by harmonics.",)
    notes: tuple[str, ...] = ()
    if all(isinstance(one, fit.ContactLoop) for one in several):
        mean = single = tuple(_smoothed(one, harmonics) for one in several if isinstance(one, fit.ContactLoop))
        numbers, summary = np.arange(1, len(single) + 1), counted(len(single), "loop")
    else:
        cycles = _cycles(several, normal_load, harmonics, columns, units)
        mean, (single, numbers) = _mean_loops(cycles), _single_loops(cycles)
        removed, notes, summary = cycles.removed, cycles.notes, cycles.summary
    work = ContactLawWork(
        mean,
        single=single,
        numbers=numbers,
        laws=laws,
        rig_stiffness=rig,
        errors=errors or fit.LoopErrors(),
        removed=removed,
        notes=notes,
        summary=summary,
        friction_over=None if friction_over is None else _loads(friction_over),
    )
    if len(work.loops) < 2 and len(laws) > 1:
        remedy = "Measure several cycles or amplitudes, or name one law: laws=['jenkins'] (--law jenkins)."
        raise fault("loops", "must be at least two, to hold one out", len(work.loops), remedy)
    return work.in_time(finite("lag", lag)).corrected()


@takes(contact_law_work)
def contact_law(work: ContactLawWork) -> ContactLaw:
    """Law, tangential stiffness and friction coefficient of one contact from its measured loops, with 95 % intervals.

    loops: files (`read_contact_records` has their formats and takes normal_load [N], columns and units), records, cycles
    (`contact_cycles`), or single loops that are steady already. Many cycles are averaged to a few loops of equal amplitude and
    smoothed to `harmonics`, by default as many as the displacement needs, since its noise makes kt too low and mu too high.

    laws: by default jenkins (one slider), iwan (the half ellipse of a cylinder on a flat), dahl and array (five sliders); also
    possible is valanis, whose shape lies between dahl and jenkins. Each is fitted to all loops, and to all but one to
    predict that one. The simplest law is chosen whose error on loops held out is within
    10 % of the smallest. That needs two loops or cycles; a single law is fitted to one, with a held-out error of NaN.

    rig_stiffness: N/m, of what lies between the displacement sensor and the contact, in series with it. The displacement of the
    contact is then u − F/rig_stiffness, so that 1/kt = 1/kt_measured − 1/rig_stiffness. errors: what loops cannot show, for the
    intervals. lag: share of a period by which the force is recorded later than the displacement; it is taken away first.
    friction_over: normal loads [N] at which the coefficient is found, from loops at several loads or under a load that varies;
    between them the slip limit is straight. `ContactLaw.friction` is then what `mu` of a law may be, and the dataset has
    `friction` with its intervals over `friction_load` and the exponent of the power of the load that it follows best; mu of each
    law is then the coefficient at the mean load.
    Raises `InputError` for wrong input and for a rig softer than rig and contact together.
    """
    return work.contact_law()


def _loads(friction_over: Sequence[float]) -> tuple[float, ...]:
    """At least two loads in ascending order."""
    loads = vector("friction_over", friction_over)
    if loads.size < 2 or np.any(np.diff(loads) <= 0.0) or loads[0] <= 0.0:
        raise fault("friction_over", "must be two or more positive loads in ascending order", loads.tolist())
    return tuple(map(float, loads))


def _cycles(
    several: Sequence[Source],
    normal_load: float | None,
    harmonics: int | None,
    columns: Mapping[str, str | int] | None,
    units: Mapping[str, str] | None,
) -> ContactCycles:
    """The cycles of files or records."""
    if len(several) == 1 and isinstance(several[0], ContactCycles):
        return several[0]
    if all(isinstance(one, str | Path) for one in several):
        files = [one for one in several if isinstance(one, str | Path)]
        return contact_cycles(read_contact_records(files, normal_load, columns, units), harmonics)
    if all(isinstance(one, ContactRecord) for one in several):
        return contact_cycles([one for one in several if isinstance(one, ContactRecord)], harmonics)
    raise InputError("loops must be files, or records, or one set of cycles, or single loops, but are of several kinds.")


def _loop(cycles: ContactCycles, members: Sequence[int] | Index, name: str) -> fit.ContactLoop:
    """The mean of some cycles as a loop."""
    count = cycles.harmonics
    table = synthesis(max(SAMPLES, 8 * count), count)
    u, force, normal = (table @ values[members].mean(axis=0) for values in (cycles.displacement, cycles.force, cycles.normal))
    return fit.ContactLoop(u, force, normal, name, count, cycles.error / np.sqrt(len(members)))


def _mean_loops(cycles: ContactCycles) -> tuple[fit.ContactLoop, ...]:
    """Cycles of like amplitude and load, averaged over neighbours to a few loops in all."""
    amplitude = cycles.amplitude
    kinds = _kinds(amplitude, cycles.normal[:, 0])
    groups = [np.flatnonzero(kinds == kind) for kind in np.unique(kinds)]
    parts = max(MEAN_LOOPS // len(groups), 1)
    found = []
    for group in groups:
        for members in np.array_split(group, min(parts, group.size)):
            first, last = cycles.numbers[members[0]], cycles.numbers[members[-1]]
            name = f"cycle {first}" if first == last else f"cycles {first} to {last}"
            found.append(_loop(cycles, members, f"{name}, {1e6 * amplitude[members].mean():.3g} um"))
    return tuple(found)


def _kinds(amplitude: Array, load: Array) -> Index:
    """A number for each combination of levels of amplitude and load, (n,)."""
    return _levels(amplitude) * amplitude.size + _levels(load)


def _levels(values: Array) -> Index:
    """The number of the level that each value belongs to, (n,); levels are apart by more than `SAME_LEVEL`."""
    order = np.argsort(values, kind="stable")
    found = np.zeros(values.size, dtype=np.int64)
    found[order[1:]] = np.cumsum(values[order][1:] > SAME_LEVEL * values[order][:-1])
    return found


def _single_loops(cycles: ContactCycles) -> tuple[tuple[fit.ContactLoop, ...], Index]:
    """Each cycle as a loop, or neighbours averaged where there are very many; the number of the middle cycle of each."""
    count = len(cycles.force)
    groups = np.array_split(np.arange(count), min(count, MOST_CYCLES))
    numbers = np.array([cycles.numbers[group[group.size // 2]] for group in groups], dtype=np.int64)
    return tuple(_loop(cycles, group, f"cycle {number}") for group, number in zip(groups, numbers, strict=True)), numbers


def _smoothed(loop: fit.ContactLoop, harmonics: int | None) -> fit.ContactLoop:
    """A loop without the noise of its displacement, unless it was smoothed before; its force goes up to the same harmonic."""
    if loop.harmonics is not None:
        return loop
    u, error = smoothed_motion(np.asarray(loop.displacement), harmonics)
    force = fit.smoothed(np.asarray(loop.force), error.size)
    return replace(loop, displacement=u, force=force, harmonics=error.size, displacement_error=error)
