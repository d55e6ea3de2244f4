"""Laws of one's own: decorators that record a function as a law, a load, a motor or a figure.

A decorator states the name by which a grid chooses the law, its keys with their SI units, and what the function needs:

    from clearsweep import laws

    @laws.contact("my-law", damper="N*s/m^2.5", doc="F = K d^n + D d^n d' (Hunt & Crossley 1975)")
    def my_law(penetration, rate, onset_rate, p):
        return p.stiffness * penetration**p.exponent + p.damper * penetration**p.exponent * rate

It returns the function unchanged and only records it, for the grid that names its file; elsewhere it has no effect.
All numbers are in SI.  The names doc, kinks, states and may_gain are no keys.  KINDS says which arguments each kind has
and what it returns.
"""

import contextlib
import contextvars
import dis
import inspect
import keyword
import linecache
import math
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple, NoReturn

from .contracts.catalogue import Field
from .language import quantity
from .language.errors import InputError, did_you_mean, quoted

__all__ = [
    "KINDS",
    "Key",
    "Law",
    "collecting",
    "contact",
    "elastic",
    "figure",
    "film",
    "friction",
    "key",
    "load",
    "motor",
    "profile",
    "wear",
]

NAME_PATTERN = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,39}")


class Kind(NamedTuple):
    """What a law of a kind takes and returns."""

    arguments: tuple[str, ...]
    returns: str
    taken: tuple[str, ...] = ()  # keys that its section of a grid has already
    variables: tuple[str, ...] = ()  # those over which it may have kinks, the default first
    given: tuple[str, ...] = ()  # further parts of `p`, which the joint gives


KINDS: Mapping[str, Kind] = {
    "elastic": Kind(
        ("penetration", "p"), "the elastic force, N", ("law", "elastic", "material", "onset", "fit"), ("penetration",)
    ),
    "contact": Kind(
        ("penetration", "rate", "onset_rate", "p"),
        "the total normal force, N",
        ("law", "elastic", "material", "onset", "fit", "exponent"),
        ("penetration", "rate"),
        ("stiffness", "exponent", "elastic_force"),
    ),
    "friction": Kind(
        ("normal", "slip", "p"),
        "the tangential force that opposes the slip, N; with states (normal, slip, state, p): the pair (force, rate of "
        "the state)",
        ("law", "preload", "radius"),
        ("slip",),
    ),
    "wear": Kind(
        ("pressure", "slip", "p"),
        "the rate of the wear depth, m/s",
        ("law", "pressure", "bins", "length_bins", "pair", "unchecked", "coefficient_unit", "evolve", "running_in"),
    ),
    "film": Kind(
        ("e_x", "e_y", "v_x", "v_y", "speed", "p"),
        "the pair (fx, fy), N, on the journal",
        ("law", "friction", "oil", "unchecked", "viscosity", "limit", "temperature", "thermal", "transition"),
        given=("viscosity", "clearance", "bearing_radius", "length"),
    ),
    "load": Kind(
        ("t", "angle", "position", "velocity", "p"),
        "(fx, fy, torque), N and N m, on the body",
        ("on", "point", "law", "table", "between", "friction", "reacted"),
    ),
    "motor": Kind(("speed", "t", "p"), "the torque, N m", ("law", "table")),
    "profile": Kind(("angle", "p"), "what the bearing's radius has more than a circle, m", ("law",)),
    "figure": Kind(
        ("t", "channels", "p"),
        "a number; t : (n,) s; channels : name of a time history -> its samples (n,), SI, read-only and in the window "
        "after `simulate.discard`",
        ("law",),
    ),
}


class Key(NamedTuple):
    """A key of a law; its bounds and its default are in SI, or the default is a quantity with its unit."""

    unit: str  # SI unit of its value, '1' for none
    above: float | None = None  # a lower bound that is not allowed itself
    at_least: float | None = None
    below: float | None = None  # an upper bound that is not allowed itself
    at_most: float | None = None
    default: float | str | None = None  # None: the key is required
    doc: str = ""  # one line


key = Key


class Kink(NamedTuple):
    """A value at which the formula of a law changes."""

    variable: str  # 'penetration', 'rate' or 'slip'
    key: str  # the key that has the value, or ''
    value: float  # the value, SI, or the factor on that of the key: 1 or -1


class Law(NamedTuple):
    """A recorded law."""

    kind: str  # one of KINDS
    name: str  # by which a grid chooses it
    keys: tuple[Field, ...]
    doc: str
    function: Any  # as decorated: a function of Python, of numba, or one with an address
    kinks: tuple[Kink, ...]
    states: int  # internal numbers, each with a rate
    may_gain: bool  # whether it may give energy
    file: str  # of the decorator
    line: int
    unit: str = ""  # of a figure

    @property
    def place(self) -> str:
        """Return where the law is, at the beginning of a message."""
        return f"{self.file}:{self.line}: laws.{self.kind} '{self.name}'"

    @property
    def body(self) -> Callable | None:
        """Return its function as Python, which the tracer reads, or None if it is called by its address."""
        body = getattr(self.function, "py_func", self.function)
        return body if inspect.isfunction(body) and not hasattr(self.function, "address") else None


def __getattr__(name: str) -> NoReturn:
    """Raise AttributeError for a kind of laws that does not exist."""
    message = f"module '{__name__}' has no kind '{name}'{did_you_mean(name, KINDS)}; kinds: {', '.join(KINDS)}"
    raise AttributeError(message)


_RECORDS: contextvars.ContextVar[list[Law] | None] = contextvars.ContextVar("_RECORDS", default=None)


@contextlib.contextmanager
def collecting() -> Iterator[list[Law]]:
    """In this context, decorators append the laws that they record to the list that it yields."""
    records: list[Law] = []
    token = _RECORDS.set(records)
    try:
        yield records
    finally:
        _RECORDS.reset(token)


def _decorator(kind: str) -> Callable[..., Any]:
    """Return the decorator of a kind of laws."""

    def decorate(
        name: str,
        unit: str = "",
        /,
        *,
        doc: str = "",
        kinks: Sequence[float | str] = (),
        states: int = 0,
        may_gain: bool = False,
        **keys: str | Key,
    ) -> Callable[[Any], Any]:
        frame = sys._getframe(1)
        place = frame.f_code.co_filename, frame.f_lineno
        return _recorder(Law(kind, name, (), doc, None, (), states, may_gain, *place, unit), keys, kinks)

    decorate.__name__ = decorate.__qualname__ = kind
    decorate.__doc__ = (
        f"Record a function ({', '.join(KINDS[kind].arguments)}) that returns {KINDS[kind].returns}.\n\n    name : by "
        "which a grid chooses it; doc : its formula and source, one line; kinks : values at which its formula changes,"
        "\n    numbers or names of keys; states : number of its internal states; may_gain : whether it may give energy;"
        "\n    keys : SI units of its keys, or `key(...)`; that of a figure follows its name.  Raises InputError."
    )
    return decorate


elastic, contact, friction, wear = (_decorator(kind) for kind in ("elastic", "contact", "friction", "wear"))
film, load, motor = (_decorator(kind) for kind in ("film", "load", "motor"))
profile, figure = (_decorator(kind) for kind in ("profile", "figure"))


def _recorder(law: Law, keys: Mapping[str, Any], kinks: Sequence[float | str]) -> Callable[[Any], Any]:
    """Return the decorator of a law whose arguments are checked."""
    if callable(law.name):
        raise InputError(f'{law.file}:{law.line}: has no name; write @laws.{law.kind}("NAME", KEY="unit") above it')
    with _reported_at(law):
        _check_names(law, keys)
        fields = tuple(_field(law, name, described) for name, described in keys.items())
        unit = _si_unit(law.unit) if law.kind == "figure" else ""
        law = law._replace(keys=fields, kinks=_kinks(law, kinks, tuple(keys)), unit=unit)

    def record(function: Any) -> Any:
        with _reported_at(law):
            _check_function(law, function)
        records = _RECORDS.get()
        if records is not None:
            earlier = next((other for other in records if (other.kind, other.name) == (law.kind, law.name)), None)
            if earlier:
                raise InputError(f"{law.place}: is recorded already in line {earlier.line}; give it another name")
            records.append(law._replace(function=function))
        return function

    return record


@contextlib.contextmanager
def _reported_at(law: Law) -> Iterator[None]:
    """Put the place of a law before the message of an InputError."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{law.place}: {error}") from None


def _check_names(law: Law, keys: Mapping[str, Any]) -> None:
    kind = KINDS[law.kind]
    if not (isinstance(law.name, str) and NAME_PATTERN.fullmatch(law.name)):
        message = "its name is not valid; expected a letter, then letters, digits, - or _, at most 40 characters"
        raise InputError(message)
    for name in keys:
        if name in kind.taken or name.startswith("_") or keyword.iskeyword(name) or not name.isascii():
            taken = f"; its section of a grid has the keys {', '.join(kind.taken)} already" if kind.taken else ""
            raise InputError(f"'{name}' cannot be a key{taken}; choose another name")
    if law.unit and law.kind != "figure":
        raise InputError(f"found {quoted(law.unit)} after its name; only a figure has a unit there")
    if not isinstance(law.doc, str):
        raise InputError(f"found doc {quoted(law.doc)}; expected a text")
    if type(law.states) is not int or not 0 <= law.states <= 8 or (law.states and law.kind != "friction"):
        raise InputError(f"found states {quoted(law.states)}; expected a whole number from 0 to 8, of a friction law")
    if type(law.may_gain) is not bool:
        raise InputError(f"found may_gain {quoted(law.may_gain)}; expected True or False")


def _si_unit(unit: Any) -> str:
    """Return a unit if it is one of SI, '1' for none; raise InputError for any other."""
    if not isinstance(unit, str):
        raise InputError(f"found the unit {quoted(unit)}; expected a text such as 'N*s/m', '1' for none")
    if unit in ("", "1"):
        return "1"
    size, dimension = quantity.value_and_dimension(f"1 {quantity.replace_exponent(unit, 1.5)}")
    if size != 1.0 or unit in ("degC", "°C"):
        raise InputError(f"'{unit}' is not the SI unit; laws compute in SI: write '{quantity.unit_of(dimension)}'")
    return unit


def _field(law: Law, name: str, described: str | Key) -> Field:
    """Return a key of a law as the grid reads it."""
    try:
        if not isinstance(described, (str, Key)):
            raise InputError(f"found {quoted(described)}; expected a unit such as 'N*s/m', or laws.key(...)")
        described = Key(described) if isinstance(described, str) else described
        bounds = described.above, described.at_least, described.below, described.at_most
        if any(bound is not None and not isinstance(bound, (int, float)) for bound in bounds):
            raise InputError("its bounds are not numbers; expected numbers in SI")
        if None not in bounds[:2] or None not in bounds[2:]:
            raise InputError("has two lower or two upper bounds; write above or at_least, below or at_most")
        low = next((bound for bound in bounds[:2] if bound is not None), -math.inf)
        high = next((bound for bound in bounds[2:] if bound is not None), math.inf)
        field = Field(
            name,
            _si_unit(described.unit),
            described.doc,
            float(low),
            float(high),
            low_open=described.at_least is None,
            high_open=described.at_most is None,
        )
        if "^exponent" in field.unit and law.kind not in ("elastic", "contact"):
            raise InputError("its unit has an exponent, which only keys of contacts have")
        if described.default is None:
            return field
        default = quantity.read(described.default, quantity.replace_exponent(field.unit, 1.5))
        if not field.contains(default):
            raise InputError(f"its default is {described.default}; allowed: {field.allowed(default)}")
        return field._replace(default=default)
    except InputError as error:
        raise InputError(f"key '{name}': {error}") from None


_KINK = re.compile(r"(?:(\w+)\s*=\s*)?([+-]?)\s*(\S+)")


def _kinks(law: Law, kinks: Sequence[float | str], keys: tuple[str, ...]) -> tuple[Kink, ...]:
    """Return the declared kinks of a law."""
    variables = KINDS[law.kind].variables
    if isinstance(kinks, str) or not isinstance(kinks, Sequence):
        raise InputError(f"found kinks {quoted(kinks)}; expected a list such as [0.0, 'v0', '-v0']")
    if kinks and not variables:
        raise InputError(f"a law of the kind {law.kind} has no kinks; leave them out")
    return tuple(_kink(kink, variables, keys) for kink in kinks)


def _kink(kink: float | str, variables: tuple[str, ...], keys: tuple[str, ...]) -> Kink:
    if isinstance(kink, (int, float)) and not isinstance(kink, bool) and math.isfinite(kink):
        return Kink(variables[0], "", float(kink))
    match = _KINK.fullmatch(kink.strip()) if isinstance(kink, str) else None
    if match is None:
        message = f"found the kink {quoted(kink)}; expected a number, or the name of a key such as 'v0' or '-v0'"
        raise InputError(message)
    variable, sign, value = match[1] or variables[0], -1.0 if match[2] == "-" else 1.0, match[3]
    if variable not in variables:
        raise InputError(f"found a kink over '{variable}'; a law of this kind has kinks over {' or '.join(variables)}")
    if value in keys:
        return Kink(variable, value, sign)
    try:
        return Kink(variable, "", sign * float(value))
    except ValueError:
        hint = did_you_mean(value, keys)
        raise InputError(f"found the kink {quoted(kink)}; '{value}' is neither a number nor a key{hint}") from None


def arguments_of(law: Law) -> tuple[str, ...]:
    """Return the arguments that the function of a law takes."""
    *arguments, parameters = KINDS[law.kind].arguments
    return (*arguments, *(("state",) if law.states else ()), parameters)


def _check_function(law: Law, function: Any) -> None:
    """Raise InputError if a function cannot be that of a law."""
    body, expected = law._replace(function=function).body, arguments_of(law)
    if body is None:
        if address_of(function) is None:
            raise InputError(f"decorates {quoted(function)}; expected a function of Python or numba, or one of C")
        return
    parameters = list(inspect.signature(body).parameters.values())
    positional = [x for x in parameters if x.kind in (x.POSITIONAL_ONLY, x.POSITIONAL_OR_KEYWORD)]
    if len(positional) != len(expected) or len(parameters) != len(expected):
        signature = ", ".join(map(str, parameters))
        raise InputError(f"{body.__name__} takes ({signature}); expected ({', '.join(expected)})")
    known = [*(field.name for field in law.keys), *KINDS[law.kind].given]
    for name, line in _parameters_used(body, positional[-1].name):
        if name and name not in known:
            hint = did_you_mean(name, known) or f" (known: {', '.join(known) or 'none'})"
            text = linecache.getline(body.__code__.co_filename, line).strip()
            raise InputError(f"line {line} uses p.{name}, which is no key of this law{hint}: {text}")


def _parameters_used(function: Callable, argument: str) -> Iterator[tuple[str, int]]:
    """Yield each part of an argument that a function reads, '' for all of it, and the line where it does."""
    if argument in function.__code__.co_cellvars:
        yield "", function.__code__.co_firstlineno
    loaded, line = (), function.__code__.co_firstlineno
    for instruction in dis.get_instructions(function):
        line = (instruction.positions.lineno if instruction.positions else None) or line
        if argument in loaded[:-1] or (argument in loaded and instruction.opname not in ("LOAD_ATTR", "LOAD_METHOD")):
            yield "", line
        elif argument in loaded:
            yield instruction.argval, line
        is_load = instruction.opname.startswith("LOAD_FAST")
        loaded = (
            (instruction.argval if isinstance(instruction.argval, tuple) else (instruction.argval,)) if is_load else ()
        )


def uses_elastic(law: Law) -> bool:
    """Return whether the force of a contact law depends on the elastic law of the joint."""
    if law.body is None or law.kind != "contact":
        return all(field.name != "stiffness" for field in law.keys)
    return not _read(law, "p").isdisjoint({"stiffness", "exponent", "elastic_force", ""} - {x.name for x in law.keys})


def reads_part(law: Law, name: str) -> bool:
    """Return whether the function of a law itself reads a part of `p`."""
    return law.body is not None and name in _read(law, "p")


def reads(law: Law, argument: str) -> bool:
    """Return whether a law may read one of its arguments, named as in KINDS."""
    return law.body is None or bool(_read(law, argument))


def _read(law: Law, argument: str) -> set[str]:
    """Return the parts of an argument, named as in KINDS, that the function of a law reads; '' for all of it."""
    body = law.body
    assert body is not None  # only laws with one
    name = body.__code__.co_varnames[arguments_of(law).index(argument)]
    return {part for part, _ in _parameters_used(body, name)}


def address_of(function: Any) -> int | None:
    """Return the address of a function of numba (@cfunc), ctypes or cffi, or an address itself; None for any other."""
    if isinstance(function, int) and not isinstance(function, bool):
        return function
    address = getattr(function, "address", None)
    if isinstance(address, int):
        return address
    loaded = sys.modules.get("_ctypes"), sys.modules.get("_cffi_backend")
    if loaded[0] and isinstance(function, loaded[0].CFuncPtr):
        import ctypes

        value: int | None = ctypes.cast(function, ctypes.c_void_p).value
        return value
    if loaded[1] and isinstance(function, loaded[1].FFI.CData):
        return int(loaded[1].FFI().cast("uintptr_t", function))
    return None
