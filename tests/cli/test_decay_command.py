"""`stickslip decay`: from a recorded ring-down to frequency and damping in one command, and what it refuses."""

import numpy as np
import pytest
from measurement import universal_writer as write
from scipy.io import savemat
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app
from stickslip.support import console

FREQUENCY, RATIO = 60.0, 0.01
TIME = np.arange(3000) / 3000.0
OMEGA = 2.0 * np.pi * FREQUENCY
ROOT = complex(-RATIO / np.sqrt(1.0 - RATIO**2) * OMEGA, OMEGA)
MOTION = [np.real(ROOT**order * 1e-3 * np.exp(ROOT * TIME)) for order in range(3)]
"""Displacement, velocity and acceleration of A exp(−ζω t) cos(ω_d t), 1 mm."""

STIFFNESS, DAMPING = OMEGA**2 / (1.0 - RATIO**2) - 1e3, -2.0 * ROOT.real

MODEL = f"""
[study]
title = "One mass"
analysis = "forced_response"
[structure]
dofs = ["1.x"]
matrices = {{ M = [[1.0]], K = [[{STIFFNESS:.9f}]], C = [[{DAMPING:.9f}]] }}
[[contact]]
tangential = {{ "1.x" = 1.0 }}
law = "macroslip"
kt = 1e3
mu = 1.0
normal_load = 1e6
[[force]]
direction = "1.x"
amplitude = 1.0
[sweep]
frequency = [50.0, 70.0]
harmonics = "auto"
outputs = ["1.x"]
"""


def command(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def text_file(folder, name="ring_down.csv", order=0, title="displacement [mm]", factor=1e3):
    rows = "\n".join(f"{1e3 * t:.9g};{factor * x:.9g}" for t, x in zip(TIME, MOTION[order], strict=True))
    (folder / name).write_text(f"time [ms];{title}\n{rows}\n")
    return folder / name


def test_a_record_becomes_frequency_and_damping_beside_the_mode_of_a_study(tmp_path, monkeypatch):
    """The stuck mass decays with the frequency and damping of its closed form, and so does its nonlinear mode."""
    monkeypatch.chdir(tmp_path)
    text_file(tmp_path)
    (tmp_path / "one.toml").write_text(MODEL)
    shown = command("decay", "ring_down.csv", "--study", "one.toml")
    assert shown.exit_code == 0, shown.output
    assert ", 60.00 Hz (standard error" in shown.output
    assert "damping        1 ± " in shown.output
    data = ss.open_results(tmp_path / "results" / "ring_down" / "results.nc")
    np.testing.assert_allclose(data["frequency"], FREQUENCY, rtol=1e-6)
    np.testing.assert_allclose(data["mode_damping_ratio"], RATIO, rtol=1e-4)
    assert "nonlinear mode 1 at the same amplitudes" in shown.output
    page = (tmp_path / "results" / "ring_down" / "report.html").read_text()
    assert 'id="table-0-frequency-and-damping-over-the-amplitude"' in page.partition('id="tables"')[0]
    again = command("decay", "ring_down.csv")
    assert again.exit_code == console.WRONG_INPUT
    assert "--overwrite" in again.output


def test_several_sensors_of_one_file_give_one_answer(tmp_path, monkeypatch):
    """Three columns, one of them still: signal is given for each, and the amplitude is that of the first."""
    monkeypatch.chdir(tmp_path)
    rows = "\n".join(f"{t:.9g};{x:.9g};{-2.0 * x:.9g};0" for t, x in zip(TIME, MOTION[2], strict=True))
    (tmp_path / "blade.csv").write_text(f"time [s];tip [m/s2];root [m/s2];disk [m/s2]\n{rows}\n")
    shown = command("decay", "blade.csv", *(f"--column=signal={name}" for name in ("tip", "root", "disk")))
    assert shown.exit_code == 0, shown.output
    assert "3 sensors as one record" in " ".join(shown.output.split())
    assert "no motion in the mode: sensor 3" in " ".join(shown.output.split())
    data = ss.open_results(tmp_path / "results" / "blade" / "results.nc")
    np.testing.assert_allclose(data["damping_ratio"], RATIO, rtol=1e-5)
    size = 1e-3 * abs(ROOT) ** 2 / OMEGA**2  # a/ω² of the acceleration
    np.testing.assert_allclose(data["amplitude"], size * np.exp(ROOT.real * data["window_time"]), rtol=1e-5)


@pytest.mark.parametrize("order", [0, 1, 2])
def test_matlab_and_universal_files_hold_the_same_decay(order, tmp_path):
    """Vectors, a matrix and structs of a .mat file; a 58 and a 58b, one of two time histories beside a response."""
    quantity, unit = ("displacement", "velocity", "acceleration")[order], ("m", "m/s", "m/s^2")[order]
    folder, x = tmp_path, MOTION[order]
    savemat(folder / "vectors.mat", {"time_ms": 1e3 * TIME, f"{quantity[:3]}": x, "gain": 2.0})
    savemat(folder / "matrix.mat", {"record": np.column_stack([TIME, x])})
    axis = {"start_value": 0.0, "increment": 1.0 / 3000.0, "number_of_values": 3000.0, "quantity": {"label": "s"}}
    signal = {"x_values": axis, "y_values": {"values": x, "quantity": {"label": unit}}}
    savemat(folder / "struct.mat", {"Signal": signal})
    kind = (write.DISPLACEMENT, write.VELOCITY, write.ACCELERATION)[order]
    about = {"kind": 1, "abscissa": (17, "s"), "denominator": (0, "NONE"), "double": True}
    histories = [write.function(TIME, x, ordinate=(kind, unit), response=(1, 3), **about)]
    histories.append(write.function(TIME, 2e3 * x, ordinate=(kind, f"m{unit}"), response=(2, 3), **about))
    response = write.function(np.arange(1.0, 50.0), np.ones(49) * 1j)
    (folder / "one.unv").write_bytes(histories[0] + response)
    (folder / "two.unv").write_bytes(b"".join(histories))
    binary = write.function(TIME, x, ordinate=(kind, unit), binary="<", **about)
    (folder / "binary.unv").write_bytes(binary)
    for name, options in (
        ("vectors.mat", {}),
        ("matrix.mat", {"quantity": quantity}),
        ("struct.mat", {}),
        ("one.unv", {}),
        ("two.unv", {"columns": {"signal": 1}}),
        ("two.unv", {"columns": {"signal": "1:+Z"}}),
        ("binary.unv", {}),
    ):
        found = ss.read_decay(folder / name, **options).dataset
        assert found.attrs["quantity"] == quantity, name
        exact = 1e-3 * np.exp(ROOT.real * found["window_time"].values)
        np.testing.assert_allclose(found["amplitude"], exact, rtol=3e-4, err_msg=name)  # |root|² is ω² (1 + ζ²)
        np.testing.assert_allclose(found["frequency"], FREQUENCY, rtol=3e-6, err_msg=name)
        assert found.sizes["window"] > 60, name
    doubled = ss.read_decay(folder / "two.unv", columns={"signal": "2:+Z"}).dataset
    np.testing.assert_allclose(doubled["amplitude"], 2e-3 * np.exp(ROOT.real * doubled["window_time"].values), rtol=3e-4)


def test_what_is_damaged_or_unclear_is_refused_in_a_sentence(tmp_path):
    """No traceback: the code of wrong input, and what to do."""
    good = text_file(tmp_path)
    (tmp_path / "one.toml").write_text(MODEL)
    whole = good.read_text()
    about = {"kind": 1, "abscissa": (17, "s"), "denominator": (0, "NONE"), "ordinate": (write.DISPLACEMENT, "m")}
    sets = [write.function(TIME, MOTION[0], response=(k, 3), **about) for k in (1, 2)]
    files = {
        "empty.csv": b"",
        "cut.csv": whole[: len(whole) // 2 - 3].encode() + b";\n1;",
        "words.csv": whole.replace("\n", "\nhere;there\n", 3).encode(),
        "gap.csv": whole.replace(f"\n{1e3 * TIME[500]:.9g};", "\nnan;").encode(),
        "binary.csv": bytes(range(256)) * 9,
        "damaged.mat": b"MATLAB 5.0 MAT-file" + bytes(500),
        "cut.unv": sets[0][:900],
        "two.unv": b"".join(sets),
        "response.unv": write.function(np.arange(1.0, 50.0), np.ones(49) * 1j),
        "per_force.csv": whole.replace("[mm]", "[mm/N]").encode(),
        "silent.csv": whole.replace("displacement [mm]", "what").encode(),
        "three.csv": ("a [V];b;c\n" + "\n".join(f"{t};{t};{t}" for t in TIME)).encode(),
    }
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    three = np.column_stack([TIME] * 3)
    savemat(tmp_path / "none.mat", {"note": "nothing"})
    savemat(tmp_path / "three.mat", {"a": three[:, 0], "b": three[:, 1], "c": three[:, 2]})
    refused = {
        "missing.csv": (["missing.csv"], "FILE must be a file that exists"),
        **{name: ([name], "must") for name in files if name != "two.unv"},
        "two": (["two.unv"], "--column signal=1"),
        "quantity": (["silent.csv"], "--quantity acceleration"),
        "none": (["none.mat"], "must be those of one"),
        "mat": (["three.mat"], "--column time=2"),
        "no function": (["two.unv", "--column", "signal=9"], "must be a number from 1 to 2"),
        "band": (["ring_down.csv", "--band", "10"], "--band must be LOW:HIGH"),
        "turned band": (["ring_down.csv", "--band", "70:50"], "band must be"),
        "no motion": (["ring_down.csv", "--band", "900:901"], "must"),
        "cycles": (["ring_down.csv", "--cycles", "0"], "cycles must be"),
        "of what": (["ring_down.csv", "--quantity", "force"], "quantity must be one of"),
        "contradiction": (["ring_down.csv", "--quantity", "velocity"], "must be one of m/s"),
        "column": (["ring_down.csv", "--column", "signal=7"], "must be a number from 1 to 2"),
        "columns": (["ring_down.csv", "--column", "signal=1", "--column", "time=1"], "must be two columns"),
        "unit": (["ring_down.csv", "--unit", "signal=furlong"], "must be one of m, mm"),
        "output": (["ring_down.csv", "--output", "1.x"], "--output must go with --study"),
        "no study": (["ring_down.csv", "--study", "missing.toml"], "--study must"),
        "other output": (["ring_down.csv", "--study", "one.toml", "--output", "1.y"], "--output must be one of 1.x"),
    }
    for name, (arguments, message) in refused.items():
        paths = [tmp_path / one if one.rpartition(".")[2] in ("csv", "mat", "unv", "toml") else one for one in arguments]
        shown = command("decay", *paths, "--out", tmp_path / "out")
        assert shown.exit_code == console.WRONG_INPUT, (name, shown.output)
        assert message in shown.output, (name, shown.output)
        assert "Traceback" not in shown.output, name
        assert not (tmp_path / "out" / "results.nc").exists(), name
