"""Newton's linear system of a nonlinear mode on coordinates of the structure and on λ: one solution to rounding."""

from copy import copy
from dataclasses import replace

import numpy as np
import pytest
from balance.problems import everything, structure
from balance.test_linear_part import CASES as DAMPINGS

import stickslip as ss
from stickslip.model.contact.point import between
from stickslip.model.contact.protocol import HELD
from stickslip.model.rigs import chain, chain_varying_load, three_mass_wedge
from stickslip.solve.balance.balance import PathCondition
from stickslip.solve.balance.mode_balance import ModeBalance
from stickslip.solve.balance.newton_parts import compile_parts
from stickslip.solve.balance.system import ON_FORCES, ON_STATES
from stickslip.solve.continuation.newton import correct, fixed

PROBLEMS = {
    "everything": everything(),
    "coupled damping": DAMPINGS["general"],
    "wedge": three_mass_wedge(0.3),
    "chain": chain_varying_load(),
    "three sliders": chain(6, sliders=(4, 5, 6), forced=3),
}
PROBLEMS["rate"] = ss.Problem(
    structure(),
    (ss.Contact("bristles", ss.LuGre(2.0, 0.5, 0.7, 0.3, 0.1, 0.05, normal_load=1.2), (between("1.x", "ground"),)),),
    (ss.Force("1.x", 1.0),),
    ("1.x",),
)
TIGHT = 1e-8


def solved_on(balance: ModeBalance, form: int) -> ModeBalance:
    """The same balance with Newton's linear system on the coordinates, or on the unknowns of λ."""
    other = copy(balance)
    other.mode_system = other.system = balance.mode_system._replace(form=form)
    compile_parts(other.mode_system)
    return other


def assert_close(found, expected) -> None:
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=TIGHT * np.abs(expected).max(initial=1e-300))


@pytest.mark.parametrize(("harmonics", "extended"), [(3, 1), (3, 3), ([0, 1, 2, 4], 1)])
@pytest.mark.parametrize("name", PROBLEMS)
def test_steps_directions_and_determinants_are_the_same(name, harmonics, extended):
    """Four of Newton's iterates from the stuck mode, for a given amplitude and along a plane."""
    balance = ModeBalance(PROBLEMS[name], harmonics, 48, 0, extended)
    size = np.max(np.abs(balance.shape[: balance.rows]))
    forces, few = (solved_on(balance, form) for form in (ON_FORCES, ON_STATES))
    point = balance.linear_point(balance.level_of(3.0 / size))
    point = replace(point, forces=point.forces * (1.0 + 0.01 * np.random.default_rng(5).standard_normal(point.forces.shape)))
    for _ in range(4):
        evaluation = balance.evaluate(point)
        weight = np.random.default_rng(3).standard_normal(evaluation.w.shape) / np.abs(evaluation.w).max()
        for condition in (fixed("level", point.level + 0.1), PathCondition("level", weight, 0.3, 0.1)):
            factors = [one.factorise(evaluation, condition) for one in (forces, few)]
            assert factors[1].bordered.columns.shape[0] == 3
            assert factors[0].bordered.columns.size == 0
            assert factors[1].orientation == factors[0].orientation
            logarithms = [np.sum(np.log(np.abs(one.pivots))) for one in factors]
            assert logarithms[0] == pytest.approx(logarithms[1], abs=1e-7)
            steps = [one.newton_step(evaluation, condition, found) for one, found in zip((forces, few), factors, strict=True)]
            assert_close(steps[1][0], steps[0][0])
            assert_close(steps[1][1], np.array(steps[0][1]))
            along = [one.tangent(evaluation, "level", found) for one, found in zip((forces, few), factors, strict=True)]
            for found, expected in zip(along[1], along[0], strict=True):
                assert_close(found, np.asarray(expected))
        point = correct(forces, point, fixed("level", point.level), iterations=1, halvings=8).evaluation.point
    assert np.any(evaluation.unknown != HELD)
