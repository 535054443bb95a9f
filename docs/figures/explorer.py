"""The pictures of docs/explorer.md, taken in Chromium: the explorer, light and dark, motion in a report, waves of disks, a damper
alone, deformed shapes; and the film of the example. `make screenshots` renews all of them, names after it some.
"""

import base64
import io
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image

import stickslip as ss
from stickslip.model.dampers import out_of_phase
from stickslip.model.rigs import laboratory_damper
from stickslip.show.report import write

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
        taken(page, name)


def taken(page, name: str, **region) -> None:
    """The window, or a part of it, as a small file: of 256 colours."""
    shot = page.call("Page.captureScreenshot", format="png", **region)
    picture = Image.open(io.BytesIO(base64.b64decode(shot["data"]))).convert("RGB")
    picture.quantize(256, dither=Image.Dither.NONE).save(HERE / name, optimize=True)


def explorer() -> None:
    """The explorer at two widths, light and dark."""
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


def film() -> None:
    """The example's film."""
    response = ss.forced_response(ss.rigs.blade_and_wedge(pull=60.0), ss.Band(300.0, 370.0), 10.0, 5, 96)
    response.animate().save(HERE / "damper_in_motion.gif", fps=15)


def report() -> None:
    """The section "Motion" of a report."""
    response = ss.forced_response(ss.rigs.blade_and_wedge(pull=60.0), ss.Band(300.0, 370.0), [5.0, 10.0], 5, 96).with_motion()
    with tempfile.TemporaryDirectory() as folder, browser() as page:
        page.call("Emulation.setDeviceMetricsOverride", width=1100, height=900, deviceScaleFactor=1, mobile=False)
        page.open(write({"wedge": response.dataset}, Path(folder) / "report.html"))
        page.value('document.querySelector(\'[data-place="chart-motion"] input[value="10 N"]\').click()')
        page.value("document.querySelector('#motion').scrollIntoView()")
        time.sleep(1.0)
        page.value("[...document.querySelectorAll('[data-place=\"chart-motion\"] .steps button')][1].click()")
        time.sleep(1.0)
        box = page.value(
            "(b => [b.x, b.y + scrollY, b.width, b.height])(document.querySelector('#motion').getBoundingClientRect())"
        )
        clip = dict(zip(("x", "y", "width", "height"), box, strict=True))
        taken(page, "motion_in_the_report.png", clip=clip | {"scale": 1}, captureBeyondViewport=True)


def shown(picture, name: str, size: tuple[int, int]) -> None:
    """A moving picture as its page shows it."""
    with tempfile.TemporaryDirectory() as folder, browser() as page:
        place = picture.save(Path(folder) / "picture.html")
        page.call("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1, mobile=False)
        page.call("Emulation.setScrollbarsHidden", hidden=True)
        page.call("Page.navigate", url=place.as_uri())
        page.until("document.readyState === 'complete' && document.querySelectorAll('.main-svg').length > 0")
        time.sleep(3.0)
        taken(page, name)


def damper_alone() -> None:
    """The cycle of a damper, and one of its steady cycles."""
    rig = laboratory_damper(platform_angle=37.0, pull=50.0, friction=(0.40, 0.22, 0.32))
    shown(ss.damper_cycle(rig, out_of_phase(30e-6)).animate(), "damper_cycle_in_motion.png", (1100, 640))
    found = ss.steady_cycles(laboratory_damper(platform_angle=45.0, pull=50.0, friction=(0.40, 0.22, 0.32)), out_of_phase(0.3e-6))
    shown(found.animate(2), "steady_cycle_in_motion.png", (1100, 640))


def disks() -> None:
    """The wave round a disk, tuned and mistuned."""
    scatter = 0.01 * np.random.default_rng(3).standard_normal(24)
    for name, disk in (
        ("disk_in_motion.png", ss.rigs.lumped_blisk("W")),
        ("mistuned_disk_in_motion.png", ss.mistuned_disk(ss.rigs.lumped_blisk("W"), ss.Mistuning(blade=scatter))),
    ):
        response = ss.forced_response(disk, ss.Band(144.0, 152.0), 0.1, harmonics=1, samples=48)
        shown(response.animate(), name, (1100, 640))


def deformed_shape() -> None:
    """The wave of a tuned disk at its peak, as a page shows it."""
    response = ss.forced_response(ss.rigs.octopus_blisk(), ss.Band(143.0, 147.0), 1.0, harmonics=1, samples=64)
    shown(response.deformed_shape(), "deformed_shape.png", (1100, 745))


if __name__ == "__main__":
    taking = {each.__name__: each for each in (explorer, film, report, damper_alone, disks, deformed_shape)}
    for name in sys.argv[1:] or taking:
        taking[name]()
