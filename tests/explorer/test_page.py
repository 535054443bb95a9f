"""The page as the server gives it: under its token and the names of this computer alone; without Dash a fault with the remedy."""

import sys
import time

import pytest

from stickslip.cli import main
from stickslip.show.explorer.page import prepared
from stickslip.support.console import WRONG_INPUT

STUDY = """
[study]
analysis = "forced_response"
[structure]
rig = "single_mass"
[sweep]
frequency = [0.1, 0.3]
samples = 64
"""


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "mass.toml"
    path.write_text(STUDY)
    return path


@pytest.fixture
def client(study):
    pytest.importorskip("dash")
    return prepared(study, "token")[1].server.test_client()


def test_the_page_stands_under_its_token(client):
    assert client.get("/token/", base_url="http://127.0.0.1:8000").status_code == 200
    for other in ("/", "/other/", "/_dash-layout", "/assets/explorer.js"):
        assert client.get(other, base_url="http://127.0.0.1:8000").status_code == 404


def test_another_name_of_this_computer_is_refused(client):
    assert client.get("/token/", base_url="http://evil.example:8000").status_code == 403
    assert client.get("/token/", base_url="http://localhost:8000").status_code == 200


def test_what_is_solved_can_be_seen_and_stopped(study):
    pytest.importorskip("dash")
    from stickslip.show.explorer.solving import Doing, OutdatedError

    solver, application = prepared(study, "token")
    client, here = application.server.test_client(), {"base_url": "http://127.0.0.1:8000"}
    assert client.get("/token/doing/one", **here).json == {}
    solver.doing["one"] = Doing("Solving the curve", 0.25, time.perf_counter() - 3.0)
    seen = client.get("/token/doing/one", **here).json
    assert (seen["words"], seen["share"], round(seen["seconds"])) == ("Solving the curve", 0.25, 3)
    assert client.get("/token/doing/another", **here).json == {}
    assert client.post("/token/stop/one/7", **here).status_code == 204
    with pytest.raises(OutdatedError):
        solver.answer({}, None, "one", 6)
    assert client.get("/doing/one", **here).status_code == 404


def test_a_coarse_curve_does_not_wait_for_its_reference(study):
    pytest.importorskip("dash")
    from stickslip.show.explorer.page import _answered

    solver, _ = prepared(study, "token")
    wanted = {"values": {"kt": 0.3}, "pinned": {}, "output": "1.x", "log": True, "dark": False, "tab": "a", "version": 1}
    coarse = _answered(solver, wanted | {"fine": False})
    assert "reference" not in [trace.get("name") for trace in coarse["figure"]["data"]]
    assert "at most 3 harmonics" in coarse["message"]
    assert len(solver.known) == 1
    fine = _answered(solver, wanted | {"fine": True})
    assert "reference" in [trace.get("name") for trace in fine["figure"]["data"]]
    coarse = _answered(solver, wanted | {"fine": False, "version": 2})
    assert "reference" in [trace.get("name") for trace in coarse["figure"]["data"]]


def test_a_request_is_answered_with_the_peak_and_a_wrong_one_with_a_sentence(study):
    pytest.importorskip("dash")
    from stickslip.show.explorer.page import _answered

    solver, _ = prepared(study, "token")
    wanted = {"values": {}, "pinned": {}, "output": "1.x", "log": True, "dark": False, "tab": "a", "version": 1, "fine": True}
    answer = _answered(solver, wanted)
    assert not answer["failed"]
    peak = float(solver.answer({}).response.dataset["peak_frequency"][0, 0, 0])
    assert answer["numbers"][0] == f"{peak:.6g} Hz"
    assert answer["changes"][0].startswith("+0.000%")
    assert "this study" in [trace["name"] for trace in answer["figure"]["data"]]
    wrong = _answered(solver, wanted | {"values": {"kt": -1.0}, "version": 2})
    assert wrong["failed"]
    assert "kt must be" in wrong["message"]


def test_the_first_curve_is_that_of_the_output_shown_and_an_unknown_one_is_refused(tmp_path):
    pytest.importorskip("dash")
    from stickslip.show.explorer.page import _answered

    path = tmp_path / "masses.toml"
    path.write_text(STUDY.replace("single_mass", "three_mass_wedge").replace("[0.1, 0.3]", "[215.0, 230.0]"))
    solver, _ = prepared(path, "token")
    wanted = {"values": {}, "pinned": {}, "log": True, "dark": False, "tab": "a", "version": 1, "fine": False}
    for output in solver.outputs[:2]:
        answer = _answered(solver, wanted | {"output": output})
        place = solver.answer({}).place(output)
        peak = float(solver.answer({}).response.dataset["peak_frequency"][0, 0, place])
        assert float(answer["numbers"][0].removesuffix(" Hz")) == pytest.approx(peak, rel=5e-3)
        assert list(solver.answer({}, output).response.dataset.output.values) == [output]
    unknown = _answered(solver, wanted | {"output": "none.x"})
    assert unknown["failed"]
    assert "output must be one of the study, but is 'none.x'" in unknown["message"]


def test_without_dash_the_fault_names_the_extra(study, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "dash", None)
    monkeypatch.delitem(sys.modules, "stickslip.show.explorer.page")
    with pytest.raises(SystemExit) as ended:
        main(["explore", str(study)])
    assert ended.value.code == WRONG_INPUT
    assert "pip install 'stickslip[explore]'" in capsys.readouterr().err
