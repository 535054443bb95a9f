"""The commands of the tutorials run, print what the pages show, and lead to what they decide."""

import json
import os
import re
import subprocess
import sys

import pytest

from tools.tutorials import DOCS, carry_out

pytestmark = pytest.mark.skipif(os.name == "nt", reason="the commands are those of a Unix shell")


def shown(page):
    """The printed lines that a page quotes."""
    blocks = re.findall(r"```text\n(.*?)```", (DOCS / f"{page}.md").read_text(), re.S)
    return [line for block in blocks for line in block.splitlines()]


def assert_prints(page, printed):
    missing = [line for line in shown(page) if line not in printed.splitlines()]
    assert not missing, f"{missing}\n{printed}"


def peaks_of(folder, results):
    """The highest peaks of all results of a folder, by name and force level, with the largest estimate of their errors."""
    command = [sys.executable, "-m", "stickslip", "peaks", results, "--json"]
    found = json.loads(subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout)
    peaks = {
        (result["name"], peak["force_level"]): peak
        for result in found["results"]
        for peak in result["peaks"]
        if peak["peak"] == 0
    }
    for peak in peaks.values():
        peak["error"] = max(abs(peak[key] or 0.0) for key in ("truncation_error", "sampling_error", "patch_error") if key in peak)
    return peaks


def assert_peaks(found, expected):
    """expected: by name and force level the frequency, the amplitude, and the largest error, of a page."""
    assert found.keys() == expected.keys()
    for key, (frequency, amplitude, error) in expected.items():
        assert found[key]["frequency"] == pytest.approx(frequency, rel=2e-4), key
        assert found[key]["amplitude"] == pytest.approx(amplitude, rel=5e-3), key
        assert found[key]["error"] == pytest.approx(error, abs=1e-3), key


@pytest.mark.slow
def test_a_lighter_damper_is_better_for_the_blade(tmp_path):
    printed = carry_out("tutorial_blade", tmp_path)
    assert_prints("tutorial_blade", printed)
    assert (tmp_path / "blade_model.html").is_file()
    free, stuck = re.search(r"without contacts: 6 rigid motions, ([\d.]+).*all contacts stuck: ([\d., ]+)", printed).groups()
    assert float(free) == pytest.approx(276, abs=0.5)
    assert [float(f) for f in stuck.split(", ")[:2]] == pytest.approx([330, 425], abs=0.6)
    found = peaks_of(tmp_path, "results/dampers")
    expected = {
        ("light", 5.0): (360.3, 0.0700, 0.018),
        ("middle", 5.0): (382.2, 0.1063, 0.024),
        ("heavy", 5.0): (396.6, 0.1633, 0.023),
    }
    assert_peaks(found, expected)
    assert found["heavy", 5.0]["patch_error"] > 0.0
    # Loads of the table, N: m r (2 pi 1692/60)^2 of one, two and four wedges
    loads = [count * 0.01911 * 0.5 * (6.283185 * 1692 / 60) ** 2 for count in (1, 2, 4)]
    assert loads == pytest.approx([300, 600, 1200], rel=1e-3)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    return folder, carry_out("tutorial_wheel", folder)


@pytest.mark.nightly
def test_engine_order_2_is_worst_for_the_wheel(wheel):
    folder, printed = wheel
    assert_prints("tutorial_wheel", printed)
    found = peaks_of(folder, "results/orders")
    expected = {
        ("order_2", 2.0): (1084.6, 0.124, 0.038),
        ("order_3", 2.0): (1091.1, 0.0938, 0.049),
        ("order_4", 2.0): (1095.9, 0.0808, 0.024),
    }
    assert_peaks(found, expected)
    speeds = [found[f"order_{order}", 2.0]["frequency"] / order * 60 for order in (2, 4)]
    assert speeds == pytest.approx([32500, 16400], abs=60)
    allowed = found["order_2", 2.0]["amplitude"] * 1.31
    assert allowed == pytest.approx(0.16, abs=5e-3)


@pytest.mark.nightly
def test_mistuned_disks_are_up_to_31_percent_worse(wheel):
    _, printed = wheel
    assert float(re.search(r"highest amplification ([\d.]+)", printed)[1]) == pytest.approx(1.31, abs=5e-3)


@pytest.mark.slow
def test_the_identified_contacts_prefer_the_tested_damper(tmp_path):
    printed = carry_out("tutorial_tests", tmp_path)
    assert_prints("tutorial_tests", printed)
    found = peaks_of(tmp_path, "results/prediction")
    amplitudes = {key: 1e6 * peak["amplitude"] for key, peak in found.items()}
    frequencies = {key: peak["frequency"] for key, peak in found.items()}
    expected = {
        ("prediction", 6.0): (50.6, 346.7),
        ("prediction", 15.0): (83.3, 333.0),
        ("heavier", 6.0): (92.7, 348.5),
        ("heavier", 15.0): (107.2, 345.5),
    }
    for key, (amplitude, frequency) in expected.items():
        assert amplitudes[key] == pytest.approx(amplitude, abs=0.1), key
        assert frequencies[key] == pytest.approx(frequency, abs=0.1), key
    difference = amplitudes["heavier", 15.0] / amplitudes["prediction", 15.0] - 1.0
    errors = [found[name, 15.0]["error"] for name in ("prediction", "heavier")]
    assert difference == pytest.approx(0.29, abs=6e-3)
    assert max(errors) < 1e-3
    low, high = map(float, re.search(r"mu = .*interval ([\d.]+) to ([\d.]+)", printed).groups())
    assert (high / low - 1.0) / 2.0 == pytest.approx(0.002, abs=5e-4)
