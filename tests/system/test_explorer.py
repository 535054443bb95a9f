"""The explorer in a real browser: sliders by keys and mouse, the newest answer, reference, wrong values, two tabs, reload, what
is saved and copied, the performance curve, a disk, light and dark, the end by Ctrl-C."""

import re
import signal
import subprocess
import sys
import time
import tomllib
from contextlib import contextmanager
from urllib.parse import parse_qs, urlparse

import pytest
from system.browser import browser, program
from system.test_first_screen import CONTRAST

import stickslip as ss
from stickslip.results.files import open_results

pytest.importorskip("dash")
pytestmark = [pytest.mark.system, pytest.mark.skipif(program() is None, reason="no Chromium: see make verify-system")]

STUDY = """
[study]
title = "Blade and wedge"
analysis = "forced_response"
[structure]
rig = "blade_and_wedge"
[sweep]
frequency = [300.0, 370.0]
force_levels = [10.0]
harmonics = 5
samples = 64
"""


DISK = """
[study]
analysis = "forced_response"
[structure]
rig = "lumped_blisk"
parameters = { case = "W", engine_order = 2, sectors = 6 }
[sweep]
frequency = [120.0, 180.0]
force_levels = [0.4]
harmonics = 3
samples = 64
"""


@contextmanager
def served(folder, study=STUDY):
    """The process of the explorer and its address."""
    (folder / "wedge.toml").write_text(study)
    command = [sys.executable, "-m", "stickslip", "explore", str(folder / "wedge.toml"), "--no-browser"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        yield process, re.search(r"http://\S+", process.stdout.readline()).group()
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    with served(tmp_path_factory.mktemp("explorer")) as (_, found):
        yield found


FINE = "(document.documentElement?.dataset.version || '').endsWith('fine')"


def opened(page, address, width=1280, height=1000):
    page.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
    page.call("Page.navigate", url="about:blank")
    page.call("Page.navigate", url=address)
    page.until(f"location.href !== 'about:blank' && {FINE} && document.querySelector('#curve .main-svg')", 180)


def version(page):
    return int(page.value("document.documentElement.dataset.version").split()[0])


def press(page, slider, times, key="ArrowRight", code=39, pause=0.0):
    """Move a slider by keys, and wait for the fine answer to its last value."""
    before = version(page)
    page.value(f"document.querySelectorAll('.slider input[type=range]')[{slider}].focus()")
    for _ in range(times):
        for kind in ("keyDown", "keyUp"):
            page.call("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code)
        time.sleep(pause)
    settled(page, before)


def settled(page, before):
    """The fine answer to the last request, after the pause that it waits for."""
    page.until(f"parseInt(document.documentElement.dataset.version) > {before} && {FINE}", 60)
    time.sleep(0.5)
    page.until(FINE, 60)


def put(page, number, value):
    """Type a number."""
    page.value(
        f"(() => {{ const input = document.querySelectorAll('.slider input[type=number]')[{number}];"
        "const set = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, 'value').set;"
        f"input.focus(); set.call(input, '{value}'); input.dispatchEvent(new Event('input', {{bubbles: true}}));"
        "input.blur(); })()"
    )


def shown(page, name):
    return page.value(f"document.getElementById('{name}').textContent")


def pull_in_address(page):
    return float(parse_qs(urlparse(page.value("location.href")).query)["pull"][0])


def peak(**parameters):
    response = ss.forced_response(ss.rigs.blade_and_wedge(**parameters), ss.Band(300.0, 370.0), 10.0, 5, 64)
    return f"{float(response.dataset['peak_frequency'][0, 0, 0]):.6g} Hz"


def test_a_slider_that_moves_shows_the_peak_of_forced_response(address):
    with browser() as page:
        opened(page, address)
        assert shown(page, "peak-frequency") == peak()
        press(page, 1, 25)
        pull = pull_in_address(page)
        assert pull > 60.0
        assert shown(page, "peak-frequency") == peak(pull=pull)
        traces = page.value("document.querySelector('#curve .js-plotly-plot').data.map(trace => trace.name).join()")
        assert {"no contacts", "contacts stuck", "reference", "this study"} <= set(traces.split(","))
        strangers = [line for line in page.log if not line.startswith("request to http://127.0.0.1:")]
        assert strangers == []


def test_a_slider_is_dragged_by_the_mouse_and_reached_by_tab(address):
    with browser() as page:
        opened(page, address)
        slider = "document.querySelectorAll('.slider input[type=range]')[1]"
        x, y, width, height = page.value(f"(b => [b.x, b.y, b.width, b.height])({slider}.getBoundingClientRect())")
        before, middle = version(page), y + 0.5 * height
        page.drag(x + 0.5 * width, middle, x + 0.7 * width, middle)
        settled(page, before)
        pull = pull_in_address(page)
        assert 70.0 < pull < 160.0
        assert shown(page, "peak-frequency") == peak(pull=pull)
        label = "document.activeElement.closest('.slider')?.title"
        assert page.value(label).startswith("pull")
        following, stops = page.value("document.querySelectorAll('.slider')[2].title"), []
        while stops[-1:] != [(following, "range")]:  # its number stands before it, with its two small buttons
            assert len(stops) < 6, stops
            for kind in ("keyDown", "keyUp"):
                page.call("Input.dispatchKeyEvent", type=kind, key="Tab", code="Tab", windowsVirtualKeyCode=9)
            stops.append((page.value(label), page.value("document.activeElement.type")))
        assert (following, "number") in stops


def test_a_click_shows_that_point_in_motion(address):
    with browser() as page:
        opened(page, address)
        time.sleep(1.0)  # the line of the message goes when the fine curve is there, and the figure moves up
        box = page.value(
            "(() => { const g = document.querySelector('#curve .js-plotly-plot');"
            "const t = g._fullData.find(t => t.name === 'this study');"
            "const k = Math.floor(t.x.length / 3), l = g._fullLayout, r = g.getBoundingClientRect();"
            "return [r.x + l.margin.l + l.xaxis.d2p(t.x[k]), r.y + l.margin.t + l.yaxis.d2p(t.y[k]), t.x[k]]; })()"
        )
        page.click(box[0], box[1])
        page.until("document.querySelectorAll('#details .main-svg').length > 0", 60)
        hertz = float(re.search(r"At ([\d.]+) Hz", shown(page, "details")).group(1))
        assert hertz == pytest.approx(box[2], abs=2.0)
        assert page.value("document.querySelector('#details .js-plotly-plot')._transitionData._frames.length") == 48
        frame = "(document.querySelector('#details .js-plotly-plot').layout.sliders[0].active || 0)"
        for name, shown_after in (("forward", 1), ("back", 0), ("back", 47)):
            page.value(f"document.querySelector('#details button[aria-label=\"one frame {name}\"]').focus()")
            for kind in ("keyDown", "keyUp"):
                page.call("Input.dispatchKeyEvent", type=kind, key="Enter", code="Enter", windowsVirtualKeyCode=13, text="\r")
            page.until(f"{frame} === {shown_after}")


def test_a_reload_shows_the_same_and_the_reference_stays(address):
    with browser() as page:
        opened(page, address)
        press(page, 1, 10)
        before = version(page)
        page.value("document.getElementById('pin').click()")
        settled(page, before)
        assert shown(page, "peak-frequency-change").startswith("+0.000%")
        press(page, 3, 20)
        state = page.value("location.href")
        seen = [shown(page, name) for name in ("peak-frequency", "peak-amplitude", "peak-frequency-change")]
        assert "pinned.pull=" in state
        opened(page, state)
        settled(page, 0)
        assert [shown(page, name) for name in ("peak-frequency", "peak-amplitude", "peak-frequency-change")] == seen


def test_a_wrong_value_shows_the_sentence_of_run_and_the_curve_stays(address):
    with browser() as page:
        opened(page, address)
        put(page, 3, -1)
        page.until("document.getElementById('page').className === 'failed'", 30)
        assert "mu must not be negative, but is -1.0" in shown(page, "message")
        assert page.value("document.querySelector('#curve .js-plotly-plot').data.length") > 3
        before = version(page)
        put(page, 3, 0.4)
        settled(page, before)
        assert shown(page, "peak-frequency") == peak()


def test_two_tabs_do_not_disturb_each_other(address):
    with browser() as one, browser() as other:
        opened(one, address)
        opened(other, address)
        press(one, 1, 15)
        press(other, 1, 15, "ArrowLeft", 37)
        for page in (one, other):
            assert shown(page, "peak-frequency") == peak(pull=pull_in_address(page))
        assert pull_in_address(one) > 60.0 > pull_in_address(other)


def test_answers_are_never_out_of_order(address):
    """Every answer that is shown is newer than the one before, while sixty values are asked for."""
    with browser() as page:
        opened(page, address)
        page.value(
            "window.seen = []; new MutationObserver(() => seen.push(parseInt(document.documentElement.dataset.version)))"
            ".observe(document.documentElement, {attributes: true, attributeFilter: ['data-version']}) || 1"
        )
        press(page, 1, 60, pause=0.04)
        seen = page.value("seen")
        assert len(seen) > 2
        assert seen == sorted(seen)
        assert shown(page, "peak-frequency") == peak(pull=pull_in_address(page))


def test_the_saved_study_and_the_copied_code_give_the_peak_that_is_seen(address, tmp_path):
    with browser() as page:
        opened(page, address)
        press(page, 1, 12)
        seen, pull = shown(page, "peak-frequency"), pull_in_address(page)
        page.call("Page.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
        page.value("document.getElementById('save').click()")
        saved, ends = tmp_path / "explored.toml", time.monotonic() + 20.0
        while not saved.exists() and time.monotonic() < ends:
            page.value("0")
            time.sleep(0.1)
        page.value("document.getElementById('copy').click()")
        page.until("document.getElementById('python').textContent.includes('forced_response')")
        code = shown(page, "python")
        assert not page.value("document.getElementById('python').hidden")
    assert tomllib.loads(saved.read_text())["structure"]["parameters"]["pull"] == pull
    run = [sys.executable, "-m", "stickslip", "run", str(saved), "--out", str(tmp_path / "out"), "--workers", "1"]
    subprocess.run(run, check=True, capture_output=True)
    peaks = open_results(tmp_path / "out" / "results.nc")["peak_frequency"]
    assert f"{float(peaks[0, 0, 0]):.6g} Hz" == seen
    (tmp_path / "copied.py").write_text(code + "print(float(response.dataset['peak_frequency'][0, 0, 0]))\n")
    copied = subprocess.run([sys.executable, str(tmp_path / "copied.py")], check=True, capture_output=True, text=True)
    assert f"{float(copied.stdout.split()[-1]):.6g} Hz" == seen


def test_the_second_tab_shows_the_performance_curve_with_the_present_point(address):
    with browser() as page:
        opened(page, address)
        page.value("[...document.querySelectorAll('.tab')].find(t => t.textContent === 'Performance curve').click()")
        page.until("document.querySelectorAll('#performance .main-svg').length > 0", 120)
        figure = "document.querySelector('#performance .js-plotly-plot')"
        page.until(f"{figure}.data.length > 0", 120)
        lines = page.value(
            f"[...{figure}.data, ...({figure}.layout.shapes || [])].map(t => t.x ? Array.from(t.x) : [t.x0, t.x1])"
        )
        assert any(line and all(x == pytest.approx(6.0) for x in line) for line in lines)
        message = page.value("document.getElementById('performance-message').textContent")
        assert message.startswith("Coarse settings for blade.mode: 3 harmonics, 64 samples")


def test_a_disk_is_explored_and_its_wave_runs_round_the_wheel(tmp_path):
    with served(tmp_path, DISK) as (_, address), browser() as page:
        opened(page, address)
        pull = page.value("[...document.querySelectorAll('.slider')].findIndex(s => s.title.startsWith('pull'))")
        press(page, pull, 25)
        disk = ss.rigs.lumped_blisk("W", engine_order=2, sectors=6, pull=pull_in_address(page))
        response = ss.forced_response(disk, ss.Band(120.0, 180.0), 0.4, 3, 64)
        assert shown(page, "peak-frequency") == f"{float(response.dataset['peak_frequency'][0, 0, 0]):.6g} Hz"
        page.value("document.getElementById('show').click()")
        page.until("document.querySelectorAll('#details .main-svg').length > 0", 60)
        blades = "document.querySelector('#details .js-plotly-plot')._fullData.find(t => t.name.startsWith('amplitude')).x"
        drawn = page.value(f"Array.from({blades}).filter(x => x === null || Number.isNaN(x)).length")
        assert drawn == 6


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [800, 1280])
def test_the_page_fits_its_width_and_is_legible(address, width, scheme):
    with browser() as page:
        page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        opened(page, address, width)
        assert page.value("document.documentElement.scrollWidth <= innerWidth")
        dark = page.value("getComputedStyle(document.body).backgroundColor") == "rgb(21, 24, 28)"
        assert dark == (scheme == "dark")
        for selector in ("#peak-frequency", ".slider label", "button", "#results p"):
            assert page.value(CONTRAST.replace(".headline", selector)) >= 4.5, selector
        text = page.value("getComputedStyle(document.querySelector('#curve .ytick text')).fill")
        assert (text == "rgb(230, 233, 236)") == (scheme == "dark")


def test_a_long_answer_shows_its_progress_and_can_be_stopped(tmp_path):
    slow = STUDY.replace("harmonics = 5", "harmonics = 150").replace("samples = 64", "samples = 2048")
    with served(tmp_path, slow) as (_, address), browser() as page:
        page.call("Page.navigate", url=address)
        page.until("document.querySelector('#doing span')?.textContent.startsWith('Solving the curve')", 120)
        assert not page.value("document.getElementById('doing').hidden")
        seen = page.value("document.documentElement.dataset.version")
        page.value("document.getElementById('stop').click()")
        page.until("document.getElementById('message').textContent.startsWith('Stopped')", 20)
        assert page.value("document.getElementById('doing').hidden")
        time.sleep(3.0)
        assert page.value("document.documentElement.dataset.version") == seen
        assert not page.value(FINE)


def test_ctrl_c_ends_it(tmp_path):
    with served(tmp_path) as (process, _):
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 0
