"""Dataset of a contact law that was found from loops, and what it says in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.laboratory.identification.force_lag import force_lag
from stickslip.laboratory.identification.loop_law import LawFit, energy_of, force_of
from stickslip.support.checks import Array, Index, counted, rounded

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.laboratory.identification.contact_law import ContactLawWork

TRAVEL = 3e-6
"""Elastic travel mu N/kt [m] from which kt is likely the rig's. In Hertzian contact it is at most the approach of the bodies, in
rough contact about the height of the roughness: about 1 µm or less for metals."""

SLIPS = 0.1
"""Energy of a loop over that of slip all the way below which mu is a lower bound."""

POOR, WIDE = 0.1, 0.2
"""Misfit from which a law is called poor; relative half width of an interval from which a parameter is hardly known."""

PLATEAU = 0.1
"""Share of a cycle that lies above the plateau of the force, and below the other one: smoothing overshoots at their corners."""

LOADS_APART = 1.5
"""Ratio of the largest to the smallest normal load from which kt at both is compared."""

LAGS = 0.35
"""Sum of squares of the residuals with a lag over that without below which a lag is named. A law that lacks the shape of the
loops leaves 0.4 or more; a lag of 0.5 % of the period, which moves kt by 7 %, 0.25 with noise of 5 % of the amplitude."""

CHANGE = 0.1
"""Relative change of mu or kt over the cycles from which one value for all is a mean."""


def contact_law_dataset(work: ContactLawWork, fits: Mapping[str, LawFit], best: str, cycles: tuple[Array, Array]) -> xr.Dataset:
    """The labelled result; see `ContactLaw`."""
    import xarray as xr

    theta, errors = cycles
    chosen = fits[best]
    own = np.array([np.log(chosen.kt), np.log(chosen.mu), *chosen.shape])
    single = work.single
    mean = [float(np.mean(np.asarray(loop.normal))) for loop in single]
    bounded = _hardly_slips(work, chosen.mu)
    cycle_mu = np.exp(theta[:, 1]) * (np.nan if bounded else 1.0)
    ends = [np.quantile(np.asarray(loop.force), (PLATEAU, 1.0 - PLATEAU)) for loop in single]
    plateau = [0.5 * float(high - low) / normal for (low, high), normal in zip(ends, mean, strict=True)]
    fitted_energy = [_energy_of_law(loop, best, row[np.isfinite(row)]) for loop, row in zip(single, theta, strict=True)]
    samples = max(np.size(loop.displacement) for loop in work.loops)
    measured, computed, moved = (np.full((len(work.loops), samples), np.nan) for _ in range(3))
    for place, loop in enumerate(work.loops):
        size = np.size(loop.displacement)
        force = np.asarray(loop.force)
        moved[place, :size], measured[place, :size] = loop.displacement, force - force.mean()
        computed[place, :size] = force_of(loop, best, own)
    law, cycle, loop_sample = ("law",), ("cycle",), ("loop", "sample")
    of = {
        key: [getattr(fit, key) for fit in fits.values()]
        for key in ("kt", "mu", "misfit", "held_out", "kt_interval", "mu_interval")
    }
    variables: dict[str, Any] = {
        "kt": (law, of["kt"], _about("N/m", "tangential stiffness")),
        "kt_interval": (("law", "bound"), of["kt_interval"], _about("N/m", "95 % interval of the tangential stiffness")),
        "mu": (law, of["mu"], _about("1", "friction coefficient")),
        "mu_interval": (("law", "bound"), of["mu_interval"], _about("1", "95 % interval of the friction coefficient")),
        "misfit": (law, of["misfit"], _about("1", "error of the fit, relative to the rms force")),
        "held_out": (law, of["held_out"], _about("1", "error on loops held out, relative to the rms force")),
        "cycle_number": (cycle, work.numbers, _about("1", "number of the cycle")),
        "cycle_kt": (cycle, np.exp(theta[:, 0]), _about("N/m", "tangential stiffness of one cycle")),
        "cycle_kt_error": (cycle, np.exp(theta[:, 0]) * errors[:, 0], _about("N/m", "standard deviation without gains")),
        "cycle_mu": (cycle, cycle_mu, _about("1", "friction coefficient of one cycle, NaN where it is only bounded")),
        "cycle_mu_error": (cycle, cycle_mu * errors[:, 1], _about("1", "standard deviation without gains")),
        "plateau": (cycle, plateau, _about("1", "plateau of the friction force over the normal load")),
        "energy_measured": (cycle, [energy_of(one) for one in single], _about("J", "energy dissipated in the cycle, measured")),
        "energy_fitted": (cycle, fitted_energy, _about("J", "energy dissipated in the cycle, by the law fitted to it")),
        "displacement": (loop_sample, moved, _about("m", "displacement of the contact")),
        "force_measured": (loop_sample, measured, _about("N", "friction force, measured, without its mean")),
        "force_fitted": (loop_sample, computed, _about("N", "friction force of the law fitted to all loops")),
    }
    if any(fit.shape for fit in fits.values()):
        shape = [fit.shape[0] if fit.shape else np.nan for fit in fits.values()]
        variables["spread"] = (law, shape, _about("1", "spread of the sliders' limits"))
    coords = {
        "law": ("law", list(fits), _about("1", "contact law")),
        "bound": ("bound", ["low", "high"], _about("1", "end of the interval")),
        "loop": ("loop", [loop.name for loop in work.loops], _about("1", "loop, the mean of these cycles")),
    }
    attributes: dict[str, Any] = {
        "title": "Law of a contact",
        "best": best,
        "summary": work.summary,
        "removed": "\n".join(work.removed),
    }
    if bounded:
        attributes["least_mu"] = _most_carried(work)
    dataset = xr.Dataset(variables, coords, attributes)
    return dataset.assign_attrs(warnings="\n".join((*work.notes, *_warnings(work, chosen, dataset))))


def _about(units: str, long_name: str) -> dict[str, str]:
    return {"units": units, "long_name": long_name}


def _energy_of_law(loop: Any, law: str, theta: Array) -> float:
    """∮ F du of a law along a loop's displacement [J]."""
    u, force = np.asarray(loop.displacement), force_of(loop, law, theta)
    return float(np.sum(force * (np.roll(u, -1) - np.roll(u, 1)))) / 2.0


def _hardly_slips(work: ContactLawWork, mu: float) -> bool:
    """Whether no loop shows the friction coefficient."""
    return max(_share_in_slip(loop, mu) for loop in work.loops) < SLIPS


def _most_carried(work: ContactLawWork) -> float:
    """The largest friction force over the normal load that a loop reaches: half its range, as its zero is unknown."""
    return max(0.5 * float(np.ptp(np.asarray(loop.force)) / np.mean(np.asarray(loop.normal))) for loop in work.loops)


def _share_in_slip(loop: Any, mu: float) -> float:
    """Energy of a loop over 4 mu N A, that of a contact which slips all the way."""
    amplitude = 0.5 * float(np.ptp(np.asarray(loop.displacement)))
    return energy_of(loop) / (4.0 * mu * float(np.mean(np.asarray(loop.normal))) * amplitude)


def _warnings(work: ContactLawWork, fit: LawFit, dataset: xr.Dataset) -> list[str]:
    """What to check before the result is used."""
    found, bounded = [], "least_mu" in dataset.attrs
    if bounded:
        slipping = max(_share_in_slip(loop, fit.mu) for loop in work.loops)
        found.append(
            f"The contact hardly slips: no loop dissipates more than {max(slipping, 0.0):.0%} of what mu N would. "
            f"mu is a lower bound then, whatever its interval: mu ≥ {_most_carried(work):.4g}, the largest friction force over "
            "the normal load. Measure with larger amplitudes or a smaller normal load."
        )
    if fit.misfit > POOR:
        found.append(f"The {fit.law} law misses the loops by {fit.misfit:.0%} of their rms force.")
    found += _lagging(work, fit)
    travel = (float(dataset.attrs["least_mu"]) if bounded else fit.mu) * work.normal / fit.kt
    if travel > TRAVEL and work.rig_stiffness is None:
        how = "yields elastically by F/kt" if bounded else "would yield elastically by mu N/kt"
        how += f" = {1e6 * travel:.3g} um{' at the largest friction force' if bounded else ''}"
        found.append(
            f"kt is likely the rig's: the contact {how}, contacts of metals "
            f"yield by about 1 um or less. Measure the displacement nearer to the contact, or give the rig's stiffness "
            f"(rig_stiffness, measured with the contact locked). mu and the energy in gross slip hardly depend on it."
        )
    motion = max(float(np.ptp(np.asarray(loop.displacement))) for loop in work.loops)
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
        for name, values in (("mu", dataset["cycle_mu"].values), ("kt", dataset["cycle_kt"].values)):
            part = max(len(values) // 10, 1)
            first, last = float(np.mean(values[:part])), float(np.mean(values[-part:]))
            if abs(last - first) > CHANGE * first:
                unit, factor = ("", 1.0) if name == "mu" else (" N/um", 1e-6)
                found.append(
                    f"{name} changes from {factor * first:.4g} ({_which(work.numbers[:part])}) to {factor * last:.4g}{unit} "
                    f"({_which(work.numbers[-part:])}): one value for all is a mean."
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
    shown = force_lag(work.loops, fit.law, np.array([np.log(fit.kt), np.log(fit.mu), *fit.shape]))
    if shown.left > LAGS:
        return []
    late = "late" if shown.lag > 0.0 else "early"
    return [
        f"The force comes {abs(shown.lag):.2%} of a period too {late} for a contact, which sticks at each reversal: with it in "
        f"time the {fit.law} law has kt = {1e-6 * shown.kt:.4g} N/um. A force that is saturated looks "
        f"the same. Record both with one filter, or give lag = {shown.lag:.4f}."
    ]


def _over_loads(work: ContactLawWork, kt: Array) -> list[str]:
    """What kt at different normal loads says about whose it is: a contact's grows with the load, a rig's does not."""
    loads = np.array([float(np.mean(np.asarray(loop.normal))) for loop in work.single])
    if loads.max() < LOADS_APART * loads.min():
        return []
    middle = np.sqrt(loads.min() * loads.max())
    low, high = (float(np.median(kt[side])) for side in (loads < middle, loads >= middle))
    about = f"kt is {rounded(1e-6 * low, 3)} N/um around {rounded(float(np.median(loads[loads < middle])), 4)} N and "
    about += f"{rounded(1e-6 * high, 3)} N/um around {np.median(loads[loads >= middle]):.4g} N"
    if abs(high - low) < CHANGE * low and work.rig_stiffness is None:
        return [f"kt is likely the rig's: {about}; that of a contact grows with the normal load."]
    return [f"One kt for all loads is a mean: {about}. Fit each load by itself."] if abs(high - low) >= CHANGE * low else []


def sentences(dataset: xr.Dataset) -> list[str]:
    """The answer in a few lines: parameters, energy, cycles, other laws, what was removed, warnings."""
    best = str(dataset.attrs["best"])
    own = dataset.sel(law=best)
    kt, mu = 1e-6 * float(own["kt"]), float(own["mu"])
    low, high = 1e-6 * own["kt_interval"].values
    lines = [
        f"{best}: kt = {kt:.4g} N/um, 95 % between {low:.4g} and {high:.4g}; "
        + (
            f"mu ≥ {float(dataset.attrs['least_mu']):.4g}, the contact hardly slips"
            if "least_mu" in dataset.attrs
            else f"mu = {mu:.4g}, 95 % between {float(own['mu_interval'][0]):.4g} and {float(own['mu_interval'][1]):.4g}"
        ),
        f"misfit {_misfits(own)}; energy per cycle {_energies(dataset)}",
        str(dataset.attrs["summary"]),
    ]
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


def _energies(dataset: xr.Dataset) -> str:
    measured, fit = (float(dataset[name].mean()) for name in ("energy_measured", "energy_fitted"))
    unit, factor = ("mJ", 1e3) if measured >= 1e-4 else ("uJ", 1e6)
    return f"{factor * measured:.4g} {unit} measured, {factor * fit:.4g} {unit} fitted, in the mean"


def _over_cycles(dataset: xr.Dataset) -> str:
    """Friction and stiffness in the first and the last cycle."""
    ends = dataset.isel(cycle=[0, -1])
    first, last = (int(number) for number in ends["cycle_number"].values)
    mu, kt, plateau = (ends[name].values * factor for name, factor in (("cycle_mu", 1.0), ("cycle_kt", 1e-6), ("plateau", 1.0)))
    friction = "" if "least_mu" in dataset.attrs else f"mu {mu[0]:.4g} to {mu[1]:.4g}, "
    return (
        f"from cycle {first} to {last} ({counted(dataset.sizes['cycle'], 'fit')}): {friction}"
        f"kt {kt[0]:.4g} to {kt[1]:.4g} N/um, plateau over load {plateau[0]:.4g} to {plateau[1]:.4g}"
    )
