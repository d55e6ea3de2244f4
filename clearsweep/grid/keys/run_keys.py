"""Keys of a run: saved results of a case (`save`), and its life (`life`)."""

from ...contracts.catalogue import Field
from .joint_keys import add_numbers
from .kinds import NameList, Number, Section, Shape, Use, Word

CHANNELS = "save.channels"
_ORBITS = Word(
    ("none", "last", "all"), "time histories that are saved: none, the last revolutions, or all revolutions", "last"
)
_CHANNELS = NameList(
    "names of the saved time histories besides `t` and `crank_angle`; default: all; with `identify`: the compared ones",
    "a list of names",
    "[slider/a, crank/torque]",
)
_SAMPLES = Field(
    "samples",
    "1",
    "number of samples per revolution; of an impact-pair: per run",
    1,
    1e7,
    low_open=False,
    high_open=False,
    default=720,
    whole=True,
)
_SAVED = Field(
    "revolutions",
    "1",
    "number of revolutions that `last` saves; default: 2, or all if the run has fewer",
    optional=True,
)
_WORST = Field(
    "worst",
    "1",
    "number of cases with a saved peak revolution: those with the largest force_peak_ratio",
    1,
    1000,
    low_open=False,
    high_open=False,
    optional=True,
    whole=True,
)


def add_save_keys(tree: Shape, *, has_turns: bool) -> None:
    """Add the keys for the saved results of a case; if it turns, also those for the saved revolutions."""
    tree["save"], tree["save.orbits"] = Section("results that are stored", "implied"), _ORBITS
    add_numbers(tree, "save", (_SAVED, _SAMPLES, _WORST) if has_turns else (_SAMPLES,), sweep=False)
    tree[CHANNELS] = _CHANNELS


LIFE = "life"
LIFE_OF = ("wear_depth_max", "clearance_growth")
TIME_BUDGET_PATH = "simulate.time_budget"
TIME_BUDGET = Field(
    "time_budget",
    "s",
    "largest process time of a case; unlimited by default with `life`; not part of `case_id`",
    0.0,
    1e9,
    high_open=False,
    default=600.0,
)
_FIELDS = (
    Field("limit", "m", "largest acceptable value of the limited quantity"),
    Field(
        "tolerance",
        "1",
        "largest share of a jump's wear that may be in other bins at its end than at its start; also the required "
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
        "largest number of revolutions of a block, `discard` included",
        0.0,
        1e6,
        high_open=False,
        default=500.0,
    ),
    Field(
        "blocks",
        "1",
        "largest number of blocks",
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
        "largest number of revolutions between two blocks; default: unlimited",
        optional=True,
    ),
)


def add_life_keys(tree: Shape) -> None:
    """Add the keys of `life`, for mechanisms with wear and revolutions."""
    wearing = tuple(path.split(".")[1] for path in tree if path.startswith("joints.") and path.endswith(".wear"))
    if not wearing or "simulate.revolutions" not in tree:
        return
    tree[LIFE] = Section(
        ("life prediction: blocks of revolutions alternate with jumps of wear until a limit is reached"), "optional"
    )
    tree[f"{LIFE}.joint"] = Word(wearing, "joint whose wear is limited; it needs a section `wear`")
    tree[f"{LIFE}.of"] = Word(
        LIFE_OF,
        (
            "limited quantity; wear_depth_max: the depth of the deepest bin of either body; "
            "clearance_growth: the increase of the clearance by wear, the largest over all directions"
        ),
        LIFE_OF[0],
    )
    for field in _FIELDS:
        tree[f"{LIFE}.{field.name}"] = Number((Use(field),), field.name == "limit")
