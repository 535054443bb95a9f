"""The study of a bladed disk from CalculiX: wedges between all neighbours, stress at the foot of the blade, fatigue margin."""

import gzip
import shutil
import subprocess
import sys
from pathlib import Path

import stickslip as ss

# wheel.toml, the deck sector.inp of make_sector.py, and what `ccx sector` wrote: sector.dof, sector.sti.gz, sector.mas.gz.
wheel = Path(__file__).with_name("wheel")
for name in ("wheel.toml", "sector.inp", "sector.dof"):
    shutil.copy(wheel / name, name)
for name in ("sector.sti", "sector.mas"):
    Path(name).write_bytes(gzip.decompress((wheel / f"{name}.gz").read_bytes()))

subprocess.run([sys.executable, "-m", "stickslip", "run", "wheel.toml", "--out", "wheel"], check=True)
data = ss.open_results("wheel/results.nc")
response = ss.ForcedResponse(data, ss.read_problem("wheel.toml"))
print(response)
response.plot("haigh").savefig("own_bladed_disk.png")

margin = float((data["fatigue_limit"] / data["stress_alternating"]).min())
