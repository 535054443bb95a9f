"""The pictures of docs/explorer.md: the explorer in Chromium, light and dark, the film of the example, a deformed shape."""

import base64
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import stickslip as ss

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[1] / "tests"))

from system.browser import browser  # noqa: E402

STUDY = """
[study]
title = "Blade and wedge"
analysis = "forced_response"
[structure]
rig = "blade_and_wedge"
[sweep]
frequency = [300.0, 370.0]
force_levels = [10.0]
"""


def picture(address: str, name: str, width: int, scheme: str) -> None:
    """The page with another pull and the peak in motion."""
    with browser() as page:
        page.call("Emulation.setDeviceMetricsOverride", width=width, height=1250, deviceScaleFactor=1, mobile=False)
        page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        page.call("Page.navigate", url=f"{address}?pull=90")
        fine = "document.documentElement?.dataset.version?.endsWith('fine')"
        page.until(f"{fine} && document.querySelector('#curve .main-svg')", 120)
        page.until(
            "document.getElementById('peak-frequency-change').textContent.length > 0 && location.search.includes('pull')", 60
        )
        page.value("document.getElementById('show').click()")
        page.until("document.querySelectorAll('#details .main-svg').length > 0", 60)
        time.sleep(1.5)
        page.until(f"{fine} && !document.querySelector('#details.old')", 60)
        shot = page.call("Page.captureScreenshot", format="png")
        (HERE / name).write_bytes(base64.b64decode(shot["data"]))


def deformed_shape() -> None:
    """The wave of a tuned disk at its peak, as a page shows it."""
    response = ss.forced_response(ss.rigs.octopus_blisk(), ss.Band(143.0, 147.0), 1.0, harmonics=1, samples=64)
    with tempfile.TemporaryDirectory() as folder, browser() as page:
        place = Path(folder) / "shape.html"
        place.write_text(response.deformed_shape().to_html())
        page.call("Emulation.setDeviceMetricsOverride", width=1100, height=745, deviceScaleFactor=1, mobile=False)
        page.call("Emulation.setScrollbarsHidden", hidden=True)
        page.call("Page.navigate", url=place.as_uri())
        page.until("document.querySelectorAll('canvas').length > 0")
        time.sleep(3.0)
        shot = page.call("Page.captureScreenshot", format="png")
        (HERE / "deformed_shape.png").write_bytes(base64.b64decode(shot["data"]))


def main() -> None:
    """All pictures."""
    with tempfile.TemporaryDirectory() as folder:
        study = Path(folder) / "wedge.toml"
        study.write_text(STUDY)
        command = [sys.executable, "-m", "stickslip", "explore", str(study), "--no-browser"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        try:
            address = re.search(r"http://\S+", process.stdout.readline()).group()
            picture(address, "explorer.png", 1280, "light")
            picture(address, "explorer_dark.png", 800, "dark")
        finally:
            process.kill()
            process.wait()
    response = ss.forced_response(ss.rigs.blade_and_wedge(pull=60.0), ss.Band(300.0, 370.0), 10.0, 5, 96)
    response.animate().save(HERE / "damper_in_motion.gif", fps=15)
    deformed_shape()


if __name__ == "__main__":
    main()
