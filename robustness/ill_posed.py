"""Ill-posed problems: each must be recognised as such, by a refusal that names the fault or by an outcome, and never answered.

Most are one change to a sound problem of two masses, the second of which rubs against the ground.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import stickslip as ss
from stickslip.support.outcome import Outcome

GROUND = ss.between("2.x", "ground")
SLIDER = ss.Macroslip(1.0, 0.5, normal_load=1.0)
ANYWHERE = (0.05, 0.1, 0.3)
HELD_BY_FRICTION = np.array([[1.0, 0.0], [0.0, 0.0]])
"""Two masses of which the contact alone holds the second."""


@dataclass(frozen=True)
class IllPosed:
    """A problem that has no answer. said: words of the refusal; or outcome: what a curve must end with."""

    name: str
    respond: Callable[[], Any]
    said: str = ""
    outcome: Outcome = Outcome.EMPTY

    def mistaken_for(self) -> str:
        """What came instead of the recognition; empty where the problem was recognised."""
        try:
            dataset = self.respond().dataset
        except ss.InputError as error:
            return "" if self.said and self.said in str(error) else f"refused, but for another reason: {error}"
        found = Outcome(int(dataset["case_outcome"].values[0]))
        if found == self.outcome and not np.any(np.isfinite(dataset["amplitude"].values)):
            return ""
        return f"answered: {found.name.lower().replace('_', ' ')}"


def structure(**changes: Any) -> ss.Structure:
    """Two masses on springs."""
    sound = {"M": np.eye(2), "K": np.array([[2.0, -1.0], [-1.0, 1.5]]), "dofs": ("1.x", "2.x"), "C": 0.02 * np.eye(2)}
    return ss.Structure(**(sound | changes))


def respond(
    contact: Callable[[], ss.Contact] = lambda: slider(),
    forces: Callable[[], tuple[ss.Force, ...]] = lambda: (ss.Force("1.x", 1.0),),
    at: Any = ANYWHERE,
    matrices: dict[str, Any] | None = None,
    outputs: tuple[str, ...] = ("2.x",),
    **settings: Any,
) -> Callable[[], Any]:
    """The forced response of a changed problem, when it is called."""

    def call() -> Any:
        problem = ss.Problem(structure(**(matrices or {})), (contact(),), forces(), outputs)
        return ss.forced_response(problem, at, **({"harmonics": 3, "samples": 64} | settings))

    return call


def slider(law: Any = SLIDER, tangential: Any = (GROUND,), **options: Any) -> ss.Contact:
    return ss.Contact("slider", law, tangential, **options)


def starting(rule: Any, law: Any = SLIDER) -> Callable[[], ss.Contact]:
    return lambda: slider(law, start=rule)


def pushed(static: float) -> Callable[[], tuple[ss.Force, ...]]:
    """A steady push on the second mass, beside a small vibration."""
    return lambda: (ss.Force("2.x", 0.01, static=static),)


NOTHING = {"K": np.array([[1.0, -1.0], [-1.0, 1.0]])}
FREE = {"K": HELD_BY_FRICTION}

ILL_POSED = (
    IllPosed(
        "nothing holds it", respond(lambda: slider(tangential=(ss.between("1.x", "2.x"),)), matrices=NOTHING), "held by nothing"
    ),
    IllPosed("a cubic spring alone holds it", respond(lambda: slider(ss.CubicSpring(1.0)), matrices=NOTHING), "held by nothing"),
    IllPosed("negative stiffness", respond(matrices={"K": np.diag([1.0, -9.0])}), "of negative stiffness"),
    IllPosed("stiffness of wrong sign", respond(matrices={"K": -10.0 * np.eye(2)}), "Turn the sign of K"),
    IllPosed("no mass", respond(matrices={"M": np.zeros((2, 2))}), "M must have mass"),
    IllPosed("negative mass", respond(matrices={"M": np.diag([1.0, -1.0])}), "M must have no negative eigenvalue"),
    IllPosed("unsymmetric stiffness", respond(matrices={"K": np.array([[2.0, 0.0], [-1.0, 2.0]])}), "K must be symmetric"),
    IllPosed("unsymmetric mass", respond(matrices={"M": np.array([[2.0, 0.5], [0.0, 2.0]])}), "M must be symmetric"),
    IllPosed("not a number", respond(matrices={"M": np.array([[np.nan, 0.0], [0.0, 1.0]])}), "must be finite"),
    IllPosed("infinite", respond(matrices={"K": np.array([[np.inf, 0.0], [0.0, 1.0]])}), "must be finite"),
    IllPosed("beyond floating point", respond(matrices={"K": 1e300 * np.eye(2)}), "must not be larger than 1e+40"),
    IllPosed("rows missing", respond(matrices={"K": np.ones((1, 2))}), "K must be a square matrix"),
    IllPosed("damping that feeds", respond(matrices={"C": -0.02 * np.eye(2)}), "C must not feed energy in"),
    IllPosed("one name twice", respond(matrices={"dofs": ("1.x", "1.x")}), "dofs must be unique"),
    IllPosed("no vibration", respond(forces=lambda: (ss.Force("1.x", static=1.0),)), "forces must contain a harmonic force"),
    IllPosed("a force too small to count", respond(forces=lambda: (ss.Force("1.x", 1e-200),)), "must be at least 1e-40"),
    IllPosed("a force on nothing", respond(forces=lambda: (ss.Force("9.x", 1.0),)), "'9.x' does not exist"),
    IllPosed(
        "a force beyond H", respond(forces=lambda: (ss.Force("1.x", {5: 1.0}),)), "harmonics must reach the load's harmonic 5"
    ),
    IllPosed("an output of nothing", respond(outputs=("3.x",)), "'3.x' does not exist"),
    IllPosed("too few samples", respond(samples=12), "samples must be at least 4 H + 2"),
    IllPosed("negative frequency", respond(at=(-0.1,)), "must be positive"),
    IllPosed("one frequency twice", respond(at=(0.1, 0.1)), "must be unique"),
    IllPosed("no force", respond(force=0.0), "must be positive"),
    IllPosed(
        "negative contact stiffness", respond(lambda: slider(ss.Macroslip(-1.0, 0.5, normal_load=1.0))), "kt must be positive"
    ),
    IllPosed("negative friction", respond(lambda: slider(ss.Macroslip(1.0, -0.5, normal_load=1.0))), "mu must not be negative"),
    IllPosed("a contact with itself", respond(lambda: slider(tangential=(ss.between("2.x", "2.x"),))), "two different places"),
    IllPosed("a start beyond the limit", respond(starting(ss.TractionRatio(1.5))), "must lie in [-1, 1]"),
    IllPosed("a disc of one direction", respond(lambda: slider(ss.FrictionDisc(1.0, 0.5, normal_load=1.0))), "two tangential"),
    IllPosed(
        "ratio holds a free body", respond(starting(ss.TractionRatio(0.5)), matrices=FREE), outcome=Outcome.BODY_HELD_BY_NOTHING
    ),
    IllPosed(
        "mean holds a free body", respond(starting(ss.MeanTraction(0.2)), matrices=FREE), outcome=Outcome.BODY_HELD_BY_NOTHING
    ),
    IllPosed("pushed beyond friction", respond(forces=pushed(0.8), matrices=FREE), outcome=Outcome.BODY_HELD_BY_NOTHING),
)
