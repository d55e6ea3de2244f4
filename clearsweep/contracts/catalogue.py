"""Descriptions of all that a user names or reads: laws, mechanisms, figures of merit, time histories."""

import math
from collections.abc import Callable
from math import inf
from typing import Any, NamedTuple

from .outline import Outline

LARGEST = 1e60  # magnitude of a quantity in SI, its inverse the smallest: products of several must be finite floats

#: Meanings of a null of a figure for a limit, other than "not known".
NOTHING = "nothing"  # there was nothing to measure: every limit is kept
ENDLESS = "endless"  # it is beyond every number: `at_least` is kept, `at_most` is exceeded


class Field(NamedTuple):
    """One number a user writes."""

    name: str
    unit: str  # SI unit of the value, '1' for none; 'N/m^exponent' depends on the key `exponent` next to it
    text: str = ""  # one line: what it is
    low: float = 0.0
    high: float = inf
    low_open: bool = True  # `low` itself is not allowed
    high_open: bool = True
    default: float | None = None  # None: required, unless `optional`
    optional: bool = False  # may be left out without a default, or with one that follows from other values
    whole: bool = False
    fit: bool = False  # a clearance that may be written as a fit of ISO 286, by the `bearing_radius` next to it

    def allowed(self, value: float = 0.0) -> str:
        """Return the range in words: 'above 0 and at most 1'; with the bounds of any quantity if `value` is beyond."""
        parts = []
        if self.low > -inf:
            parts.append(f"{'above' if self.low_open else 'at least'} {self.low:.15g}")
        if self.high < inf:
            parts.append(f"{'below' if self.high_open else 'at most'} {self.high:.15g}")
        if not _is_sized(value):
            parts.append(f"of a size from {1.0 / LARGEST:g} to {LARGEST:g}")
        unit = "" if self.unit == "1" else f" ({self.unit})"
        return ("a whole number " if self.whole else "") + (" and ".join(parts) or "any finite number") + unit

    def contains(self, value: float) -> bool:
        """Return whether `value`, in SI, is allowed."""
        above = value > self.low if self.low_open else value >= self.low
        below = value < self.high if self.high_open else value <= self.high
        return above and below and (not self.whole or value == int(value)) and _is_sized(value)


def _is_sized(value: float) -> bool:
    """Return whether a quantity is zero or between 1 / LARGEST and LARGEST."""
    return value == 0.0 or 1.0 / LARGEST <= abs(value) <= LARGEST


class Range(NamedTuple):
    """A range that a law requires of a value outside its own keys."""

    path: str  # within the joint, such as 'clearance'; of `Law.trusted` what simulation.advice measures, too
    low: float  # allowed, like all between
    high: float
    unit: str  # SI
    reason: str

    def contains(self, value: float) -> bool:
        """Return whether a value, in SI, is within."""
        return self.low <= value <= self.high

    def allowed(self) -> str:
        """Return the range in words: 'from 5e-06 to 0.01 m', 'up to 10 deg'."""
        turn, unit = (math.degrees(1.0), "deg") if self.unit == "rad" else (1.0, "" if self.unit == "1" else self.unit)
        low, high = f"{turn * self.low:.4g}", f"{turn * self.high:.4g}"
        words = "" if self.high == inf else f"up to {high}" if self.low in (0.0, -inf) else f"from {low} to {high}"
        return f"{words or f'from {low}'} {unit}".rstrip()


class Order(NamedTuple):
    """Two values of which one has to be below the other."""

    low: str  # dotted path; of a law's order the key next to the law's name
    high: str
    reason: str
    equal: bool = False  # they may be equal


class Merit(NamedTuple):
    """What speaks for a law where several are valid."""

    rank: int  # the lower the better, of one family
    reason: str  # continues 'recommended, because'


class Law(NamedTuple):
    """One law of a family, as a user names it."""

    family: str  # 'law' (contact.law), 'elastic', 'roughness', 'friction' (friction.law), 'wear', 'pressure', 'film',
    # 'film-friction', 'transition', or 'mechanism', 'drive', 'load', which have no `law` to choose by
    name: str
    summary: str
    formula: str
    source: str
    fields: tuple[Field, ...] = ()
    uses_elastic: bool = True  # family 'law': False where the law brings its own stiffness and takes no `elastic`
    notes: str = ""  # pitfalls
    needs: tuple[str, ...] = ()  # required besides: 'length', 'material', 'bearing_radius', 'modulus', 'hertz'
    ranges: tuple[Range, ...] = ()  # outside of which it is refused
    trusted: tuple[Range, ...] = ()  # outside of which it is allowed, but nothing supports its use
    contact: str = ""  # family 'elastic': 'line' of two cylinders, 'ball' in a socket; '': neither
    yields: bool = False  # family 'law': leaves an indentation, for impacts beyond the elastic range
    unsound: str = ""  # objection to its use in any joint
    merit: Merit | None = None  # None: nothing speaks for it rather than for others
    uses_onset: bool = False  # family 'law': depends on the rate at which a contact began as long as it lasts
    orders: tuple[Order, ...] = ()
    remembers: bool = False  # family 'friction': depends on more than the present sliding
    sticks: bool = False  # family 'friction': can hold surfaces that do not slide
    tables: tuple["Columns", ...] = ()  # that may be given with it, each instead of `fields` that are optional


class JointSite(NamedTuple):
    """A place where two bodies meet, and where there may be clearance."""

    name: str  # as in the grid: 'rod-slider'
    proximal: str  # the body towards the drive
    distal: str
    kind: str = "revolute"  # 'guide': prismatic; 'slot': a pin in one; 'spatial', with flanges, or 'through', without;
    # or 'line': a gap with two ends, which is always there
    journal: str = ""  # body of the journal unless the grid names it; default: the distal one

    @property
    def journals(self) -> tuple[str, str]:
        """Return the bodies that the journal may sit on, the one it sits on unless it is said first."""
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
    over: tuple[Field, ...]  # it has one of these columns, which increases
    values: tuple[Field, ...]  # and at least one of these
    above_zero: tuple[str, ...] = ()  # columns that are not zero in every row


_SIZED = {  # unit of a key of a friction law -> its unit where a couple is given, and where a force is
    "coefficient": ("N*m", "N"),
    "static_coefficient": ("N*m", "N"),
    "viscous": ("N*m*s", "N*s/m"),
    "m/s": ("rad/s", "m/s"),
    "s/m": ("s", "s/m"),
}


def sized(law: Law, given: str) -> Law:
    """Return a friction law with a 'torque' or a 'force' in place of its coefficient, and speeds to match."""
    names = {"coefficient": given, "static_coefficient": f"static_{given}"}
    place = ("torque", "force").index(given)
    fields = []
    for field in law.fields:
        units = _SIZED.get(field.name) or _SIZED.get(field.unit)
        text = f"{field.text}, a {'couple' if given == 'torque' else 'force'}" if field.name in names else field.text
        unit = units[place] if units else field.unit
        fields.append(field._replace(name=names.get(field.name, field.name), unit=unit, text=text))
    orders = [
        each._replace(low=names.get(each.low, each.low), high=names.get(each.high, each.high)) for each in law.orders
    ]
    return law._replace(fields=tuple(fields), orders=tuple(orders))


class Keys(NamedTuple):
    """A section of the grid file that belongs to a mechanism."""

    path: str  # 'mechanism.crank'; 'mechanism' for keys of no body
    text: str
    fields: tuple[Field, ...] = ()  # named '0', '1' where a list of quantities is written
    need: str = "required"  # 'optional', or 'implied': there even if it is not written
    words: tuple[Choice, ...] = ()  # named '0', '1' where a list of words is written
    tables: tuple[Columns, ...] = ()
    family: str = ""  # of the laws among which a key `law` chooses
    flags: tuple[tuple[str, str], ...] = ()  # name and text of keys that are true, or left out
    alone: tuple[int, ...] = ()  # of a list: by what a single quantity in its place is multiplied for each item
    given: str = ""  # of friction laws: 'torque' or 'force' in place of a coefficient, see `sized`

    @property
    def items(self) -> int:
        """Return of how many items the list is in which it is written; 0: it is no list."""
        names = (*(field.name for field in self.fields), *(choice.name for choice in self.words))
        return len(names) if "0" in names else 0


class Output(NamedTuple):
    """The body by whose motion a mechanism is judged."""

    name: str  # 'slider': what its columns begin with
    unit: str  # SI, of its place: 'm', or 'rad' where it turns


class Channel(NamedTuple):
    """A time history; one of a joint is named within it."""

    name: str
    unit: str  # SI
    text: str


class Mechanism(NamedTuple):
    """A kind of mechanism, as a user names it.

    bodies : numbers in SI by their keys below `mechanism`, such as 'crank.length'; drive : rad/s, None if nothing turns
    """

    name: str  # mechanism.type
    summary: str
    formula: str
    source: str
    notes: str
    bodies: tuple[str, ...]
    joints: tuple[JointSite, ...]
    keys: tuple[Keys, ...]
    channels: tuple[Channel, ...]  # after the time, as its compiled form describes itself
    turns: bool  # a drive turns it: there are revolutions
    #: its own equations: (bodies, drive, joint -> compiled Joint, joint -> (2,) m, place of its distal pin) -> Built
    build: Callable | None
    output: Output | None = None
    orders: tuple[Order, ...] = ()
    outlined: Callable | None = None  # outline.Outline -> the mechanism with the keys and parts that this has
    #: case.Case -> machine.Machine of the plane: its ideal, and what it is built of where `build` is None
    machine: Callable | None = None
    refusal: Callable | None = None  # (Mechanism, Case) -> path below `mechanism` and sentence, None: nothing is wrong
    free: bool = False  # its crank is free
    spatial: bool = False  # its bodies move in space

    @property
    def law(self) -> Law:
        """Return the mechanism as the laws are described, its keys as parameters."""
        fields = tuple(
            field._replace(name=f"{keys.path}.{field.name}".removeprefix("mechanism."))
            for keys in self.keys
            for field in keys.fields
        )
        return Law("mechanism", self.name, self.summary, self.formula, self.source, fields, notes=self.notes)

    def site(self, joint: str) -> JointSite:
        """Return the site of a joint, by its name."""
        return next(site for site in self.joints if site.name == joint)


class Shown(NamedTuple):
    """Where the report shows a figure."""

    table: str  # 'forces', 'output', 'wear', 'certainty', 'sample', 'case', 'effects'
    heading: str  # '{output}' represents the output, '{per_rev}' and '{per_revolution}' for that, where anything turns
    order: int = 50  # the smaller the earlier; those of equal order as in the summary
    if_any: bool = False  # only where it is above zero in some case


class Figure(NamedTuple):
    """A figure of merit of a case: a column of the summary, and whatever becomes of it.

    unit, text : `{output}` represents the unit of the output's place, or for its name; `{until}` for those of the
    figure that `simulate.until` judges.
    """

    name: str  # of a joint 'force_peak': the column is 'rod_slider_force_peak'
    unit: str  # SI
    text: str
    of: str = "case"  # 'joint': one for each joint with clearance; 'output': of a mechanism's output; 'case'
    #: 'turns', 'free', 'rests' (the mechanism); 'wear', 'film', 'friction', 'judged' (the joint); 'horizon', 'until',
    #: 'life'
    needs: tuple[str, ...] = ()
    value: Callable | None = None  # (simulation.window.Window, place of the joint) -> value; None: see `sums`
    sums: Any = None  # the sums it is made of, such as simulation.sums.Mean: it settles, `simulate.until` may judge it
    kind: str = "float"  # or 'int'
    differs: bool = True  # `simulate.error_check` gives how far it is from a run at a tenth of the tolerance
    shown: tuple[Shown, ...] = ()
    null: str = ""  # what a null of a case that finished means to a limit: NOTHING, ENDLESS; '': it is not known

    @property
    def settles(self) -> bool:
        """Return whether it settles as a run grows longer, so that its blocks give it an interval."""
        return self.sums is not None

    def column(self, owner: str) -> str:
        """Return the name of its column; `owner`: the joint's ('rod_slider'), the output's, or ''."""
        return f"{owner}_{self.name}" if owner else self.name


class Catalogue(NamedTuple):
    """All laws and mechanisms of a grid, and all figures and channels of a case."""

    laws: tuple[Law, ...]
    mechanisms: tuple[Mechanism, ...] = ()  # the first one is meant where none is named
    figures: tuple[Figure, ...] = ()  # in the order of the columns
    joint_channels: tuple[Channel, ...] = ()
    film_channels: tuple[Channel, ...] = ()  # of joints with a film, behind those
    spatial_channels: tuple[Channel, ...] = ()  # the same of a joint in space, those of its contact points behind them
    point_channels: tuple[Channel, ...] = ()  # of each of these; '{}' represents its number

    def mechanism(self, name: str) -> Mechanism | None:
        """Return the mechanism called `name`, or None."""
        return next((mechanism for mechanism in self.mechanisms if mechanism.name == name), None)

    def outlined(self, name: str, outline: Outline) -> Mechanism | None:
        """Return the mechanism called `name` with what a grid of this outline has, or None."""
        mechanism = self.mechanism(name)
        return mechanism.outlined(outline) if mechanism and mechanism.outlined else mechanism

    def of(self, family: str) -> tuple[Law, ...]:
        """Return the laws of one family."""
        return tuple(law for law in self.laws if law.family == family)

    def names(self, family: str) -> tuple[str, ...]:
        """Return the names of one family's laws."""
        return tuple(law.name for law in self.of(family))

    def find(self, family: str, name: str) -> Law | None:
        """Return the law called `name`, or None."""
        return next((law for law in self.of(family) if law.name == name), None)
