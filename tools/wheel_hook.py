"""Puts compiled kernels into the wheel where `tools/wheel.py` names their folder, and the system and Python they are for into its
name."""

import os
import platform
import sys

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

LINUX = "manylinux_2_28"
"""The systems for which numba itself has wheels: package indexes take none for any "linux". Kernels call nothing but numba."""

FOLDER = "STICKSLIP_COMPILED_KERNELS"
"""The variable that names the folder of compiled kernels."""


class CompiledKernels(BuildHookInterface):
    def initialize(self, version, build_data):
        if folder := os.environ.get(FOLDER):
            build_data["force_include"][folder] = "stickslip/compiled_kernels"
            build_data["pure_python"] = False
            if sys.platform == "linux":
                python = f"cp{sys.version_info.major}{sys.version_info.minor}"
                build_data["tag"] = f"{python}-{python}-{LINUX}_{platform.machine()}"
            else:
                build_data["infer_tag"] = True
