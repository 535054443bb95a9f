"""The look of figures: colours that every reader can distinguish on light, dark and paper, dashes, sizes, thin frames.

A layer of a chart names its colour by what it shows ("level 2/6", "contact 0", "failed"); `colour` gives the value.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.results.view import spread
from stickslip.support.checks import Array
from stickslip.support.late import Figure

STICK, SLIP, OPEN = "#2b6ca3", "#f2a33a", "#f7f4ee"
"""States of a contact, ordered in lightness too: dark blue, orange, near white."""
CONTACTS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#8c6d31", "#666666")
"""Okabe and Ito's colours without yellow; the last one for what is grouped as "others"."""
_CONTACTS_ON_DARK = ("#4ba3e3", "#e9ad2b", "#2bbf94", "#df9cc2", "#8accf5", "#f58a4b", "#c6a15f", "#a3a9b0")
GREY = "#6b7078"
_NAMED = {
    "ink": ("#000000", "#e6e9ec"),
    "paper": ("#ffffff", "#15181c"),
    "grey": (GREY, "#a0a9b3"),
    "pale": ("#c9cdd2", "#59626d"),
    "text": ("#1b1f24", "#e6e9ec"),
    "grid": ("#d6dbe0", "#3a424b"),
    "failed": ("#c1272d", "#ff8a80"),
    "stick": (STICK, STICK),
    "slip": (SLIP, SLIP),
    "open": (OPEN, OPEN),
    "half": ("#8f886f", "#8f886f"),
    "microslip": ("#8fa6a0", "#8fa6a0"),
    "lift-off": (CONTACTS[3], CONTACTS[3]),
}
"""Colours by name, on light and on dark."""

PAGE = 11.7
"""The long side of a page (A4), inches: no figure is wider or higher."""
WIDTH = 7.6
"""Width of a figure with its legend, inches."""
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

Dash = Literal["solid", "dash", "dot", "dashdot", "none"]
Marker = Literal["", "circle", "ring", "cross", "diamond", "square", "star"]


@dataclass(frozen=True)
class Style:
    """How a layer is drawn: the name of its colour, dash and width of its line in points, marker and its size in points."""

    colour: str = "ink"
    dash: Dash = "solid"
    width: float = 1.7
    marker: Marker = ""
    size: float = 4.0
    opacity: float = 1.0


LOWER, UPPER = Style("contact 0", marker="circle", size=3), Style("contact 5", marker="circle", size=3)
"""The bounds of a response or of a peak."""
BETWEEN = Style("contact 4", opacity=0.2)
"""The area between bounds."""
FREE, STUCK = Style("grey", "dot", 1.0, opacity=0.8), Style("grey", "dash", 1.0, opacity=0.8)
"""The linear structure without contacts and with all of them stuck."""
OUTSIDE = Style("grey")
"""The part of a curve outside its band."""
SAMPLE = Style("grey", width=0.6, opacity=0.7)
"""One of many samples."""
EMPHASIS = Style("ink")
"""What stands out among many curves: a median, an envelope, virgin contacts."""
CROSS = Style("failed", "none", marker="cross", size=5)
"""A point that was not solved."""


def level(place: int, count: int, **more: Any) -> Style:
    """One of `count` force levels, or of other cases in an order, from cool to warm."""
    return Style(f"level {place}/{count}", **more)


def contact(place: int, **more: Any) -> Style:
    """One of several contacts, or of other things without an order."""
    return Style(f"contact {place % len(CONTACTS)}", **more)


def colour(name: str, dark: bool = False) -> str:
    """The value of a colour by its name, on a light or a dark background."""
    kind, _, place = name.partition(" ")
    if kind == "level":
        k, count = map(int, place.split("/"))
        return level_colours(count, dark)[k]
    return (_CONTACTS_ON_DARK if dark else CONTACTS)[int(place)] if kind == "contact" else _NAMED[name][dark]


@contextmanager
def house_style() -> Iterator[None]:
    """Draw with `STYLE`, whatever the user's settings; they are restored afterwards."""
    from matplotlib import style

    with style.context(["default", STYLE]):
        yield


def level_colours(count: int, dark: bool = False) -> list[str]:
    """`count` colours from cool to warm, their lightness in one order too, for a light or a dark background."""
    anchors = np.array([rgb(anchor) for anchor in (_LEVELS_ON_DARK if dark else _LEVELS_ON_LIGHT)])
    at = np.linspace(0.0, 1.0, max(count, 2))[:count] * (len(anchors) - 1)
    mixed = np.stack([np.interp(at, np.arange(len(anchors)), anchors[:, channel]) for channel in range(3)], axis=-1)
    return ["#" + "".join(f"{round(255 * channel):02x}" for channel in shade) for shade in np.clip(mixed, 0.0, 1.0)]


def state_colour(stick: ArrayLike, slip: ArrayLike, open_: ArrayLike) -> Array:
    """Shares of the period, each (...), as a mixture of the three state colours, (..., 3) from 0 to 1."""
    shares = np.stack([np.asarray(share, dtype=float) for share in (stick, slip, open_)], axis=-1)
    return np.asarray(shares @ np.array([rgb(colour) for colour in (STICK, SLIP, OPEN)]))


def shown_levels(levels: NDArray[Any]) -> tuple[NDArray[Any], str]:
    """Force levels that have a panel, evenly spread, and words on those that have none."""
    kept = spread(len(levels), MOST_PANELS)
    return levels[kept], f"{len(kept)} of {len(levels)} force levels" if len(kept) < len(levels) else ""


def entries(labels: Sequence[str]) -> list[str]:
    """Of labels, some of them equal, those that a legend shows."""
    different = list(dict.fromkeys(labels))
    return [different[place] for place in spread(len(different), MOST_ENTRIES)]


def level_lines(labels: Sequence[str], **more: Any) -> list[dict[str, Any]]:
    """Style, label and whether a legend lists it, of the lines of cases in an order, one for each label."""
    listed = entries(labels)
    return [{"style": level(k, len(labels), **more), "label": label, "listed": label in listed} for k, label in enumerate(labels)]


def headed(figure: Figure, text: str, words: str = "") -> None:
    """The head of a figure, with a line on what it leaves out."""
    lines = [text, *([words[:1].upper() + words[1:]] if words else [])]
    figure.suptitle(plain("\n".join(lines)), x=0.01, ha="left", fontweight="bold", fontsize=10.5)


def spoken(name: str) -> str:
    """A variable or parameter of a study in words."""
    symbols = {"mu": "friction coefficient", "kt": "tangential stiffness", "kn": "normal stiffness"}
    return symbols.get(name, name.replace("_", " "))


def plain(name: str) -> str:
    """A name as it is: matplotlib would read text between dollar signs as a formula."""
    return str(name).replace("$", r"\$")


def rgb(colour: str) -> Array:
    """Red, green and blue, 0 to 1, of a hexadecimal colour."""
    return np.array([int(colour[start : start + 2], 16) for start in (1, 3, 5)]) / 255.0
