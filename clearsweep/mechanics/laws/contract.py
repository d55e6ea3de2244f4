"""The interface of all laws: the modes of their contact, internal state, guards, kinks, and how they are registered.

The integration knows no law by name.  A law is one block in a file of its kind: a NamedTuple with members of the
families of its kind, which `require` declares, and, if necessary, of these:

    internal_state(law)                    error scale of each number, and whether a separation resets it
    internal_rates(law, contact)           rates of these numbers
    guards(law), guard_values(...)         its possible events by mode, and the functions that locate them
    latched(law, event, contact, root)     its internal state after an event

The last fields of a law, with defaults, are its internal state; the defaults are the initial values.  A member of
`internal_state` and `internal_rates` integrates it; a member of `latched` only changes it at events.  Guards are
functions of the motion that cross zero upwards where something changes: the loop locates that time on the dense output,
changes the mode as the guard requires and lets the law latch new internal values.

The formula of some laws changes at *kinks*: steps end there, and within a step one formula applies.  A method of high
order loses its order at a kink, and an iteration hardly converges there.  So a law of this kind stores the number of
the piece that applies, counted over the variable of its kinks.  A trial step beyond the end of the piece continues with
its formula and is cut at the end.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from ...contracts.case import Joint
from ...contracts.catalogue import Field, Law, declared_law
from ...language.errors import InputError
from ...tracing.compiled.choosing import where
from ...tracing.compiled.dual import plain
from ...tracing.compiled.family import family, family_with_default, kernel, known

# A mode is a number below 63 whose bits inform the loop; bits from LAWS_OWN on distinguish the modes of a law.
# ACTS: there is a force.  MEETS: apart, search for an onset.  TOUCHES: touching, search for a separation.
ACTS, MEETS, TOUCHES, LAWS_OWN = 1, 2, 4, 8
FREE = MEETS  # apart and without force
PRESSED = ACTS | TOUCHES
# Modes of laws, listed here so that numbers stay unique.
CLIPPED = PRESSED + LAWS_OWN  # penetrating, but the normal force is clipped because it would pull
STUCK = PRESSED + 2 * LAWS_OWN  # pressed, and the surfaces stick
AT_LIMIT_UP = PRESSED + 3 * LAWS_OWN  # as STUCK, but the tangential force has reached its limit, upwards
AT_LIMIT_DOWN = PRESSED + 4 * LAWS_OWN  # the same downwards
REPORTING = 5 * LAWS_OWN  # no contact: its normal force and its powers are integrated, and the depth has a maximum
STICKING = (STUCK, AT_LIMIT_UP, AT_LIMIT_DOWN)
TOUCHING = tuple(mode for mode in range(63) if mode & TOUCHES)  # all modes of touching surfaces


@kernel
def acts(mode):
    """Return whether a contact in this mode exerts a force."""
    return mode & ACTS != 0


@kernel
def meets(mode):
    """Return whether the surfaces of a contact in this mode are apart and may come to touch."""
    return mode & MEETS != 0


@kernel
def touches(mode):
    """Return whether the surfaces of a contact in this mode touch."""
    return mode & TOUCHES != 0


@kernel
def is_sticking(mode):
    """Return whether the surfaces of a contact in this mode stick."""
    any_sticking = False
    for sticking_mode in STICKING:
        any_sticking = any_sticking | (mode == sticking_mode)
    return any_sticking


# ---------------------------------------------------------------------------------------------- what a law may have


ENTERED, LEFT = -1, -2  # events of a contact for `latched`; numbers from 0 on are the law's own guards
SAME = -1  # of Guard.next_mode: the mode stays
ONSET_FLOOR = 1e-3  # m/s, lower bound: laws divide by the onset rate; values from 1e-6 to 1e-3 give the same results
NEVER = -math.inf  # value of an inactive guard


class InternalState(NamedTuple):
    """Properties of a number of a law's internal state; its rate has the same unit per second."""

    scale: float  # scale of its error
    survives_separation: bool  # if not: reset by a separation to its initial value, without a rate out of contact


class StepStart(NamedTuple):
    """A law and its contact at the start of a step."""

    law: tuple  # with its internal state then
    contact: tuple  # Observed


class Guard(NamedTuple):
    """An event at which a function of the motion crosses zero upwards."""

    modes: tuple  # mode in which it is active
    next_mode: int = SAME  # mode after the event
    at_start: bool = False  # also triggered if it is above zero when a motion restarts
    counted: bool = False  # counted in the figure `force_clips`
    observable: int = -1  # index of the observable that equals its value; -1: none
    sign: float = 1.0  # factor on that observable
    ends_run: bool = False  # ends the run: the journal has left its bearing


# ---------------------------------------------------------------------------------------------- of a law


@family_with_default
def internal_state(law):
    """Return an InternalState for each integrated number of a law's internal state."""
    return ()


@family_with_default
def internal_rates(law, contact):
    """Return the rates (1/s) of the law's internal state at its Contact."""
    return ()


@family_with_default
def guards(law):
    """Return the Guards of a law; they depend only on its type, since code is compiled for their number."""
    return ()


@family_with_default
def guard_values(law, start, contact, root):
    """Return the values of the law's guards.

    start : StepStart; contact : Observed, now; root : m^0.5, present root of penetration.
    """
    return ()


@family_with_default
def latched(law, event, contact, root):
    """Return the internal state of a law after an event: ENTERED, LEFT or the index of its guard.

    contact : Observed, at the event; root : m^0.5, of the penetration.  Integrated numbers are reset after a
    separation as `internal_state` specifies, whatever this returns.
    """
    return ()


PAIRED_FAMILIES = (
    (internal_state, internal_rates),
    (guards, guard_values),
)  # a law must be a member of both or of neither


def describe_missing_members(law_type):
    """Yield descriptions of the missing members of a law's type."""
    for declaration, evaluation in PAIRED_FAMILIES:
        if (law_type in declaration.members) != (law_type in evaluation.members):
            yield f"declares one of {declaration.__name__} and {evaluation.__name__}; a law needs both or neither"
    if (is_integrated(law_type) or law_type in latched.members) != bool(getattr(law_type, "_field_defaults", ())):
        yield (
            "must declare an internal_state with rates, or latched numbers, if and only if fields have defaults: these "
            "fields are the state"
        )


@known
def is_integrated(law_type):
    """Return whether the internal state of a type of law is integrated rather than only latched at events."""
    return law_type in internal_state.members


# ---------------------------------------------------------------------------------------------- kinks


UNKNOWN = -1.0  # number of the piece until the first step of a contact
#: A step that begins closer to a kink than this has just passed it: relative to the kink, and its least value.
RELATIVE_CLOSENESS, ABSOLUTE_CLOSENESS = 1e-6, 1e-9
#: Guards: the end of the piece is passed; its beginning is passed; the first step, with an unknown piece.
END_PASSED, BEGIN_PASSED, FIRST_STEP = 0, 1, 2


@family
def kinks(law):
    """Return the values of its variable (a tuple, increasing) at which the formula of a law changes."""


@kernel
def piece_at(kink_values, x):
    """Return the number of the piece that contains `x`."""
    number = 0.0
    for kink in kink_values:
        number = number + where(plain(x) > kink, 1.0, 0.0)
    return number


@kernel
def current_piece(piece, kink_values, x):
    """Return the number of the piece that applies: the `piece` of a law or, if that is UNKNOWN, the piece of `x`."""
    return where(piece >= 0.0, piece, piece_at(kink_values, x))


@kernel
def _next_piece(kink_values, piece, event):
    """Return the next piece after END_PASSED or BEGIN_PASSED; pieces without width are skipped."""
    number, passed_kink = 0.0, 0.0
    for i in range(len(kink_values)):
        passed_kink = where(piece == (i if event == END_PASSED else i + 1.0), kink_values[i], passed_kink)
    for i in range(len(kink_values)):
        is_passed = kink_values[i] <= passed_kink if event == END_PASSED else kink_values[i] < passed_kink
        number = number + where(is_passed, 1.0, 0.0)
    return number


@family
def kink_variable(law, contact, root):
    """Return the variable over which a law has its kinks.

    contact : Observed; root : m^0.5, of the penetration.
    """


def guards_of_pieces(law):
    """Return the Guards END_PASSED, BEGIN_PASSED and FIRST_STEP of a law with a stored number of the piece."""
    return Guard(TOUCHING), Guard(TOUCHING), Guard(TOUCHING, at_start=True)


def _guard_values_of_pieces(law, start, contact, root):
    if law.piece < 0.0:
        return NEVER, NEVER, 1.0
    kink_values, x, above_kink, below_kink = kinks(law), kink_variable(law, contact, root), NEVER, NEVER
    for i in range(len(kink_values)):  # a piece without end or beginning is never left there
        above_kink = where(law.piece == i, x - kink_values[i], above_kink)
        below_kink = where(law.piece == i + 1.0, kink_values[i] - x, below_kink)
    return above_kink, below_kink, NEVER


def _latched_piece(law, event, contact, root):
    if event in (ENTERED, LEFT):
        return (UNKNOWN,)
    if event == FIRST_STEP:
        return (piece_at(kinks(law), kink_variable(law, contact, root)),)
    return (_next_piece(kinks(law), law.piece, event),)


def register_pieces(law_type, variable, kink_values):
    """Register a type of law whose contacts end steps at its kinks over a `variable`; see `kink_variable`, `kinks`.

    The last field of the type is its `piece`, UNKNOWN at first.
    """
    kink_variable.member(law_type)(variable)
    kinks.member(law_type)(kink_values)
    guards.member(law_type)(guards_of_pieces)
    guard_values.member(law_type)(_guard_values_of_pieces)
    latched.member(law_type)(_latched_piece)


# ---------------------------------------------------------------------------------------------- stateless laws


@kernel
def _closeness(kink):
    return max(RELATIVE_CLOSENESS * abs(kink), ABSOLUTE_CLOSENESS)


@kernel
def distances_past_kinks(kink_values, start_value, value):
    """Return how far a variable at `value` is above the next kink and below the previous one of the step's start."""
    next_above, next_below = math.inf, -math.inf
    for kink in kink_values:
        next_above = where((start_value < kink - _closeness(kink)) & (kink < next_above), kink, next_above)
        next_below = where((start_value > kink + _closeness(kink)) & (kink > next_below), kink, next_below)
    return value - next_above, next_below - value


def _guard_values_of_kinks(law, start, contact, root):
    start_value = kink_variable(start.law, start.contact, root)
    return distances_past_kinks(kinks(law), start_value, kink_variable(law, contact, root))


def register_kinks(law_type, variable, kink_values):
    """Register a type of law whose contacts end steps at its kinks, without a stored number of the piece.

    This is for laws with another state, or whose formula covers all pieces; the `variable` may not depend on the root.
    """
    kink_variable.member(law_type)(variable)
    kinks.member(law_type)(kink_values)
    guards.member(law_type)(lambda law: (Guard(TOUCHING), Guard(TOUCHING)))
    guard_values.member(law_type)(_guard_values_of_kinks)


def zero_kink(law):
    """Return the kink, at 0, of a law that has one there."""
    return (0.0,)


def slip_variable(law, contact, root):
    """Return the sliding speed, m/s."""
    return contact.slip


def depth_variable(law, contact, root):
    """Return the penetration from the coordinates, m."""
    return contact.depth


def rate_variable(law, contact, root):
    """Return the rate of the penetration, m/s."""
    return contact.rate


def penetration_variable(law, contact, root):
    """Return the penetration, m."""
    return root * root


# ---------------------------------------------------------------------------------------------- registered laws


REQUIRED_FAMILIES: dict[str, tuple[Callable, ...]] = {}  # kind of laws -> the compiled families that it requires


def require(kind: str, *families: Callable) -> None:
    """Declare a kind of laws, and the compiled families of which each type of this kind must be a member."""
    REQUIRED_FAMILIES[kind] = families


class Recipe(NamedTuple):
    """A law as described to users, and the constructor of its compiled form."""

    law: Law
    types: tuple[type, ...]  # the types that `make` may return
    make: Callable  # joint -> compiled form
    free_restitution: Callable | None = None  # requested restitution -> restitution of a free impact, in closed form
    limit: Callable = lambda joint: math.inf  # joint -> largest valid penetration, m
    derived: Callable = lambda joint: {}  # joint -> derived values: path within the joint -> (value, unit)
    spring: Callable | None = None  # joint -> elastic law of a law of the normal force that uses none of the joint
    check: Callable = lambda joint: ()  # of one's own law: joint -> remarks; raises InputError if it cannot be used


RECIPES: dict[tuple[str, str], Recipe] = {}
#: Hash of the laws of a grid's own -> their recipes.  One hash is one text, so nothing here ever changes.
OWN_RECIPES: dict[str, dict[tuple[str, str], Recipe]] = {}


def recipe_of(family: str, name: str, owner) -> Recipe:
    """Return the recipe of the law called `name`, of the package or of those of its `owner`, a joint, load or drive.

    Raises InputError if it is of a law file that this process has not run.
    """
    recipe = RECIPES.get((family, name))
    if recipe is None and owner.laws not in OWN_RECIPES:
        raise InputError(f"{family} '{name}' is of a law file that has not run here: load the grid that names the file")
    return recipe or OWN_RECIPES[owner.laws][family, name]


def register(
    written: str,
    formula: str,
    source: str,
    fields: tuple[Field, ...] = (),
    *,
    types: tuple[type, ...],
    make: Callable | None = None,
    **further,
) -> None:
    """Enter a law of the package, written as "family name: summary"; further : other fields of its Law and Recipe.

    make : default: the type with the values of the keys that its fields name.
    A `source` that begins with 'after' names the paper whose formula was taken from later work that quotes it.
    """
    options = {name: further.pop(name) for name in Recipe._fields if name in further}
    law = declared_law(written, formula, source, fields, **further)
    register_recipe(Recipe(law, types, make or _maker_from_values(law.family, types[0]), **options))


def register_recipe(recipe: Recipe, recipes: dict[tuple[str, str], Recipe] = RECIPES) -> None:
    """Enter a law of the package, or one of a grid's own in the `recipes` of these.

    Raises TypeError, of a law of one's own InputError, if its name is taken or a member is missing.
    """
    law = recipe.law
    for problem in _describe_faults(recipe):
        text = f"{law.family} '{law.name}': {problem}"
        raise InputError(f"{law.origin}: {text}") if law.origin else TypeError(text)
    recipes[law.family, law.name] = recipe


def _maker_from_values(family: str, law_type) -> Callable:
    """Return a function that creates a law of this type from the section of a joint."""
    section = "contact" if family in ("law", "elastic") else family
    names = [name for name in law_type._fields if name not in law_type._field_defaults]
    return lambda joint: law_type(*(getattr(joint, section).values[name] for name in names))


def _describe_faults(recipe: Recipe):
    """Yield descriptions of the missing declarations of a law."""
    law = recipe.law
    if law.family not in REQUIRED_FAMILIES:
        yield f"unknown family (known: {', '.join(REQUIRED_FAMILIES)})"
        return
    if (law.family, law.name) in RECIPES:
        yield "is the name of a law of the package; choose another one"
    for law_type in recipe.types:
        missing = [family.__name__ for family in REQUIRED_FAMILIES[law.family] if law_type not in family.members]
        if missing:
            yield f"{law_type.__name__} declares no {', '.join(missing)}"
        yield from (f"{law_type.__name__} {problem}" for problem in describe_missing_members(law_type))
    names = {field.name for field in law.fields}
    if "restitution" in names and recipe.free_restitution is None and not law.origin:
        yield "takes a restitution, but declares none that a free impact returns"
    if not law.uses_elastic and "stiffness" not in names and recipe.spring is None:
        yield "uses no elastic law, but takes no stiffness for a spring of its own"


def compile_law(family: str, name: str, joint: Joint):
    """Return the compiled form of the law called `name` for a joint."""
    recipe = recipe_of(family, name, joint)
    compiled = recipe.make(joint)
    if type(compiled) not in recipe.types:
        types = ", ".join(law_type.__name__ for law_type in recipe.types)
        raise TypeError(f"{family} '{name}': makes a {type(compiled).__name__}, entered with {types}")
    return compiled
