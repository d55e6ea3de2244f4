"""Laws of one's own: compiled types and recipes of the functions that `clearsweep.laws` records.

Each recorded law gets a type of its own, a NamedTuple whose field `p` has the values of its keys; the members of the
families call the recorded function, which the tracer reads like any body of the package.  A law that is called by its
address has the address, and that of its parameters, among its numbers: its machine code does not depend on them.

A type is created once for each text of a file (its hash is in the name of the type, and so in that of its code).
"""

import functools
import itertools
import math
import re
from collections import namedtuple
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ... import laws as recorded
from ...contracts.case import Joint
from ...contracts.catalogue import Law
from ...language.errors import InputError
from ...tracing.compiled.dual import as_type_of
from ...tracing.compiled.family import is_plain
from ...tracing.compiled.pinned import array_handle, call_number
from ...tracing.objects import trace_scene
from ...tracing.symbols import NotTraceableError
from . import contract
from .bearings import elastic_of_elements
from .elastic import elastic_force, root_parity
from .film import FilmMotion, film_force
from .friction import Sliding, friction_force
from .loss import always_needs_onset_rate, contact_force, lowest_force, needs_onset_rate, sign_past_separation
from .sampled import GAIN, MASSES, SPEEDS, Range, attempted, checked, rebound, undeclared_kinks

FAMILIES = {kind: kind for kind in recorded.KINDS} | {"contact": "law"}
VARIABLES = {"penetration": contract.depth_variable, "rate": contract.rate_variable, "slip": contract.slip_variable}
WITHOUT_ADDRESS = "film", "load", "figure"  # kinds of laws that take or return other things than numbers
MAKERS: dict[str, Callable[..., contract.Recipe]] = {}  # kind -> (law, its description) -> recipe


def maker(kind: str) -> Callable[[Callable[..., contract.Recipe]], Callable[..., contract.Recipe]]:
    """Return the decorator that registers the function which makes the recipe of an `Own` law of a kind."""

    def register(make: Callable[..., contract.Recipe]) -> Callable[..., contract.Recipe]:
        MAKERS[kind] = make
        return make

    return register


def enter_laws(records: Sequence[recorded.Law], digest: str) -> tuple[Law, ...]:
    """Make the recipes of recorded laws, and return the laws as grids name them.

    digest : hash of all that they depend on; the same hash gives the same recipes.  Raises InputError.
    """
    if digest not in contract.OWN_RECIPES:
        recipes: dict[tuple[str, str], contract.Recipe] = {}
        for law in records:
            if law.body is None and law.kind in WITHOUT_ADDRESS:
                raise InputError(
                    f"{law.place}: needs more than numbers, and a function of C has no more; write it in Python"
                )
            contract.register_recipe(MAKERS[law.kind](Own(law, digest), description_of(law)), recipes)
        contract.OWN_RECIPES[digest] = recipes
    return tuple(recipe.law for recipe in contract.OWN_RECIPES[digest].values())


_SPRING_OF_C = (
    "a contact law of C takes stiffness and exponent of the joint; if it is a spring of its own, call one of its keys "
    "`stiffness`"
)


def description_of(law: recorded.Law) -> Law:
    """Return the description of a recorded law."""
    return Law(
        FAMILIES[law.kind],
        law.name,
        re.sub(r" \([^()]*\)$", "", law.doc) or "a law of one's own",
        law.doc or f"the function {getattr(law.body, '__name__', 'at an address')}",
        f"{law.file}:{law.line}",
        law.keys,
        uses_elastic=recorded.uses_elastic(law),
        notes=_SPRING_OF_C if law.kind == "contact" and law.body is None and recorded.uses_elastic(law) else "",
        has_state=law.states > 0,
        origin=f"{law.file}:{law.line}",
        unit=law.unit,
    )


# ---------------------------------------------------------------------------------------------- types and functions


class Own:
    """A recorded law, and the types and functions that are made of it; digest : hash of all that it depends on."""

    def __init__(self, law: recorded.Law, digest: str) -> None:
        """Store the law and the function (p, *arguments) that evaluates it."""
        self.law, self.place, self.digest, self.evaluate = law, law.place, digest, function_of(law)

    def type_of(self, role: str, fields: Sequence[str], states: int = 0) -> type:
        """Return a new type; role : what it is for; the last `states` fields are internal, 0 at first."""
        name = f"{self.law.kind}_{self.law.name.replace('-', '_')}_{role}_{self.digest}"
        state_names = [f"state_{i}" for i in range(states)]
        made = namedtuple(name, [*fields, *state_names], defaults=[0.0] * states, module=__name__)
        globals()[name] = made  # where pickle looks for it
        return made

    def names(self, *further: str) -> tuple[str, ...]:
        """Return the names of the numbers in the field `p` of the law's types."""
        if self.law.body is None:
            return "address", "parameters"
        return (*(field.name for field in self.law.keys), *further)

    @functools.cached_property
    def values(self) -> type:
        """The type of the field `p`."""
        return self.type_of("values", self.names(*recorded.KINDS[self.law.kind].given))

    def parameters(self, given: Mapping[str, float], *further: float, kind: type | None = None) -> Any:
        """Return the field `p`: the numbers of the keys or, of a law with an address, this and that of its numbers."""
        numbers = [float(x) for x in (*(given[field.name] for field in self.law.keys), *further)]
        if self.law.body is None:
            numbers = [float(recorded.address_of(self.law.function)), array_handle(np.array([*numbers, 0.0]))]
        return (kind or self.values)(*numbers)

    def check_traced(self, p: Any, *arguments: Any) -> None:
        """Raise InputError, with the statement, if the law cannot be compiled; arguments : any of their form."""
        body = self.law.body
        if body is None or is_plain():
            return

        def entry(scene, _):
            return body(*scene[0][1:], scene[0][0])

        try:
            trace_scene(entry, (p, *arguments), "")
        except NotTraceableError as error:
            raise InputError(f"{self.place}: {(error.places or [str(error)])[0]}") from None

    def check_at(self, function: Callable[..., float], **places: Sequence[float]) -> None:
        """Raise InputError if a function of the law is no finite number at one of the places of its arguments."""
        sampled = checked(function, tuple(places), self.place)
        for place in itertools.product(*places.values()):
            sampled(*place)


def function_of(law: recorded.Law) -> Callable:
    """Return the function (p, *arguments) that evaluates a law."""
    body = law.body
    if body is None:

        def call_address(p, *arguments):
            return call_number(p.address, p.parameters, *arguments)

        return call_address

    def call_body(p, *arguments):
        return body(*arguments, p)

    return call_body


def declared_kinks(law: recorded.Law, variable: str, values: Any) -> tuple[float, ...]:
    """Return the declared kinks of a law over a variable, in order; values : of its keys."""
    kinks = (kink for kink in law.kinks if kink.variable == variable)
    return tuple(sorted(kink.value * (values[kink.key] if kink.key else 1.0) for kink in kinks))


def kink_values(law: recorded.Law, values: Any) -> tuple[tuple[float, ...], ...]:
    """Return the kinks of a law over each variable that has any; values : of its keys."""
    return tuple(kinks for x in VARIABLES if (kinks := declared_kinks(law, x, values)))


def register_kinks_of(law: recorded.Law, law_type: type) -> None:
    """Let contacts end their steps at the kinks of a law, whose field `kinks` has those over each variable."""
    variables = tuple(
        variable for name, variable in VARIABLES.items() if any(kink.variable == name for kink in law.kinks)
    )
    if not variables:
        return

    contract.guards.member(law_type)(lambda law: (contract.Guard(contract.TOUCHING),) * (2 * len(variables)))

    @contract.guard_values.member(law_type)
    def guard_values_of_kinks(law, start, contact, root):
        values = ()
        for i in range(len(variables)):
            before = variables[i](start.law, start.contact, root)
            values = values + contract.distances_past_kinks(law.kinks[i], before, variables[i](law, contact, root))
        return values


# ---------------------------------------------------------------------------------------------- elastic


SMALL_DEPTHS = (1e-12, 1e-11)  # m: between these, the power of a force at small penetration is taken


def power_at_zero(force: Callable[[float], float]) -> float:
    """Return the power of the penetration with which a force (N) begins, 0 if it jumps, is 0 or is not a number."""
    low, high = (attempted(functools.partial(force, depth), 0.0) for depth in SMALL_DEPTHS)
    if not (low > 0.0 and high > 0.0 and math.isfinite(high)):
        return 0.0
    return math.log(high / low) / math.log(SMALL_DEPTHS[1] / SMALL_DEPTHS[0])


def parity_of(power: float) -> float:
    """Return -1 if a power of the penetration is an odd power of its root, else 1."""
    return -1.0 if abs(2.0 * power - round(2.0 * power)) < 1e-3 and round(2.0 * power) % 2 else 1.0


@maker("elastic")
def _elastic_recipe(own: Own, description: Law) -> contract.Recipe:
    law, evaluate, kind = own.law, own.evaluate, own.type_of("law", ("p", "parity", "kinks"))

    @elastic_force.member(kind)
    def force(elastic, pen):
        return evaluate(elastic.p, pen)

    root_parity.member(kind)(lambda elastic: elastic.parity)
    register_kinks_of(law, kind)

    def make(joint):
        p = own.parameters(joint.contact.values)
        parity = parity_of(power_at_zero(lambda depth: evaluate(p, depth)))
        return kind(p, parity, kink_values(law, joint.contact.values))

    def check(joint):
        elastic = make(joint)
        own.check_traced(elastic.p, joint.clearance)
        sampled_force = checked(lambda depth: force(elastic, depth), ("penetration",), law.place)
        remarks = _check_at_zero(sampled_force, joint, law)
        depths = _depths(joint.clearance)
        for shallow, deep in itertools.pairwise(depths):
            if sampled_force(deep) <= sampled_force(shallow):
                raise InputError(f"{law.place}: does not grow from penetration {shallow:.4g} to {deep:.4g} m; it must")
        return remarks

    return contract.Recipe(description, (kind,), make, check=check)


def _depths(clearance: float) -> list[float]:
    """Return the penetrations (m) at which a law is sampled."""
    return [clearance * 10.0 ** (0.25 * i - 6.0) for i in range(25)]


def _check_at_zero(force: Callable, joint: Joint, law: recorded.Law) -> tuple[str, ...]:
    """Return remarks on a force (N) over the penetration (m); raise InputError if it is not 0 at 0, or pulls."""
    clearance, values = joint.clearance, joint.contact.values
    at_zero, *_, at_deepest = forces = [force(depth) for depth in (0.0, *_depths(clearance))]
    if abs(at_zero) > 1e-9 * max(map(abs, forces[1:])):
        raise InputError(
            f"{law.place}: gives {at_zero:.4g} N at rest at penetration 0; surfaces that just touch have none"
        )
    if at_deepest <= 0.0:
        where = f"at rest at penetration {clearance:.4g} m"
        raise InputError(f"{law.place}: gives {at_deepest:.4g} N {where}; it must push the surfaces apart")
    kinks = declared_kinks(law, "penetration", values)
    return tuple(undeclared_kinks(force, Range("penetration", "m", 1e-6 * clearance, clearance), kinks, law.place))


# ---------------------------------------------------------------------------------------------- normal force


def _values_type(own: Own, further: tuple[str, ...]) -> type:
    """Return the type of the field `p` of a contact law with further numbers, and with the elastic law of the joint."""
    role, names = "_".join(("values", *further)), own.names(*further)
    if own.law.body is None:
        return own.type_of(role, names)

    class Values(own.type_of(role, (*names, "elastic"))):
        __slots__ = ()

        def elastic_force(self, penetration):
            return elastic_force(self.elastic, penetration)

    Values.__name__ = Values.__qualname__ = Values.__mro__[1].__name__
    globals()[Values.__name__] = Values
    return Values


NO_ELASTIC = 0.0  # the field `elastic` among the numbers of a scene: the joint has its elastic law
SPEED_AT_ZERO = 0.1  # m/s, at which the power of a normal force at small penetration is taken


@maker("contact")
def _contact_recipe(own: Own, description: Law) -> contract.Recipe:
    law, evaluate, is_python = own.law, own.evaluate, own.law.body is not None
    kind, at_rest = own.type_of("law", ("p", "sign_past", "kinks")), own.type_of("at_rest", ("p", "parity"))
    powers = ("stiffness", "exponent") if description.uses_elastic else ()
    types = {names: _values_type(own, names) for names in {powers, ()}}

    @contact_force.member(kind)
    def force(law, elastic, pen, rate, onset_rate):
        p = law.p._replace(elastic=elastic) if is_python else law.p
        return evaluate(p, pen, rate, onset_rate), elastic_force(elastic, pen)

    lowest_force.member(kind)(lambda law: 0.0)
    sign_past_separation.member(kind)(lambda law, elastic: law.sign_past)
    elastic_force.member(at_rest)(lambda elastic, pen: evaluate(elastic.p, pen, 0.0, 1.0))
    root_parity.member(at_rest)(lambda elastic: elastic.parity)
    if recorded.reads(law, "onset_rate"):
        needs_onset_rate.member(kind)(always_needs_onset_rate)
    register_kinks_of(law, kind)

    def parameters(joint):
        values, further, names = joint.contact.values, [], ()
        if powers and joint.contact.elastic == "power":
            further, names = [contract.compile_law("elastic", "power", joint).stiffness, values["exponent"]], powers
        return own.parameters(values, *further, *[NO_ELASTIC] * is_python, kind=types[names])

    def spring(joint):
        p = parameters(joint)
        return at_rest(p, parity_of(power_at_zero(lambda depth: evaluate(p, depth, 0.0, 1.0))))

    def make(joint):
        elastic = elastic_of(joint)
        trial = kind(parameters(joint), 1.0, kink_values(law, joint.contact.values))
        power = power_at_zero(lambda depth: force(trial, elastic, depth, SPEED_AT_ZERO, SPEED_AT_ZERO)[0])
        is_times_elastic = abs(power - power_at_zero(lambda depth: elastic_force(elastic, depth))) < 1e-6
        return trial._replace(sign_past=float(root_parity(elastic)) if is_times_elastic else parity_of(power))

    def elastic_of(joint):
        if not description.uses_elastic:
            return spring(joint)
        elastic = joint.contact.elastic
        return elastic_of_elements(joint) if joint.rolling else contract.compile_law("elastic", elastic, joint)

    def bound(joint):
        compiled, elastic = make(joint), elastic_of(joint)
        return lambda depth, rate, onset_rate: force(compiled, elastic, depth, rate, onset_rate)[0]

    def check(joint):
        missing = [name for name in powers if recorded.reads_part(law, name) and joint.contact.elastic != "power"]
        if missing:
            raise InputError(
                f"{law.place}: uses p.{missing[0]}, which only elastic: power has; use p.elastic_force(penetration)"
            )
        p, elastic = parameters(joint), elastic_of(joint)
        own.check_traced(p._replace(elastic=elastic) if is_python else p, joint.clearance, 0.1, 0.1)
        return _check_contact(law, joint, bound(joint))

    own_spring = None if description.uses_elastic else spring
    derived = functools.partial(_restitutions, bound)
    return contract.Recipe(description, (kind,), make, derived=derived, spring=own_spring, check=check)


def _restitutions(bound: Callable, joint: Joint) -> dict[str, tuple[float, str]]:
    """Return the restitution at SPEEDS; bound : joint -> its force (N) over penetration, rate and onset rate."""
    force, restitutions = bound(joint), {}
    for speed in SPEEDS:
        light, heavy = (
            rebound(lambda depth, rate: force(depth, rate, speed), mass, speed)  # noqa: B023 - called in this pass
            for mass in MASSES
        )
        mass_text = "" if abs(heavy - light) < 1e-5 else f" and {MASSES[0]:g} kg"
        restitutions[f"contact.restitution at {speed:g} m/s{mass_text}"] = light, "1"
    return restitutions


def _check_contact(law: recorded.Law, joint: Joint, force: Callable) -> tuple[str, ...]:
    """Return remarks on a contact law; raise InputError if its force (N) cannot be used, see `_restitutions`."""
    sampled_force = checked(force, ("penetration", "rate", "onset rate"), law.place)
    depths, shares = [0.0, *_depths(joint.clearance)], (-1.0, -0.3, 0.0, 0.3, 1.0)
    for depth, onset_rate, share in itertools.product(depths, (contract.ONSET_FLOOR, 0.1, 10.0), shares):
        sampled_force(depth, share * onset_rate, onset_rate)
    remarks = _check_at_zero(lambda depth: sampled_force(depth, 0.0, 0.1), joint, law)
    for key, (value, _) in _restitutions(lambda _: force, joint).items():
        if value > 1.0 + GAIN and not law.may_gain:
            raise InputError(
                f"{law.place}: gives energy: its {key.partition('.')[2]} is {value:.6g}; allow it by may_gain=True"
            )
    kinks, over = declared_kinks(law, "rate", joint.contact.values), Range("rate", "m/s", -0.1, 0.1)
    for depth in (1e-2 * joint.clearance, 0.1 * joint.clearance):
        by_rate = functools.partial(lambda depth, rate: sampled_force(depth, rate, 0.1), depth)
        remarks += tuple(undeclared_kinks(by_rate, over, kinks, law.place))
    return tuple(dict.fromkeys(remarks))


# ---------------------------------------------------------------------------------------------- friction


SLIPS = (1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0)  # m/s, at which friction laws are sampled, in both directions
SETTLED_SLIP = 1.0  # m/s, at which the internal state that long sliding gives is the scale of its error


@maker("friction")
def _friction_recipe(own: Own, description: Law) -> contract.Recipe:
    law, evaluate, count, fields = own.law, own.evaluate, own.law.states, ("p", "sign", "kinks", "scales")
    kind = own.type_of("law", fields, count)

    def state_of(friction):
        return friction[len(fields)] if count == 1 else friction[len(fields) :]

    @friction_force.member(kind)
    def force(friction, normal, slip):
        if count == 0:
            return friction.sign * evaluate(friction.p, normal, slip)
        return friction.sign * evaluate(friction.p, normal, slip, state_of(friction))[0]

    if count:

        @contract.internal_state.member(kind)
        def declared(friction):
            return tuple([contract.InternalState(scale, False) for scale in friction.scales])

        @contract.internal_rates.member(kind)
        def rates(friction, contact):
            rate = evaluate(friction.p, contact.normal, contact.slip, state_of(friction))[1]
            return (rate,) if count == 1 else rate

    register_kinks_of(law, kind)

    def make(joint):
        given = joint.friction.values
        trial = kind(own.parameters(given), 1.0, kink_values(law, given), (1.0,) * count)
        if count:
            keys = [given[field.name] for field in law.keys]
            scales = [
                _as_quotient(attempted(functools.partial(_settled, trial, rates, i), 1.0), keys) for i in range(count)
            ]
            trial = trial._replace(scales=tuple(scales))
        slips = [slip for size in SLIPS for slip in (size, -size)]
        power = attempted(lambda: sum(force(_after_sliding(trial, slip), 1.0, slip) * slip for slip in slips), 0.0)
        return trial._replace(sign=-1.0 if power > 0.0 else 1.0)

    def _length(returned):
        return len(returned) if isinstance(returned, tuple) else 1

    def _after_sliding(trial, slip):
        return trial._replace(**{f"state_{i}": math.copysign(trial.scales[i], slip) for i in range(count)})

    def check(joint):
        if count and not isinstance(joint, Joint):
            raise InputError(f"{law.place}: has states, which only joints with clearance keep")
        friction = make(joint)
        state = () if count == 0 else (state_of(friction),)
        own.check_traced(friction.p, 1.0, 0.1, *state)
        if count:
            returned = attempted(lambda: _length(evaluate(friction.p, 1.0, 0.1, *state)), 2)
            if returned != 2:
                raise InputError(
                    f"{law.place}: a law with states returns two values, the force and the rate of its state or "
                    f"states; found {returned:g}"
                )
        sampled_force = checked(lambda normal, slip: force(friction, normal, slip), ("normal", "slip"), law.place)
        sampled_rates = checked(lambda slip: sum(rates(friction, Sliding(slip=slip))), ("slip",), law.place)
        for slip in (0.0, *SLIPS, *(-size for size in SLIPS)):
            for normal in (0.0, 1.0, 1e4):
                power = sampled_force(normal, slip) * slip
                if power > GAIN * normal and not law.may_gain and count == 0:
                    raise InputError(
                        f"{law.place}: drives the sliding at slip {slip:g} m/s and opposes it elsewhere; allow it by "
                        "may_gain=True"
                    )
            if count:
                sampled_rates(slip)
        over, kinks = Range("slip", "m/s", -1.0, 1.0), declared_kinks(law, "slip", joint.friction.values)
        return tuple(undeclared_kinks(lambda slip: sampled_force(1.0, slip), over, kinks, law.place))

    return contract.Recipe(description, (kind,), make, check=check)


def _settled(friction, rates: Callable, index: int) -> float:
    """Return the size of an internal state at which its rate vanishes in sliding, or 1 if it does not settle."""
    name = f"state_{index}"

    def rate(state: float) -> float:
        return float(rates(friction._replace(**{name: state}), Sliding(slip=SETTLED_SLIP))[index])

    direction = math.copysign(1.0, rate(0.0))
    low, high = 0.0, 1e-15
    while rate(direction * high) * direction > 0.0 and high < 1e15:
        low, high = high, 2.0 * high
    for _ in range(100 if high < 1e15 else 0):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if rate(direction * middle) * direction > 0.0 else (low, middle)
    return high if high < 1e15 else 1.0


def _as_quotient(number: float, keys: Sequence[float]) -> float:
    """Return a positive number as a key or as the quotient of two, if it is one but for rounding."""
    candidates = [*keys, *(a / b for a in keys for b in keys if b)]
    return next((float(x) for x in candidates if abs(x - number) < 1e-6 * number), number)


# ---------------------------------------------------------------------------------------------- film


@maker("film")
def _film_recipe(own: Own, description: Law) -> contract.Recipe:
    evaluate, kind = own.evaluate, own.type_of("law", ("p",))

    @film_force.member(kind)
    def force(film, motion):
        zero = as_type_of(0.0, motion.eccentricity)
        return evaluate(film.p, motion.eccentricity, zero, motion.rate, zero, motion.spin)

    def make(joint):
        film = joint.film
        return kind(own.parameters(film.own, film.viscosity, joint.clearance, joint.bearing_radius, joint.length))

    def check(joint):
        film, zero = make(joint), 0.0
        own.check_traced(film.p, 0.5 * joint.clearance, zero, 0.1, zero, 10.0)

        def total(ratio, rate, speed):
            fx, fy = force(film, FilmMotion(ratio, 0.0, speed, ratio * joint.clearance, rate))
            return fx + fy

        ratios, rates = (0.0, 0.01, 0.1, 0.5, 0.9, joint.film.limit), (-0.1, -1e-3, 0.0, 1e-3, 0.1)
        own.check_at(total, ratio=ratios, rate=rates, speed=(-100.0, 0.0, 100.0))
        return ()

    return contract.Recipe(description._replace(needs=("length",)), (kind,), make, check=check)


# ---------------------------------------------------------------------------------------------- figures


contract.require("figure")  # runs as Python


@maker("figure")
def _figure_recipe(own: Own, description: Law) -> contract.Recipe:
    """Return the recipe of a figure; it makes a function (t, channels), which runs as Python."""
    return contract.Recipe(
        description,
        (functools.partial,),
        lambda figure: functools.partial(own.evaluate, own.parameters(figure.values)),
    )
