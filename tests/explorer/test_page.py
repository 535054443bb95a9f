"""The page as the server gives it: under its token and the names of this computer alone; without Dash a fault with the remedy."""

import builtins

import pytest

from stickslip.checks import InputError
from stickslip.explorer.server import prepared

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


def test_a_request_is_answered_with_the_peak_and_a_wrong_one_with_a_sentence(study):
    pytest.importorskip("dash")
    from stickslip.explorer.page import _answered

    solver, _ = prepared(study, "token")
    wanted = {"values": {}, "pinned": {}, "output": "1.x", "log": True, "dark": False, "tab": "a", "version": 1, "fine": True}
    answer = _answered(solver, wanted)
    assert not answer["failed"]
    peak = float(solver.answer({}, True).response.dataset["peak_frequency"][0, 0, 0])
    assert answer["numbers"][0] == f"{peak:.6g} Hz"
    assert answer["changes"][0].startswith("+0.000%")
    assert "this study" in [trace["name"] for trace in answer["figure"]["data"]]
    wrong = _answered(solver, wanted | {"values": {"kt": -1.0}, "version": 2})
    assert wrong["failed"]
    assert "kt must be" in wrong["message"]


def test_without_dash_the_fault_names_the_extra(study, monkeypatch):
    genuine = builtins.__import__

    def absent(name, *more):
        if name == "dash":
            raise ImportError(name)
        return genuine(name, *more)

    monkeypatch.setattr(builtins, "__import__", absent)
    with pytest.raises(InputError, match=r"pip install 'stickslip\[explore\]'"):
        prepared(study, "token")
