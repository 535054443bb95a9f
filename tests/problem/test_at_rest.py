"""Normal loads at rest, against the mean forces that the harmonic balance finds without vibration."""

from dataclasses import replace

import numpy as np
import pytest
from problem.loose_wedge import wedge_between
from scipy.optimize import brentq

import stickslip as ss
from stickslip.model.problem.at_rest import normal_loads_at_rest
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.sweep import solve_cold
from stickslip.study import job
from stickslip.study.templates import write_new


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("blades")
    write_new("two_blades", folder / "study.toml")
    return folder


@pytest.mark.parametrize("across", [0.0, 25.0, 40.0, 100.0])
def test_a_pull_across_is_carried_by_one_platform_more_than_by_the_other(folder, across):
    """Some nodes slip and some open: the states of one round led to those of the next and back."""
    text = (folder / "study.toml").read_text().replace("pull = [0.0, 300.0, 0.0]", f"pull = [{across}, 300.0, 0.0]")
    made = job(text, folder, "study")
    problem = made.sweep.problem
    found = normal_loads_at_rest(problem)
    balance = HarmonicBalance(problem, 1, 8)
    solved = solve_cold(balance.holding(None), 100.0, 0.0)
    assert solved.converged
    normal = [row for row, direction in enumerate(d for c in problem.contacts for d in c.direction_names) if direction == "n"]
    expected = balance.carried_forces(solved.evaluation)[normal, 0]
    np.testing.assert_allclose(list(found.values()), expected, atol=1e-6 * expected.max())
    assert not any("no state of rest" in note for note in made.notes)


@pytest.mark.parametrize("pull", [3.0, 12.0, 30.0])
def test_a_wedge_that_slips_at_rest_carries_what_the_coefficient_of_its_load_lets_it(pull):
    """Both sides slip along their faces at 45° under a pull that begins at nothing: 2 (N + μ(N) N)/√2 = pull."""
    mu = ss.LoadDependentFriction((2.0, 5.0, 15.0), (0.4, 0.25, 0.15))
    wedge = wedge_between()
    problem = replace(
        wedge.with_contacts(lambda c: replace(c, law=replace(c.law, mu=mu, preload=0.0), balanced=False)),
        forces=(*wedge.forces, ss.Force("body.y", static=pull)),
    )
    load = brentq(lambda N: np.sqrt(2.0) * (N + float(mu.limit(N))) - pull, 0.1, pull)
    np.testing.assert_allclose(list(normal_loads_at_rest(problem).values()), [load, load], rtol=1e-9)
