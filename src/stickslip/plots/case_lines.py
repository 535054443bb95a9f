"""Line styles for many cases: one colour per force level; start states thin, their median emphasised."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stickslip.plots.look import level_colours
from stickslip.results.representative import is_cloud, levels_of, representative_starts
from stickslip.results.view import force_text, level_text

if TYPE_CHECKING:
    import xarray as xr

Line = dict[str, Any]
"""How matplotlib is to draw a line: colour, label, width."""
THIN = {"linewidth": 0.6, "alpha": 0.45}


def case_lines(dataset: xr.Dataset) -> list[Line]:
    """Colour, label and width of the line of each case. Lines of one level have one label, which a legend then shows once."""
    groups = levels_of(dataset)
    lines: dict[int, Line] = {}
    for cases, colour in zip(groups, level_colours(len(groups)), strict=True):
        middle = median(dataset, cases)
        for case in cases:
            if not is_cloud(dataset):
                lines[case] = {"color": colour, "label": level_text(dataset, case)}
            elif case == middle:
                lines[case] = {"color": colour, "label": f"{force_text(dataset, case)}, median", "zorder": 3}
            else:
                lines[case] = {"color": colour, "label": f"{force_text(dataset, case)}, {len(cases)} start states", **THIN}
    return [lines[case] for case in range(dataset.sizes["case"])]


def median(dataset: xr.Dataset, cases: list[int]) -> int:
    """The start state whose highest peak is the median one."""
    found = representative_starts(dataset, cases)
    return found[len(found) // 2]
