"""The common style of figures and report: colours that every reader can distinguish, sizes, thin frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.checks import Array
from stickslip.results.representative import spread

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.legend import Legend

STICK, SLIP, OPEN = "#2b6ca3", "#f2a33a", "#f7f4ee"
"""States of a contact, ordered in lightness too: dark blue, orange, near white."""
CONTACTS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#8c6d31", "#666666")
"""Okabe and Ito's colours without yellow; the last one for what is grouped as "others"."""
GREY = "#6b7078"
FAILED = "#c1272d"

PAGE = 11.7
"""The long side of a page (A4), inches: no figure is wider or higher."""
MOST_ENTRIES = 10
"""Entries of a legend; of more, evenly spread ones stand for those between, whose colours lie between too."""
MOST_PANELS = 4
"""Panels, one a force level, below each other."""

_LEVELS_ON_LIGHT = ("#0d0887", "#5c01a6", "#9c179e", "#cc4778", "#e8704f", "#f0a01e")
_LEVELS_ON_DARK = ("#7d7aff", "#a680fa", "#d082dc", "#f7929a", "#fcb865", "#f5ec7a")

STYLE: dict[str, Any] = {
    "font.size": 9.5,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#555555",
    "axes.linewidth": 0.8,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.7,
    "lines.solid_joinstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "xtick.color": "#333333",
    "ytick.color": "#333333",
    "figure.dpi": 120,
    "savefig.dpi": 160,
    "svg.hashsalt": "stickslip",
}


@contextmanager
def house_style() -> Iterator[None]:
    """Draw with `STYLE`, whatever the user's settings; they are restored afterwards."""
    from matplotlib import style

    with style.context(["default", STYLE]):
        yield


def level_colours(count: int, dark: bool = False) -> list[str]:
    """`count` colours from cool to warm, their lightness in one order too, for a light or a dark background."""
    anchors = _LEVELS_ON_DARK if dark else _LEVELS_ON_LIGHT
    return [_hex(colour) for colour in _between(anchors, np.linspace(0.0, 1.0, max(count, 2))[:count])]


def state_colour(stick: ArrayLike, slip: ArrayLike, open_: ArrayLike) -> Array:
    """Shares of the period, each (...), as a mixture of the three state colours, (..., 3) from 0 to 1."""
    shares = np.stack([np.asarray(share, dtype=float) for share in (stick, slip, open_)], axis=-1)
    return np.asarray(shares @ np.array([_rgb(colour) for colour in (STICK, SLIP, OPEN)]))


def legend(axes: Axes | Figure, handles: Sequence[Any] | None = None, **place: Any) -> Legend:
    """The legend of at most `MOST_ENTRIES` different entries; it gives their number where some are left out."""
    found = axes.get_legend_handles_labels()[0] if handles is None else handles  # type: ignore[union-attr]
    different = {str(handle.get_label()): handle for handle in reversed(found)}
    shown = [different[label] for label in entries([*different][::-1])]
    title = f"{len(shown)} of {len(different)}" if len(shown) < len(different) else None
    return axes.legend(handles=shown, title=title, title_fontsize=8.5, **place)


def shown_levels(levels: NDArray[Any]) -> tuple[NDArray[Any], str]:
    """Force levels that have a panel, evenly spread, and words on those that have none."""
    kept = spread(len(levels), MOST_PANELS)
    return levels[kept], f"{len(kept)} of {len(levels)} force levels" if len(kept) < len(levels) else ""


def entries(labels: Sequence[str]) -> list[str]:
    """Of labels, some of them equal, those that a legend shows."""
    different = list(dict.fromkeys(labels))
    return [different[place] for place in spread(len(different), MOST_ENTRIES)]


def beside(axes: Axes, handles: Sequence[Any] | None = None) -> Legend:
    """The legend to the right of the axes."""
    return legend(axes, handles, loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)


def headed(figure: Figure, text: str, words: str = "") -> None:
    """The head of a figure, with a line on what it leaves out."""
    lines = [text, *([words[:1].upper() + words[1:]] if words else [])]
    figure.suptitle(plain("\n".join(lines)), x=0.01, ha="left", fontweight="bold", fontsize=10.5)


def plain(name: str) -> str:
    """A name as it is: matplotlib would read text between dollar signs as a formula."""
    return str(name).replace("$", r"\$")


def _between(anchors: Sequence[str], positions: Array) -> Array:
    colours = np.array([_rgb(anchor) for anchor in anchors])
    at = positions * (len(anchors) - 1)
    return np.stack([np.interp(at, np.arange(len(anchors)), colours[:, channel]) for channel in range(3)], axis=-1)


def _rgb(colour: str) -> Array:
    return np.array([int(colour[start : start + 2], 16) for start in (1, 3, 5)]) / 255.0


def _hex(colour: Array) -> str:
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in np.clip(colour, 0.0, 1.0))
