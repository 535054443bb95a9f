"""The page: layout and callbacks of Dash. `assets/explorer.js` pairs sliders with their numbers and asks for answers.

What is seen as a study file, and as Python code.

Serving of the page: on the loopback alone, under a random token, until Ctrl-C.
"""

import secrets
import socket
import time
from collections.abc import Mapping, Sequence
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from dash import ALL, MATCH, ClientsideFunction, Dash, Input, Output, State, ctx, dcc, html, no_update

from stickslip.analyses.settings import ForcedResponseSettings, marks
from stickslip.show.explorer import solving
from stickslip.show.explorer.solving import COARSE, OutdatedError, Slider, Solver, Values, varied
from stickslip.show.plots.deformed_shape import CONFIG as ALONE
from stickslip.show.plots.deformed_shape import step_script
from stickslip.show.plots.look import spoken
from stickslip.support.checks import InputError, between, fault, nearest
from stickslip.support.console import say

SAVED = "explored.toml"
HOW = [name for name, mark in marks(ForcedResponseSettings).items() if mark.means and not mark.key]
"""Settings of [sweep] whose keys are arguments of `forced_response`."""


def python_of(solver: Solver, values: Values) -> str:
    """Code that computes the response that is seen: with the rig where there is one, else from the study as a file."""
    document = varied(solver.document, solver.sliders, values)
    sweep = document["sweep"]
    lines = ["import stickslip as ss", ""]
    structure = document["structure"]
    simple = isinstance(structure, Mapping) and "rig" in structure and "start" not in structure.get("parameters", {})
    if simple and "outputs" not in sweep and "units" not in document:
        arguments = ", ".join(f"{key}={value!r}" for key, value in structure.get("parameters", {}).items())
        lines.append(f"problem = ss.rigs.{structure['rig']}({arguments})")
        where = f"ss.Band({', '.join(map(repr, sweep['frequency']))})" if "frequency" in sweep else repr(sweep["at"])
        settings = "".join(f", {key}={sweep[key]!r}" for key in HOW if key in sweep)
        lines.append(f"response = ss.forced_response(problem, {where}, {sweep['force_levels'][0]!r}{settings})")
    else:
        lines += [f"# {SAVED}: the study as saved, in the folder of {solver.name}.toml", f'problem = ss.read_problem("{SAVED}")']
        checked: Any = solver.job(values).sweep  # its frequencies are in Hz, whatever the units of the study
        where = repr(list(checked.band)) if checked.listed else f"ss.Band({checked.band.start!r}, {checked.band.stop!r})"
        settings = "".join(f", {key}={getattr(checked, key)!r}" for key in HOW)
        lines.append(f"response = ss.forced_response(problem, {where}, {checked.levels[0]!r}{settings})")
    return "\n".join([*lines, "print(response.peaks())", ""])


STEPS = 400
"""Steps of a slider."""
RATIOS, RATIO_REACH = 9, 3.0
"""Points of the performance curve, from the present ratio divided by this to it times this."""
CONFIG = ALONE | {"responsive": True}
NOTHING: dict[str, Any] = {"data": [], "layout": {"xaxis": {"visible": False}, "yaxis": {"visible": False}}}
"""The figure before the first answer."""

Wanted = Mapping[str, Any]


def application(solver: Solver, token: str) -> Dash:
    """The application, all of it under /TOKEN/."""
    app = Dash(
        "stickslip",
        title=f"{solver.name} – stickslip",
        update_title="",
        url_base_pathname=f"/{token}/",
        assets_folder=str(files("stickslip.show.explorer").joinpath("assets")),
        serve_locally=True,
    )
    app.index_string = app.index_string.replace("{%scripts%}", f"<script>{step_script()}</script>{{%scripts%}}")
    app.layout = _layout(solver)
    _add_client(app)
    _add_server(app, solver)
    return app


def _layout(solver: Solver) -> Any:
    shown = ""
    if solver.analysis != "forced_response":
        tuned = ", with all sectors alike" if solver.analysis == "mistuned_population" else ""
        shown = f"Forced response of the problem of this study{tuned}. The analysis of the study is {solver.analysis}."
    header = html.Header(
        [
            html.Div([html.H1(solver.job({}).title), html.P(shown, className="note")]),
            html.Div([_number("peak-frequency", "Peak at"), _number("peak-amplitude", "Amplitude")], className="numbers"),
        ]
    )
    stores = [dcc.Store(id=name) for name in ("wanted", "answer", "code", "place")]
    return html.Div(
        [
            dcc.Location(id="location", refresh=False),
            *stores,
            dcc.Store(id="start", data={slider.name: slider.value for slider in solver.sliders}),
            dcc.Download(id="download"),
            header,
            html.P("", id="message", role="status", **{"aria-live": "polite"}),
            html.Div(
                [
                    html.Progress(value="0", max="1", **{"aria-label": "Progress"}),
                    html.Span(""),
                    html.Button("Stop", id="stop", type="button"),
                ],
                id="doing",
                hidden=True,
            ),
            html.Main([_controls(solver, solver.outputs), _results()]),
        ],
        id="page",
    )


def _number(name: str, words: str) -> Any:
    return html.Div([html.Span(words, className="words"), html.Strong("…", id=name), html.Small("", id=f"{name}-change")])


def _controls(solver: Solver, outputs: Sequence[str]) -> Any:
    choice = (
        dcc.RadioItems(outputs, outputs[0], id="output")
        if len(outputs) < 5
        else html.Div(dcc.Dropdown(outputs, outputs[0], id="output", clearable=False))
    )
    buttons = [
        html.Button(words, id=name, type="button")
        for name, words in (
            ("pin", "Pin as reference"),
            ("reset", "Back to the study"),
            ("save", "Save as study"),
            ("copy", "Copy as Python"),
        )
    ]
    return html.Form(
        [
            html.H2("Parameters"),
            *map(_control, solver.sliders),
            html.Fieldset([html.Legend("Output"), choice]),
            dcc.Checklist([{"label": "Logarithmic scale", "value": "log"}], ["log"], id="scale"),
            html.Div(buttons, className="buttons"),
            html.Pre("", id="python", hidden=True, tabIndex=0),
        ],
        id="controls",
        **{"aria-label": "Parameters"},
    )


def _control(slider: Slider) -> Any:
    """A slider with its number: both hold the value, which the page keeps equal."""
    data = {
        "name": slider.name,
        "low": slider.low,
        "high": slider.high,
        "log": slider.logarithmic,
        "steps": STEPS,
        "value": slider.value,
    }
    label, place = f"{spoken(slider.name)}{f' in {slider.unit}' if slider.unit else ''}", {"name": slider.name}
    share = (
        np.log(slider.value / slider.low) / np.log(slider.high / slider.low)
        if slider.logarithmic
        else (slider.value - slider.low) / (slider.high - slider.low)
    )
    position, number = round(STEPS * float(share)), {"value": slider.value, "debounce": 0.4}
    return html.Div(
        [
            dcc.Store(id={"type": "slider", **place}, data=data),
            html.Label([html.Span(label), dcc.Input(id={"type": "number", **place}, type="number", step="any", **number)]),
            html.Div(dcc.Input(id={"type": "range", **place}, type="range", min=0, max=STEPS, step=1, value=position)),
        ],
        className="slider",
        title=label,
    )


def _results() -> Any:
    response = [
        dcc.Graph(id="curve", config=CONFIG, figure=NOTHING, style={"height": "470px"}),
        html.P(
            "Click a point of the curve, or the button below it, to see how the contacts and the structure move there.",
            className="note",
        ),
        html.Div(html.Button("Show the peak", id="show", type="button"), className="buttons"),
        html.Div(id="details"),
    ]
    performance = [
        html.P("Highest peak over the ratio of pull to excitation. The vertical line marks this study.", className="note"),
        dcc.Loading(dcc.Graph(id="performance", config=CONFIG, figure=NOTHING)),
        html.P("", id="performance-message"),
    ]
    tabs = [
        dcc.Tab(response, label="Response", value="response"),
        dcc.Tab(performance, label="Performance curve", value="performance"),
    ]
    return html.Section(dcc.Tabs(tabs, id="tabs", value="response"), id="results")


def _add_client(app: Dash) -> None:
    """Callbacks that run in the page."""

    def client(name: str) -> ClientsideFunction:
        return ClientsideFunction("explorer", name)

    both = [({"type": kind, "name": MATCH}, "value") for kind in ("range", "number")]
    app.clientside_callback(
        client("paired"),
        *(Output(*each) for each in both),
        *(Input(*each) for each in both),
        State({"type": "slider", "name": MATCH}, "data"),
        prevent_initial_call=True,
    )
    app.clientside_callback(
        client("want"),
        Output("wanted", "data"),
        Input({"type": "number", "name": ALL}, "value"),
        Input("output", "value"),
        Input("scale", "value"),
        Input("pin", "n_clicks"),
        State({"type": "slider", "name": ALL}, "data"),
        State("location", "href"),
    )
    app.clientside_callback(
        client("reset"), Output("reset", "title"), Input("reset", "n_clicks"), State("start", "data"), prevent_initial_call=True
    )
    shown = ["curve.figure", "peak-frequency.children", "peak-amplitude.children"]
    shown += ["peak-frequency-change.children", "peak-amplitude-change.children", "message.children", "page.className"]
    app.clientside_callback(
        client("show"), *(Output(*name.split(".")) for name in shown), Input("answer", "data"), prevent_initial_call=True
    )
    step = {"type": "step", "by": MATCH, "figure": MATCH}
    app.clientside_callback(client("step"), Output(step, "title"), Input(step, "n_clicks"), prevent_initial_call=True)
    app.clientside_callback(
        client("copied"),
        Output("python", "children"),
        Output("python", "hidden"),
        Input("code", "data"),
        prevent_initial_call=True,
    )


def _add_server(app: Dash, solver: Solver) -> None:
    """Callbacks that solve; each answers with nothing before the page wants something."""
    wanted = State("wanted", "data")
    app.callback(Output("answer", "data"), Input("wanted", "data"))(partial(_answered, solver))
    app.callback(
        Output("details", "children"),
        Input("show", "n_clicks"),
        Input("curve", "clickData"),
        State("answer", "data"),
        wanted,
        prevent_initial_call=True,
    )(partial(_detailed, solver))
    app.callback(
        Output("performance", "figure"),
        Output("performance-message", "children"),
        Input("tabs", "value"),
        Input("wanted", "data"),
    )(partial(_performed, solver))
    app.callback(Output("download", "data"), Input("save", "n_clicks"), wanted, prevent_initial_call=True)(
        lambda _, now: {"content": solver.study(now["values"]), "filename": SAVED} if now else no_update
    )
    app.callback(Output("code", "data"), Input("copy", "n_clicks"), wanted, prevent_initial_call=True)(
        lambda _, now: python_of(solver, now["values"]) if now else no_update
    )


def _answered(solver: Solver, wanted: Wanted | None) -> Any:
    """The answer to a request, or nothing where a newer one has come."""
    if not wanted:
        return no_update
    tab, version, fine = str(wanted["tab"]), int(wanted["version"]), bool(wanted["fine"])
    solver.ask(tab, version)
    head = {"version": version, "fine": fine}
    try:
        output = _output(solver, wanted)
        answer = solver.answer(wanted["values"], None if fine else output, tab, version)
        pinned = None
        if wanted.get("pinned") is not None:  # a coarse curve does not wait for its reference
            pinned = solver.answer(wanted["pinned"], None, tab, version) if fine else solver.kept(wanted["pinned"])
        if not answer.response.dataset["frequency"].notnull().any():
            return head | {"message": " ".join(answer.sentences), "failed": True}
        return head | {
            "figure": solving.curve_figure(answer, pinned, output, bool(wanted["log"]), bool(wanted["dark"])),
            "numbers": solving.peak_words(answer, output),
            "changes": solving.change_words(answer, pinned, output),
            "message": " ".join(answer.sentences)
            or ("" if fine else f"Preview with at most {COARSE} harmonics. The curve with the settings of the study follows."),
            "failed": False,
            "seconds": answer.seconds,
        }
    except OutdatedError:
        return no_update
    except InputError as error:
        return head | {"message": str(error), "failed": True}


def _output(solver: Solver, wanted: Wanted) -> str:
    """The output that is shown."""
    output = str(wanted["output"])
    if output not in solver.outputs:
        raise fault("output", "must be one of the study", output, nearest(output, solver.outputs))
    return output


def _detailed(solver: Solver, clicks: int, clicked: Any, answer: Any, wanted: Wanted | None) -> Any:
    """The point that was clicked, or the peak."""
    if wanted is None or not answer or answer["failed"]:
        return no_update
    try:
        output = _output(solver, wanted)
        solved = solver.answer(wanted["values"])
        clicks_on_points = (clicked or {}).get("points", ())
        if ctx.triggered_id == "curve" and clicks_on_points:
            pinned, at = solver.answer(wanted["pinned"]), clicks_on_points[0]
            point: int | None = solving.clicked_point(solved, pinned, output, float(at["x"]), float(at["y"]))
        else:
            point = solving.peak_place(solved, output)
        if point is None:
            return html.P("No point of the curve converged.")
        hertz = float(solved.response.dataset["frequency"].values[0, point])
        drawn = solving.detail_figures(solved, point, output, bool(wanted["dark"]), bool(wanted.get("narrow")))
    except InputError as error:
        return html.P(str(error))
    graphs = [_graph(number, figure) for number, figure in enumerate(drawn)]
    return html.Div([html.H2(f"At {hertz:.6g} Hz"), *graphs], **{"data-version": str(wanted["version"])})


def _graph(number: int, figure: dict[str, Any]) -> Any:
    """A figure, with steps of one frame where it moves."""
    graph = dcc.Graph(figure=figure, config=CONFIG)
    if not figure.get("frames"):
        return graph
    steps = [
        html.Button(words, id={"type": "step", "by": by, "figure": number}, type="button", **{"aria-label": name})
        for by, words, name in ((-1, "◀ step", "one frame back"), (1, "step ▶", "one frame forward"))
    ]
    return html.Div([graph, html.Div(steps, className="buttons")], className="moving")


def _performed(solver: Solver, shown: str, wanted: Wanted | None) -> Any:
    """The performance curve round the present ratio, where its tab is shown."""
    if not (wanted and shown == "performance" and wanted["fine"]):
        return no_update, no_update
    try:
        problem = solver.problem(wanted["values"])
        pull = solver.performance_settings.get("pull") or max((abs(force.static) for force in problem.forces), default=0.0)
        level = float(wanted["values"].get("force_level", 1.0))
        excitation = max((abs(a) for force in problem.forces for a in force.amplitudes.values()), default=0.0) * level
        if not pull or not excitation:
            return no_update, "A performance curve needs a pull, which is a static force, and an excitation."
        ratio = pull / excitation
        ratios = np.geomspace(ratio / RATIO_REACH, ratio * RATIO_REACH, RATIOS)
        output = _output(solver, wanted)
        curve, said = solver.performance(wanted["values"], ratios, output, str(wanted["tab"]), int(wanted["version"]))
        return solving.performance_figure(curve, ratio, bool(wanted["dark"])), said
    except OutdatedError:
        return no_update, no_update
    except InputError as error:
        return no_update, str(error)


HOST = "127.0.0.1"


def explore(path: Path, port: int = 0, open_browser: bool = True) -> None:
    """Serve the explorer of a study until Ctrl-C; port 0: a free one. The address is printed."""
    import logging
    import webbrowser

    solver, application = prepared(path, token := secrets.token_urlsafe(16))
    from werkzeug.serving import make_server

    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    server = make_server(HOST, _free(between("port", port, 0, 65535)), application.server, threaded=True)
    address = f"http://{HOST}:{server.server_port}/{token}/"
    try:
        say(f"Explorer of {solver.name}: {address}\nOnly this computer can open it. Ctrl-C ends it.")
        if open_browser:
            webbrowser.open(address)
        server.serve_forever()  # ends by Ctrl-C without an exception
    except KeyboardInterrupt:
        pass
    finally:
        server.server_close()
    say("Explorer stopped.")


def prepared(path: Path, token: str) -> tuple[Solver, Any]:
    """The solver of a study, and the Dash application that shows it under a token."""
    solver = Solver.of(path)
    app = application(solver, token)
    app.server.before_request(_refuse_other_names)
    app.server.add_url_rule(f"/{token}/doing/<tab>", "doing", partial(_doing, solver))
    app.server.add_url_rule(f"/{token}/stop/<tab>/<int:version>", "stop", partial(_stop, solver), methods=["POST"])
    return solver, app


def _doing(solver: Solver, tab: str) -> dict[str, Any]:
    """What is solved for a tab now; empty where nothing is."""
    now = solver.doing.get(tab)
    return {} if now is None else {"words": now.words, "share": now.share, "seconds": time.perf_counter() - now.started}


def _stop(solver: Solver, tab: str, version: int) -> tuple[str, int]:
    """End what is solved for a tab: its requests up to this one count as overtaken."""
    solver.ask(tab, version)
    return "", 204


def _refuse_other_names() -> Any:
    """A page of another site whose name leads to this computer is refused."""
    from flask import abort, request

    if request.host.rpartition(":")[0] not in (HOST, "localhost"):
        abort(403)


def _free(port: int) -> int:
    """The port, where nothing listens there."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except OSError as error:
            raise InputError(f"port must be free, but {port} is not ({error.strerror}). Leave it out.") from None
        return int(probe.getsockname()[1])
