"""One case of a grid, resolved and in SI, as typed records instead of nested dicts.

The numbers of a mechanism or a law are stored by the name of their key, since each has its own; the code that
declares a key reads it.  Everything else has a field.
"""

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

from .catalogue import Law, Outline
from .vibration import Vibration


@dataclass(frozen=True)
class LawFile:
    """A file of laws of one's own.  A process runs its text only where the user trusts it: grid.written.trust."""

    name: str  # as in the grid, and in messages
    path: str  # where it was read, absolute
    text: str
    named: tuple[tuple[str, str], ...] = ()  # paths of the libraries and tables that its text names, and their SHA-256
    package: str = ""  # of an installed library, for its relative imports
    laws: tuple[Law, ...] = ()  # as grids name them
    is_allowed: bool = field(default=False, compare=False)  # the process that began the run may run it

    @cached_property
    def sha256(self) -> str:
        """Return the SHA-256 of the content of the file, in lower-case hexadecimal digits."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    @cached_property
    def key(self) -> str:
        """Return 16 hexadecimal digits of all on which its laws depend: the place, the text, and what this names."""
        content = repr((self.path, self.sha256, self.named, self.package))
        return hashlib.sha256(content.encode()).hexdigest()[:16]

    @cached_property
    def source(self) -> str:
        """Return the text as Python reads it: without a byte order mark, with one kind of line ends."""
        return self.text.removeprefix("\ufeff").replace("\r\n", "\n")


class Mechanism(NamedTuple):
    """The bodies: numbers and words by dotted path below `mechanism`, such as 'crank.length' (m)."""

    type: str
    values: Mapping[str, Any]


Table = Mapping[str, tuple[float, ...]]  # column -> its values in SI


class Drive(NamedTuple):
    """The drive of the crank: a speed, a table, a torque, a motor or a servo."""

    speed: float = 0.0  # rad/s, constant
    #: time (s) and speed (rad/s), time and angle (rad), also as the target of a servo, or speed and torque (N m)
    table: Table | None = None
    torque: float = 0.0  # N m, constant; of a motor, at rest
    no_load_speed: float = math.inf  # rad/s, at which a motor gives no torque
    initial_speed: float = 0.0  # rad/s, of a free crank
    inertia: float = 0.0  # kg m^2, of a flywheel
    start_angle: float = 0.0  # rad
    law: str = ""  # of a motor of one's own
    values: Mapping[str, float] = {}  # its parameters, or those of a servo, by key
    laws: str = ""  # hash of the laws of the grid's own


class Load(NamedTuple):
    """An external load on a mechanism."""

    name: str
    form: str  # the name of a law of the family 'load'
    values: Mapping[str, Any]  # numbers and words by key
    table: Table | None = None
    friction: "Friction | None" = None
    laws: str = ""  # hash of the laws of the grid's own


class Material(NamedTuple):
    """The material of a body."""

    young: float  # Pa
    poisson: float  # 1
    yield_strength: float | None = None  # Pa


class Materials(NamedTuple):
    """The materials of the bodies of a joint."""

    bearing: Material
    journal: Material


class Contact(NamedTuple):
    """The normal force of a joint."""

    law: str
    elastic: str | None  # None: the law has its own stiffness
    values: Mapping[str, float]  # parameters of both laws, by key
    material: Materials | None = None
    onset: str | None = None  # how long the onset rate counts: 'first' or 'renewed'; None: the law does not use it
    fit: Table | None = None  # penetration (m) and force (N) that the elastic law is fitted to


class Roughness(NamedTuple):
    """The roughness of the surfaces of a joint."""

    law: str
    values: Mapping[str, float]
    tables: Mapping[str, Table]  # parameters, by key


class Friction(NamedTuple):
    """The friction of a joint."""

    law: str
    values: Mapping[str, float]


class Profile(NamedTuple):
    """The shape of a bearing that is no circle."""

    law: str
    values: Mapping[str, float]


#: Bounds of k times the hardness, the dimensionless wear coefficient (share of contacts that shed a particle): what
#: no pair of materials reaches, above which it is doubtful, and below which it is one in m^2/N that lacks its unit.
LARGEST_WEAR_NUMBER, DOUBTFUL_WEAR_NUMBER, LEAST_WEAR_NUMBER = 0.1, 1e-2, 1e-10


class Wear(NamedTuple):
    """The wear of a joint."""

    law: str
    pressure: str
    bins: int  # of each body
    values: Mapping[str, float]  # bearing_coefficient, journal_coefficient, and further parameters of the laws
    dimensionless: bool = False  # the coefficients are k times the hardness
    running_in: Mapping[str, float] | None = None  # bearing_initial, journal_initial, distance (m)
    evolve: bool = False  # the worn shape affects contact
    length_bins: int = 1  # of each body along its length

    def coefficients(self) -> dict[str, tuple[float, ...]]:
        """Return the wear coefficients (m^2/N or m^3/J) of both bodies: after and before running-in."""
        divisor = self.values["hardness"] if self.dimensionless else 1.0
        initial = self.running_in or {}
        return {
            body: tuple(
                numbers[key] / divisor
                for numbers, key in ((self.values, f"{body}_coefficient"), (initial, f"{body}_initial"))
                if key in numbers
            )
            for body in ("bearing", "journal")
        }


class Oil(NamedTuple):
    """An oil with temperature-dependent viscosity."""

    viscosity_40: float  # m^2/s, kinematic, at 40 degC
    viscosity_100: float  # m^2/s, at 100 degC
    density: float  # kg/m^3

    def viscosity(self, temperature: float) -> float:
        """Return the dynamic viscosity (Pa s) at a temperature T (K) by Walther's equation (ASTM D341).

        log10(log10(nu + 0.7)) is linear in log10(T), where nu is the kinematic viscosity in mm^2/s, at most 1e300:
        it rises steeply towards low temperatures.
        """
        log_log_40, log_log_100 = (
            math.log10(math.log10(1e6 * nu + 0.7)) for nu in (self.viscosity_40, self.viscosity_100)
        )
        fraction = (math.log10(temperature) - math.log10(313.15)) / (math.log10(373.15) - math.log10(313.15))
        log_log = min(log_log_40 + fraction * (log_log_100 - log_log_40), math.log10(300.0))
        dynamic: float = self.density * 1e-6 * (10.0**10.0**log_log - 0.7)
        return dynamic


class Housing(NamedTuple):
    """A housing that grips a bush at its outside and does not give."""

    expansion: float  # 1/K
    wall: float  # m, thickness of the bush


class Thermal(NamedTuple):
    """Heat conduction from a film or from dry friction, and thermal expansion of the bodies of a dry joint."""

    conductance: float  # W/K
    ambient: float  # K
    bearing: float = 0.0  # 1/K, thermal expansion
    journal: float = 0.0  # 1/K
    housing: Housing | None = None  # None: the bearing expands freely


class Film(NamedTuple):
    """The film of oil in a joint."""

    law: str
    friction: str  # law of friction in the film
    viscosity: float  # Pa s
    limit: float  # eccentricity ratio up to which the formula is valid
    density: float = 870.0  # kg/m^3, of the oil
    transition: str = "ramp"  # law of the transition to dry contact
    begin: float = 0.0  # m, eccentricity minus clearance at which dry contact begins to carry load
    width: float = 0.0  # m, width of the transition
    asperities: Mapping[str, float] | None = None  # further parameters of that law, by key
    oil: Oil | None = None  # determines the viscosity at the temperature
    temperature: float | None = None  # K
    thermal: Thermal | None = None
    own: Mapping[str, float] = {}  # parameters of a law of one's own, by key


#: The contact of a joint with a film but no dry contact.
NO_CONTACT = Contact("", None, {})


HARDNESS_OVER_STRENGTH = 2.8  # of a fully plastic metal (Tabor 1951, The Hardness of Metals)


REFERENCE_TEMPERATURE = 293.15  # K, at which clearances are given
POISSON_OF_BUSH = 0.3  # where the material of the bearing is unknown


def value_at(tree: Mapping, path: str) -> Any:
    """Return the value at a dotted path of a nested mapping, or None."""
    value: Any = tree
    for key in path.split("."):
        if not isinstance(value, Mapping) or key not in value:
            return None
        value = value[key]
    return value


def column_name(joint: str) -> str:
    """Return the name of a joint ('rod-slider') in columns and channels: 'rod_slider'."""
    return joint.replace("-", "_")


def housing_name(joint: str, axis: str = "y") -> str:
    """Return the name of the body that is the housing of a joint; 'x': of what lies between its springs."""
    return f"{joint}~{axis}"


class Capacity(NamedTuple):
    """The load ratings of a rolling bearing, as its catalogue gives them."""

    dynamic: float | None = None  # N, ISO 281
    static: float | None = None  # N, ISO 76


class Rolling(NamedTuple):
    """The rolling elements between the rings of a bearing."""

    kind: str  # 'ball', 'roller' or 'needle'
    elements: int
    element_diameter: float  # m
    pitch_diameter: float  # m
    groove: tuple[float, ...] = ()  # of balls: radii of inner and outer groove over the element's diameter
    phase: float = 0.0  # rad, of the first element in the fixed frame at the start
    material: Material = Material(210e9, 0.3)  # of balls and rings
    capacity: Capacity = Capacity()
    bore: float | None = None  # m, of the inner ring
    outside_diameter: float | None = None  # m, of the outer ring

    @property
    def has_balls(self) -> bool:
        """Return whether the elements are balls; others touch along a line."""
        return self.kind == "ball"

    @property
    def least_load(self) -> float:
        """Return the least load (N) against skidding, 0 if the dynamic rating is unknown.

        It is 0.01 of the rating of ball bearings and 0.02 of roller bearings (SKF, general catalogue, requisite minimum
        load).
        """
        return (0.01 if self.has_balls else 0.02) * (self.capacity.dynamic or 0.0)


STOPS_SUFFIX = "~stops"  # of the name of the stops of a joint in a machine
SUFFIX_WITH_CLEARANCE = "-stops"  # likewise in columns and channels where the joint has a clearance, too


class Joint(NamedTuple):
    """A joint with clearance."""

    name: str  # as in the grid: 'rod-slider'
    clearance: float  # m, radial; of a rolling bearing half its internal clearance, negative with a preload; of a gear
    # half of its backlash on the pitch circle, of a coupling half of its play (rad)
    contact: Contact
    bearing_radius: float | None = None  # m
    length: float | None = None  # m, along the pin
    journal: str | None = None  # the body it sits on, or None if there is no choice
    friction: Friction | None = None
    wear: Wear | None = None
    height: float | None = None  # m, of a guide's block
    roughness: Roughness | None = None
    film: Film | None = None
    flange: bool | None = None  # of a spatial joint: whether flanges guide the journal; None: not spatial
    axial_clearance: float | None = None  # m, at each flange
    journal_length: float | None = None  # m
    tilt: tuple[float, ...] = ()  # rad, rotation vector of the bearing about x and y of its body
    offset: tuple[float, ...] = ()  # m, of the bearing centre, along the axes of its body
    axial: Contact | None = None  # contact at a flange; None: same as `contact`
    slot_length: float | None = None  # m, between the centres of a slot's ends
    thermal: Thermal | None = None  # of a dry joint
    temperature: float | None = None  # K, of both bodies, once the heat balance is solved
    walls: str | None = None  # 'spread'; otherwise a spatial joint carries load at the journal's ends
    backlash: float | None = None  # m, of two wheels in mesh, on the pitch circle; twice the clearance
    play: float | None = None  # rad, of a coupling, from stop to stop; twice the clearance
    drag: float = 0.0  # N m s/rad, of the second body relative to the first
    mesh_stiffness: Table | None = None  # stiffness of teeth over the mean: pitch (1) and factor (1)
    stops: tuple[float, ...] = ()  # rad, or m of a guide: both ends of the motion of a pin or a guide
    slides: bool = False  # the stops are those of a guide
    stopped: str = ""  # the joint that has them
    laws: str = ""  # hash of the laws of the grid's own
    rolling: Rolling | None = None  # elements of a rolling bearing; None: the journal slides in the bearing
    profile: Profile | None = None  # shape of the bearing; None: a circle

    @property
    def flanked(self) -> str:
        """Return 'gear', 'coupling', 'stops' or 'guide_stops' if the joint touches on two sides, else ''."""
        if self.stops:
            return "guide_stops" if self.slides else "stops"
        return "gear" if self.backlash is not None else "coupling" if self.play is not None else ""

    @property
    def kind(self) -> str:
        """Return the kind of its site, as in JointSite, where a slot and a gap on a line count as pins."""
        if self.is_spatial:
            return "spatial" if self.flange else "through"
        return "rolling" if self.rolling else self.flanked or ("guide" if self.is_guide else "revolute")

    @property
    def name_in_machine(self) -> str:
        """Return the name of what is open in the machine: the joint, or its stops."""
        return f"{self.stopped}{STOPS_SUFFIX}" if self.stops else self.name

    @property
    def elastic_name(self) -> str:
        """Return the name of the joint's elastic force: 'johnson', 'johnson with fractal roughness'."""
        elastic = self.contact.elastic or "spring"
        roughness_law = self.roughness and self.roughness.law
        return f"{elastic} with {roughness_law} roughness" if roughness_law and roughness_law != "smooth" else elastic

    @property
    def strength(self) -> float | None:
        """Return the yield strength (Pa) of the weaker body, if necessary from hardness, or None if unknown."""
        strengths = [body.yield_strength for body in self.contact.material or () if body.yield_strength]
        if strengths:
            return min(strengths)
        sections = [section.values for section in (self.roughness, self.wear) if section]
        hardnesses = [values["hardness"] for values in sections if "hardness" in values]
        return min(hardnesses) / HARDNESS_OVER_STRENGTH if hardnesses else None

    @property
    def heat_balance(self) -> Thermal | None:
        """Return the heat balance of the film or of dry friction, or None if no temperature is computed."""
        return self.film.thermal if self.film else self.thermal

    def warm_clearance(self, temperature: float) -> float:
        """Return the clearance (m) of a dry joint at a temperature (K); `clearance` is that at 20 degC."""
        return self.clearance + self.clearance_rate * (temperature - REFERENCE_TEMPERATURE)

    @property
    def clearance_rate(self) -> float:
        """Return the rate (m/K) of the clearance of a dry joint with the temperature of its bodies.

        Journal and bore grow by expansion coefficient x bearing radius.  Those of a bush (radii r_i, r_o) in a housing
        of expansion alpha_h that does not give: alpha + (alpha_h - alpha) 2 r_o^2 / ((1 - nu) r_o^2 + (1 + nu) r_i^2),
        by Lame's ring in plane stress under the pressure that makes its outside follow the housing (Timoshenko &
        Goodier 1970, section 28).
        """
        assert self.thermal is not None  # called only for joints with a heat balance
        radius, bore, housing = self.bearing_radius or 0.0, self.thermal.bearing, self.thermal.housing
        if housing:
            material = self.contact.material
            poisson = material.bearing.poisson if material else POISSON_OF_BUSH
            outer_square = (radius + housing.wall) ** 2
            flexibility = (1.0 - poisson) * outer_square + (1.0 + poisson) * radius**2
            bore += (housing.expansion - bore) * 2.0 * outer_square / flexibility
        return (bore - self.thermal.journal) * radius

    @property
    def is_guide(self) -> bool:
        """Return whether the joint is prismatic: a block between walls."""
        return self.height is not None

    @property
    def is_dry(self) -> bool:
        """Return whether the surfaces of the joint can touch; otherwise only a film acts."""
        return self.contact.law != NO_CONTACT.law

    @property
    def is_spatial(self) -> bool:
        """Return whether the journal of the joint may tilt and shift along its axis."""
        return self.flange is not None

    @property
    def column(self) -> str:
        """Return the name of the joint in columns and channels: 'rod_slider'."""
        return column_name(self.name)


class Until(NamedTuple):
    """Criterion by which a run of open length ends."""

    figure: str  # column of the summary
    relative_ci: float  # relative half-width of its 95 % interval
    max_revolutions: float


class Simulate(NamedTuple):
    """Length, accuracy and start of a run."""

    tolerance: float
    method: str
    step_budget: int  # per revolution
    event_budget: int  # per revolution
    time_budget: float = math.inf  # s of process time
    revolutions: float = 0.0  # `discard` included
    discard: float = 0.0
    start: str = "centred"
    carried_axis: str = ""  # the axis along which the state is carried
    direction: str = ""  # of this axis, 'up' or 'down'
    draw: int = 0  # number of a random start, from 1
    seed: int = 0  # of the random starts
    impacts: int = 0  # number of impacts after which a run without a crank ends
    error_check: bool = False
    horizon: bool = False
    until: Until | None = None
    time_limit: float = math.inf  # s, for a free crank
    period: float | None = None  # s, of a cycle, which then takes the place of a revolution; None: the crank's own

    def turns(self, rate: float) -> float:
        """Return the turns of a crank at `rate` (rad/s) during the run."""
        return self.revolutions if self.period is None else self.revolutions * self.period * rate / (2.0 * math.pi)


class Life(NamedTuple):
    """Limit of a life, and accuracy of its extrapolation from blocks of revolutions."""

    limit: float  # m
    of: str  # 'wear_depth_max' or 'clearance_growth'
    joint: str  # as in the grid: 'rod-slider'
    tolerance: float
    max_revolutions: float  # of a block, `discard` included
    blocks: int  # at most
    longest_jump: float = math.inf  # revolutions

    @property
    def column(self) -> str:
        """Return the name of the joint in columns: 'rod_slider'."""
        return column_name(self.joint)


class Uncertain(NamedTuple):
    """A 95 % interval of wear coefficients of a joint."""

    joint: str  # as in the grid: 'rod-slider'
    keys: tuple[str, ...]  # of Wear.values
    low: float  # in the unit of the coefficient, or relative to its value if `relative`
    high: float
    relative: bool


class Save(NamedTuple):
    """The results that are kept."""

    orbits: str
    samples: int  # per revolution; without a crank in all
    revolutions: float = 0.0  # how many last revolutions if `orbits` is 'last'
    worst: int = 0  # number of worst cases whose peak revolution is kept; a property of the run, not of a case
    channels: tuple[str, ...] = ()  # time histories that are stored; (): all of them


class OwnFigure(NamedTuple):
    """A figure of one's own."""

    name: str  # of its column
    law: str  # the name by which its law file declares it
    values: Mapping[str, float]  # its parameters, by key
    laws: str  # hash of the laws of the grid's own


class Case(NamedTuple):
    """One case."""

    mechanism: Mechanism
    joints: tuple[Joint, ...]
    simulate: Simulate
    save: Save
    drive: Drive | None = None  # None: nothing turns
    loads: tuple[Load, ...] = ()
    outline: Outline = Outline()
    life: Life | None = None
    uncertain: tuple[Uncertain, ...] = ()
    law_files: tuple[LawFile, ...] = ()  # with laws of one's own
    vibration: Vibration | None = None
    figures: tuple[OwnFigure, ...] = ()
    before: tuple["Case", ...] = ()  # of a carried state: the cases before it in its chain, which have none
