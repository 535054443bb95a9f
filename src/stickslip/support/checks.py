"""Argument checks and error messages.

Every message has four parts: what is wrong, the rule, the value found and, where there is one, the remedy.
"""

import difflib
import unicodedata
from collections.abc import Iterable, Sequence
from datetime import date, time
from itertools import islice
from numbers import Complex
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

Kind = TypeVar("Kind")
Array = NDArray[np.float64]
Index = NDArray[np.int64]


SMALLEST, LARGEST = 1e-40, 1e40
"""Sizes of numbers: beyond them squares and products leave the range of floating point, and nothing physical lies there."""

MOST = 100_000
"""Points, start states or designs of one analysis: more is a slip of the pen, and would compute for months."""
LARGEST_SEED = 2**63 - 1
LARGEST_DENSE = 20_000
"""Rows of a sparse matrix that is made dense: more need gigabytes, and their eigenvalues hours."""


class InputError(ValueError):
    """Wrong input. The message states what is wrong, the rule, the value and the remedy."""


class Faults(InputError):
    """Several faults of one input, found in one pass."""

    def __init__(self, faults: Sequence[str]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(self.faults))

    def __reduce__(self) -> "tuple[type[Faults], tuple[tuple[str, ...]], dict[str, Any]]":
        return Faults, (self.faults,), self.__dict__


def fault(what: str, rule: str, value: Any, remedy: str = "") -> InputError:
    """The error for `what`, which `rule` ("must be positive") but is `value`."""
    huge = isinstance(value, int) and abs(value) > LARGEST  # Python does not even write one of many thousand digits
    shown = "a huge integer" if huge else f"the date or time {value}" if isinstance(value, date | time) else repr(value)
    return InputError(f"{what} {rule}, but is {shown}." + (f" {remedy}" if remedy else ""))


def finite(what: str, value: float) -> float:
    """`value` as a float; refused when it is NaN or infinite, a text or a truth value."""
    if isinstance(value, str | bytes | bool | np.bool_):
        raise fault(what, "must be a number", value)
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise fault(what, "must be a number", value) from None
    except OverflowError:
        raise fault(what, f"must not be larger than {LARGEST:g} in size", value, "Check its unit.") from None
    if not np.isfinite(number):
        raise fault(what, "must be finite", number)
    if abs(number) > LARGEST:
        raise fault(what, f"must not be larger than {LARGEST:g} in size", number, "Check its unit.")
    return number


def finite_complex(what: str, value: Any, rule: str = "must be a number") -> complex:
    """`value` as a complex number; refused when it is NaN or infinite, a text or a truth value."""
    if isinstance(value, bool) or not isinstance(value, Complex):
        raise fault(what, rule, value)
    try:
        number = complex(value)
    except OverflowError:
        raise fault(what, f"must not be larger than {LARGEST:g} in size", value, "Check its unit.") from None
    for part in (number.real, number.imag):
        finite(what, part)
    return number


def positive(what: str, value: float) -> float:
    """`value` as a float; refused unless it is above zero."""
    number = finite(what, value)
    if number <= 0.0:
        raise fault(what, "must be positive", number)
    if number < SMALLEST:
        raise fault(what, f"must be at least {SMALLEST:g}", number, "Check its unit.")
    return number


def not_negative(what: str, value: float) -> float:
    """`value` as a float; refused when it is below zero."""
    number = finite(what, value)
    if number < 0.0:
        raise fault(what, "must not be negative", number)
    return number


SHOWN = 20
"""Entries of an array that a message lists."""


def numbers(what: str, value: ArrayLike) -> Array:
    """`value` as an array of floats; refused when it holds something else."""
    try:
        array = np.asarray(value)
        if array.dtype.kind in "USb":
            raise TypeError
        if not (np.iscomplexobj(array) and np.any(array.imag)):
            return np.asarray(array.real, dtype=float)
    except (TypeError, ValueError):
        raise fault(what, "must hold numbers", value) from None
    except OverflowError:
        raise fault(what, f"must not be larger than {LARGEST:g} in size", "a huge integer", "Check its unit.") from None
    raise fault(what, "must be real", f"complex, as {complex(array.flat[np.argmax(array.imag != 0.0)])}")


def vector(what: str, value: ArrayLike, size: int | None = None) -> Array:
    """`value` as a finite vector, of length `size` when given; a scalar is repeated."""
    array = numbers(what, value)
    if array.ndim == 0:
        array = np.full(1 if size is None else size, float(array))
    if array.ndim != 1 or (size is not None and array.size != size):
        given = array.tolist() if array.size <= SHOWN else f"of shape {array.shape}"
        raise fault(what, f"must have {'one axis' if size is None else counted(size, 'entry', 'entries')}", given)
    if not np.all(np.isfinite(array)):
        first = int(np.argmin(np.isfinite(array)))
        raise fault(what, "must be finite", array.tolist() if array.size <= SHOWN else f"{array[first]} at entry {first + 1}")
    if np.any(np.abs(array) > LARGEST):
        raise fault(what, f"must not be larger than {LARGEST:g} in size", array.tolist(), "Check its unit.")
    return array


def square(what: str, value: ArrayLike, size: int | None = None) -> Array:
    """`value`, dense or a SciPy sparse matrix of any format, as a finite square matrix, (size, size) when given."""
    array = numbers(what, _dense(what, value) if hasattr(value, "toarray") else value)
    if array.ndim != 2 or array.shape[0] != array.shape[1]:
        raise fault(what, "must be a square matrix", array.shape, "Give as many rows as columns.")
    if size is not None and array.shape[0] != size:
        raise fault(what, f"must have shape ({size}, {size})", array.shape)
    if not np.all(np.isfinite(array)):
        row, column = np.argwhere(~np.isfinite(array))[0]
        raise fault(f"{what}[{row}, {column}]", "must be finite", float(array[row, column]))
    if array.size and float(np.max(np.abs(array))) > LARGEST:
        raise fault(what, f"must not be larger than {LARGEST:g} in size", float(np.max(np.abs(array))), "Check its unit.")
    return array


def _dense(what: str, stored: Any) -> ArrayLike:
    """A sparse matrix as a dense one, where that is sensible."""
    shape = tuple(stored.shape)
    if len(shape) != 2 or shape[0] != shape[1]:
        raise fault(what, "must be a square matrix", shape, "Give as many rows as columns.")
    if shape[0] > LARGEST_DENSE:
        remedy = "A structure is dense: reduce the model first, as `ss.read_structure` does."
        raise fault(what, f"must have at most {LARGEST_DENSE} rows", shape[0], remedy)
    dense: ArrayLike = stored.toarray()
    return dense


def symmetric(what: str, value: ArrayLike, size: int | None = None, tolerance: float = 1e-8) -> Array:
    """`value` as a square matrix equal to its transpose within `tolerance` of its largest entry; returned exactly symmetric."""
    array = square(what, value, size)
    scale = float(np.max(np.abs(array), initial=0.0))
    gap = np.abs(array - array.T)
    if gap.size and float(gap.max()) > tolerance * scale:
        row, column = np.unravel_index(int(gap.argmax()), gap.shape)
        raise fault(
            what,
            "must be symmetric",
            f"{what}[{row}, {column}] = {array[row, column]:g} against {what}[{column}, {row}] = {array[column, row]:g}",
            "Only one triangle stored? Fill the other; else check the export.",
        )
    return np.asarray(0.5 * (array + array.T))


def whole(what: str, value: Any, remedy: str = "") -> int:
    """`value` as an int; refused when it is no whole number."""
    try:
        number = int(value)
    except (TypeError, ValueError, OverflowError):
        raise fault(what, "must be a whole number", value, remedy) from None
    if isinstance(value, bool | str) or number != value:
        raise fault(what, "must be a whole number", value, remedy)
    return number


def between(what: str, value: Any, least: int, most: int = MOST) -> int:
    """`value` as a whole number from `least` to `most`."""
    number = whole(what, value)
    if number < least:
        raise fault(what, f"must be at least {least}", number)
    if number > most:
        raise fault(what, f"must be at most {most}", number)
    return number


def seed_of(value: Any) -> int:
    """A seed of random draws, as it fits into a results file."""
    return between("seed", value, 0, LARGEST_SEED)


def truth(what: str, value: Any) -> bool:
    """`value`, refused unless it is True or False."""
    if not isinstance(value, bool | np.bool_):
        raise fault(what, "must be True or False", value)
    return bool(value)


def among(what: str, value: Any, known: Iterable[str]) -> str:
    """`value`, refused unless it is one of the known words."""
    words = list(known)
    if not isinstance(value, str) or value not in words:
        raise fault(what, f"must be one of {', '.join(words)}", value)
    return value


def of_kind(what: str, value: Any, kind: type[Kind]) -> Kind:
    """`value`, refused unless it is of a class."""
    if not isinstance(value, kind):
        raise fault(what, f"must be a {kind.__name__}", value)
    return value


def unique(what: str, names: Sequence[Any]) -> None:
    """Refuse what stands twice in `names`."""
    repeated = [name for name in dict.fromkeys(names) if list(names).count(name) > 1] if len(set(names)) < len(names) else []
    if repeated:
        listed = ", ".join(repr(name) for name in repeated)
        raise InputError(f"{what} must be unique, but {listed} {'is' if len(repeated) == 1 else 'are'} given more than once.")


def several(what: str, values: Iterable[Any]) -> tuple[Any, ...]:
    """`values` as a tuple; one value alone is refused, a text too, whose letters would pass for names."""
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise fault(what, "must be a tuple or list", values, "For a single one write (...,).")
    return tuple(values)


def is_definite(matrix: Array, shift: float = 0.0) -> bool:
    """Whether all eigenvalues of a symmetric or Hermitian matrix are larger than −shift.

    A Cholesky factorisation shows it in a tenth of the time of eigenvalues.
    """
    try:
        np.linalg.cholesky(matrix + np.diag(np.full(len(matrix), shift)))
    except np.linalg.LinAlgError:
        return False
    return True


def storable(what: str, text: str) -> str:
    """`text` as it can stand in a results file and on one line of a table: without control characters."""
    if not isinstance(text, str):
        raise fault(what, "must be a text", text)
    if not text.isprintable() and any(unicodedata.category(character) in ("Cc", "Cs") for character in text):
        raise fault(what, "must hold no control characters", text)
    return text


def counted(number: int, singular: str, plural: str = "") -> str:
    """`1 entry`, `2 entries`."""
    return f"{number} {singular if number == 1 else plural or singular + 's'}"


def in_percent(share: float, sign: str = "") -> str:
    """A share in per cent to two digits, or to the last one where it has more: `0.55 %`, `140 %`; sign: "+" to say it always."""
    digits = ".2g" if abs(share) < 0.995 else ".0f"
    return f"{100.0 * share:{sign}{digits}} %"


def listed(words: Sequence[str]) -> str:
    """`a, b and c`."""
    return " and ".join(filter(None, [", ".join(words[:-1]), words[-1]]))


LISTED = 6
"""Of many things, those that a sentence names."""


def first_of(words: Sequence[str], most: int = LISTED) -> str:
    """`a, b, ... (7 in all)`: the first of many words."""
    return ", ".join(words[:most]) + (f", ... ({len(words)} in all)" if len(words) > most else "")


def similar(word: str, known: Iterable[str], likeness: float = 0.5) -> str:
    """A remedy that names the known word nearest to `word`; empty where none is as near as `likeness`, 1 for the same word."""
    close = difflib.get_close_matches(word, list(known), n=1, cutoff=likeness)
    return f"Did you mean {close[0]!r}?" if close else ""


def similar_file(path: Path) -> str:
    """A remedy that names the file beside a missing one whose name is nearest to it, empty where none is near."""
    try:
        names = [each.name for each in islice(path.parent.iterdir(), MOST) if each.name != path.name]
    except OSError:
        return "" if path.parent.is_dir() else f"The folder {str(path.parent)!r} does not exist."
    return similar(path.name, names, 0.7)


def nearest(word: str, known: Iterable[str]) -> str:
    """A remedy that names the known word nearest to `word`, or lists a few."""
    names = list(known)
    if meant := similar(word, names):
        return meant
    listed = ", ".join(names[:8]) + (", ..." if len(names) > 8 else "")
    return f"Known: {listed}." if names else "None is known."


def existing(what: str, paths: Sequence[Path]) -> None:
    """Refuse paths that are no files."""
    for path in paths:
        if path.is_dir():
            raise fault(what, "must be a file", f"{path}, a folder", f"Name the files in it, such as {path}/*.csv.")
        if path.exists() and not path.is_file():
            raise fault(what, "must be a file", f"{path}, a device or pipe")
    if missing := [str(path) for path in paths if not path.is_file()]:
        raise fault(what, "must be a file that exists", ", ".join(missing), similar_file(Path(missing[0])))


def digits_between(low: float, high: float, least: int) -> int:
    """Digits with which the ends of an interval differ by ten units of the last one, `least` at least: 1.3699e5 to 1.3701e5."""
    size, width = max(abs(low), abs(high)), abs(high - low)
    if not (np.isfinite(size) and width > 0.0):
        return least
    return int(np.clip(np.floor(np.log10(size)) - np.floor(np.log10(width)) + 2.0, least, 12))


def rounded(value: float, digits: int) -> str:
    """A number with so many digits, without an exponent where a reader would not write one: `120`, never `1.2e+02`."""
    return f"{float(f'{value:.{digits}g}'):.15g}" if abs(value) < 1e7 else f"{value:.{digits}g}"
