"""Keys of `save`: which time histories of a case are stored, how many samples of them."""

from ..contracts.catalogue import Field
from ..contracts.layout import ALWAYS_STORED, Layout
from ..language.errors import nearest, shown
from .document import WrittenValue
from .joint_keys import add_numbers
from .keys import NameList, Section, Shape, Word
from .reader import Reader

CHANNELS = "save.channels"
_ORBITS = Word(("none", "last", "all"), "which time histories are saved", "last")
_CHANNELS = NameList(
    "time histories that are stored, with `t` and `crank_angle`; default all, with `identify` those that it compares",
    "a list of names",
    "[slider/a, crank/torque]",
)
_SAMPLES = Field(
    "samples",
    "1",
    "samples per revolution; of an impact-pair: per run",
    1,
    1e7,
    low_open=False,
    high_open=False,
    default=720,
    whole=True,
)
_SAVED = Field(
    "revolutions", "1", "number of last revolutions that `last` saves; default 2, or all if fewer", optional=True
)
_WORST = Field(
    "worst",
    "1",
    "number of cases with the largest force_peak_ratio whose revolution of the largest peak is saved",
    1,
    1000,
    low_open=False,
    high_open=False,
    optional=True,
    whole=True,
)


def enter_save(tree: Shape, *, has_turns: bool) -> None:
    """Enter what is kept of a case; of one that turns also of how many revolutions."""
    tree["save"], tree["save.orbits"] = Section("what is kept", "implied"), _ORBITS
    add_numbers(tree, "save", (_SAVED, _SAMPLES, _WORST) if has_turns else (_SAMPLES,), sweep=False)
    tree[CHANNELS] = _CHANNELS


def read_channels(reader: Reader, path: str) -> None:
    """Read the names of the time histories that are stored; `check_channels` knows which there are."""
    written, node = reader.written.get(path), reader.shape[path]
    if written is None:
        return
    assert isinstance(node, NameList), path
    items = written.value if isinstance(written.value, list) else []
    invalid = [item for item in items if not isinstance(item.value, str)]
    for item in invalid or ([] if items else [written]):
        sentence = f"found {shown(item.value)}; expected {node.noun}, such as {node.example}"
        reader.problems.add(item, path, sentence)
    if invalid or not items:
        return
    if reader.values.get("save.orbits") == "none":
        sentence = "is not used, as save.orbits is none; leave one of them out"
        reader.problems.add(written, path, sentence)
    else:
        reader.values[path] = list(dict.fromkeys(item.value for item in items))


def check_channels(reader: Reader, layout: Layout) -> None:
    """Note names in `save.channels` that no time history of these cases has."""
    written = reader.written.get(CHANNELS)
    if written is None or CHANNELS not in reader.values:
        return
    allowed = [channel.name for channel in layout.channels if channel.name not in ALWAYS_STORED]
    for item in written.value:
        if isinstance(item, WrittenValue) and item.value not in (*allowed, *ALWAYS_STORED):
            suggestion = nearest(item.value, allowed) or f" (known: {', '.join(allowed)})"
            reader.problems.add(item, CHANNELS, f"there is no channel '{item.value}'{suggestion}")
