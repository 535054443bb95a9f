"""Samples of every contact law for the law harness, and the springs and sliders that each one stands for, written by hand.

A new law brings its samples here: without them the harness fails and says so.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from dataclasses import dataclass

import numpy as np

import stickslip.model.contact
from stickslip.model.contact.cubic import CubicSpring, Gap
from stickslip.model.contact.dahl import Dahl
from stickslip.model.contact.friction_disc import FrictionDisc
from stickslip.model.contact.law import Law, LoadDependentFriction
from stickslip.model.contact.lugre import LuGre
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.microslip import FourParameter, Hertz, Iwan, MicroslipArray, Parabolic, Spectrum
from stickslip.model.contact.tanh_coulomb import TanhCoulomb
from stickslip.model.contact.valanis import Valanis


@dataclass(frozen=True)
class Element:
    """What one element of a law is: N = max(kn (z − gap) + preload, 0) + load, a Jenkins element (kt, μN) in each direction;
    where it has a table of loads and coefficients, the limit goes straight between its μN and from nothing to the first."""

    kt: float = 0.0
    mu: float = 0.0
    kn: float = 0.0
    gap: float = 0.0
    preload: float = 0.0
    load: float = 0.0
    table: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())

    def limit(self, z: np.ndarray) -> np.ndarray:
        """Slip limit at normal displacements z, N."""
        (loads, values), N = map(np.array, self.table), self.normal(z)
        if not loads.size:
            return self.mu * N
        inside = np.interp(N, np.append(0.0, loads), np.append(0.0, loads * values))
        return np.where(loads[-1] < N, values[-1] * N, inside)

    def normal(self, z: np.ndarray) -> np.ndarray:
        """N at normal displacements z, N."""
        return np.maximum(self.signed(z), 0.0) + self.load

    def signed(self, z: np.ndarray) -> np.ndarray:
        """The normal spring's force if it could pull, N."""
        return self.kn * (z - self.gap) + self.preload

    def landings(self, z: np.ndarray) -> np.ndarray:
        """The share of each step at which the element lands, 0 where it does not; [n] is the step from sample n − 1 to n."""
        after, before = self.signed(z), np.roll(self.signed(z), 1)
        lands = (before <= 0.0) & (after > 0.0) & (self.load == 0.0)
        return np.where(lands, before / np.where(lands, before - after, 1.0), 0.0)


@dataclass(frozen=True)
class Sample:
    """A law, its number of tangential directions, and the elements it must be equal to."""

    name: str
    law: Law
    tangential: int
    elements: tuple[Element, ...]

    @property
    def stiffness(self) -> tuple[float, ...]:
        """Stiffness of all elements closed and stuck, by row t1, t2, n, N/m."""
        normal = (sum(e.kn for e in self.elements),) if self.law.has_normal else ()
        return (sum(e.kt for e in self.elements),) * self.tangential + normal


def every_law() -> list[type[Law]]:
    """Every concrete law of stickslip.model.contact, found by listing its modules."""
    for module in pkgutil.iter_modules(stickslip.model.contact.__path__):
        importlib.import_module(f"stickslip.model.contact.{module.name}")
    found, pending = [], [Law]
    while pending:
        members = pending.pop().__subclasses__()
        pending += members
        found += [law for law in members if not inspect.isabstract(law) and law.__module__.startswith("stickslip.")]
    return sorted(found, key=lambda law: law.__name__)


def samples_of(law: type[Law]) -> list[Sample]:
    """The samples of one law, be it a table of sliders or not."""
    return [sample for sample in EVERY_SAMPLE if type(sample.law) is law]


def _array(kts: tuple[float, ...], mu: float, **others: tuple[float, ...]) -> tuple[Element, ...]:
    columns = [dict(zip(others, values, strict=True)) for values in zip(*others.values(), strict=True)]
    return tuple(Element(kt, mu, **column) for kt, column in zip(kts, columns, strict=True))


def _iwan(kt: float, mu: float, spectrum: Spectrum, count: int, **whole: float) -> tuple[Element, ...]:
    """The elements of an Iwan law: an equal share of the normal load each, and friction that makes up for it."""
    share, slip = spectrum.elements(count)
    size = share.size
    each = {key: value if key == "gap" else value / size for key, value in whole.items()}
    return tuple(Element(kt * k, mu * size * k * s, **each) for k, s in zip(share, slip, strict=True))


LOADS, VALUES = (0.4, 1.0, 2.0), (0.8, 0.5, 0.4)
FALLING = LoadDependentFriction(LOADS, VALUES)
RISING = LoadDependentFriction((0.5, 1.5), (0.3, 0.6))


def _bent(kt: float, share: float = 1.0, **others: float) -> Element:
    """An element with the falling coefficient, of a share of the contact."""
    return Element(kt, VALUES[0], table=(tuple(share * load for load in LOADS), VALUES), **others)


SAMPLES = (
    Sample("gap", Gap(2.5, gap=0.3, preload=0.4), 0, (Element(kn=2.5, gap=0.3, preload=0.4),)),
    Sample("constant load", Macroslip(2.0, 0.5, normal_load=1.2), 1, (Element(2.0, 0.5, load=1.2),)),
    Sample("constant load, plane", Macroslip(1.5, 0.3, normal_load=2.0), 2, (Element(1.5, 0.3, load=2.0),)),
    Sample("varying load", Macroslip(2.0, 0.4, 3.0, 1.0), 1, (Element(2.0, 0.4, 3.0, preload=1.0),)),
    Sample("varying load with gap, plane", Macroslip(1.3, 0.7, 2.0, 0.2, 0.1), 2, (Element(1.3, 0.7, 2.0, 0.1, 0.2),)),
    Sample("coefficient that falls with the load", Macroslip(2.0, FALLING, 3.0, 1.0), 1, (_bent(2.0, kn=3.0, preload=1.0),)),
    Sample("coefficient that falls, constant load", Macroslip(2.0, FALLING, normal_load=1.6), 1, (_bent(2.0, load=1.6),)),
    Sample(
        "coefficient that rises with the load, plane",
        Macroslip(1.3, RISING, 2.0, 0.2, 0.1),
        2,
        (Element(1.3, 0.3, 2.0, 0.1, 0.2, table=(RISING.over, RISING.values)),),
    ),
    Sample(
        "array whose coefficient falls with the load",
        MicroslipArray((1.0, 0.4), FALLING, (2.0, 3.0), (0.0, 0.2), (0.3, 0.9)),
        1,
        (_bent(1.0, 0.4, kn=2.0, preload=0.3), _bent(0.4, 0.6, kn=3.0, gap=0.2, preload=0.9)),
    ),
    Sample("without friction", Macroslip(1.0, 0.0, 2.0, 0.5), 1, (Element(1.0, 0.0, 2.0, preload=0.5),)),
    Sample(
        "array of constant loads",
        MicroslipArray((1.0, 0.6, 0.3), 0.5, normal_load=(0.2, 0.8, 2.0)),
        1,
        _array((1.0, 0.6, 0.3), 0.5, load=(0.2, 0.8, 2.0)),
    ),
    Sample(
        "array with gaps, plane",
        MicroslipArray.from_totals(3.0, 6.0, 0.4, 0.5, 4),
        2,
        _array((0.75,) * 4, 0.4, kn=(1.5,) * 4, gap=(0.0, 1 / 6, 1 / 3, 0.5)),
    ),
    Sample(
        "array of unequal elements",
        MicroslipArray((1.0, 0.4), 0.6, (2.0, 3.0), (0.0, 0.2), (0.3, 0.9)),
        1,
        _array((1.0, 0.4), 0.6, kn=(2.0, 3.0), gap=(0.0, 0.2), preload=(0.3, 0.9)),
    ),
    Sample("Iwan of constant load", Iwan(2.0, 0.5, normal_load=1.2, count=4), 1, _iwan(2.0, 0.5, Hertz(), 4, load=1.2)),
    Sample(
        "Iwan of varying load, plane",
        Iwan(1.7, 0.4, 3.0, 1.0, 0.1, spectrum=FourParameter(), count=2),
        2,
        _iwan(1.7, 0.4, FourParameter(), 2, kn=3.0, preload=1.0, gap=0.1),
    ),
    Sample(
        "Iwan of a concave pressure",
        Iwan(1.5, 0.6, 2.5, 0.5, spectrum=Parabolic(2.0), count=6),
        1,
        _iwan(1.5, 0.6, Parabolic(2.0), 6, kn=2.5, preload=0.5),
    ),
)

DISC_SAMPLES = (
    Sample("disc of constant load", FrictionDisc(2.0, 0.4, normal_load=1.5), 2, (Element(2.0, 0.4, load=1.5),)),
    Sample("disc of varying load", FrictionDisc(1.6, 0.5, 3.0, 1.0), 2, (Element(1.6, 0.5, 3.0, preload=1.0),)),
    Sample("disc whose coefficient falls", FrictionDisc(1.6, FALLING, 3.0, 1.0), 2, (_bent(1.6, kn=3.0, preload=1.0),)),
    Sample("disc with gap", FrictionDisc(1.2, 0.6, 2.0, 0.1, 0.2), 2, (Element(1.2, 0.6, 2.0, 0.2, 0.1),)),
)
"""Laws whose two directions are coupled: `test_friction_disc` referees them."""

SPRING_SAMPLES = (
    Sample("stiffening", CubicSpring(0.7), 1, ()),
    Sample("softening, plane", CubicSpring(-0.2), 2, ()),
)
"""Springs without friction and without a linear part: `test_cubic_spring` referees them."""

DAHL_SAMPLES = (
    Sample("Dahl of constant load", Dahl(2.0, 0.5, normal_load=1.2), 1, (Element(2.0, 0.5, load=1.2),)),
    Sample("Dahl of varying load", Dahl(2.0, 0.4, 3.0, 1.0), 1, (Element(2.0, 0.4, 3.0, preload=1.0),)),
    Sample("Dahl whose coefficient falls", Dahl(2.0, FALLING, 3.0, 1.0), 1, (_bent(2.0, kn=3.0, preload=1.0),)),
    Sample("Dahl with gap, plane", Dahl(1.3, 0.7, 2.0, 0.2, 0.1), 2, (Element(1.3, 0.7, 2.0, 0.1, 0.2),)),
)
"""Friction that never sticks: `test_dahl` referees it; of elements the kt, L and N."""

VALANIS_SAMPLES = (
    Sample("Valanis of constant load", Valanis(2.0, 0.5, 0.6, normal_load=1.2), 1, (Element(2.0, 0.5, load=1.2),)),
    Sample("Valanis of varying load", Valanis(2.0, 0.4, 0.9, 3.0, 1.0), 1, (Element(2.0, 0.4, 3.0, preload=1.0),)),
    Sample("Valanis with gap, plane", Valanis(1.3, 0.7, 0.3, 2.0, 0.2, 0.1), 2, (Element(1.3, 0.7, 2.0, 0.1, 0.2),)),
)
"""Friction that yields later than Dahl's: `test_valanis` referees it; of elements the kt, L and N."""

LUGRE_SAMPLES = (
    Sample("LuGre of constant load", LuGre(2.0, 0.5, 0.7, 0.3, 0.1, 0.05, normal_load=1.2), 1, (Element(2.0, 0.5, load=1.2),)),
    Sample(
        "LuGre of varying load", LuGre(2.0, 0.4, 0.5, 0.4, 0.2, kn=3.0, preload=1.0), 1, (Element(2.0, 0.4, 3.0, preload=1.0),)
    ),
    Sample("LuGre with gap, plane", LuGre(1.3, 0.7, 0.9, 0.5, 0.1, 0.1, 2.0, 0.2, 0.1), 2, (Element(1.3, 0.7, 2.0, 0.1, 0.2),)),
)
"""Friction by the path and the velocity, which may exceed μN: `test_lugre` referees it; of elements the kt, L and N."""

TANH_SAMPLES = (
    Sample("tanh of constant load", TanhCoulomb(0.5, 0.3, normal_load=1.2), 1, (Element(0.0, 0.5, load=1.2),)),
    Sample("tanh of varying load", TanhCoulomb(0.4, 0.2, 3.0, 1.0), 1, (Element(0.0, 0.4, 3.0, preload=1.0),)),
    Sample("tanh whose coefficient falls", TanhCoulomb(FALLING, 0.2, 3.0, 1.0), 1, (_bent(0.0, kn=3.0, preload=1.0),)),
    Sample("tanh with gap, plane", TanhCoulomb(0.7, 0.5, 2.0, 0.2, 0.1), 2, (Element(0.0, 0.7, 2.0, 0.1, 0.2),)),
)
"""Friction by the velocity, without a spring: `test_tanh_coulomb` referees it; of elements the L and N."""

SMOOTH_SAMPLES = (*DAHL_SAMPLES, *VALANIS_SAMPLES, *LUGRE_SAMPLES, *TANH_SAMPLES)
"""What shares the properties of sliders but for sticking and a start."""

KERNEL_SAMPLES = (*DISC_SAMPLES, *SPRING_SAMPLES, *SMOOTH_SAMPLES)
"""Laws with a step of their own."""

EVERY_SAMPLE = (*SAMPLES, *KERNEL_SAMPLES)
