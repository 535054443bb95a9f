"""Both renderers draw what a chart says: the same numbers, labels and legend; names stay names."""

from itertools import pairwise

import numpy as np
import pytest
from matplotlib.colors import to_hex
from plotly.graph_objects import Figure

from stickslip.results.schema import Result
from stickslip.show.plots.chart import Area, Axis, Bars, Cells, Chart, Key, Line, Panel, Rule, Shades, band, closed, edges_between
from stickslip.show.plots.interactive import description, plotly_figure
from stickslip.show.plots.look import FREE, Style, colour, contact, level
from stickslip.support.checks import InputError

X = np.linspace(1.0, 200.0, 30)
CURVE = Line(X, 5.0 / X, level(1, 4), "force × 5", {"phase in °": -X})
EVERYTHING = Chart(
    "Everything",
    [
        Panel(
            Axis("frequency", "Hz"),
            Axis("amplitude |X₁|", "µm", log=True),
            [
                CURVE,
                Line(X, 7.0 / X, FREE, "no contacts"),
                Rule(30.0, Style("grey"), "30 Hz"),
                band(X, 1.0 / X, 2.0 / X, contact(2)),
            ],
            "above",
        ),
        Panel(
            Axis("", names={0.0: "cylinder", 1.0: "flat"}),
            Axis("share", "%", limits=(0.0, 100.0)),
            [Bars([0.0, 1.0], [30.0, 60.0], Style("stick"), "shares", hover={"energy in J": [1.0, 2.0]})],
        ),
        Panel(
            Axis("frequency", "Hz"),
            Axis("", names={0.0: "cylinder"}, upside_down=True),
            [Cells([1.0, 2.0, 4.0], np.array([[[0.0, 0.0, 1.0], [np.nan] * 3]]), [["stick", ""]]), Key("stick", Style("stick"))],
        ),
        Panel(Axis("kt", "N/µm"), Axis("mass", "kg"), [Shades(X, X**2, X**3, Axis("peak", "µm"), 1e6, "designs")]),
    ],
    note="one of two",
)


def test_matplotlib_and_plotly_draw_the_same_numbers():
    axes, found = EVERYTHING.plot().axes, EVERYTHING.to_plotly()
    assert isinstance(found, Figure)
    line, trace = axes[0].lines[0], found.data[0]
    for letter, values in (("x", X), ("y", 5.0 / X)):
        np.testing.assert_array_equal(getattr(line, f"get_{letter}data")(), values)
        np.testing.assert_array_equal(getattr(trace, letter), values)
    assert line.get_label() == trace.name == "force × 5"
    assert to_hex(line.get_color()) == trace.line.color == colour("level 1/4")
    assert [bar.get_height() for bar in axes[1].patches] == list(next(t for t in found.data if t.type == "bar").y) == [30.0, 60.0]
    scattered = next(t for t in found.data if t.name == "designs")
    np.testing.assert_array_equal(axes[3].collections[0].get_offsets()[:, 1], scattered.y)
    np.testing.assert_array_equal(scattered.marker.color, X**3)


def test_axes_and_legend_are_the_same():
    figure, found = EVERYTHING.plot(), EVERYTHING.to_plotly()
    assert figure.axes[0].get_ylabel() == found.layout.yaxis.title.text == "amplitude |X₁| in µm"
    assert (figure.axes[0].get_yscale(), found.layout.yaxis.type) == ("log", "log")
    assert (
        [text.get_text() for text in figure.axes[1].get_xticklabels()]
        == list(found.layout.xaxis2.ticktext)
        == ["cylinder", "flat"]
    )
    assert tuple(found.layout.yaxis2.range) == figure.axes[1].get_ylim() == (0.0, 100.0)
    shown = {trace.name for trace in found.data if trace.showlegend} | {s.name for s in found.layout.shapes if s.showlegend}
    assert shown == {text.get_text() for text in figure.legends[0].get_texts()} == {*EVERYTHING.entries}
    assert figure.get_suptitle() == "Everything\nOne of two"
    assert found.layout.title.text == "<b>Everything</b><br>one of two"


def test_hovering_shows_quantities_with_their_units():
    trace = EVERYTHING.to_plotly().data[0]
    assert trace.hovertemplate == (
        "frequency %{x:.7~g} Hz<br>amplitude |X₁| %{y:.5~g} µm<br>phase %{customdata[0]:.4~g} °<extra>force × 5</extra>"
    )
    np.testing.assert_array_equal(np.array(trace.customdata, dtype=float).ravel(), -X)


def test_dark_figures_have_their_own_colours_and_no_name_of_a_colour_is_left():
    light, dark = (plotly_figure(EVERYTHING, scheme) for scheme in (False, True))
    assert light.data[0].line.color != dark.data[0].line.color == colour("level 1/4", dark=True)
    assert '"@' not in light.to_json() + dark.to_json()


def test_names_stay_names():
    hostile = '<a href="x">$x$</a>'
    chart = Chart(hostile, [Panel(Axis(hostile), Axis("y"), [Line([1.0, 2.0], [1.0, 2.0], Style(), "@level 0/1")])])
    found = chart.to_plotly()
    assert "<a" not in found.layout.title.text + found.layout.xaxis.title.text
    assert found.data[0].name == "&#64;level 0/1"
    chart.plot().draw_without_rendering()


def test_a_legend_shows_a_label_once_and_says_what_it_leaves_out():
    lines = [Line(X, k * X, level(k, 12), f"case {k}", listed=k < 3) for k in range(12)]
    chart = Chart("", [Panel(Axis("x"), Axis("y"), lines), Panel(Axis("x"), Axis("y"), lines)])
    assert list(chart.entries) == ["case 0", "case 1", "case 2"]
    assert chart.legend_title == "3 of 12"
    assert sum(trace["showlegend"] for trace in description(chart)["data"]) == 3


def test_panels_stand_below_each_other_on_a_narrow_screen():
    """Each keeps its height in pixels; side by side none overlaps the next."""
    panels = [Panel(Axis("x", "m"), Axis("y", names={0.0: "a long name of a case"}), [CURVE], f"panel {k}") for k in range(4)]
    found = description(Chart("", panels, columns=2))
    wide, narrow = (
        [[found[width][f"{letter}axis{k or ''}"]["domain"] for letter in "xy"] for k in ("", 2, 3, 4)]
        for width in ("wide", "narrow")
    )
    assert wide[0][0][1] < wide[1][0][0]
    assert wide[0][1] == wide[1][1]
    assert all(domain[0] == [0.0, 1.0] for domain in narrow)
    assert all(above[1][0] > below[1][1] for above, below in pairwise(narrow))
    heights = [
        (found[width]["height"] - found[width]["margin"]["t"] - found[width]["margin"]["b"])
        * np.ptp(found[width]["yaxis"]["domain"])
        for width in ("wide", "narrow")
    ]
    assert heights == pytest.approx([230.0, 230.0])


def test_bands_are_broken_where_a_bound_is_missing():
    area = band([1.0, 2.0, 3.0, 4.0, 5.0], [1.0, 1.0, np.nan, 1.0, 1.0], [2.0] * 5, Style())
    assert isinstance(area, Area)
    np.testing.assert_array_equal(area.x, [1.0, 2.0, 2.0, 1.0, np.nan, 4.0, 5.0, 5.0, 4.0, np.nan])
    figure = Chart("", [Panel(Axis("x"), Axis("y"), [area])]).plot()
    assert [len(path.vertices) for path in figure.axes[0].collections[0].get_paths()] == [5, 5]


def test_edges_lie_halfway_between_points():
    assert edges_between(np.array([1.0, 2.0, 4.0])).tolist() == [0.5, 1.5, 3.0, 5.0]
    np.testing.assert_allclose(edges_between(np.array([1.0, 4.0, 16.0]), log=True), [0.5, 2.0, 8.0, 32.0])
    assert closed([1.0, 2.0]).tolist() == [1.0, 2.0, 1.0]


def test_a_result_gives_plotly_figures_and_says_what_has_no_curves():
    class Drawn(Result):
        dataset = None

        def _figure(self, figure, options):
            return EVERYTHING.plot() if figure else EVERYTHING

    assert isinstance(Drawn().to_plotly(), Figure)
    assert Drawn().to_plotly(dark=True).layout.font.color == colour("text", dark=True)
    with pytest.raises(InputError, match=r"figure ring is a drawing without curves: plot\(\) draws it"):
        Drawn().to_plotly("ring")
