"""Figures as PNG and SVG files, reproducible and written atomically."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip.show.plots.chart import Chart
from stickslip.show.plots.look import house_style
from stickslip.support.files import replacing
from stickslip.support.late import xr

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Figures = Mapping[str, Callable[[Any], "Chart | Figure"]]
"""Name of the file: function from a dataset to its chart, or to a drawing where it has no curves."""


def write_figures(
    figures: Figures, dataset: xr.Dataset, directory: str | Path, formats: tuple[str, ...] = ("png", "svg")
) -> list[Path]:
    """Every figure of a dataset in every format; returns the paths."""
    paths = []
    for name, draw in figures.items():
        drawn = draw(dataset)
        figure = drawn.plot() if isinstance(drawn, Chart) else drawn
        for suffix in formats:
            path = Path(directory) / f"{name}.{suffix}"
            write_figure(figure, path, suffix)
            paths.append(path)
    return paths


def write_figure(figure: Figure, path: Path, suffix: str) -> None:
    """Save without the date, so that equal figures are equal files."""
    dated: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with house_style(), replacing(path) as temporary:
        figure.savefig(temporary, format=suffix, metadata=dated.get(suffix))
