"""Descriptions of everything that a user names or reads: laws, mechanisms, figures of merit, time histories."""

import math
from collections.abc import Callable, Sequence
from math import inf
from typing import Any, NamedTuple

from .vibration import FRAME, PlaceOutline, VibrationOutline

# Roles of varied values: what the designer chooses, what must hold at every value, and what is uncertain.

CHOICE = "choice"  # the designer decides
CONDITION = "condition"  # the design must meet the limits at every value
UNCERTAINTY = "uncertainty"  # unknown: the worst over its values, or its distribution, counts
MODEL = "model"  # a law or its smoothing: an uncertainty, too
NUMERICS = "numerics"  # never an answer: the finest value decides, the others show convergence
ROLES = (CHOICE, CONDITION, UNCERTAINTY, MODEL, NUMERICS)
#: Order in which the uses of a quantity of one's own decide its role.
PRECEDENCE = (CONDITION, UNCERTAINTY, MODEL, CHOICE, NUMERICS)
#: Paths that say where a motion starts: up or down a carried axis, and the number of a random start.
STARTS = ("simulate.direction", "simulate.draw")


# User-defined names of a grid, which determine its keys: form of the drive, loads, bodies and joints.
#
# It contains no numbers and nothing that can be swept: all cases of a grid have the same outline.

GROUND = "ground"
ANY = "NAME"  # placeholder for user-defined names in lists of keys


class BodyOutline(NamedTuple):
    """A body of a `planar` mechanism."""

    name: str
    points: tuple[str, ...]


class JointOutline(NamedTuple):
    """A joint of a `planar` mechanism; its two points are 'body.point', or '' if that could not be read."""

    name: str
    type: str  # 'revolute', 'prismatic', 'slot', or 'gear' or 'coupling', which connect whole bodies
    proximal: str
    distal: str
    journal: str = ""  # the body that carries the journal; '': the distal one
    stops: bool = False  # its motion ends at stops

    @property
    def bodies(self) -> tuple[str, str]:
        """Return the proximal and the distal body."""
        return self.proximal.partition(".")[0], self.distal.partition(".")[0]


class LoadOutline(NamedTuple):
    """A load."""

    name: str
    form: str  # the name of a law of the family 'load'
    on: str = ""  # the body or joint that it acts on
    given: str = ""  # for friction of a given size: 'torque' or 'force'
    reacted: bool = True  # whether the frame of the machine reacts it


class BendingOutline(NamedTuple):
    """An elastic link that bends."""

    name: str
    stretches: bool = False  # also along its line
    fatigue: bool = False  # it has a stress-life line

    @property
    def features(self) -> set[str]:
        """Return the features that figures require."""
        return {"bends", "fatigue"} if self.fatigue else {"bends"}


class FigureOutline(NamedTuple):
    """A figure of one's own: a column of the summary."""

    name: str
    law: str  # the name by which its law file declares it
    unit: str = "1"  # SI
    text: str = ""


class Outline(NamedTuple):
    """The user-defined names of a grid."""

    type: str = ""  # mechanism.type
    drive: str = "speed"  # the name of a law of the family 'drive'
    loads: tuple[LoadOutline, ...] = ()
    bodies: tuple[BodyOutline, ...] = ()  # of a `planar` mechanism, including the ground
    joints: tuple[JointOutline, ...] = ()  # of a `planar` mechanism
    rotary: bool = False  # whether the output of a `planar` mechanism is an angle
    clearances: frozenset[str] = frozenset()  # joints with clearance
    spatial: bool = False  # its bodies move in space
    axial: frozenset[str] = frozenset()  # joints with clearance between flanges, of a mechanism in space
    rolling: frozenset[str] = frozenset()  # joints that are rolling bearings
    elastic: frozenset[str] = frozenset()  # bodies with elastic links
    bending: tuple[BendingOutline, ...] = ()  # of these, links that bend
    mounts: tuple[str, ...] = ()  # joints at the ground whose housing yields
    laws: str = ""  # hash of the laws of the grid's own
    vibration: VibrationOutline | None = None
    figures: tuple[FigureOutline, ...] = ()  # of one's own
    length: str = "revolutions"  # what the length of a run is measured in: 'revolutions', 'cycles' or 'time'
    inclined: bool = False  # gravity has two components, in the plane

    @property
    def free(self) -> bool:
        """Return whether the crank is free, its motion not prescribed."""
        return self.drive in ("torque", "motor", "motor-law", "motor-table", "servo")

    def sites(self, joints: "tuple[JointSite, ...]") -> "tuple[JointSite, ...]":
        """Return the sites of a mechanism, with the kind 'rolling' where a pin is a rolling bearing."""
        return tuple(
            site._replace(kind="rolling") if site.name in self.rolling and site.kind == "revolute" else site
            for site in joints
        )

    def bending_of(self, body: str) -> BendingOutline | None:
        """Return how a body bends, or None if it does not."""
        return next((link for link in self.bending if link.name in (body, ANY)), None)


#: Keys that set the size of friction directly: a couple in a pin, a force in a guide.
SIZES = ("torque", "force")

_NAMED = Outline(
    bodies=(BodyOutline(GROUND, (ANY,)), BodyOutline(ANY, (ANY,))),
    joints=(JointOutline(ANY, ANY, "", ""),),
    vibration=VibrationOutline((PlaceOutline(FRAME), PlaceOutline(ANY))),
    length=ANY,
)
#: An outline of a mechanism in space, for lists of keys.
IN_SPACE = _NAMED._replace(spatial=True, axial=frozenset((ANY,)))
_BENDING = (BendingOutline(ANY, stretches=True, fatigue=True),)
#: An outline with everything that a grid may define, for lists of keys.
FULL_OUTLINE = _NAMED._replace(drive=ANY, loads=(LoadOutline(ANY, ANY, ANY),), bending=_BENDING, mounts=(ANY,))

LARGEST = 1e60  # largest magnitude of a quantity in SI, its inverse the smallest: products of several stay finite

#: What a missing figure means to a limit, other than "unknown".
NOTHING = "nothing"  # there was nothing to measure: every limit is met
ENDLESS = "endless"  # it is infinite: `at_least` is met, `at_most` is exceeded

#: Figures that are infinite where nothing wears or loads; of all others an infinite value is missing.
_LIFE_ENDS = ("life_low", "life_low_hours", "life_high", "life_low_uncertain", "life_high_uncertain")
LIVES = ("life_revolutions", "life_hours", *_LIFE_ENDS, "life_l10r", "life_l10r_revolutions")


class Field(NamedTuple):
    """A number that a user writes."""

    name: str
    unit: str  # SI unit of the value, '1' for none; 'N/m^exponent' and 'N*s/m^exponent+1' depend on the key `exponent`
    text: str = ""  # description in one line
    low: float = 0.0
    high: float = inf
    low_open: bool = True  # `low` itself is not allowed
    high_open: bool = True
    default: float | None = None  # None: required, unless `optional`
    optional: bool = False  # may be left out; its default, if any, follows from other values
    integer: bool = False
    refusal: str = ""  # why laws without this number do not take it
    fit: str = ""  # a clearance that may be an ISO 286 'fit' for the `bearing_radius` next to it, or an ISO 5753-1
    # 'group' for the `bore`
    role: str = ""  # one of contracts.roles; '': that of its section or of the laws of its family
    nonzero: bool = False  # 0 is not allowed

    def allowed(self, value: float = 0.0) -> str:
        """Return the range in words: 'above 0 and at most 1'; with the global bounds if `value` exceeds them."""
        bounds = []
        factor, shown = (math.degrees(1.0), "deg") if self.unit == "rad" and _is_sized(value) else (1.0, self.unit)
        if self.low > -inf:
            bounds.append(f"{'above' if self.low_open else 'at least'} {factor * self.low:.15g}")
        if self.high < inf:
            bounds.append(f"{'below' if self.high_open else 'at most'} {factor * self.high:.15g}")
        if not _is_sized(value):
            bounds.append(f"of a size from {1.0 / LARGEST:g} to {LARGEST:g}")
        if self.nonzero:
            bounds.append("not 0")
        unit = "" if shown == "1" else f" ({shown})"
        return ("a whole number " if self.integer else "") + (" and ".join(bounds) or "any finite number") + unit

    def contains(self, value: float) -> bool:
        """Return whether `value`, in SI, is allowed."""
        is_above = value > self.low if self.low_open else value >= self.low
        is_below = value < self.high if self.high_open else value <= self.high
        is_whole = not self.integer or value == int(value)
        return is_above and is_below and is_whole and _is_sized(value) and not (self.nonzero and value == 0.0)


def ranged(name: str, unit: str, text: str, interval: str, **further: Any) -> Field:
    """Return a number in an interval, such as "[0, 1)" from 0 to below 1, both in SI; further : fields of Field."""
    low, high = map(float, interval[1:-1].split(","))
    return Field(name, unit, text, low, high, interval[0] == "(", interval[-1] == ")", **further)


def _is_sized(value: float) -> bool:
    """Return whether a quantity is zero or between 1 / LARGEST and LARGEST."""
    return value == 0.0 or 1.0 / LARGEST <= abs(value) <= LARGEST


class Range(NamedTuple):
    """A range that a law requires of a value other than its own parameters."""

    path: str  # within the joint, such as 'clearance'; in `Law.trusted` also a measure of simulation.advice
    low: float  # both bounds are allowed
    high: float
    unit: str  # SI
    reason: str

    def contains(self, value: float) -> bool:
        """Return whether a value in SI lies in the range."""
        return self.low <= value <= self.high

    def allowed(self) -> str:
        """Return the range in words: 'from 5e-06 to 0.01 m', 'up to 10 deg'."""
        unit_factor, unit = (
            (math.degrees(1.0), "deg") if self.unit == "rad" else (1.0, "" if self.unit == "1" else self.unit)
        )
        low, high = f"{unit_factor * self.low:.4g}", f"{unit_factor * self.high:.4g}"
        range_text = "" if self.high == inf else f"up to {high}" if self.low in (0.0, -inf) else f"from {low} to {high}"
        return f"{range_text or f'from {low}'} {unit}".rstrip()


class Order(NamedTuple):
    """Two values in a required order."""

    low: str  # dotted path; in a law's order the key next to the law's name
    high: str
    reason: str
    equal: bool = False  # they may be equal


class Merit(NamedTuple):
    """Reasons to prefer a law if several are valid."""

    rank: int  # the lower the better, of one family
    reason: str  # continues 'recommended, because'


class Law(NamedTuple):
    """One law of a family, as a user names it."""

    family: str  # 'law' (contact.law), 'elastic', 'roughness', 'friction' (friction.law), 'wear', 'pressure', 'film',
    # 'film-friction', 'transition', 'profile', 'figure', or 'mechanism', 'drive', 'load', which have no key `law`
    name: str
    summary: str
    formula: str
    source: str
    fields: tuple[Field, ...] = ()
    uses_elastic: bool = True  # family 'law': False if the law has its own stiffness and accepts no `elastic`
    notes: str = ""  # pitfalls
    needs: tuple[str, ...] = ()  # further requirements: 'length', 'material', 'bearing_radius', 'modulus', 'hertz'
    ranges: tuple[Range, ...] = ()  # outside of these the law is refused
    trusted: tuple[Range, ...] = ()  # outside of these it is allowed, but unsupported by evidence
    contact: str = ""  # family 'elastic': 'line' for two cylinders, 'ball' for a ball in a socket; '': neither
    yields: bool = False  # family 'law': leaves a permanent indentation, for impacts beyond the elastic range
    unsound: str = ""  # objection to its use in any joint
    merit: Merit | None = None  # None: nothing favours it over other valid laws
    uses_onset: bool = False  # family 'law': depends on the closing rate at onset for the whole contact
    orders: tuple[Order, ...] = ()
    has_state: bool = False  # family 'friction': has internal state
    sticks: bool = False  # family 'friction': surfaces can stick
    tables: tuple["Columns", ...] = ()  # optional parameters, each instead of optional `fields`
    one_of: tuple[str, ...] = ()  # names of optional fields of which exactly one is given
    origin: str = ""  # file and line of a law of one's own
    unit: str = ""  # SI, of a figure of one's own

    def unit_of(self, name: str) -> str:
        """Return the SI unit of one of its fields."""
        return next(field.unit for field in self.fields if field.name == name)


def declared_law(written: str, formula: str, source: str, *further: Any, **fields: Any) -> Law:
    """Return the law that is written as "family name: summary"; further, fields : the other fields of Law."""
    family, _, rest = written.partition(" ")
    name, _, summary = rest.partition(": ")
    return Law(family, name, summary, formula, source, *further, **fields)


class JointSite(NamedTuple):
    """A joint of a mechanism, which may have clearance."""

    name: str  # as in the grid: 'rod-slider'
    proximal: str  # the body nearer the drive
    distal: str
    kind: str = "revolute"  # 'guide': prismatic; 'slot': a pin in one; 'rolling': a rolling bearing; 'gear' or
    # 'coupling': play in rotation; 'stops' or 'guide_stops': ends of the motion of a pin or a guide; 'spatial', with
    # flanges, or 'through', without; or 'line': a gap with two ends, which is always there
    journal: str = ""  # default body of the journal; '': the distal one
    stopped: str = ""  # of stops with a clearance: the joint that has both

    @property
    def journals(self) -> tuple[str, str]:
        """Return the bodies that may carry the journal, the default first."""
        return (self.proximal, self.distal) if self.journal == self.proximal else (self.distal, self.proximal)


class Choice(NamedTuple):
    """A key that contains one of a few words."""

    name: str
    options: tuple[str, ...]
    text: str
    default: str | None = None  # None: required


class Columns(NamedTuple):
    """A key that contains a table, or the name of a file that does."""

    name: str
    text: str
    over: tuple[Field, ...]  # exactly one of these columns, increasing
    values: tuple[Field, ...]  # at least one of these columns
    nonzero: tuple[str, ...] = ()  # columns that are not zero in every row
    from_zero: bool = False  # the first row of the independent column is 0


_SIZED_UNITS = {  # unit of a friction parameter -> its unit for friction given as a couple, and as a force
    "coefficient": ("N*m", "N"),
    "static_coefficient": ("N*m", "N"),
    "viscous": ("N*m*s", "N*s/m"),
    "bristle_stiffness": ("N*m", "N/m"),
    "bristle_damping": ("N*m*s", "N*s/m"),
    "m/s": ("rad/s", "m/s"),
    "s/m": ("s", "s/m"),
}


def with_given_size(law: Law, quantity: str) -> Law:
    """Return a friction law with a 'torque' or a 'force' instead of its coefficient, and speeds to match."""
    names = {"coefficient": quantity, "static_coefficient": f"static_{quantity}"}
    index = ("torque", "force").index(quantity)
    fields = []
    for field in law.fields:
        units = _SIZED_UNITS.get(field.name) or _SIZED_UNITS.get(field.unit)
        text = field.text
        if field.name in names:
            text = f"{text.replace('coefficient', quantity).replace(', mu', ', instead of mu')} N"
        unit = units[index] if units else field.unit
        fields.append(field._replace(name=names.get(field.name, field.name), unit=unit, text=text))
    orders = [
        order._replace(low=names.get(order.low, order.low), high=names.get(order.high, order.high))
        for order in law.orders
    ]
    return law._replace(fields=tuple(fields), orders=tuple(orders))


_TORSIONAL_UNITS = {  # unit of a contact -> its unit where angles replace lengths, and torques forces
    "N/m^exponent": "N*m/rad^exponent",
    "N*s/m^exponent+1": "N*m*s/rad^exponent+1",
    "N/m": "N*m/rad",
    "N*s/m": "N*m*s/rad",
    "N*s/m^1.5": "N*m*s/rad^1.5",
    "N": "N*m",
    "m": "rad",
    "m/s": "rad/s",
    "s/m": "s/rad",
    "kg": "kg*m^2",
}


def torsional(law: Law) -> Law:
    """Return a law of the normal force with angles in place of penetrations and torques in place of forces."""
    fields = tuple(field._replace(unit=torsional_unit(field.unit)) for field in law.fields)
    return law._replace(fields=fields)


def torsional_unit(unit: str) -> str:
    """Return the unit of a quantity of a contact where angles replace lengths and torques replace forces."""
    return _TORSIONAL_UNITS.get(unit, unit)


class Keys(NamedTuple):
    """A section of the grid file for a mechanism."""

    path: str  # 'mechanism.crank'; 'mechanism' for keys outside the bodies
    text: str
    fields: tuple[Field, ...] = ()  # named '0', '1' for a list of quantities
    need: str = "required"  # 'optional', or 'implied': exists even if it is not written
    words: tuple[Choice, ...] = ()  # named '0', '1' for a list of words
    tables: tuple[Columns, ...] = ()
    family: str = ""  # family of the laws that the key `law` chooses from
    flags: tuple[tuple, ...] = ()  # name and description of keys that are true or left out; a default, if always stored
    materials: tuple[Choice, ...] = ()  # keys that take the name of a material, without options
    scalar_factors: tuple[int, ...] = ()  # of a list: factors that turn a single quantity into the items
    given_size_key: str = ""  # of friction laws: 'torque' or 'force' instead of a coefficient, see `with_given_size`
    role: str = ""  # one of contracts.roles: the role of its numbers; required where it has any

    @property
    def items(self) -> int:
        """Return the number of items if the section is a list, else 0."""
        names = (*(field.name for field in self.fields), *(choice.name for choice in self.words))
        return len(names) if "0" in names else 0


class Output(NamedTuple):
    """The body whose motion is the output of a mechanism."""

    name: str  # 'slider': prefix of its columns
    unit: str  # SI unit of its position: 'm', or 'rad' if it turns


class Channel(NamedTuple):
    """A time history; the name of a joint's channel is relative to the joint."""

    name: str
    unit: str  # SI
    text: str


class Mechanism(NamedTuple):
    """A kind of mechanism, as a user names it.

    bodies : numbers in SI by their keys below `mechanism`, such as 'crank.length'; drive : rad/s, or None
    """

    name: str  # mechanism.type
    summary: str
    formula: str
    source: str
    notes: str
    bodies: tuple[str, ...]
    joints: tuple[JointSite, ...]
    keys: tuple[Keys, ...]
    channels: tuple[Channel, ...]  # in the order of `describe`, after the time
    turns: bool  # has a drive, and so revolutions
    #: (bodies, drive, joint -> compiled Joint, joint -> (2,) m, place of its distal pin) -> Built
    build: Callable | None
    output: Output | None = None
    orders: tuple[Order, ...] = ()
    with_outline: Callable | None = None  # outline.Outline -> the mechanism with the keys and parts of the outline
    #: case.Case -> planar machine.Machine: for the ideal motion, and for building it if `build` is None
    machine: Callable | None = None
    refusal: Callable | None = None  # (Mechanism, Case) -> path below `mechanism` and sentence, or None if valid
    free: bool = False  # has a free crank
    length: str = "revolutions"  # what the length of a run is measured in, as in Outline
    spatial: bool = False  # moves in space

    @property
    def law(self) -> Law:
        """Return the mechanism in the form of a law, with its keys as parameters."""
        fields = tuple(
            field._replace(name=f"{keys.path}.{field.name}".removeprefix("mechanism."))
            for keys in self.keys
            for field in keys.fields
        )
        return Law("mechanism", self.name, self.summary, self.formula, self.source, fields, notes=self.notes)

    def site(self, joint: str) -> JointSite:
        """Return the site of a joint, by its name."""
        return next(site for site in self.joints if site.name == joint)


class Entry(NamedTuple):
    """The entry of a figure in a table of the report."""

    table: str  # 'forces', 'output', 'wear', 'certainty', 'sample', 'case', 'effects'
    heading: str  # may contain '{output}', '{per_rev}' and '{per_revolution}', which are filled in
    order: int = 50  # ascending; equal ranks keep the order of the summary
    if_any: bool = False  # shown only if it is above zero in some case


class Figure(NamedTuple):
    """A figure of merit of a case: a column of the summary, and its use elsewhere.

    unit, text : `{output}` is replaced by the unit of the output's place, or for its name; `{until}` for those of the
    figure that `simulate.until` judges.
    """

    name: str  # 'force_peak' of a joint: the column is 'rod_slider_force_peak'
    unit: str  # SI
    text: str
    of: str = "case"  # 'joint': one for each joint with clearance; 'output': of a mechanism's output; 'place': one for
    # each place of `vibration.at`; 'order': one for each of `vibration.orders`; 'link': one for each that bends;
    # 'mount': one for each housing that yields; 'case'
    #: 'turns', 'free', 'rests' (mechanism); 'wear', 'film', 'friction', 'limited' (joint); 'horizon', 'until',
    #: 'life'
    needs: tuple[str, ...] = ()
    value: Callable | None = None  # (simulation.window.Window, index of the joint) -> value; None: see `sums`
    sums: Any = None  # its sums, such as simulation.sums.Mean: it converges, so `simulate.until` accepts it
    kind: str = "float"  # or 'int', 'text'
    differs: bool = True  # `simulate.error_check` compares it with a run at a tenth of the tolerance
    tables: tuple[Entry, ...] = ()
    null: str = ""  # what a missing value of a finished case means to a limit: NOTHING, ENDLESS; '': unknown

    @property
    def settles(self) -> bool:
        """Return whether it converges as a run grows longer, so that block means give an interval."""
        return self.sums is not None

    def column(self, owner: str) -> str:
        """Return the name of its column; `owner`: name of the joint ('rod_slider') or output, or ''."""
        return f"{owner}_{self.name}" if owner else self.name


def figure(written: str, **further: Any) -> Figure:
    """Return the figure that is written as "name [unit]: text"; further : fields of Figure."""
    name, _, rest = written.partition(" [")
    unit, _, text = rest.partition("]: ")
    return Figure(name, unit, text, **further)


def shown(heading: str, *, if_any: bool = False, **orders: int) -> tuple[Entry, ...]:
    """Return the entries of a figure that has one heading in all tables; orders : its order in each, by name."""
    return tuple(Entry(table, heading, order, if_any) for table, order in orders.items())


class Catalogue(NamedTuple):
    """All laws, mechanisms and searches of grids, and all figures and channels of cases."""

    laws: tuple[Law, ...]
    mechanisms: tuple[Mechanism, ...] = ()  # the first is the default
    figures: tuple[Figure, ...] = ()  # in the order of the columns
    joint_channels: tuple[Channel, ...] = ()
    film_channels: tuple[Channel, ...] = ()  # further channels of joints with a film
    spatial_channels: tuple[Channel, ...] = ()  # channels of a spatial joint, before those of its contact points
    point_channels: tuple[Channel, ...] = ()  # channels of each contact point; '{}' is its number
    rolling_channels: tuple[Channel, ...] = ()  # channels of a rolling bearing, before those of its elements
    element_channels: tuple[Channel, ...] = ()  # channels of each element; '{}' is its number
    frame_channels: tuple[Channel, ...] = ()  # channels of the frame, with `vibration`
    place_channels: tuple[Channel, ...] = ()  # channels of each place of `vibration`; '{}' is its name
    #: Returns the path at fault and a sentence if a Case cannot start.
    start_problem: Callable[[Any], tuple[str, str] | None] = lambda _: None
    searches: tuple[Any, ...] = ()  # kinds of search: subclasses of `contracts.search.Search`
    #: Takes recorded laws (clearsweep.laws.Law) and their hash into mechanics; returns what their names mean in grids.
    enter_laws: Callable[[Sequence[Any], str], tuple[Law, ...]] = lambda records, digest: ()
    own_laws: str = ""  # hash of the laws of one's own among `laws`

    def mechanism(self, name: str) -> Mechanism | None:
        """Return the mechanism called `name`, or None."""
        return next((mechanism for mechanism in self.mechanisms if mechanism.name == name), None)

    def with_laws(self, records: Sequence[Any], digest: str) -> "Catalogue":
        """Return the catalogue with recorded laws; digest : hash of all that they depend on.  Raises InputError."""
        return self._replace(laws=(*self.laws, *self.enter_laws(records, digest)), own_laws=digest)

    def with_outline(self, name: str, outline: Outline) -> Mechanism | None:
        """Return the mechanism called `name` with the parts in this outline, or None."""
        mechanism = self.mechanism(name)
        return mechanism.with_outline(outline) if mechanism and mechanism.with_outline else mechanism

    def of(self, family: str) -> tuple[Law, ...]:
        """Return the laws of one family."""
        return tuple(law for law in self.laws if law.family == family)

    def names(self, family: str) -> tuple[str, ...]:
        """Return the names of one family's laws."""
        return tuple(law.name for law in self.of(family))

    def find(self, family: str, name: str) -> Law | None:
        """Return the law called `name`, or None."""
        return next((law for law in self.of(family) if law.name == name), None)
