"""Lines of many cases: one colour per force level; start states thin, their median emphasised."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stickslip.results.representative import is_cloud, levels_of, representative_starts
from stickslip.results.view import force_text, level_text
from stickslip.show.plots.look import Style, entries, level

if TYPE_CHECKING:
    import xarray as xr

THIN = 0.6
"""Width of the line of a start state."""


def case_lines(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """Style, label and whether a legend lists it, of the line of each case. Lines of one level have one label."""
    groups = levels_of(dataset)
    styles: dict[int, Style] = {}
    labels: dict[int, str] = {}
    for place, cases in enumerate(groups):
        starts = representative_starts(dataset, cases)
        middle = starts[len(starts) // 2]  # the start state whose highest peak is the median one
        for case in cases:
            thin = is_cloud(dataset) and case != middle
            styles[case] = level(place, len(groups), **({"width": THIN, "opacity": 0.45} if thin else {}))
            if not is_cloud(dataset):
                labels[case] = level_text(dataset, case)
            else:
                labels[case] = f"{force_text(dataset, case)}, {f'{len(cases)} start states' if thin else 'median'}"
    listed = entries([labels[case] for case in range(len(labels))])
    return [{"style": styles[case], "label": labels[case], "listed": labels[case] in listed} for case in range(len(labels))]
