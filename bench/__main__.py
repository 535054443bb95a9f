"""`make bench`: run everything, print the table, write results/bench.json, the figures and docs/benchmarks.md."""

from __future__ import annotations

import argparse
import json
import sys
import time
from datetime import date
from pathlib import Path
from typing import Any

import environment
import page
from cases import CASES
from channel import Side
from explorer import explorer
from fe_blades import fe_blades
from growth import grow
from headline import headline
from many_contacts import many_contacts
from page_comparison import table
from scaling import scaling
from startup import memory, startup

ROOT = Path(__file__).parent.parent
sys.path.append(str(ROOT))
RESULTS = ROOT / "results" / "bench.json"
STARTED_WITH = ("B1 F=1", "B2a", "B2b")
BLADE_SECONDS = 90
BLADE = {"harmonics": 5, "force": 80.0, "band": (480.0, 600.0)}


def main() -> None:
    arguments = _arguments()
    found: dict[str, Any] = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    if arguments.only != "page":
        _measure(found, arguments.only)
    page.write(found, ROOT / "docs")
    print(table(found))


def source_commit() -> str:
    """The last commit of the sources; with a + when they differ from it."""
    from tools.commits import commit

    return commit("src")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python bench", description=__doc__)
    parser.add_argument("--only", choices=(*page.PARTS, "page"), help="one part; the rest stays")
    return parser.parse_args()


def _measure(found: dict[str, Any], only: str | None) -> None:
    environment.install_pyharm()
    stickslip, pyharm = environment.stickslip_side(), environment.pyharm_side()
    found["machine"] = environment.machine()
    measured = found.setdefault("measured", {})
    found["versions"] = {side.name: side.start()["versions"] for side in (stickslip, pyharm)}
    steps = {
        "headline": lambda: headline(stickslip, pyharm, CASES),
        "limit": lambda: (
            {case: stickslip.ask("parts", case=case) for case in ("B1 F=1", "B1 F=2", "B2a", "B2b")}
            | {"blade": stickslip.ask("parts", case="blade", **BLADE)}
        ),
        "blade": lambda: _blade(stickslip, pyharm),
        "growth": lambda: grow(stickslip),
        "many_contacts": lambda: many_contacts(environment.stickslip_side),
        "fe_blades": lambda: fe_blades(stickslip),
        "startup": lambda: {
            "stickslip": startup(environment.stickslip_side, {case: {} for case in STARTED_WITH}),
            "pyHarm": startup(environment.pyharm_side, {"B1 F=1": {"ds": 0.1}, "B2a": {"ds": 2.0}, "B2b": {"ds": 0.5}}),
        },
        "memory": lambda: _memory(found),
        "scaling": scaling,
        "explorer": explorer,
    }
    for name, step in steps.items():
        if only in (None, name):
            began = time.monotonic()
            found[name] = step()
            measured[name] = f"on {date.today().isoformat()} at commit `{source_commit()}`"
            print(f"{name}: {time.monotonic() - began:.0f} s", flush=True)
            RESULTS.parent.mkdir(exist_ok=True)
            RESULTS.write_text(json.dumps(found, indent=1))
    stickslip.close()
    pyharm.close()


def _blade(stickslip: Side, pyharm: Side) -> dict[str, Any]:
    """The single-blade rig: stickslip's second sweep, and what pyHarm does with its matrices in a bounded time."""
    stickslip.ask("blade", **BLADE)
    path = str(environment.BUILD / "blade.npz")
    stickslip.ask("export_blade", path=path)
    settings = {"solver": "scipyroot", "ds": 0.1, "length": 1e-6, "seconds": BLADE_SECONDS}
    theirs = pyharm.ask("blade", path=path, **settings, **BLADE)
    return {"stickslip": stickslip.ask("blade", **BLADE), "pyHarm": {"seconds": BLADE_SECONDS} | theirs}


def _memory(found: dict[str, Any]) -> dict[str, Any]:
    best = {name: {case: found["headline"][case][name]["settings"] for case in STARTED_WITH} for name in ("stickslip", "pyHarm")}
    blade = environment.stickslip_side()
    answer = blade.ask("blade", **BLADE)
    blade.close()
    ours = memory(environment.stickslip_side, best["stickslip"]) | {"blade": answer.get("peak_memory_MiB")}
    return {"stickslip": ours, "pyHarm": memory(environment.pyharm_side, best["pyHarm"])}


if __name__ == "__main__":
    main()
