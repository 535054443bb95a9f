"""The public names, grouped by topic; `__init__.py` loads each from its module when it is first used."""

from . import dampers as dampers
from . import rigs as rigs
from . import units as units

# Structures and models
from .model.readers.read import read_model as read_model, read_structure as read_structure
from .model.readers.sector import read_sector as read_sector, read_sector_at_speeds as read_sector_at_speeds
from .model.interfaces.node_surface import NodeSurface as NodeSurface, mean_motion as mean_motion
from .model.interfaces.node_surface import surface_contacts as surface_contacts
from .model.structure.aerodynamics import Aerodynamics as Aerodynamics, BladeMode as BladeMode, blade_alone as blade_alone
from .model.structure.assembly import Spring as Spring, assemble as assemble
from .model.structure.cyclic import (
    CyclicStructure as CyclicStructure,
    cyclic as cyclic,
    sector_chain as sector_chain,
    with_bodies as with_bodies,
)
from .model.structure.matrices import (
    AerodynamicDamping as AerodynamicDamping,
    Dashpot as Dashpot,
    ModalDamping as ModalDamping,
    RayleighDamping as RayleighDamping,
)
from .model.readers.stress_places import StrainGauge as StrainGauge
from .model.structure.stress import FatigueLimit as FatigueLimit
from .model.structure.matrices import Structure as Structure
from .model.structure.assembly import RigidBody as RigidBody, box_inertia as box_inertia

# Loads, outputs and the problem
from .model.loads import BaseMotion as BaseMotion, Force as Force, Output as Output
from .model.problem.speed import CentrifugalLoad as CentrifugalLoad, in_rotation as in_rotation
from .model.problem.load_steps import LoadStep as LoadStep, after_load_steps as after_load_steps
from .model.problem import Problem as Problem
from .model.problem.speed import SpeedDependence as SpeedDependence

# Contacts: laws, directions, start states, stiffness
from .analyses.hysteresis_loop import ContactStiffness as ContactStiffness, contact_stiffness as contact_stiffness
from .model.contact.cubic import CubicSpring as CubicSpring
from .model.contact.dahl import Dahl as Dahl
from .model.contact.law import LoadDependentFriction as LoadDependentFriction
from .model.contact.friction_disc import FrictionDisc as FrictionDisc
from .model.contact.cubic import Gap as Gap
from .model.contact.microslip import Iwan as Iwan
from .model.contact.lugre import LuGre as LuGre
from .model.contact.macroslip import Macroslip as Macroslip
from .model.contact.microslip import MicroslipArray as MicroslipArray
from .model.contact.point import Contact as Contact, between as between
from .model.contact.microslip import FourParameter as FourParameter, Hertz as Hertz, Parabolic as Parabolic
from .model.contact.point import MeanTraction as MeanTraction, SliderOffset as SliderOffset, TractionRatio as TractionRatio
from .model.contact.stiffness import (
    LineContact as LineContact,
    SphereContact as SphereContact,
    static_normal_load as static_normal_load,
)
from .model.contact.tanh_coulomb import TanhCoulomb as TanhCoulomb
from .model.contact.valanis import Valanis as Valanis

from .analyses.hysteresis_loop import HysteresisLoop as HysteresisLoop, hysteresis_loop as hysteresis_loop

# Units and frequencies
from .support.units import Band as Band, hertz as hertz, logspace as logspace, radians_per_second as radians_per_second

# Forced response, in frequency and in time
from .analyses.forced_response import ForcedResponse as ForcedResponse, forced_response as forced_response
from .analyses.controlled_response import (
    ControlledResponse as ControlledResponse,
    PhaseResonance as PhaseResonance,
    controlled_response as controlled_response,
    phase_resonance as phase_resonance,
)
from .analyses.stepped_sine import SteppedSine as SteppedSine, stepped_sine as stepped_sine
from .analyses.time_response import time_response as time_response
from .analyses.free_decay import FreeDecay as FreeDecay, free_decay as free_decay
from .solve.time.period import GeneralisedAlpha as GeneralisedAlpha, Newmark as Newmark

# Nonlinear modes
from .analyses.modes.nonlinear_modes import NonlinearModes as NonlinearModes, nonlinear_modes as nonlinear_modes
from .analyses.modes.nonlinear_modes import LimitCycles as LimitCycles, limit_cycles as limit_cycles

# Sensitivities and peaks over a parameter
from .analyses.performance.curve import PeakPath as PeakPath, follow_peaks as follow_peaks
from .analyses.performance.sensitivity_indices import (
    SensitivityIndices as SensitivityIndices,
    sensitivity_indices as sensitivity_indices,
)
from .analyses.sensitivity import Parameter as Parameter, Sensitivity as Sensitivity, sensitivity as sensitivity

# Response variability
from .analyses.variability.bounds import ResponseBounds as ResponseBounds, response_bounds as response_bounds
from .analyses.variability.samples import ResponseHistory as ResponseHistory, response_history as response_history
from .analyses.variability.samples import ResponseSamples as ResponseSamples, response_samples as response_samples

# Damper performance and design
from .analyses.performance.curve import PerformanceBand as PerformanceBand, performance_band as performance_band
from .analyses.performance.curve import PerformanceCurve as PerformanceCurve, performance_curve as performance_curve
from .analyses.performance.design import DamperDesign as DamperDesign, damper_design as damper_design

# Bladed disks
from .analyses.mistuning.disk import Mistuning as Mistuning, Scatter as Scatter, mistuned_disk as mistuned_disk
from .analyses.mistuning.work import (
    MistunedPopulation as MistunedPopulation,
    mistuned_population as mistuned_population,
    mistuned_response as mistuned_response,
)
from .analyses.mistuning.work import run_in as run_in
from .analyses.nodal_diameters import (
    DampingByNodalDiameter as DampingByNodalDiameter,
    damping_by_nodal_diameter as damping_by_nodal_diameter,
)
from .analyses.speed.campbell import Campbell as Campbell, campbell as campbell
from .analyses.speed.campbell import InterferenceDiagram as InterferenceDiagram, interference_diagram as interference_diagram
from .analyses.speed.speed_sweep import RunUp as RunUp, run_up as run_up
from .analyses.speed.speed_sweep import SpeedSweep as SpeedSweep, speed_sweep as speed_sweep
from .analyses.nodal_diameters import NodalDiameters as NodalDiameters, nodal_diameters as nodal_diameters
from .model.disks.tuned import FullDisk as FullDisk
from .model.disks.tuned import TunedDisk as TunedDisk

# The damper alone
from .analyses.damper_alone.cycle import DamperCycle as DamperCycle, damper_cycle as damper_cycle
from .analyses.damper_alone.cycle import damper_evolution as damper_evolution, steady_cycles as steady_cycles

# Measurements and identification
from .laboratory.identification.contact_law.fit import LoopErrors as LoopErrors
from .laboratory.identification.contact_law.fit import ContactLoop as ContactLoop
from .laboratory.identification.contact_law.work import ContactLaw as ContactLaw
from .laboratory.identification.contact_law.work import contact_law as contact_law
from .laboratory.identification.damper.work import Identification as Identification
from .laboratory.identification.damper.work import identify as identify
from .laboratory.identification.response.prediction_result import ResponsePrediction as ResponsePrediction
from .laboratory.identification.response.decay_prediction import predict_decay as predict_decay
from .laboratory.identification.response.decay_prediction import DecayPrediction as DecayPrediction
from .laboratory.identification.response.prediction import predict_response as predict_response
from .laboratory.identification.response.result import ResponseIdentification as ResponseIdentification
from .laboratory.identification.response.work import identify_response as identify_response
from .laboratory.identification.least_squares import FreeParameter as FreeParameter
from .laboratory.measurement.contact_cycles import contact_cycles as contact_cycles
from .laboratory.measurement.contact_record import ContactRecord as ContactRecord, read_contact_records as read_contact_records
from .laboratory.measurement.decay import (
    MeasuredDecay as MeasuredDecay,
    measured_decay as measured_decay,
    read_decay as read_decay,
)
from .laboratory.measurement.cycles import whole_cycles as whole_cycles
from .laboratory.measurement.measured_response import MeasuredResponse as MeasuredResponse
from .laboratory.measurement.response_table import read_measured_response as read_measured_response
from .laboratory.measurement.response_table import read_measured_responses as read_measured_responses
from .laboratory.measurement.cycles import read_load_removal as read_load_removal
from .laboratory.measurement.reconstruction import reconstruct as reconstruct
from .laboratory.measurement.records import Record as Record, read_record as read_record
from .laboratory.measurement.reconstruction import RigErrors as RigErrors

# Results, execution, errors
from .support.checks import InputError as InputError
from .support.console import progress_bar as progress_bar
from .support.outcome import Outcome as Outcome
from .results.files import open_results as open_results
from .results.files import save_mat as save_mat
from .results.quantities import as_quantity as as_quantity, peak_table as peak_table, quantity_table as quantity_table
from .runs.cases import CheckpointFolder as CheckpointFolder
from .runs.dask_cluster import DaskCluster as DaskCluster
from .study.reading import read_problem as read_problem

__version__: str
