"""The Slurm job of docs/cluster.md, with a stand-in for `srun` that starts its tasks on this machine."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import stickslip as ss
from stickslip.runs import dask_cluster

JOB = re.search(r"```sh\n(#!/bin/bash\n.*?)```", (Path(__file__).parents[2] / "docs" / "cluster.md").read_text(), re.S)[1]
STUDY = """
[study]
analysis = "forced_response"
[structure]
rig = "single_mass"
[sweep]
frequency = [0.1, 0.3]
force_levels = [0.5, 1.0]
harmonics = 1
samples = 24
"""
SRUN = """#!/bin/bash
for task in $(seq "${1#--ntasks=}"); do "${@:2}" --host 127.0.0.1 & done
trap 'kill $(jobs -p)' TERM
wait
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt" or not dask_cluster.installed(), reason="needs bash and distributed")
@pytest.mark.parametrize(("study", "code"), [(STUDY, 0), (STUDY.replace("harmonics = 1", "harmonics = -1"), 2)])
def test_the_job_computes_a_study_and_ends_with_its_exit_code(study, code, tmp_path):
    (tmp_path / "study.toml").write_text(study)
    activate = tmp_path / ".venv" / "bin" / "activate"
    activate.parent.mkdir(parents=True)
    activate.write_text("")
    tools = tmp_path / "tools"
    tools.mkdir()
    (tools / "srun").write_text(SRUN)
    (tools / "srun").chmod(0o755)
    (tmp_path / "job.sh").write_text(JOB)
    path = os.pathsep.join([str(tools), str(Path(sys.executable).parent), os.environ["PATH"]])
    settings = {"PATH": path, "SLURM_NTASKS": "3", "SLURM_JOB_ID": "1", "PYTHONSAFEPATH": "1"}
    ran = subprocess.run(
        ["bash", "job.sh"], cwd=tmp_path, env={**os.environ, **settings}, capture_output=True, text=True, timeout=300, check=False
    )
    assert ran.returncode == code, ran.stderr
    results = tmp_path / "results" / "disks" / "results.nc"
    assert results.is_file() == (code == 0)
    if code == 0:
        assert ss.open_results(results).sizes["case"] == 2
