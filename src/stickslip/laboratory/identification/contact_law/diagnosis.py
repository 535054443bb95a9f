"""What to check before a contact law from loops is used: little slip, a poor fit, a lag, whose stiffness it is, wear."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.laboratory.identification.contact_law.fit import force_lag
from stickslip.laboratory.identification.contact_law.model import ContactLoop
from stickslip.laboratory.identification.contact_law.result import LawFit
from stickslip.support.checks import Array, Index, rounded
from stickslip.support.late import xr

if TYPE_CHECKING:
    from stickslip.laboratory.identification.contact_law.work import ContactLawWork

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
