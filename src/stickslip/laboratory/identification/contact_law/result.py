"""What a contact law from loops is given as: the result, its dataset, and the answer in sentences.

What to check before a contact law from loops is used: little slip, a poor fit, a lag, whose stiffness it is, wear.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.laboratory.identification.contact_law.fit import ContactLoop, force_lag, force_of, interval, work_along
from stickslip.laboratory.identification.least_squares import CERTAINTY
from stickslip.model.contact.law import LoadDependentFriction
from stickslip.results.schema import Result, named, stacked, tabulated
from stickslip.support.checks import Array, Index, counted, fault, rounded
from stickslip.support.late import xr

if TYPE_CHECKING:
    from stickslip.laboratory.identification.contact_law.work import ContactLawWork

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
