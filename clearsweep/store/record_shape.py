"""Validation of run.json: its checksum proves integrity, but not that `clearsweep run` wrote it.

A results directory may be untrusted, so run.json is validated like a grid before it is used: names become
names of files, texts appear in pages and tables.
"""

import re
from collections.abc import Callable, Iterable
from typing import Any

from ..contracts.layout import Column, JointLayout, Layout
from ..grid import Fit

LONGEST = 10_000  # characters of a text
LARGEST = 10**300  # largest integer that a float represents
DEEPEST = 20  # nesting of sections
_CONTROL = re.compile("[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]")  # including line ends and bidirectional marks

Check = Callable[[Any, str], None]  # (value, where it is); raises MisshapenError


class MisshapenError(Exception):
    """Content of run.json that `clearsweep run` does not write; the text states key, value and what was expected."""


def check(record: dict[str, Any]) -> None:
    """Raise MisshapenError if the content of a run.json cannot have been written by `clearsweep run`."""
    _plain(record, "")
    _sections(_REQUIRED, _OPTIONAL)(record, "")
    columns = {column["name"] for column in record["layout"]["columns"]} | record.get("figures", {}).keys()
    limits = record.get("limits", {})
    times = [limit["times"] for limit in limits.values() if isinstance(limit, dict) and "times" in limit]
    for kind, names, available in (("keys", record["keys"], record.keys()), ("limits", [*limits, *times], columns)):
        unknown = [name for name in names if name not in available]
        if unknown:
            raise MisshapenError(f"{kind} names {unknown[0]!r}, which is missing")


def _refused(path: str, value: Any, expected: str) -> MisshapenError:
    actual = repr(value)
    return MisshapenError(f"{path or 'it'} is {actual if len(actual) <= 60 else actual[:57] + '...'}, not {expected}")


def _plain(value: Any, path: str, depth: int = 0) -> None:
    """Check that all texts, keys included, have one line and that the nesting of sections is limited."""
    if depth > DEEPEST:
        raise MisshapenError(f"{path} is nested too deeply")
    if isinstance(value, str):
        if len(value) > LONGEST or _CONTROL.search(value):
            raise _refused(path, value, f"a line of at most {LONGEST} characters")
    elif isinstance(value, list):
        for item in value:
            if not isinstance(item, int | float):  # shortcut for long axes
                _plain(item, path, depth + 1)
    elif isinstance(value, dict):
        for key, item in value.items():
            _plain(key, path, depth + 1)
            _plain(item, f"{path}.{key}" if path else key, depth + 1)


def _of(kinds: type | tuple[type, ...], expected: str) -> Check:
    """Return a check of the type of a value; a bool is no number."""

    def checked(value: Any, path: str) -> None:
        flag = isinstance(value, bool)
        if not isinstance(value, kinds) or (flag and kinds is not bool):
            raise _refused(path, value, expected)

    return checked


def _text(pattern: str, expected: str, flags: re.RegexFlag = re.ASCII) -> Check:
    """Return a check that a value is text of a form."""
    result_schema = re.compile(pattern, flags)

    def checked(value: Any, path: str) -> None:
        if not isinstance(value, str) or not result_schema.fullmatch(value):
            raise _refused(path, value, expected)

    return checked


def _either(*checks: Check) -> Check:
    """Return a check that passes if one of some checks passes; the error is that of the last one."""

    def checked(value: Any, path: str) -> None:
        for check in checks[:-1]:
            try:
                return check(value, path)
            except MisshapenError:
                continue
        return checks[-1](value, path)

    return checked


def _list(check_item: Check) -> Check:
    """Return a check of a list, item by item."""

    def checked(value: Any, path: str) -> None:
        _of(list, "a list")(value, path)
        for index, item in enumerate(value):
            check_item(item, f"{path}[{index}]")

    return checked


def _by(key: Check, check_item: Check) -> Check:
    """Return a check of a section whose keys are chosen freely."""

    def checked(value: Any, path: str) -> None:
        _of(dict, "a section")(value, path)
        for name, item in value.items():
            key(name, f"a key of {path}")
            check_item(item, f"{path}.{name}")

    return checked


def _sections(required: dict[str, Check], optional: dict[str, Check]) -> Check:
    """Return a check of a section with some keys; other keys are not checked."""

    def checked(value: Any, path: str) -> None:
        _of(dict, "a section")(value, path)
        for name, check_key in (required | optional).items():
            key_path = f"{path}.{name}" if path else name
            if name in value:
                check_key(value[name], key_path)
            elif name in required:
                raise MisshapenError(f"{key_path} is missing")

    return checked


def _fields(kind: Any, checks: dict[str, Check]) -> Check:
    """Return a check of a section written from a NamedTuple: it has all fields without a default, and no others."""
    required = {name: checks[name] for name in kind._fields if name not in kind._field_defaults}
    check_section = _sections(required, {name: checks[name] for name in kind._field_defaults})

    def checked(value: Any, path: str) -> None:
        check_section(value, path)
        unknown = [name for name in value if name not in kind._fields]
        if unknown:
            raise MisshapenError(f"{path}.{unknown[0]} is unknown")

    return checked


def _anything(value: Any, path: str) -> None:
    """Accept any value."""


def _lists_of_values(value: Any, path: str) -> None:
    _of(list, "a list")(value, path)
    nested = next((item for item in value if isinstance(item, list | dict)), None)
    if nested is not None:
        raise _refused(path, nested, "a number or a word")


def _number(value: Any, path: str) -> None:
    _of((int, float), "a number")(value, path)
    if isinstance(value, int) and abs(value) > LARGEST:
        raise _refused(path, value, "a number")


def _some(*names: str) -> Iterable[str]:
    return names


_NAME = _text(r"[A-Za-z_]\w{0,199}", "a name of letters, digits and _")
_NAME_OR_NONE = _text(r"([A-Za-z_]\w{0,199})?", "a name of letters, digits and _")
_WORD = _text(r"[A-Za-z_][\w-]{0,199}", "a name of letters, digits, - and _")
_WORD_OR_NONE = _text(r"([A-Za-z_][\w-]{0,199})?", "a name of letters, digits, - and _")
_CHANNEL = _text(r"[\w-]{1,99}(/[\w-]{1,99}){0,9}", "names of letters, digits, - and _ with / between")
_PATH = _text(r"[\w-]{1,99}(\.[\w-]{1,99}){0,19}", "a dotted path of a grid")
_UNIT = _text(r"[A-Za-z0-9*/^().+% -]{0,99}", "a unit")
_TEXT = _of(str, "text")
_FLAG = _of(bool, "true or false")
_NUMBER = _number
_COUNT = _of(int, "a whole number")
_NOTHING = _of(type(None), "null")
_SECTION = _of(dict, "a section")
_CHECKSUM = _text(r"[0-9a-f]{1,64}", "a checksum")
_DIGESTS = _by(_text(r"mark|[a-z]+\.(parquet|h5)", "the name of a file of results"), _CHECKSUM)
_LISTED = _by(_PATH, _lists_of_values)
_COLUMN = _TEXT  # of a user's own figures: any identifier, checked where it is read
_BOUND = _either(_sections({}, {"at_most": _NUMBER, "at_least": _NUMBER, "times": _COLUMN}), _NUMBER)
_JOINT = {name: {str: _NAME, int: _COUNT, bool: _FLAG}[kind] for name, kind in JointLayout.__annotations__.items()}
_KINDS = _text("float|int|text", "float, int or text")
_GIVEN = {"unit": _UNIT, "description": _TEXT, "kind": _KINDS, "figure": _NAME_OR_NONE, "joint": _NAME_OR_NONE}
_GIVEN["null"] = _text("|nothing|endless", "nothing or endless")
_LAYOUT = {
    "mechanism": _WORD,
    "output": _WORD_OR_NONE,
    "joints": _list(_fields(JointLayout, _JOINT)),
    "columns": _list(_fields(Column, _GIVEN | {"name": _NAME})),
    "channels": _list(_fields(Column, _GIVEN | {"name": _CHANNEL})),
    "until": _NAME_OR_NONE,
    "life": _NAME_OR_NONE,
    "frictions": _list(_NAME),
    "listed": _list(_CHANNEL),
    **dict.fromkeys(_some("turns", "horizon", "error_check"), _FLAG),
}
_SPAN = _sections({"unit": _UNIT, "min": _NUMBER, "max": _NUMBER}, {})
_FIT = _fields(Fit, {"name": _TEXT, **dict.fromkeys(_some("diameter", "low", "mean", "high"), _NUMBER)})
_PART = _sections({}, {"law": _WORD, "elastic": _WORD, "exponent": _NUMBER, "pressure": _WORD})
_FITTED = {**dict.fromkeys(_some("channel", "kind", "feature"), _TEXT), "unit": _UNIT}
_FITTED |= dict.fromkeys(_some("measured", "computed", "deviations"), _NUMBER)
_READ = {"file": _TEXT, "channel": _TEXT, "revolutions": _COUNT, "speed": _either(_NOTHING, _NUMBER)}
_READ |= dict.fromkeys(_some("samples", "orders", "angle"), _NUMBER) | {"noise": _list(_NUMBER)}
_FOUND = {"path": _PATH, "determined": _text("well|weakly|not", "well, weakly or not"), "ends": _list(_WORD)}
_FOUND |= dict.fromkeys(_some("value", "low", "high"), _NUMBER)
_IDENTIFIED = _sections(
    {
        "parameters": _list(_sections(_FOUND, {})),
        "traded": _list(_list(_either(_PATH, _NUMBER))),
        "fits": _list(_sections(_FITTED, {})),
        "signals": _list(_sections(_READ, {})),
        "misfit": _NUMBER,
        "explained": _FLAG,
        **dict.fromkeys(_some("looked_at", "finished"), _COUNT),
        "computed_speed": _NUMBER,
        "priors": _sections({"gain": _NUMBER, "noise": _list(_NUMBER)}, {}),
    },
    {},
)
_NUMBER_OR_NONE = _either(_NOTHING, _NUMBER)
_BEST = _sections(
    {
        "point": _by(_PATH, _either(_NOTHING, _TEXT, _FLAG, _NUMBER)),
        "value": _NUMBER,
        "margin": _NUMBER_OR_NONE,
        "needed": _by(_COLUMN, _TEXT),
        **dict.fromkeys(_some("fit", "limiting"), _either(_NOTHING, _TEXT)),
    },
    {},
)
_EFFECT = {"path": _PATH, "unit": _UNIT, "value": _NUMBER, "margin": _NUMBER}
_EFFECT |= dict.fromkeys(_some("lower", "upper"), _NUMBER_OR_NONE)
_NEAREST = {"best": _list(_BEST), "needed": _by(_COLUMN, _TEXT), "effects": _list(_sections(_EFFECT, {}))}
_NEAREST["furthest"] = _either(_NOTHING, _sections({"point": _SECTION, "value": _NUMBER, "margin": _NUMBER}, {}))
_REQUIRED: dict[str, Check] = {
    "frame": _SECTION,
    "keys": _list(_WORD),
    "layout": _fields(Layout, _LAYOUT),
    "units": _by(_PATH, _UNIT),
}
_OPTIONAL: dict[str, Check] = {
    "name": _text(r"\w[\w .+-]{0,99}", "the name of a run", re.UNICODE),
    "mechanism": _sections({"type": _WORD}, {"ideal": _by(_WORD, _WORD)}),
    **dict.fromkeys(_some("drive", "loads", "simulate", "save", "refine"), _SECTION),
    "life": _sections({}, {"limit": _NUMBER, "of": _WORD, "joint": _WORD}),
    "joints": _by(_WORD, _sections({}, dict.fromkeys(("contact", "friction", "wear", "film", "roughness"), _PART))),
    **dict.fromkeys(_some("sweep", "zip", "cases"), _LISTED),
    "sample": _sections({"method": _WORD, "drawn": _LISTED}, {"seed": _COUNT}),
    "check_laws": _either(_FLAG, _SECTION),
    "limits": _by(_COLUMN, _BOUND),
    "figures": _by(_COLUMN, _TEXT),
    "seek": _sections({}, {**dict.fromkeys(_some("largest", "smallest"), _either(_PATH, _list(_PATH))), "for": _WORD}),
    "optimise": _sections(
        {"over": _by(_PATH, _anything)}, dict.fromkeys(_some("minimise", "maximise"), _list(_COLUMN))
    ),
    "identify": _sections({"over": _by(_PATH, _anything)}, {}),
    "identified": _either(_NOTHING, _IDENTIFIED),
    "nearest": _sections(_NEAREST, {}),
    "define": _by(_NAME, _TEXT),
    "source": _either(_TEXT, _NOTHING),
    "fits": _by(_PATH, _list(_FIT)),
    "labels": _by(_PATH, _by(_TEXT, _NUMBER)),
    "written_units": _by(_PATH, _sections({"unit": _TEXT, "factor": _NUMBER, "offset": _NUMBER}, {})),
    "seeds": _SECTION,
    "versions": _by(_WORD, _TEXT),
    "machine": _SECTION,
    **dict.fromkeys(_some("start", "end"), _either(_TEXT, _NOTHING)),
    "counts": _by(_WORD, _COUNT),
    "merged": _DIGESTS,
    "blocks": _sections({"size": _COUNT, "count": _COUNT, "numbers": _list(_COUNT)}, {}),
    "answers": _DIGESTS,
    "derived": _by(_TEXT, _SPAN),
    "warnings": _list(_TEXT),
    "shard": _either(_NOTHING, _text(r"\d{1,9}/\d{1,9}", "a shard such as 2/8")),
    "joined": _list(_TEXT),
}
