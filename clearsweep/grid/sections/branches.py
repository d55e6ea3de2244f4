"""Coexisting motions: the axes that `simulate.start: carried` and `{random: N}` add, and what refuses them."""

from contextlib import suppress
from dataclasses import replace
from typing import Any

from ...language import quantity
from ...language.errors import InputError, did_you_mean, quoted
from ..keys.kinds import KeyTable, Number, word_key
from ..keys.run_keys import BRANCHES, CARRIED, DIRECTION, DRAW, LIFE, START
from ..written.document import Problems, WrittenValue
from .reader import Reader

_FORMS = "{random: 32, seed: 1} or {carried: drive.speed}"
_MOST_DRAWS = 100_000


def with_branch_axes(root: WrittenValue, problems: Problems) -> WrittenValue:
    """Return a document in which the start of the motion is a word, and the starts of each point are an axis."""
    simulate = root.value.get("simulate")
    settings = simulate.value if simulate is not None and isinstance(simulate.value, dict) else {}
    start = settings.get("start")
    if start is None:
        return root
    if isinstance(start.value, dict):
        settings = {**settings, **_settings_of(start, settings, problems)}
        root = _with(root, "simulate", replace(simulate, value=settings))
    word, sweep = settings["start"].value, root.value.get("sweep", WrittenValue({}, start.origin))
    if word not in BRANCHES or not isinstance(sweep.value, dict):
        return root
    path = DIRECTION if word == "carried" else DRAW
    if path.rpartition(".")[2] in settings or path in sweep.value:
        return root
    values = ["up", "down"] if word == "carried" else range(1, 1 + (_count(settings.get("random")) or 1))
    items = [WrittenValue(value, start.origin, start.line, start.column) for value in values]
    axis = WrittenValue(items, start.origin, start.line, start.column)
    root = _with(root, "simulate", replace(simulate, value={k: v for k, v in settings.items() if k != "random"}))
    return _with(root, "sweep", replace(sweep, value={**sweep.value, path: axis})) if len(items) > 1 else root


def _settings_of(start: WrittenValue, settings: dict[str, Any], problems: Problems) -> dict[str, Any]:
    """Return the keys of `simulate` that a start written as a section means; report an invalid one."""
    allowed = {"random": ("random", "seed"), "carried": ("carried",)}
    word = next((word for word in BRANCHES[::-1] if word in start.value), "")
    wrong = [key for key in start.value if key not in allowed.get(word, ())]
    plain = {"start": replace(start, value="centred")}
    if not word or wrong:
        fault = f"unknown key '{wrong[0]}'" if wrong else "found an empty section"
        problems.add(start, START, f"{fault}; expected {_FORMS}")
        return plain
    written = {"carried_axis" if key == "carried" else key: value for key, value in start.value.items()}
    if clash := [key for key in written if key in settings]:
        problems.add(start, START, f"conflicts with simulate.{clash[0]}, which says the same; remove one of the two")
        return plain
    if word == "random" and _count(start.value["random"]) is None:
        count = start.value["random"]
        message = f"found {quoted(count.value)}; expected a whole number from 2 to {_MOST_DRAWS}"
        problems.add(count, f"{START}.random", message)
        return plain
    return {**written, "start": replace(start, value=word)}


def _count(written: WrittenValue | None) -> int | None:
    """Return the number of random starts, None for anything but a whole number in range."""
    with suppress(InputError):
        number = quantity.read(written.value, "1") if written is not None else 0.0
        if number == int(number) and 2 <= number <= _MOST_DRAWS:
            return int(number)
    return None


def _with(root: WrittenValue, name: str, section: WrittenValue) -> WrittenValue:
    return replace(root, value={**root.value, name: section})


def with_carried_paths(keys: KeyTable, varied: list[str]) -> None:
    """Let `simulate.carried_axis` name any varied quantity, except numerical settings."""
    if CARRIED in keys:
        physical = [path for path in varied if isinstance(keys.get(path), Number) and not path.startswith("simulate.")]
        keys[CARRIED] = word_key(keys, CARRIED)._replace(options=tuple(physical))


def check_branches(reader: Reader, root: WrittenValue) -> None:
    """Report what cannot be combined with carried or random starts, and find the axis that is carried."""
    word = reader.values.get(START)
    if word not in BRANCHES:
        return
    position = reader.position_of(START)

    def refuse(reason: str) -> None:
        reader.problems.add(position, START, f"{word} {reason}")

    if not reader.values_of("drive.speed") or "drive.speed" in reader.sections:
        refuse("needs a drive of constant speed: without it no two cases pass the same angles at the same times")
    if "simulate.revolutions" in reader.values and any(
        value != int(value) for value in reader.values_of("simulate.revolutions")
    ):
        refuse("needs a whole number of revolutions, so that every case begins at the angle at which another ends")
    for path, reason in _REFUSED_SECTIONS.items():
        if path in reader.keys_in_use and reader.is_given(path):
            refuse(f"conflicts with {path}: {reason}; remove one of the two")
    for path in reader.keys_in_use:
        if (reason := _refusal_of(reader, path, word)) and reader.is_given(path):
            refuse(f"conflicts with {path}: {reason}")
            break
    sections = [name for name in reader.searches if name in root.value]
    sections += ["sample"] if "sample" in root.value else []
    for name in sections:
        refuse(f"conflicts with `{name}`, which would judge every start as a case of its own; sweep values instead")
    if word == "carried":
        for path in reader.keys_in_use:
            if path.startswith("loads.") and any("time" in v for v in reader.values_of(path) if isinstance(v, dict)):
                refuse(f"conflicts with {path}: a load over time begins again in every case; write it over crank_angle")
        _find_carried(reader, refuse)


_REFUSED_SECTIONS = {
    "simulate.until": "starts are compared over equal windows",
    LIFE: "a life follows one motion",
    "simulate.horizon": "its second run has another start",
    "simulate.cycles": "a case ends after whole revolutions",
    "simulate.time": "a case ends after whole revolutions",
}
#: Last keys of paths in a joint, a body or a load -> why they conflict with either start.
_REFUSED_KEYS = {
    "evolve": "a surface that wears has a history of its own; leave `evolve` out",
    "profile": "the room in which its journal starts is no circle; leave `profile` out",
    "thermal": "a temperature is that of one motion; give `temperature` or leave `thermal` out",
    "height": "only pins, gears and couplings have such a start, no guides",
    "slot_length": "only pins, gears and couplings have such a start, no slots",
    "element_diameter": "only plain pins, gears and couplings have such a start, no rolling bearings",
}


def _refusal_of(reader: Reader, path: str, word: str) -> str:
    """Return why a written key conflicts with a start, '' if it does not."""
    parts = path.split(".")
    if parts[0] == "joints" and parts[-1] in _REFUSED_KEYS:
        return _REFUSED_KEYS[parts[-1]]
    if parts[0] == "mechanism" and parts[-1] in ("initial", "elastic") and (word == "random" or parts[-1] == "elastic"):
        why = {"initial": "it says where the body starts", "elastic": "an elastic link has a state of its own"}
        return f"{why[parts[-1]]}; remove one of the two"
    if parts[0] == "loads" and parts[-1] in ("torsional_stiffness", "torsional_damping"):
        return "a body that only a torsion spring reaches has no position in a play"
    return ""


def _find_carried(reader: Reader, refuse: Any) -> None:
    """Find the axis along which the state is carried, or report that there is none or more than one."""
    axes = {
        path: values
        for path, values in reader.axes.items()
        if len(values) > 1 and not isinstance(values[0], str) and not path.startswith("simulate.")
    }
    swept = [path for path in axes if reader.varied_by[path] == "sweep"]
    named = reader.values.get(CARRIED, "")
    others = [path for path in axes if reader.varied_by[path] != "sweep"]
    if named and named not in swept:
        refuse(f"names {named}, which `sweep` does not vary{did_you_mean(named, swept)}; sweep two values or more")
    elif not named and not swept:
        place = f": {others[0]} is under `{reader.varied_by[others[0]]}`" if others else ""
        example = "such as drive.speed: [500 rpm, 600 rpm]"
        refuse(f"needs a quantity with two values or more under `sweep`{place}; {example}")
    elif not named and len(swept) > 1:
        written = " or ".join(f"{{carried: {path}}}" for path in swept[:2])
        refuse(f"does not say along which of {', '.join(swept)}; write start: {written}")
    else:
        reader.values[CARRIED] = named or swept[0]
