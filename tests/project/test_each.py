"""Cases gathered in one test: all of them run, and the message names those that fail."""

import pytest
from each import each

RAN = []


@each("number", (1, 2, 3))
def squares(number):
    RAN.append(number)
    assert number**2 < 4


@each(("first", "second"), [(1, 1), (2, 1)], ids=("same", "other"))
def equal(second, first):
    assert first == second


@each("error", (ValueError, TypeError))
def raises(error):
    with pytest.raises(error):
        raise ValueError


def test_all_cases_run_and_those_that_fail_are_named():
    with pytest.raises(AssertionError, match=r"2 of 3 cases fail:\n\[2\] AssertionError: (.|\n)*\n\[3\]") as raised:
        squares()
    assert RAN == [1, 2, 3]
    assert isinstance(raised.value.__cause__, AssertionError)


def test_cases_of_several_values_and_names():
    with pytest.raises(AssertionError, match=r"1 of 2 cases fail:\n\[other\]"):
        equal()


def test_an_error_of_another_kind_fails_too():
    with pytest.raises(AssertionError, match=r"1 of 2 cases fail:\n\[TypeError\] ValueError"):
        raises()


@pytest.mark.parametrize("first", [4, 5])
@each("second", [6, 7])
def test_fixtures_and_parameters_of_pytest_stay(tmp_path, first, second):
    assert tmp_path.is_dir()
    assert first < second


def test_no_case_at_all_is_a_fault():
    with pytest.raises(AssertionError, match="no case"):
        each("number", ())
