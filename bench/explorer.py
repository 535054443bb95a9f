"""Fifty moves of a slider of the explorer in a real browser: from the key to the drawn curve, server and drawing included."""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

MOVES = 50
HEAD = """
[study]
analysis = "forced_response"
[structure]
rig = "{rig}"
[sweep]
frequency = {band}
force_levels = [{level}]
"""
STUDIES = {
    "blade and wedge": (HEAD.format(rig="blade_and_wedge", band=[300.0, 370.0], level=5.0), "pull"),
    "three masses, wedge": (HEAD.format(rig="three_mass_wedge", band=[145.0, 235.0], level=0.5), "mu"),
    "single blade": (HEAD.format(rig="single_blade", band=[390.0, 600.0], level=20.0), "gap_factor"),
    "lumped disk": (HEAD.format(rig="lumped_blisk", band=[120.0, 180.0], level=0.4), "pull"),
    "bladed disk": (HEAD.format(rig="octopus_blisk", band=[138.0, 150.0], level=0.2) + "harmonics = 3\nsamples = 96\n", "pull"),
}
"""Studies and the slider that is moved: the templates of one blade and of a disk, and their lumped relatives."""

MOVE = """
(() => new Promise(done => {
  const graph = document.querySelector("#curve .js-plotly-plot");
  const range = [...document.querySelectorAll(".slider")].find(s => s.title.startsWith(%s)).querySelector("input[type=range]");
  const root = document.documentElement, before = parseInt(root.dataset.version), began = performance.now();
  let coarse = null;
  const drawn = () => {
    if (parseInt(root.dataset.version) <= before) return;
    const now = performance.now() - began;
    if (root.dataset.version.endsWith("fine")) { graph.removeListener("plotly_afterplot", drawn); done([coarse ?? now, now]); }
    else coarse ??= now;
  };
  graph.on("plotly_afterplot", drawn);
  const set = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  set.call(range, Number(range.value) + %d);
  range.dispatchEvent(new Event("input", { bubbles: true }));
}))()
"""


def explorer() -> dict[str, Any]:
    """Seconds of each move, to the first and to the fine curve, by study, and the day."""
    sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
    studies = {name: _moves(study, slider) for name, (study, slider) in STUDIES.items()}
    return {"date": date.today().isoformat(), "studies": studies}


def _moves(study: str, slider: str) -> dict[str, Any]:
    from system.browser import browser

    from stickslip.show.plots.look import spoken

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.toml"
        path.write_text(study)
        command = [sys.executable, "-m", "stickslip", "explore", str(path), "--no-browser"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        try:
            assert process.stdout is not None
            found = re.search(r"http://\S+", process.stdout.readline())
            assert found is not None
            with browser() as page:
                page.call("Page.navigate", url=found.group())
                drawn = "document.querySelector('#curve .main-svg')"
                page.until(f"(document.documentElement?.dataset.version || '').endsWith('fine') && {drawn}", 300)
                times = [_move(page, spoken(slider), 3 if k % 2 else 5) for k in range(MOVES)]
        finally:
            process.kill()
            process.wait()
    first, fine = np.array(times).T / 1e3
    return {"first": first.tolist(), "fine": fine.tolist()}


def _move(page: Any, slider: str, steps: int) -> list[float]:
    expression = MOVE % (repr(slider), steps)
    found = page.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
    assert "exceptionDetails" not in found, found["exceptionDetails"]
    times: list[float] = found["result"]["value"]
    return times


def table(found: dict[str, Any]) -> str:
    """The section of the page."""
    day = date.fromisoformat(found["date"])
    rows = [f"| {name} | {_words(times['first'])} | {_words(times['fine'])} |" for name, times in found["studies"].items()]
    return "\n".join(
        (
            "## A slider that moves",
            "",
            f"`stickslip explore` in Chromium, {MOVES} moves of a slider, wall time in seconds from the move to the drawn curve:",
            "the first curve, of at most three harmonics and 64 samples, and that of the study, of five and 256 (bladed disk:",
            "three and 96), for which the slider has to rest for 0.25 s. Median and 95th percentile, kernels warm, server and",
            "browser on the same machine.",
            f"Measured on {day.day} {day:%B %Y}.",
            "",
            "| study | first curve | curve of the study |",
            "| --- | --- | --- |",
            *rows,
        )
    )


def _words(seconds: list[float]) -> str:
    return f"{np.median(seconds):.2f}, {np.percentile(seconds, 95):.2f}"


if __name__ == "__main__":
    print(table(explorer()))
