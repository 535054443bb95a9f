"""Serving of the page: on the loopback alone, under a random token, until Ctrl-C."""

from __future__ import annotations

import secrets
import socket
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip.support.checks import InputError, between
from stickslip.support.console import say

if TYPE_CHECKING:
    from stickslip.show.explorer.solving import Solver

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
    try:
        import dash  # noqa: F401
    except ImportError:
        raise InputError(
            "The explorer needs Dash, which is not installed. `pip install 'stickslip[explore]'` installs it."
        ) from None
    from stickslip.show.explorer.page import application
    from stickslip.show.explorer.solving import Solver

    solver = Solver.of(path)
    app = application(solver, token)
    app.server.before_request(_refuse_other_names)
    app.server.before_request(partial(_refuse_malformed, app))
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


def _refuse_malformed(application: Any) -> Any:
    """A request that the page itself never sends is answered by 400 and one line, not by an error of the server."""
    from flask import Response, request

    # By this path the page asks for new figures.
    if request.method != "POST" or not request.path.endswith("/_dash-update-component"):
        return None
    body = request.get_json(silent=True)
    if not isinstance(body, dict):
        return Response("The request must be a JSON object.\n", 400, mimetype="text/plain")
    known = application.callback_map.get(str(body.get("output")))
    if known is None:
        return Response("The request must name an output of the page.\n", 400, mimetype="text/plain")
    if not isinstance(body.get("outputs"), dict | list):
        return Response("The request must list its outputs.\n", 400, mimetype="text/plain")
    for part in ("inputs", "state"):
        given = body.get(part, [])
        if not isinstance(given, list) or len(given) != len(known[part]) or not all(map(_is_named, given, known[part])):
            return Response(f"The {part} of the request must be those of its output.\n", 400, mimetype="text/plain")
    return None


def _is_named(given: Any, expected: dict[str, Any]) -> bool:
    """Whether an entry of a request is the component that a callback takes; of a pattern, a list of components or one of them."""
    if not expected["id"].startswith("{"):
        return isinstance(given, dict) and (given.get("id"), given.get("property")) == (expected["id"], expected["property"])
    entries = given if isinstance(given, list) else [given]
    return all(
        isinstance(entry, dict) and isinstance(entry.get("id"), dict) and entry.get("property") == expected["property"]
        for entry in entries
    )


def _free(port: int) -> int:
    """The port, where nothing listens there."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except OSError as error:
            raise InputError(f"port must be free, but {port} is not ({error.strerror}). Leave it out.") from None
        return int(probe.getsockname()[1])
