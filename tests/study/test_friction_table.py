"""The coefficient of friction of a study file as a table over the normal load: units, forms, and what is refused."""

import pytest

import stickslip as ss
from stickslip.study import job
from stickslip.support.checks import InputError

STUDY = """
[study]
analysis = "forced_response"

[units]
force = "kN"
length = "mm"

[structure]
dofs = ["1.x", "1.y"]
matrices = {{ M = [[1.0, 0.0], [0.0, 1.0]], K = [[1.0, 0.0], [0.0, 1.0]] }}

[damping]
modal = 0.01

[[contact]]
name = "foot"
law = "{law}"
tangential = ["1.x", "ground"]
normal = ["1.y", "ground"]
kt = 1.0
kn = 2.0
preload = 0.05
mu = {mu}
{more}

[[force]]
direction = "1.x"
amplitude = 0.01

[sweep]
frequency = [50.0, 150.0]
outputs = ["1.x"]
"""
TABLE = "{ over = [0.01, 0.1], values = [0.6, 0.4] }"


def law_of(folder, law="macroslip", mu=TABLE, more=""):
    return job(STUDY.format(law=law, mu=mu, more=more), folder, "study").sweep.problem.contacts[0].law


@pytest.mark.parametrize("law", ["macroslip", "dahl", "iwan"])
def test_loads_are_in_the_units_of_the_study(tmp_path, law):
    assert law_of(tmp_path, law).mu == ss.LoadDependentFriction((10.0, 100.0), (0.6, 0.4))


def test_a_power_law_is_tabulated_about_its_load(tmp_path):
    found = law_of(tmp_path, mu="{ value = 0.5, at = 0.05, exponent = -0.25 }").mu
    assert found == ss.LoadDependentFriction.power(0.5, 50.0, -0.25)
    narrow = law_of(tmp_path, mu="{ value = 0.5, at = 0.05, exponent = -0.25, over = [0.01, 0.2] }").mu
    assert narrow == ss.LoadDependentFriction.power(0.5, 50.0, -0.25, (10.0, 200.0))


def test_an_array_shares_the_loads_among_its_elements(tmp_path):
    law = law_of(tmp_path, "microslip_array", more="elements = 4")
    assert law.elements(1, True).friction[0].limits(law.elements(1, True).normal.forces(0.0)).sum() == pytest.approx(
        float(ss.LoadDependentFriction((10.0, 100.0), (0.6, 0.4)).limit(50.0)), rel=1e-12
    )


@pytest.mark.parametrize(
    ("mu", "words"),
    [
        ("{ over = [0.01, 0.1], values = [0.6, 0.05] }", "must not fall faster than 1/N"),
        ("{ over = [0.01, 0.1] }", "must have over and values, or value, at and exponent"),
        ("{ over = [0.01, 0.1], values = [0.6] }", "must have 2 entries or more"),
        ("{ over = [0.01, 0.1], valves = [0.6, 0.4] }", "must be a known one, but is 'valves'. Did you mean 'values'"),
        ("{ value = 0.5, at = 0.05, exponent = -1.5 }", "between -1 and 1"),
        ("[0.5, 0.4]", "mu must be a single value or a table, but is"),
    ],
)
def test_what_is_no_table_is_refused(tmp_path, mu, words):
    with pytest.raises(InputError, match=words):
        law_of(tmp_path, mu=mu)


def test_lugre_takes_a_number_alone(tmp_path):
    with pytest.raises(InputError, match="mu of a lugre contact must be a number"):
        law_of(tmp_path, "lugre", more="mu_static = 0.7\nstribeck = 0.001")


def test_a_load_beyond_the_table_is_noted(tmp_path):
    made = job(STUDY.format(law="macroslip", mu="{ over = [0.001, 0.01], values = [0.6, 0.4] }", more=""), tmp_path, "study")
    said = " ".join(made.sweep.problem.warnings)
    assert "16.67 N at foot, whose mu is given from 1 to 10 N. Beyond them mu is constant, there 0.4." in said
    inside = job(STUDY.format(law="macroslip", mu=TABLE, more=""), tmp_path, "study")
    assert "mu is given" not in " ".join(inside.sweep.problem.warnings)
