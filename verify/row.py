"""One promised number: what was computed, what it must be, how close, and where the reference comes from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal["relative", "absolute", "at most"]

INDEPENDENT = "independent script of this project"
CLOSED = "closed form"
PAGE = "this program, as a page of the documentation states it"


@dataclass(frozen=True)
class Row:
    """value against reference within tolerance; kind "at most": value ≤ tolerance, without a reference."""

    name: str
    value: float
    reference: float | None
    tolerance: float
    source: str
    kind: Kind = "relative"

    @property
    def error(self) -> float:
        """What is compared with the tolerance."""
        if self.reference is None:
            return self.value
        gap = abs(self.value - self.reference)
        return gap / abs(self.reference) if self.kind == "relative" else gap

    @property
    def passed(self) -> bool:
        return self.error <= self.tolerance

    def as_dict(self) -> dict[str, object]:
        """The row of results/verify.json."""
        keys = ("name", "value", "reference", "tolerance", "kind", "error", "source", "passed")
        return {key: getattr(self, key) for key in keys}


def relative(name: str, value: float, reference: float, tolerance: float, source: str) -> Row:
    """|value/reference − 1| ≤ tolerance."""
    return Row(name, float(value), float(reference), tolerance, source)


def absolute(name: str, value: float, reference: float, tolerance: float, source: str) -> Row:
    """|value − reference| ≤ tolerance."""
    return Row(name, float(value), float(reference), tolerance, source, "absolute")


def at_most(name: str, value: float, tolerance: float, source: str) -> Row:
    """value ≤ tolerance."""
    return Row(name, float(value), None, tolerance, source, "at most")
