"""Old public names and arguments still work for one release, and warn of the new ones."""

import pytest
from each import each

import stickslip as ss
from stickslip import _RENAMED
from stickslip.support.renamed import renamed_arguments


@each(("old", "new"), _RENAMED.items())
def test_an_old_name_gives_the_new_object_with_a_warning(old, new):
    with pytest.warns(DeprecationWarning, match=rf"stickslip\.{old} is now stickslip\.{new}\."):
        found = getattr(ss, old)
    assert found is getattr(ss, new)
    assert old not in ss.__all__


@renamed_arguments(finished="checkpoint")
def analysis(problem, checkpoint=None):
    return problem, checkpoint


def test_an_old_argument_is_passed_on_with_a_warning():
    with pytest.warns(DeprecationWarning, match="The argument `finished` is now `checkpoint`"):
        assert analysis(1, finished=2) == (1, 2)
    assert analysis(1, checkpoint=2) == analysis(1, 2) == (1, 2)


def test_old_and_new_argument_together_are_refused():
    with pytest.raises(TypeError, match=r"analysis\(\) got both `finished` and `checkpoint`"):
        analysis(1, finished=2, checkpoint=2)


def test_a_forced_response_fills_a_checkpoint_given_under_the_old_names(tmp_path):
    with pytest.warns(DeprecationWarning, match="CheckpointFolder"):
        kept = ss.FinishedFolder(tmp_path)
    with pytest.warns(DeprecationWarning, match="`checkpoint`"):
        ss.forced_response(ss.rigs.single_mass(), [0.1, 0.2], 1.0, harmonics=1, finished=kept)
    assert len(kept) == 1


def test_an_old_property_gives_the_new_one_with_a_warning():
    problem = ss.rigs.single_mass()
    with pytest.warns(DeprecationWarning, match=r"Problem\.doubts is now Problem\.warnings\."):
        assert problem.doubts == problem.warnings
