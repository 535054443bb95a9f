"""Settings of a forced response, which speed sweeps, other analyses and the table [sweep] of studies share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, fields
from typing import Annotated, Any, Literal

from stickslip.analyses.settings import (
    Execution,
    Frequencies,
    Measured,
    OfKind,
    OfProblem,
    Setting,
    Settings,
    Whole,
    Within,
    force_levels,
    measure_name,
    quantity_name,
)
from stickslip.solve.balance.orders import MOST_SAMPLES, Harmonics, checked_harmonics
from stickslip.solve.peaks.search import TOLERANCE
from stickslip.support.checks import whole
from stickslip.support.units import Band

OR_AUTO = 'Or write "auto".'


def _harmonics(name: str, value: Any) -> Harmonics | Literal["auto"]:
    return "auto" if isinstance(value, str) and value == "auto" else checked_harmonics(value, OR_AUTO)


def _levels(name: str, value: Any) -> tuple[float, ...]:
    return force_levels(value)


@dataclass(frozen=True, eq=False)
class Fineness(Settings):
    """The force levels, and how finely each curve is computed."""

    force: Annotated[
        float | Sequence[float],
        Setting(_levels, "factors on every harmonic force", key="force_levels"),
    ] = 1.0
    harmonics: Annotated[
        int | Sequence[int] | Literal["auto"],
        Setting(
            _harmonics,
            'H, highest harmonic, or a list that holds 1, such as [0, 1, 3, 5]; "auto": raised, and samples doubled, until the '
            "rest at the peaks is below `tolerance`, where the contacts start as the problem says",
        ),
    ] = 5
    samples: Annotated[int, Setting(Whole(1, MOST_SAMPLES), "samples of a period")] = 256
    _: KW_ONLY
    tolerance: Annotated[
        float, Setting(Within(0.0, 0.5), 'for harmonics = "auto": left-out motion of the contacts, relative')
    ] = 2e-3
    peak_tolerance: Annotated[float, Setting(Within(0.0, 0.1), "relative amplitude by which a peak may be too low")] = TOLERANCE

    @property
    def fineness(self) -> dict[str, Any]:
        """These settings by name."""
        return {each.name: getattr(self, each.name) for each in fields(Fineness)}

    @property
    def levels(self) -> tuple[float, ...]:
        """The force levels, a case each."""
        return force_levels(self.force)


@dataclass(frozen=True, eq=False)
class OverBand(Settings):
    """A problem and the frequencies in Hz: a band, or a list in the order of travel."""

    problem: OfProblem
    band: Frequencies


@dataclass(frozen=True, eq=False)
class ForcedResponseSettings(Measured, Fineness, OverBand, Execution):
    """The arguments of `forced_response`."""

    quantity: Annotated[str, Setting(quantity_name, "what the peaks, bounds and optima are of")] = "displacement"
    measure: Annotated[
        str,
        Setting(
            measure_name,
            "of it: amplitude of the first harmonic, root mean square, or largest value over the period",
        ),
    ] = "amplitude"
    periods: Annotated[int, Setting(whole)] = 1
    isolated: Annotated[bool, Setting(OfKind(bool))] = False

    @property
    def listed(self) -> bool:
        """Whether only the frequencies of a list are wanted."""
        return not isinstance(self.band, Band)

    @property
    def frequencies(self) -> tuple[float, ...]:
        """In Hz, in the order of travel: the ends of a band, or those of a list."""
        return (self.band.start, self.band.stop) if isinstance(self.band, Band) else tuple(self.band)
