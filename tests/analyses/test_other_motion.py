"""A higher motion that enters the band from outside is told, with where it is found.

Mass and stiffnesses of random problems, whose resonance leans over a narrow band: a curve that begins in the band stays below it.
"""

import numpy as np
import pytest

import stickslip as ss
from robustness.problems import random_case
from stickslip.show.report.answer import warnings_of

CASES = [("varying load", 20), ("lift-off", 64), ("varying load", 66)]
"""Two that lean to lower frequencies, and one to higher ones."""


@pytest.mark.parametrize(("kind", "seed"), CASES)
def test_the_band_decides(kind, seed):
    case = random_case(kind, seed)
    whole = ss.forced_response(case.problem, case.band, case.level)
    peak = whole.peaks().iloc[0]
    band = ss.Band(0.97 * peak["frequency"], 1.03 * peak["frequency"])
    narrow = ss.forced_response(case.problem, band, case.level)
    highest = float(np.nanmax(narrow.dataset["amplitude"].values))
    assert highest < 0.2 * peak["amplitude"]
    message = str(narrow.dataset["case_message"].values[0])
    assert "Another motion enters the band at" in message
    ratio = float(message.partition("Hz, with ")[2].partition(" times")[0])
    assert ratio == pytest.approx(peak["amplitude"] / highest, rel=0.02)
    assert "Another motion" in str(narrow)
    assert any("Another motion" in sentence for sentence in warnings_of(narrow.dataset))
    assert "Another motion" not in str(whole.dataset["case_message"].values[0])


def test_a_linear_structure_has_no_other_motion():
    structure = ss.Structure(np.eye(2), [[2.0, -1.0], [-1.0, 2.0]], ("1.x", "2.x"), damping=ss.ModalDamping(1e-3))
    problem = ss.Problem(structure, (), (ss.Force("1.x", 1.0),), ("1.x",))
    for band in (ss.Band(0.15, 0.18), ss.Band(0.3, 0.2)):
        assert "Another" not in str(ss.forced_response(problem, band).dataset["case_message"].values[0])
