"""Settings that are declared once, on an analysis of a few fields: arguments in Python, table of a study, name of a case."""

from __future__ import annotations

import inspect
import pickle
from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from typing import Annotated, Any, Literal, get_args, get_type_hints

import pytest
from pydantic import Field

import stickslip as ss
from stickslip.analyses.controlled_response import ControlledResponseWork
from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.settings import ForcedResponseSettings, Setting, Settings, Whole, takes
from stickslip.study.faults import parsed
from stickslip.study.fields import Positive, check_of, table_of
from stickslip.support.checks import Faults, InputError, among, positive, unique
from tools.reference import rows

RIG = ss.rigs.single_mass()


Scale = Literal["fine", "coarse"]


def _scale(name: str, value: Any) -> str:
    return among(name, value, get_args(Scale))


def _sizes(name: str, value: Any) -> tuple[float, ...]:
    found = tuple(positive(name, each) for each in (value if isinstance(value, list | tuple) else [value]))
    unique(name, found)
    return found


@dataclass(frozen=True, eq=False)
class Weighing(Settings):
    size: Annotated[float | Sequence[float], Setting(_sizes, "of the samples")]
    _: KW_ONLY
    scale: Annotated[Scale, Setting(_scale, "its steps")] = "fine"
    repeats: Annotated[int, Setting(Whole(1, 9), "of each sample", key="times")] = 2
    place: Annotated[int, Setting(Whole(0))] = 0
    workers: int = 1
    progress: Callable[[float, str], None] = lambda share, text: None


@takes(Weighing)
def weighed(weighing: Weighing) -> Weighing:
    """What is weighed."""
    return weighing


def test_arguments_are_those_of_the_dataclass_and_the_docstring_is_of_the_function():
    parameters = inspect.signature(weighed).parameters
    assert {name: each.default for name, each in parameters.items() if name != "progress"} == {
        "size": inspect.Parameter.empty,
        "scale": "fine",
        "repeats": 2,
        "place": 0,
        "workers": 1,
    }
    assert parameters["repeats"].annotation is int
    assert parameters["size"].kind is inspect.Parameter.POSITIONAL_OR_KEYWORD
    assert parameters["scale"].kind is inspect.Parameter.KEYWORD_ONLY
    assert inspect.signature(weighed).return_annotation == "Weighing"
    assert list(get_type_hints(weighed)) == [*parameters, "return"]
    assert (weighed.__name__, weighed.__doc__) == ("weighed", "What is weighed.")
    assert pickle.loads(pickle.dumps(weighed)) is weighed  # noqa: S301


@pytest.mark.parametrize(
    ("given", "message"),
    [({}, "size"), ({"size": 1.0, "sclae": "fine"}, "sclae")],
)
def test_a_missing_or_unknown_argument_is_an_error_of_the_function(given, message):
    with pytest.raises(TypeError, match=rf"^weighed\(\) .*{message}"):
        weighed(**given)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"size": -1.0}, "size must be positive"),
        ({"size": [1.0, 1.0]}, "size must be unique"),
        ({"size": 1.0, "repeats": 10}, "repeats must be at most 9"),
        ({"size": 1.0, "place": -1}, "place must be at least 0"),
        ({"size": 1.0, "scale": "rough"}, "scale must be one of fine, coarse"),
    ],
)
def test_every_marked_field_is_checked(given, message):
    with pytest.raises(InputError, match=message):
        weighed(**given)


def test_what_is_kept_is_what_the_check_returns_also_in_a_copy():
    weighing = weighed(2.0, repeats=3)
    assert weighing.size == (2.0,)
    assert replace(weighing, repeats=4).size == (2.0,)


def test_what_computes_the_cases_neither_travels_nor_names_them():
    weighing = weighed([1.0, 2.0], repeats=3, workers=4, progress=lambda share, text: None)
    assert weighing.identity() == "size (1.0, 2.0), scale 'fine', repeats 3, place 0"
    assert weighing.identity("size", "scale") == "repeats 3, place 0"
    there = pickle.loads(pickle.dumps(weighing))  # noqa: S301
    assert there.identity() == weighing.identity()
    assert there.workers == 1


def test_a_problem_is_named_by_its_fingerprint():
    work = ControlledResponseWork(RIG, [0.1], 0.1)
    assert f"problem {RIG.fingerprint}, band [0.1]" in work.identity()


TABLE = table_of(
    Weighing,
    "What is on the scales.",
    size=Annotated[list[Positive], Field(min_length=1)],
    note=(Annotated[str | None, Field(description="only in a file")], None),
)


def test_the_table_has_keys_types_defaults_ranges_and_meanings_of_the_settings():
    assert TABLE.__doc__ == "What is on the scales."
    assert list(rows(TABLE)) == [
        "| `size` | list of numbers | - | required | > 0 | of the samples |",
        '| `scale` | `"fine"`, `"coarse"` | - | `"fine"` | - | its steps |',
        "| `times` | whole number | - | `2` | ≥ 1, ≤ 9 | of each sample |",
        "| `note` | text | - | - | - | only in a file |",
    ]


def test_the_table_refuses_what_python_refuses():
    with pytest.raises(Faults, match=r"times must be at most 9, but is 10\.\nkey must be a known one, but is 'place'"):
        parsed(TABLE, {"size": [1.0], "times": 10, "place": 1})
    with pytest.raises(InputError, match=r"size must be unique, but 1\.0 is given more than once"):
        check_of(Weighing)(parsed(TABLE, {"size": [1.0, 1.0]}))


@dataclass(frozen=True, eq=False)
class Limited(Settings):
    size: Annotated[float, Setting(positive, "of the sample")]
    limit: Annotated[float | None, Setting(positive, "of the scale")] = None


def test_none_is_not_checked_where_it_is_the_default_and_nowhere_else():
    assert Limited(1.0).limit is None
    with pytest.raises(InputError, match=r"limit must be positive, but is -1\.0"):
        Limited(1.0, -1.0)
    with pytest.raises(InputError, match="size must be a number, but is None"):
        Limited(None)
    table = table_of(Limited, "A limit.")
    check_of(Limited)(parsed(table, {"size": 1.0}))
    with pytest.raises(InputError, match=r"limit must be positive, but is -1\.0"):
        check_of(Limited)(parsed(table, {"size": 1.0, "limit": -1.0}))


@dataclass(frozen=True, eq=False)
class WithDummy(ForcedResponseSettings):
    dummy: Annotated[int, Setting(Whole(1, 9), "a setting that a developer adds in one line")] = 2


def test_a_new_setting_of_a_forced_response_is_a_key_an_argument_part_of_the_name_of_a_case_and_of_the_results():
    works = [ForcedResponseWork.of(WithDummy(RIG, ss.hertz(0.1, 0.2), samples=64, dummy=dummy)) for dummy in (3, 4)]
    assert works[0].names != works[1].names
    assert "dummy 3" in works[0].so_far({}).attrs["settings"]
    with pytest.raises(InputError, match="dummy must be at most 9, but is 10"):
        WithDummy(RIG, ss.hertz(0.1, 0.2), dummy=10)
    assert "dummy" in inspect.signature(takes(WithDummy)(lambda settings: settings)).parameters
    table = table_of(WithDummy, "Where to compute.")
    meaning = "a setting that a developer adds in one line"
    assert f"| `dummy` | whole number | - | `2` | ≥ 1, ≤ 9 | {meaning} |" in rows(table)
    with pytest.raises(Faults, match="dummy"):
        parsed(table, {"dummy": 10})
