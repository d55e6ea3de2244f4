"""Keys of a run: what is saved of a case (`save`), and its life (`life`)."""

from ...contracts.catalogue import Field
from ...contracts.layout import ALWAYS_STORED, Layout
from ...language.errors import nearest, shown
from ..reading.reader import Reader
from ..written.document import WrittenValue
from .joint_keys import add_numbers
from .kinds import NameList, Number, Section, Shape, Use, Word

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


def add_save_keys(tree: Shape, *, has_turns: bool) -> None:
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


LIFE = "life"
LIFE_OF = ("wear_depth_max", "clearance_growth")
SHALLOW = 0.1  # of the bearing radius; deeper wear is no longer a small change of shape
WHOLE = 1e-9  # revolutions; tolerance on a whole number of them
_PATH = "simulate.time_budget"
TIME_BUDGET = Field(
    "time_budget",
    "s",
    "largest process time of a case; not part of `case_id`; no default with `life`",
    0.0,
    1e9,
    high_open=False,
    default=600.0,
)
_FIELDS = (
    Field("limit", "m", "largest acceptable value of `of`"),
    Field(
        "tolerance",
        "1",
        "largest share of a jump's wear whose position may differ between the wear rates before and after it; also the "
        "relative half-width of the 95 % interval of a block's wear rate",
        1e-4,
        0.5,
        low_open=False,
        high_open=False,
        default=0.05,
    ),
    Field(
        "max_revolutions",
        "1",
        "most revolutions of a block, `discard` included",
        0.0,
        1e6,
        high_open=False,
        default=500.0,
    ),
    Field(
        "blocks",
        "1",
        "most blocks of revolutions",
        2,
        1e6,
        low_open=False,
        high_open=False,
        default=200,
        whole=True,
    ),
    Field(
        "longest_jump",
        "1",
        "largest number of revolutions from one block to the next; default: unlimited",
        optional=True,
    ),
)


def add_life_keys(tree: Shape) -> None:
    """Add the section to mechanisms with wear and revolutions."""
    wearing = tuple(path.split(".")[1] for path in tree if path.startswith("joints.") and path.endswith(".wear"))
    if not wearing or "simulate.revolutions" not in tree:
        return
    tree[LIFE] = Section("wear on until a limit is reached, by jumps from block to block of revolutions", "optional")
    tree[f"{LIFE}.joint"] = Word(wearing, "the joint whose wear is limited; it needs `wear`")
    tree[f"{LIFE}.of"] = Word(
        LIFE_OF,
        "the depth of the deepest bin of either body, or the largest increase of the eccentricity at first touch",
        LIFE_OF[0],
    )
    for field in _FIELDS:
        tree[f"{LIFE}.{field.name}"] = Number((Use(field),), field.name == "limit")


def put_time_budget(reader: Reader) -> None:
    """Set the default of `patience` from the time budget of a case with a life."""
    if LIFE in reader.shape and _PATH in reader.shape:
        field = TIME_BUDGET._replace(default=None, optional=True)
        reader.shape[_PATH] = Number((Use(field),), sweep=False)


def check_life(reader: Reader) -> None:
    """Report keys that conflict with `life`."""
    if LIFE not in reader.shape:
        return
    joint = reader.values.get(f"{LIFE}.joint")
    if joint is not None:
        _limited_joint(reader, str(joint))
    for path, reason in (
        ("simulate.until", "a life makes its blocks as long as the wear rate needs"),
        ("simulate.error_check", "a life gives its own error, in the interval of its revolutions"),
        ("save.worst", "a life has many blocks; its history contains the peak of each"),
    ):
        if path in reader.sections or path in reader.values:
            reader.problems.add(reader.place(path), path, f"has no effect with `life`: {reason}; leave it out")
    _blocks(reader)
    _repeats(reader)


def _limited_joint(reader: Reader, joint: str) -> None:
    """Check that the limited joint wears, and that its limit is a small change of shape."""
    path, own = f"{LIFE}.joint", f"joints.{joint}"
    if own not in reader.shape:
        wearing = [name.split(".")[1] for name in reader.shape if name.startswith("joints.") and name.endswith(".wear")]
        some = f"name one that wears ({', '.join(wearing)})" if wearing else "give it clearance and wear"
        reader.problems.add(reader.place(path), path, f"{joint} has no clearance here; {some}")
        return
    if f"{own}.wear" not in reader.shape:
        sentence = "is missing; life needs the wear of its joint; for example: {law: archard, coefficient: 2e-14 m^2/N}"
        reader.problems.add(reader.place(path), f"{own}.wear", sentence)
    limits, radii = reader.values_of(f"{LIFE}.limit"), reader.values_of(f"{own}.bearing_radius")
    if limits and radii and max(limits) > SHALLOW * min(radii):
        path = f"{LIFE}.limit"
        sentence = (
            f"found {reader.text(path, max(limits))}; allowed: at most {SHALLOW:g} of {own}.bearing_radius, "
            f"{reader.text(f'{own}.bearing_radius', min(radii))}: wear must remain a small change of the shape"
        )
        reader.problems.add(reader.place(path), path, sentence)


def _blocks(reader: Reader) -> None:
    """Check that blocks are whole revolutions, and that the longest is not below the shortest."""
    path = f"{LIFE}.max_revolutions"
    least, most = reader.values_of("simulate.revolutions"), reader.values_of(path)
    if least and most and min(most) < max(least):
        sentence = (
            f"found {reader.text(path, min(most))}; allowed: at least "
            f"{reader.text('simulate.revolutions', max(least))}, the value of simulate.revolutions, the shortest block"
        )
        reader.problems.add(reader.place(path), path, sentence)
    discards = reader.values_of("simulate.discard") or (2.0,)
    for turns in least:
        for discard in discards:
            window = turns - (discard if turns > 2.0 or reader.is_given("simulate.discard") else 0.0)
            if abs(window - round(window)) > WHOLE or round(window) < 1:
                where = "simulate.revolutions"
                sentence = (
                    f"found {window:.6g} revolutions after simulate.discard; with life the number must be whole, "
                    "as their wear is extrapolated to all revolutions"
                )
                reader.problems.add(reader.place(where), where, sentence)
                return


def _repeats(reader: Reader) -> None:
    """Check that drive and loads repeat every revolution."""
    tables = {path: values for path, values in reader.values.items() if isinstance(values, dict)}
    for path, table in tables.items():
        if path.startswith(("drive.", "loads.")) and "time" in table:
            sentence = (
                "depends on time, but `life` assumes a periodic drive: write a table over "
                "crank_angle, or a constant speed"
            )
            reader.problems.add(reader.place(path), path, sentence)
