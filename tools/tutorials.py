"""Carries out the commands of the tutorials, and renews their pictures: `make tutorials`."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"
PICTURES = {
    "tutorial_blade": ("results/dampers/light", "response"),
    "tutorial_wheel": ("results/mistuned", "amplification"),
    "tutorial_tests": ("results/responses", "measured_and_computed"),
}
"""The results and the figure that a tutorial shows."""
BLOCK = re.compile(r"^```(sh|toml)\n(.*?)^```", re.S | re.M)


def carry_out(page: str, folder: Path) -> str:
    """Write the files and carry out the commands of a page one after another in a folder; returns what they print."""
    printed = ""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    for kind, text in BLOCK.findall((DOCS / f"{page}.md").read_text()):
        if kind == "toml":
            (folder / text.splitlines()[0].removeprefix("# ")).write_text(text)
            continue
        for command in text.splitlines():
            ran = subprocess.run(
                command, shell=True, cwd=folder, env={**os.environ, "PATH": path}, capture_output=True, text=True, check=False
            )
            if ran.returncode:
                raise RuntimeError(f"{command}\n{ran.stdout}{ran.stderr}")
            printed += ran.stdout
    return printed


def main() -> None:
    """Renew the picture of each tutorial."""
    from stickslip.cli import app

    for page, (results, figure) in PICTURES.items():
        with tempfile.TemporaryDirectory() as place:
            carry_out(page, Path(place))
            out = Path(place) / "figures"
            app(
                ["plot", str(Path(place) / results), "--figure", figure, "--format", "svg", "--out", str(out)],
                standalone_mode=False,
            )
            shutil.copy(out / f"{figure}.svg", DOCS / "figures" / f"{page}.svg")


if __name__ == "__main__":
    main()
