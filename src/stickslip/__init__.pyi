"""The public names, grouped by topic; `__init__.py` loads each from its module when it is first used."""

from . import dampers as dampers
from . import rigs as rigs
from . import units as units

# Structures and models
from .models.read import read_model as read_model, read_structure as read_structure
from .models.sector import read_sector as read_sector, read_sector_at_speeds as read_sector_at_speeds
from .interfaces.node_surface import NodeSurface as NodeSurface, mean_motion as mean_motion
from .interfaces.surface_contacts import surface_contacts as surface_contacts
from .structure.aerodynamics import Aerodynamics as Aerodynamics, BladeMode as BladeMode, blade_alone as blade_alone
from .structure.assembly import Spring as Spring, assemble as assemble
from .structure.cyclic import (
    CyclicStructure as CyclicStructure,
    cyclic as cyclic,
    sector_chain as sector_chain,
    with_bodies as with_bodies,
)
from .structure.damping import (
    AerodynamicDamping as AerodynamicDamping,
    Dashpot as Dashpot,
    ModalDamping as ModalDamping,
    RayleighDamping as RayleighDamping,
)
from .models.stress_places import StrainGauge as StrainGauge
from .structure.fatigue import FatigueLimit as FatigueLimit
from .structure.matrices import Structure as Structure
from .structure.rigid_body import PlanarBody as PlanarBody, RigidBody as RigidBody, box_inertia as box_inertia

# Loads, outputs and the problem
from .loads import BaseMotion as BaseMotion, Force as Force, Output as Output
from .problem import Problem as Problem
from .problem.speed import SpeedDependence as SpeedDependence

# Contacts: laws, directions, start states, stiffness
from .analyses.contact_stiffness import ContactStiffness as ContactStiffness, contact_stiffness as contact_stiffness
from .contact.cubic import CubicSpring as CubicSpring
from .contact.dahl import Dahl as Dahl
from .contact.friction_disc import FrictionDisc as FrictionDisc
from .contact.gap import Gap as Gap
from .contact.iwan import Iwan as Iwan, mindlin_sphere as mindlin_sphere
from .contact.lugre import LuGre as LuGre
from .contact.macroslip import Macroslip as Macroslip
from .contact.microslip import MicroslipArray as MicroslipArray
from .contact.point import Contact as Contact, between as between
from .contact.spectrum import FourParameter as FourParameter, Hertz as Hertz, Parabolic as Parabolic
from .contact.start import MeanTraction as MeanTraction, SliderOffset as SliderOffset, TractionRatio as TractionRatio
from .contact.stiffness import (
    LineContact as LineContact,
    SphereContact as SphereContact,
    static_normal_load as static_normal_load,
)
from .contact.tanh_coulomb import TanhCoulomb as TanhCoulomb
from .contact.valanis import Valanis as Valanis

from .analyses.hysteresis_loop import HysteresisLoop as HysteresisLoop, hysteresis_loop as hysteresis_loop

# Units and frequencies
from .units import Band as Band, hertz as hertz, logspace as logspace, radians_per_second as radians_per_second

# Forced response, in frequency and in time
from .analyses.forced_response import ForcedResponse as ForcedResponse, forced_response as forced_response
from .analyses.controlled_response import (
    ControlledResponse as ControlledResponse,
    PhaseResonance as PhaseResonance,
    controlled_response as controlled_response,
    phase_resonance as phase_resonance,
)
from .analyses.time_response import time_response as time_response
from .analyses.free_decay import FreeDecay as FreeDecay, free_decay as free_decay
from .time.methods import GeneralisedAlpha as GeneralisedAlpha, Newmark as Newmark

# Nonlinear modes
from .analyses.modes.nonlinear_modes import NonlinearModes as NonlinearModes, nonlinear_modes as nonlinear_modes
from .analyses.modes.limit_cycles import LimitCycles as LimitCycles, limit_cycles as limit_cycles

# Sensitivities and peaks over a parameter
from .analyses.performance.peak_path import PeakPath as PeakPath, follow_peaks as follow_peaks
from .analyses.performance.sensitivity_indices import (
    SensitivityIndices as SensitivityIndices,
    sensitivity_indices as sensitivity_indices,
)
from .analyses.sensitivity import Parameter as Parameter, Sensitivity as Sensitivity, sensitivity as sensitivity

# Response variability
from .analyses.variability.bounds import ResponseBounds as ResponseBounds, response_bounds as response_bounds
from .analyses.variability.freedom import FrictionFreedom as FrictionFreedom, friction_freedom as friction_freedom
from .analyses.variability.history import ResponseHistory as ResponseHistory, response_history as response_history
from .analyses.variability.samples import ResponseSamples as ResponseSamples, response_samples as response_samples

# Damper performance and design
from .analyses.performance.band import PerformanceBand as PerformanceBand, performance_band as performance_band
from .analyses.performance.curve import PerformanceCurve as PerformanceCurve, performance_curve as performance_curve
from .analyses.performance.design import DamperDesign as DamperDesign, damper_design as damper_design

# Bladed disks
from .analyses.mistuning.disk import Mistuning as Mistuning, Scatter as Scatter, mistuned_disk as mistuned_disk
from .analyses.mistuning.population import (
    MistunedPopulation as MistunedPopulation,
    mistuned_population as mistuned_population,
    mistuned_response as mistuned_response,
)
from .analyses.mistuning.run_in import run_in as run_in
from .analyses.damping_by_nodal_diameter import (
    DampingByNodalDiameter as DampingByNodalDiameter,
    damping_by_nodal_diameter as damping_by_nodal_diameter,
)
from .analyses.speed.campbell import Campbell as Campbell, campbell as campbell
from .analyses.speed.interference import InterferenceDiagram as InterferenceDiagram, interference_diagram as interference_diagram
from .analyses.speed.run_up import RunUp as RunUp, run_up as run_up
from .analyses.speed.speed_sweep import SpeedSweep as SpeedSweep, speed_sweep as speed_sweep
from .analyses.nodal_diameters import NodalDiameters as NodalDiameters, nodal_diameters as nodal_diameters
from .disks.full import FullDisk as FullDisk
from .disks.tuned import TunedDisk as TunedDisk

# The damper alone
from .analyses.damper_alone.cycle import DamperCycle as DamperCycle, damper_cycle as damper_cycle
from .analyses.damper_alone.cycles import damper_evolution as damper_evolution, steady_cycles as steady_cycles
from .analyses.damper_alone.force_plane import force_plane as force_plane
from .analyses.damper_alone.harmonic_cycle import harmonic_cycle as harmonic_cycle
from .analyses.damper_alone.routine import blade_with_routine as blade_with_routine

# Measurements and identification
from .analyses.identification.contact_law import (
    ContactLaw as ContactLaw,
    contact_law as contact_law,
    identify_law as identify_law,
)
from .analyses.identification.identify import Identification as Identification, identify as identify
from .analyses.identification.identify_response import (
    ResponseIdentification as ResponseIdentification,
    identify_response as identify_response,
)
from .analyses.identification.response_fit import FreeParameter as FreeParameter
from .analyses.identification.loop_law import ContactLoop as ContactLoop, LoopErrors as LoopErrors
from .measurement.contact_cycles import contact_cycles as contact_cycles
from .measurement.contact_record import ContactRecord as ContactRecord, read_contact_records as read_contact_records
from .measurement.cycles import whole_cycles as whole_cycles
from .measurement.measured_response import MeasuredResponse as MeasuredResponse
from .measurement.response_table import read_measured_response as read_measured_response
from .measurement.response_table import read_measured_responses as read_measured_responses
from .measurement.load_removal import read_load_removal as read_load_removal
from .measurement.reconstruction import reconstruct as reconstruct
from .measurement.records import Record as Record, read_record as read_record
from .measurement.rig_errors import RigErrors as RigErrors

# Results, execution, errors
from .checks import InputError as InputError
from .console import progress_bar as progress_bar
from .outcome import Outcome as Outcome
from .results.files import open_results as open_results
from .results.matlab import save_mat as save_mat
from .results.quantities import as_quantity as as_quantity, peak_table as peak_table, quantity_table as quantity_table
from .runs.checkpoint import CheckpointFolder as CheckpointFolder
from .runs.dask_cluster import DaskCluster as DaskCluster
from .study.read import read_problem as read_problem

__version__: str
