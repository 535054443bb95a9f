"""stickslip: vibration of turbine blades and bladed disks with friction dampers.

The public names, each loaded from its module when it is first used, so that importing the package costs next to nothing:

>>> import stickslip as ss
>>> ss.hertz(480, 600)
Band(start=480.0, stop=600.0)
"""

from __future__ import annotations

import warnings
from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

_HOME = {
    "Structure": "stickslip.structure.matrices",
    "ModalDamping": "stickslip.structure.damping",
    "RayleighDamping": "stickslip.structure.damping",
    "Contact": "stickslip.contact.point",
    "between": "stickslip.contact.point",
    "Macroslip": "stickslip.contact.macroslip",
    "MicroslipArray": "stickslip.contact.microslip",
    "FrictionDisc": "stickslip.contact.friction_disc",
    "Iwan": "stickslip.contact.iwan",
    "mindlin_sphere": "stickslip.contact.iwan",
    "Hertz": "stickslip.contact.spectrum",
    "Parabolic": "stickslip.contact.spectrum",
    "FourParameter": "stickslip.contact.spectrum",
    "Gap": "stickslip.contact.gap",
    "CubicSpring": "stickslip.contact.cubic",
    "Dahl": "stickslip.contact.dahl",
    "TanhCoulomb": "stickslip.contact.tanh_coulomb",
    "Dashpot": "stickslip.structure.damping",
    "BaseMotion": "stickslip.loads",
    "SliderOffset": "stickslip.contact.start",
    "TractionRatio": "stickslip.contact.start",
    "MeanTraction": "stickslip.contact.start",
    "LineContact": "stickslip.contact.stiffness",
    "SphereContact": "stickslip.contact.stiffness",
    "static_normal_load": "stickslip.contact.stiffness",
    "ContactStiffness": "stickslip.analyses.contact_stiffness",
    "contact_stiffness": "stickslip.analyses.contact_stiffness",
    "Force": "stickslip.loads",
    "Output": "stickslip.loads",
    "Problem": "stickslip.problem",
    "NodalDiameters": "stickslip.analyses.nodal_diameters",
    "nodal_diameters": "stickslip.analyses.nodal_diameters",
    "TunedDisk": "stickslip.disks.tuned",
    "FullDisk": "stickslip.disks.full",
    "Mistuning": "stickslip.analyses.mistuning.disk",
    "Scatter": "stickslip.analyses.mistuning.disk",
    "DaskCluster": "stickslip.runs.dask_cluster",
    "mistuned_disk": "stickslip.analyses.mistuning.disk",
    "run_in": "stickslip.analyses.mistuning.run_in",
    "MistunedPopulation": "stickslip.analyses.mistuning.population",
    "mistuned_response": "stickslip.analyses.mistuning.population",
    "mistuned_population": "stickslip.analyses.mistuning.population",
    "CyclicStructure": "stickslip.structure.cyclic",
    "cyclic": "stickslip.structure.cyclic",
    "sector_chain": "stickslip.structure.cyclic",
    "Spring": "stickslip.structure.assembly",
    "Outcome": "stickslip.outcome",
    "Band": "stickslip.units",
    "hertz": "stickslip.units",
    "radians_per_second": "stickslip.units",
    "logspace": "stickslip.units",
    "InputError": "stickslip.checks",
    "read_structure": "stickslip.models.read",
    "read_model": "stickslip.models.read",
    "ForcedResponse": "stickslip.analyses.forced_response",
    "forced_response": "stickslip.analyses.forced_response",
    "ResponseSamples": "stickslip.analyses.variability.samples",
    "response_samples": "stickslip.analyses.variability.samples",
    "ResponseBounds": "stickslip.analyses.variability.bounds",
    "response_bounds": "stickslip.analyses.variability.bounds",
    "ResponseHistory": "stickslip.analyses.variability.history",
    "response_history": "stickslip.analyses.variability.history",
    "FrictionFreedom": "stickslip.analyses.variability.freedom",
    "friction_freedom": "stickslip.analyses.variability.freedom",
    "PerformanceCurve": "stickslip.analyses.performance.curve",
    "performance_curve": "stickslip.analyses.performance.curve",
    "PerformanceBand": "stickslip.analyses.performance.band",
    "performance_band": "stickslip.analyses.performance.band",
    "DamperDesign": "stickslip.analyses.performance.design",
    "damper_design": "stickslip.analyses.performance.design",
    "Parameter": "stickslip.analyses.sensitivity",
    "Sensitivity": "stickslip.analyses.sensitivity",
    "sensitivity": "stickslip.analyses.sensitivity",
    "SensitivityIndices": "stickslip.analyses.performance.sensitivity_indices",
    "sensitivity_indices": "stickslip.analyses.performance.sensitivity_indices",
    "PeakPath": "stickslip.analyses.performance.peak_path",
    "follow_peaks": "stickslip.analyses.performance.peak_path",
    "force_plane": "stickslip.analyses.damper_alone.force_plane",
    "DamperCycle": "stickslip.analyses.damper_alone.cycle",
    "damper_cycle": "stickslip.analyses.damper_alone.cycle",
    "steady_cycles": "stickslip.analyses.damper_alone.cycles",
    "damper_evolution": "stickslip.analyses.damper_alone.cycles",
    "harmonic_cycle": "stickslip.analyses.damper_alone.harmonic_cycle",
    "blade_with_routine": "stickslip.analyses.damper_alone.routine",
    "time_response": "stickslip.analyses.time_response",
    "GeneralisedAlpha": "stickslip.time.methods",
    "Newmark": "stickslip.time.methods",
    "open_results": "stickslip.results.files",
    "read_problem": "stickslip.study.read",
    "save_mat": "stickslip.results.matlab",
    "CheckpointFolder": "stickslip.runs.checkpoint",
    "as_quantity": "stickslip.results.quantities",
    "quantity_table": "stickslip.results.quantities",
    "peak_table": "stickslip.results.quantities",
    "read_record": "stickslip.measurement.records",
    "Record": "stickslip.measurement.records",
    "read_load_removal": "stickslip.measurement.load_removal",
    "whole_cycles": "stickslip.measurement.cycles",
    "reconstruct": "stickslip.measurement.reconstruction",
    "RigErrors": "stickslip.measurement.rig_errors",
    "ContactLoop": "stickslip.analyses.identification.loop_law",
    "identify_law": "stickslip.analyses.identification.loop_law",
    "Identification": "stickslip.analyses.identification.identify",
    "identify": "stickslip.analyses.identification.identify",
}
_MODULES = ("dampers", "rigs", "units")
_RENAMED = {
    "Design": "DamperDesign",
    "FinishedFolder": "CheckpointFolder",
    "MistunedDisks": "MistunedPopulation",
    "WhatMatters": "SensitivityIndices",
    "design_damper": "damper_design",
    "what_matters": "sensitivity_indices",
}
"""Old public names, which still work for one release, with a DeprecationWarning."""

__all__ = ["__version__", *_HOME, *_MODULES]

if TYPE_CHECKING:
    from stickslip import dampers, rigs, units
    from stickslip.analyses.contact_stiffness import ContactStiffness, contact_stiffness
    from stickslip.analyses.damper_alone.cycle import DamperCycle, damper_cycle
    from stickslip.analyses.damper_alone.cycles import damper_evolution, steady_cycles
    from stickslip.analyses.damper_alone.force_plane import force_plane
    from stickslip.analyses.damper_alone.harmonic_cycle import harmonic_cycle
    from stickslip.analyses.damper_alone.routine import blade_with_routine
    from stickslip.analyses.forced_response import ForcedResponse, forced_response
    from stickslip.analyses.identification.identify import Identification, identify
    from stickslip.analyses.identification.loop_law import ContactLoop, identify_law
    from stickslip.analyses.mistuning.disk import Mistuning, Scatter, mistuned_disk
    from stickslip.analyses.mistuning.population import MistunedPopulation, mistuned_population, mistuned_response
    from stickslip.analyses.mistuning.run_in import run_in
    from stickslip.analyses.nodal_diameters import NodalDiameters, nodal_diameters
    from stickslip.analyses.performance.band import PerformanceBand, performance_band
    from stickslip.analyses.performance.curve import PerformanceCurve, performance_curve
    from stickslip.analyses.performance.design import DamperDesign, damper_design
    from stickslip.analyses.performance.peak_path import PeakPath, follow_peaks
    from stickslip.analyses.performance.sensitivity_indices import SensitivityIndices, sensitivity_indices
    from stickslip.analyses.sensitivity import Parameter, Sensitivity, sensitivity
    from stickslip.analyses.time_response import time_response
    from stickslip.analyses.variability.bounds import ResponseBounds, response_bounds
    from stickslip.analyses.variability.freedom import FrictionFreedom, friction_freedom
    from stickslip.analyses.variability.history import ResponseHistory, response_history
    from stickslip.analyses.variability.samples import ResponseSamples, response_samples
    from stickslip.checks import InputError
    from stickslip.contact.cubic import CubicSpring
    from stickslip.contact.dahl import Dahl
    from stickslip.contact.friction_disc import FrictionDisc
    from stickslip.contact.gap import Gap
    from stickslip.contact.iwan import Iwan, mindlin_sphere
    from stickslip.contact.macroslip import Macroslip
    from stickslip.contact.microslip import MicroslipArray
    from stickslip.contact.point import Contact, between
    from stickslip.contact.spectrum import FourParameter, Hertz, Parabolic
    from stickslip.contact.start import MeanTraction, SliderOffset, TractionRatio
    from stickslip.contact.stiffness import LineContact, SphereContact, static_normal_load
    from stickslip.contact.tanh_coulomb import TanhCoulomb
    from stickslip.disks.full import FullDisk
    from stickslip.disks.tuned import TunedDisk
    from stickslip.loads import BaseMotion, Force, Output
    from stickslip.measurement.cycles import whole_cycles
    from stickslip.measurement.load_removal import read_load_removal
    from stickslip.measurement.reconstruction import reconstruct
    from stickslip.measurement.records import Record, read_record
    from stickslip.measurement.rig_errors import RigErrors
    from stickslip.models.read import read_model, read_structure
    from stickslip.outcome import Outcome
    from stickslip.problem import Problem
    from stickslip.results.files import open_results
    from stickslip.results.matlab import save_mat
    from stickslip.results.quantities import as_quantity, peak_table, quantity_table
    from stickslip.runs.checkpoint import CheckpointFolder
    from stickslip.runs.dask_cluster import DaskCluster
    from stickslip.structure.assembly import Spring
    from stickslip.structure.cyclic import CyclicStructure, cyclic, sector_chain
    from stickslip.structure.damping import Dashpot, ModalDamping, RayleighDamping
    from stickslip.structure.matrices import Structure
    from stickslip.study.read import read_problem
    from stickslip.time.methods import GeneralisedAlpha, Newmark
    from stickslip.units import Band, hertz, logspace, radians_per_second


def __getattr__(name: str) -> Any:
    if name in _RENAMED:
        warnings.warn(f"stickslip.{name} is now stickslip.{_RENAMED[name]}.", DeprecationWarning, stacklevel=2)
        name = _RENAMED[name]
    if name in _MODULES:
        return import_module(f"stickslip.{name}")
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'stickslip' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
