"""Macroslip: one Jenkins element per tangential direction, with a constant or a varying normal load and lift-off."""

from dataclasses import dataclass
from typing import ClassVar

from stickslip.model.contact.law import Elements, Friction, SingleLoad
from stickslip.support.checks import fault, positive


@dataclass(frozen=True)
class Macroslip(SingleLoad):
    """A spring kt in series with a Coulomb slider, |T| ≤ μN.

    With kn: N = max(kn (z − gap) + preload, 0), from the motion z of a normal direction (positive closes).
    Without kn: N = normal_load, constant.

    kt, kn [N/m]; mu [-]; preload N0 [N]; gap [m]; normal_load [N]; kt2 [N/m]: along t2, where it differs from kt along t1.
    Source: Griffin (1980) for constant load; Yang, Chu and Menq (1998) for varying load.
    """

    extensive: ClassVar[tuple[str, ...]] = (*SingleLoad.extensive, "kt2")

    kt: float
    mu: Friction
    kn: float | None = None
    preload: float = 0.0
    gap: float = 0.0
    normal_load: float | None = None
    kt2: float | None = None

    name: ClassVar[str] = "macroslip"

    def __post_init__(self) -> None:
        positive("kt", self.kt)
        if self.kt2 is not None:
            positive("kt2", self.kt2)
        self.check_load()

    def elements(self, tangential: int, normal: bool) -> Elements:
        if self.kt2 is not None and tangential < 2:
            raise fault("A macroslip contact", "must have a second tangential direction for its kt2", f"{tangential} direction")
        return self.under_load((self.kt, self.kt if self.kt2 is None else self.kt2)[:tangential], normal)
