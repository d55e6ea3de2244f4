"""The keys of `life`: its limit, the accuracy of its extrapolation, and the checks against other keys."""

from ..contracts.catalogue import Field
from .keys import Number, Section, Shape, Use, Word
from .reader import Reader

LIFE = "life"
OF = ("wear_depth_max", "clearance_growth")
SHALLOW = 0.1  # of the bearing radius; deeper wear is no longer a small change of shape
WHOLE = 1e-9  # revolutions; tolerance on a whole number of them
_PATH = "simulate.time_budget"
TIME_BUDGET = Field(
    "time_budget",
    "s",
    "most process time of a case; not part of `case_id`; none with `life` unless it is written",
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
        "largest share of a jump's wear that the wear rates before and after it may distribute differently; also the "
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
    Field("longest_jump", "1", "most revolutions from one block to the next; left out: no bound", optional=True),
)


def add_keys(tree: Shape) -> None:
    """Add the section to mechanisms with wear and revolutions."""
    wearing = tuple(path.split(".")[1] for path in tree if path.startswith("joints.") and path.endswith(".wear"))
    if not wearing or "simulate.revolutions" not in tree:
        return
    tree[LIFE] = Section("wear on until a limit is reached, by jumps from block to block of revolutions", "optional")
    tree[f"{LIFE}.joint"] = Word(wearing, "the joint that is judged; it needs `wear`")
    tree[f"{LIFE}.of"] = Word(
        OF,
        "the depth of the deepest bin of either body, or the largest increase of the eccentricity at first touch",
        OF[0],
    )
    for field in _FIELDS:
        tree[f"{LIFE}.{field.name}"] = Number((Use(field),), field.name == "limit")


def put_patience(reader: Reader) -> None:
    """Set the default of `patience` from the time budget of a case with a life."""
    if LIFE in reader.shape and _PATH in reader.shape:
        field = TIME_BUDGET._replace(default=None, optional=True)
        reader.shape[_PATH] = Number((Use(field),), sweep=False)


def check(reader: Reader) -> None:
    """Report keys that conflict with `life`."""
    if LIFE not in reader.shape:
        return
    joint = reader.values.get(f"{LIFE}.joint")
    if joint is not None:
        _joint(reader, str(joint))
    for path, reason in (
        ("simulate.until", "a life makes its blocks as long as the wear rate needs"),
        ("simulate.error_check", "a life gives its own error, in the interval of its revolutions"),
        ("save.worst", "the largest peak of a life is that of one of many blocks, and its history gives of all"),
    ):
        if path in reader.sections or path in reader.values:
            reader.problems.add(reader.place(path), path, f"has no effect with `life`: {reason}; leave it out")
    _blocks(reader)
    _repeats(reader)


def _joint(reader: Reader, joint: str) -> None:
    """Check that the limited joint wears, and that its limit is a small change of shape."""
    path, joint_ = f"{LIFE}.joint", f"joints.{joint}"
    if joint_ not in reader.shape:
        wearing = [name.split(".")[1] for name in reader.shape if name.startswith("joints.") and name.endswith(".wear")]
        remedy = f"name one that wears ({', '.join(wearing)})" if wearing else "give it clearance and wear"
        reader.problems.add(reader.place(path), path, f"{joint} has no clearance here; {remedy}")
        return
    if f"{joint_}.wear" not in reader.shape:
        sentence = (
            "is missing; a life needs the wear of the joint that it judges; for example: {law: archard, coefficient: "
            "2e-14 m^2/N}"
        )
        reader.problems.add(reader.place(path), f"{joint_}.wear", sentence)
    limits, radii = reader.reached(f"{LIFE}.limit"), reader.reached(f"{joint_}.bearing_radius")
    if limits and radii and max(limits) > SHALLOW * min(radii):
        path = f"{LIFE}.limit"
        sentence = (
            f"found {reader.said(path, max(limits))}; allowed: at most {SHALLOW:g} of {joint_}.bearing_radius, "
            f"{reader.said(f'{joint_}.bearing_radius', min(radii))}: what is worn is to be a small change of the shape"
        )
        reader.problems.add(reader.place(path), path, sentence)


def _blocks(reader: Reader) -> None:
    """Check that blocks are whole revolutions, and that the longest is not below the shortest."""
    path = f"{LIFE}.max_revolutions"
    lowest, total = reader.reached("simulate.revolutions"), reader.reached(path)
    if lowest and total and min(total) < max(lowest):
        sentence = (
            f"found {reader.said(path, min(total))}; allowed: at least "
            f"{reader.said('simulate.revolutions', max(lowest))}, the value of simulate.revolutions, the shortest block"
        )
        reader.problems.add(reader.place(path), path, sentence)
    discards = reader.reached("simulate.discard") or (2.0,)
    for revolutions in lowest:
        for discard in discards:
            window = revolutions - (discard if revolutions > 2.0 or reader.there("simulate.discard") else 0.0)
            if abs(window - round(window)) > WHOLE or round(window) < 1:
                where = "simulate.revolutions"
                sentence = (
                    f"found {window:.6g} revolutions after simulate.discard; with life they have to be a whole number, "
                    "as what wears off in them is taken for that of all"
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
