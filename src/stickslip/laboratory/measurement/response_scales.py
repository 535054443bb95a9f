"""What measured responses say of their units by themselves: units that were assumed, and tests a thousand times apart."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from stickslip.laboratory.measurement.measured_response import MeasuredResponse
from stickslip.support.checks import Array, first_of

LISTED = 4
"""Names that a sentence lists."""

THOUSAND = (300.0, 3000.0)
"""Ratio of the responses per force of two tests that a unit a thousand times another explains: friction moves them by less than
three, but for the resonance."""

SAMPLES = 50
"""Frequencies at which two tests are compared."""


def assumed_units(tests: Sequence[MeasuredResponse]) -> list[str]:
    """For each set of units that files do not state: the files, the columns and what was assumed."""
    sets: dict[tuple[tuple[str, str], ...], list[str]] = {}
    for test in tests:
        lacking = tuple((key, unit.text) for key, unit in test.units.items() if unit.assumed)
        if lacking:
            sets.setdefault(lacking, []).append(test.name)
    return [
        f"No unit is stated of {listed([key for key, _ in lacking])} in {first_of(names, LISTED)}: "
        f"{listed([unit for _, unit in lacking])} {'is' if len(lacking) == 1 else 'are'} assumed."
        for lacking, names in sets.items()
    ]


def joined(notes: Sequence[tuple[str, str]]) -> list[str]:
    """Sentences on tests, (name, sentence) each: those that differ in the name alone as one, and each once."""
    alike: dict[tuple[str, str], dict[str, None]] = {}
    for name, note in notes:
        places = list(re.finditer(rf"\b{re.escape(name)}(\.[A-Za-z]\w*)?(?!\w)", note))  # the test, or its file
        if len(places) == 1:
            (place,) = places
            alike.setdefault((note[: place.start()], note[place.end() :]), {})[place.group()] = None
        else:
            alike.setdefault((note, ""), {})
    return [f"{start}{first_of(list(names), LISTED)}{end}" for (start, end), names in alike.items()]


def listed(words: Sequence[str]) -> str:
    """`a, b and c`."""
    return " and ".join(filter(None, [", ".join(words[:-1]), words[-1]]))


def mixed_units(tests: Sequence[MeasuredResponse]) -> list[str]:
    """A sentence where the responses per force of some tests are about 1000 times those of others at the same frequencies."""
    found = []
    for quantity, output in dict.fromkeys((test.quantity, test.output) for test in tests):
        alike = [test for test in tests if (test.quantity, test.output) == (quantity, output)]
        ratios = {test.name: ratio for test in alike if (ratio := _ratio(test, alike[0])) is not None}
        groups = [
            [name for name, ratio in ratios.items() if low <= ratio <= high]
            for low, high in ((1.0 / THOUSAND[1], 1.0 / THOUSAND[0]), (0.2, 5.0), THOUSAND)
        ]
        for small, large in pairwise(groups):
            if small and large:
                found.append(
                    f"The responses per force of {first_of(large, LISTED)} are about 1000 times those of "
                    f"{first_of(small, LISTED)} at the same frequencies. Are the units of {quantity} and force the same?"
                )
    return found


def _ratio(test: MeasuredResponse, other: MeasuredResponse) -> float | None:
    """The median ratio of the responses per force of two tests at the frequencies of both; None where they have none."""
    curves = [_by_frequency(one) for one in (test, other)]
    low, high = max(f[0] for f, _ in curves), min(f[-1] for f, _ in curves)
    if not low < high:
        return None
    at = np.linspace(low, high, SAMPLES)
    sizes = [np.interp(at, f, size) for f, size in curves]
    return float(np.exp(np.median(sizes[0] - sizes[1])))


def _by_frequency(test: MeasuredResponse) -> tuple[Array, Array]:
    """Frequencies in order, and logarithms of the responses per force."""
    order = np.argsort(np.asarray(test.frequency), kind="stable")
    return np.asarray(test.frequency)[order], np.log(np.abs(test.per_force))[order]
