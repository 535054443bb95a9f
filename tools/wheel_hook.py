"""Puts compiled kernels into the wheel where `tools/wheel.py` names their folder, and the system and Python they are for into its
name."""

import os

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

FOLDER = "STICKSLIP_COMPILED_KERNELS"
"""The variable that names the folder of compiled kernels."""


class CompiledKernels(BuildHookInterface):
    def initialize(self, version, build_data):
        if folder := os.environ.get(FOLDER):
            build_data["force_include"][folder] = "stickslip/compiled_kernels"
            build_data["pure_python"], build_data["infer_tag"] = False, True
