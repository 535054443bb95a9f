"""Tables of a study file: [structure], [damping], [[force]], [[dashpot]], [base] and [sweep]."""

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, TypeAlias

from pydantic import Field, Tag, WrapValidator, field_validator, model_validator

from stickslip.analyses.settings import ForcedResponseSettings
from stickslip.model.dampers import SHAPES
from stickslip.model.loads import HIGHEST_POWER
from stickslip.model.structure.cyclic import MOST_SECTORS
from stickslip.study.fields import (
    ACCELERATION,
    FORCE,
    FREQUENCY,
    INERTIA,
    LENGTH,
    MASS,
    STIFFNESS,
    VELOCITY,
    VISCOSITY,
    Amplitude,
    Coefficients,
    Dimension,
    Direction,
    Groups,
    Harmonics,
    NotNegative,
    NotNegatives,
    Number,
    Place,
    Positive,
    QuantityName,
    Table,
    Vector,
    Words,
    by_form,
    table_of,
)
from stickslip.support.checks import MOST, fault, unique

if TYPE_CHECKING:
    ShapeKey: TypeAlias = str
else:
    ShapeKey = Literal[tuple(SHAPES)]

Two = Annotated[list[Number], Field(min_length=2, max_length=2), Words("pair of numbers")]
Ends = Annotated[list[Positive], Field(min_length=2, max_length=2), Words("pair of numbers")]
Order = Annotated[int, Field(ge=1, le=10_000)]
Matrix = Annotated[list[list[Number]], Words("list of rows")]


Named = Annotated[dict[str, Number], Words("table of numbers")]
NONE: Any = Field(default_factory=dict)


def _where_form(value: Any) -> str:
    return "<number>" if isinstance(value, int) else "<list>" if isinstance(value, list) else "<single>"


class MatricesTable(Table):
    """Small matrices, written row by row in the study file itself."""

    M: Annotated[Matrix, Dimension("kg"), Field(description="mass")]
    K: Annotated[Matrix, Dimension("N/m"), Field(description="stiffness")]
    C: Annotated[Matrix | None, Dimension("N s/m"), Field(description="damping")] = None


class FilesTable(Table):
    """The files of the matrices of a model, where a format has one matrix a file."""

    M: Annotated[str, Field(description="file of the mass")]
    K: Annotated[str, Field(description="file of the stiffness")]
    C: Annotated[str | None, Field(description="file of the damping")] = None


ModelFile = Annotated[
    Annotated[str, Tag("<single>")] | Annotated[FilesTable, Tag("<table>")], by_form(), Words("file, or table of files")
]
NodeOrSet = Annotated[str, Tag("<single>")] | Annotated[int, Tag("<number>")]
Where = Annotated[
    NodeOrSet | Annotated[list[Number], Field(min_length=3, max_length=3), Tag("<list>")], by_form(_where_form), Words("place")
]


class GaugeTable(Table):
    """A strain gauge at a place of stress."""

    at: Annotated[Where, Field(description="its node or its coordinates")]
    direction: Annotated[Vector, Field(description="direction in which it measures, in the axes of the model")]


StressPlace = Annotated[
    Annotated[Where, Tag("<place>")] | Annotated[GaugeTable, Tag("<table>")],
    by_form(lambda value: "<table>" if isinstance(value, dict | GaugeTable) else "<place>"),
    Words("place, or strain gauge"),
]
Keep = Annotated[
    Annotated[dict[str, Where], Field(min_length=1), Tag("<table>")]
    | Annotated[list[Annotated[NodeOrSet, by_form(_where_form)]], Field(min_length=1), Tag("<list>")],
    by_form(),
    Words("table of places, or list of nodes and sets"),
]

Matrices = Annotated[Annotated[str, Tag("<single>")] | Annotated[MatricesTable, Tag("<table>")], by_form()]


class OverSpeedTable(Table):
    """Engine orders EO excite with ω = EO Ω; stiffness and static forces go with the square of the rotor speed Ω."""

    key: ClassVar[str] = ""
    """Its name in a study, for messages."""

    speed: Annotated[list[Positive], Field(min_length=2, max_length=2, description="[first, last] rotor speed, rev/min")]
    engine_orders: Annotated[list[Order], Field(min_length=1, description="engine orders, one curve for each")]
    reference_speed: Positive | None = None
    """speed at which [structure] and the static forces hold, rev/min; static forces vary as Ω²; default: the speed of [rotation]
    or [structure.sector]"""
    stiffness_at_rest: (
        Annotated[Annotated[str, Tag("<single>")] | Annotated[list[list[Number]], Tag("<list>")], by_form()] | None
    ) = None
    """K at speed 0, in the order of `dofs`, or a file .npz or .mat; default: K without the spin softening added by [rotation]"""

    def check(self) -> None:
        """Two different ends, and each engine order once."""
        if self.speed[0] == self.speed[1]:
            raise fault("speed", "must have two different ends", self.speed)
        unique("engine_orders", self.engine_orders)


class AxisTable(Table):
    """An axis of rotation. The following sector of a disk comes counter-clockwise about it."""

    point: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    """a point of the axis, in the unit of length of the model"""
    direction: Vector = Field(default_factory=lambda: [0.0, 0.0, 1.0])
    """direction of the axis, of any length"""


class RotationTable(Table):
    """Steady rotation. The centrifugal load of every model and rigid body acts as a static load; `speed` and `axis` of
    [structure] and `pull` of [[body]] must be left out. Spin softening is added to the K of a supported model that has none."""

    speed: Annotated[Positive, Field(description="rotor speed in rev/min")]
    axis: Annotated[AxisTable, Words("table")] = Field(default_factory=AxisTable)
    """axis in the coordinates of the study, its point in the study's unit of length; default: z through the origin"""
    coriolis: bool = False
    """whether Coriolis forces act; the rotation is right-handed about `direction`"""


class LoadStepTable(Table):
    """A load that acts before the load of the study; sliders start where it leaves them. Several tables are applied in order,
    and the load of the study comes last. What a table does not state is as in the study."""

    at_most_one: ClassVar[Groups] = (("factor", "speed"),)

    factor: Annotated[Number, Field(description="factor of all static forces of the study")] = 1.0
    speed: Annotated[NotNegative | None, Field(description="rotor speed in rev/min, which sets the load of [rotation]")] = None
    static: Annotated[Named, FORCE, Field(description="{ NAME = static part of that [[force]] }, whatever `factor` is")] = NONE
    pull: Annotated[dict[str, Vector], Words("table of lists"), FORCE] = NONE
    """{ NAME = [x, y, z], the pull on that [[body]] }"""
    preload: Annotated[Named, FORCE] = NONE
    """{ NAME = N0 of that [[contact]] }, in place of its `preload` and `mean_pressure`; of a surface as a whole"""
    gap: Annotated[Named, LENGTH, Field(description="{ NAME = gap of that [[contact]] }; negative: an interference")] = NONE
    normal_load: Annotated[Named, FORCE, Field(description="{ NAME = constant normal load of that [[contact]] }")] = NONE


class AtSpeedTable(Table):
    """The same sector at another rotor speed."""

    speed: Annotated[NotNegative, Field(description="rev/min")]
    model: Annotated[str, Field(description="its model file, relative to the study file, with the same rows and the same mass")]


class SectorTable(Table):
    """The model is one sector of a bladed disk of equal sectors, with both faces free. The disk needs [excitation]."""

    sectors: Annotated[int, Field(ge=2, le=MOST_SECTORS, description="number N of sectors of the disk")]
    low: Annotated[str, Field(min_length=1, description="set of nodes of the face to the preceding sector")]
    high: Annotated[str, Field(min_length=1)]
    """set of nodes of the face to the following sector: low turned by 360°/N about the axis"""
    axis: Annotated[AxisTable, Words("table")] = Field(default_factory=AxisTable)
    """axis of rotation; default: z through the origin"""
    faces: Annotated[
        Literal["matching", "interpolated"],
        Field(
            description='"matching": node k of one face is node k of the other; "interpolated": the finer face follows the nodes '
            "of the other by interpolation"
        ),
    ] = "matching"
    speed: NotNegative | None = None
    """rotor speed in rev/min whose stress stiffening K contains, and spin softening as in CalculiX"""
    at_speeds: Annotated[list[AtSpeedTable], Words("list of tables")] = Field(default_factory=list)
    """models at other speeds, for analyses over the speed: K varies with the square of the speed"""


class StructureTable(Table):
    """A ready rig by name with its parameters, a model of another program, or matrices with names of their degrees of freedom."""

    exactly_one: ClassVar[Groups] = (("rig", "matrices", "model"),)
    at_most_one: ClassVar[Groups] = (("parameters", "matrices"), ("parameters", "model"), ("dofs", "names"))
    together: ClassVar[tuple[tuple[str, str], ...]] = (("matrices", "dofs"),)

    name: Annotated[str | None, Field(min_length=1)] = None
    """where there are several, [[structure]]: in front of the names of this one, NAME/NODE"""
    rig: Annotated[str | None, Field(description="name of a ready problem")] = None
    parameters: Annotated[dict[str, Any], Field(description="arguments of the rig, in SI")] = Field(default_factory=dict)
    matrices: Matrices | None = None
    """a .npz or .mat file (beside the study) that holds M, K and perhaps C; or a table of these"""
    dofs: Annotated[list[str] | None, Field(min_length=1)] = None
    """NODE.DIRECTION of each row of the matrices; directions rx, ry, rz are rotations"""
    model: ModelFile | None = None
    """a finite-element model (beside the study): a file of any format of the page on models"""
    names: str | None = None
    """coordinates, sets and names of rows that the model lacks: a deck (.cdb, .inp, .bdf) or a table (CSV)"""
    variables: Annotated[dict[Literal["M", "K", "C"], str] | None, Words("table of names")] = None
    """names of the matrices in the file"""
    units: Literal["SI", "mm-t-s", "mm-kg-s", "mm-kg-ms"] | None = None
    """units of the model, unless those of the study"""
    own_damping: bool = True
    """whether the C of model or matrices counts; false where [damping] is to stand for it"""
    keep: Annotated[
        Keep | None,
        Field(
            description="places that stay when the model is reduced: NAME = node, set or [x, y, z]; the rest becomes modes. "
            "Without it the model is taken whole"
        ),
    ] = None
    modes: Annotated[int | None, Field(ge=0, le=MOST)] = None
    """number of fixed-interface modes of the reduction, of a sector for each nodal diameter; default: 30"""
    stress: Annotated[
        dict[str, StressPlace] | None,
        Field(
            min_length=1,
            description="places whose stress is recovered from the elements of the deck: NAME = node, set or [x, y, z], or a "
            "strain gauge, NAME = { at = node or [x, y, z], direction = [x, y, z] }",
        ),
        Words("table of places"),
    ] = None
    shift: Vector | None = None
    """of all nodes, in the unit of length of the model: the same blade again, beside itself"""
    speed: NotNegative | None = None
    """rotor speed in rev/min of a model that is not a sector; the mean stress then contains that due to rotation"""
    axis: Annotated[AxisTable | None, Words("table")] = None
    """axis of this rotation, in the coordinates of the model; by default z through the origin"""
    sector: Annotated[SectorTable | None, Words("table")] = None
    """[structure.sector]: the model is one sector of a bladed disk"""


Inertia = Annotated[
    Annotated[list[Positive], Field(min_length=3, max_length=3), Tag("<list>")]
    | Annotated[list[Vector], Field(min_length=3, max_length=3), Tag("<several>")],
    by_form(lambda value: "<several>" if isinstance(value, list) and value and isinstance(value[0], list) else "<list>"),
    Words("three numbers, or three rows of them"),
]


class BodyTable(Table):
    """A rigid body, such as a damper: its degrees of freedom are NAME/centre.x, .y, .z, .rx, .ry, .rz."""

    exactly_one: ClassVar[Groups] = (("mass", "shape"),)
    at_most_one: ClassVar[Groups] = (("mass", "dimensions"), ("between", "centre"), ("between", "axes"), ("between", "mass"))
    together: ClassVar[tuple[tuple[str, str], ...]] = (("mass", "inertia"),)

    name: Annotated[str, Field(min_length=1, description="name of the body")]
    shape: ShapeKey | None = None
    """shape of a damper, which gives mass, inertia and outline; contacts are placed by their own tables"""
    dimensions: dict[str, Any] = Field(default_factory=dict)
    """arguments of the shape; lengths in units of the study, angles in degrees; defaults by shape"""
    mass: Annotated[Positive | None, MASS, Field(description="mass of the body, in place of a shape")] = None
    inertia: Annotated[Inertia | None, INERTIA, Field(description="about the mass centre: three moments, or the matrix")] = None
    centre: Annotated[Vector, LENGTH] = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    """mass centre, in the coordinates of the model"""
    between: Annotated[list[str] | None, Field(min_length=2, max_length=2)] = None
    """sets of nodes of the left and right platform, both flat: centre, axes and angles of the shape, its depth, and width and
    height of a wedge follow; the pull, or the radius in [rotation], points to the ridge of the platforms"""
    axes: Annotated[list[Vector] | None, Field(min_length=2, max_length=2)] = None
    """x and y of the body, at right angles, in the coordinates of the model; default: those of the model"""
    pull: Annotated[Vector, FORCE] = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    """static force at the mass centre, such as the centrifugal pull"""


class DampingTable(Table):
    """Viscous damping, when there is no C."""

    exactly_one: ClassVar[Groups] = (("modal", "rayleigh"),)

    modal: Annotated[NotNegatives | None, Field(description="damping ratio of all modes, or of the first ones one by one")] = None
    on: Annotated[Literal["stuck", "free"], Field(description="modes with the contacts stuck, or absent")] = "stuck"
    rayleigh: Annotated[Two | None, Dimension("1/s, s"), Field(description="[a, b]: C = a M + b K")] = None


class ExcitationTable(Table):
    """Engine orders of a bladed disk: EO forces sector j by F cos(EO Ωt − 2π EO j/N). Frequencies are those of the lowest common
    one, EO Ω/2π."""

    exactly_one: ClassVar[Groups] = (("engine_order", "orders"),)

    engine_order: Annotated[int | None, Field(ge=0, le=10_000, description="EO, by which every [[force]] acts")] = None
    orders: Annotated[dict[str, Amplitude] | None, Field(min_length=1), Words("table of factors")] = None
    """several at once, EO = factor on the forces, a number or [re, im]; the frequency is that of their greatest common divisor"""


class MeanSpringTable(Table):
    """A spring that acts on the mean position alone, where friction alone restrains a body; vibration does not feel it."""

    direction: Place
    """degree of freedom, or a table of coefficients, such as that of the axial position of a damper"""
    k: Annotated[Positive, STIFFNESS, Field(description="stiffness, far below that of the contacts")]


class ForceTable(Table):
    """p(t) = static + Re(level · amplitude · ω^k exp(i h ω t)). Several at one place make a polynomial in ω."""

    name: Annotated[str, Field(description="name for [[load_step]]")] = ""
    direction: Place
    """degree of freedom, or a table of coefficients; with `surface` x, y or z, or a table of these"""
    surface: str | None = None
    """set of nodes over which the force is spread by area; `amplitude` is the whole force"""
    line: bool | None = None
    """true for a line load, spread over the length of nodes along an edge; required for a bent edge"""
    amplitude: Annotated[Amplitude, FORCE, Field(description="F for F cos ωt, or [re, im]; F sin ωt is [0, −F]")] = 0.0
    harmonic: Annotated[int, Field(ge=1, le=1000, description="h")] = 1
    static: Annotated[Number, FORCE, Field(description="constant part; force levels leave it as it is")] = 0.0
    omega_power: Annotated[int, Field(ge=0, le=HIGHEST_POWER)] = 0
    """k, with ω in rad/s whatever the units; 2 for an unbalance m e, then `amplitude`"""


class DashpotTable(Table):
    """A viscous damper, force c ẇ, beside whatever damping the structure has."""

    between: Annotated[Direction, Field(description="[A, B]: A relative to B, of which one may be ground; or coefficients")]
    c: Annotated[Positive, VISCOSITY, Field(description="force per velocity")]


class BaseTable(Table):
    """A base that moves as given. Degrees of freedom, outputs and contacts to ground are relative to it."""

    exactly_one: ClassVar[Groups] = (("acceleration", "velocity", "displacement"),)

    direction: Place
    """"x": every degree of freedom NODE.x moves with the base; or a table of coefficients"""
    acceleration: Annotated[Amplitude | None, ACCELERATION] = None
    """A for A cos ωt, or [re, im]; force levels multiply it"""
    velocity: Annotated[Amplitude | None, VELOCITY, Field(description="or that of the velocity, at every frequency")] = None
    displacement: Annotated[Amplitude | None, LENGTH, Field(description="or that of the displacement, at every frequency")] = None
    harmonic: Annotated[int, Field(ge=1, le=1000, description="h")] = 1


class OutputTable(Table):
    """A displacement along an inclined direction, with a name."""

    name: Annotated[str, Field(min_length=1, description="name in the results")]
    direction: Annotated[Coefficients, Field(description="coefficients of degrees of freedom")]


OutputPlace = Annotated[Annotated[str, Tag("<single>")] | Annotated[OutputTable, Tag("<table>")], by_form()]


class FrequenciesTable(Table):
    """Frequencies and outputs, the keys of [sweep] that are no settings of a forced response."""

    exactly_one: ClassVar[Groups] = (("frequency", "at"),)

    frequency: Annotated[Ends | None, FREQUENCY, Field(description="[start, stop]: continue over this band")] = None
    at: Annotated[list[Positive] | None, FREQUENCY, Field(min_length=1)] = None
    """instead of a band: solve exactly at these frequencies"""
    outputs: Annotated[list[OutputPlace] | None, Field(min_length=1)] = None
    """degrees of freedom to report; a rig has its own"""

    @field_validator("frequency")
    @classmethod
    def _two_ends(cls, frequency: list[float] | None) -> list[float] | None:
        if frequency is not None and frequency[0] == frequency[1]:
            raise ValueError("must have two different ends")
        return frequency


class OwnRangeTable(FrequenciesTable):
    """[sweep] of an analysis whose own table says where to compute."""

    exactly_one: ClassVar[Groups] = ()

    @model_validator(mode="after")
    def _without_frequencies(self) -> "OwnRangeTable":
        given = [key for key in ("frequency", "at") if getattr(self, key) is not None]
        if given:
            raise ValueError(f"must not hold {given[0]}, since the analysis has a range of its own")
        return self


SweepTable, FinenessTable = (
    table_of(
        ForcedResponseSettings,
        "Where to compute, and how finely. A speed sweep has neither `frequency` nor `at`.",
        base,
        force_levels=(Annotated[list[Positive], Field(min_length=1)], [1.0]),
        harmonics=Annotated[Harmonics, WrapValidator(lambda value, check: value if value == "auto" else check(value))],
        quantity=QuantityName,
        measure=Literal["amplitude", "rms", "max_abs"],
    )
    for base in (FrequenciesTable, OwnRangeTable)
)
