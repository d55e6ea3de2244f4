"""Keys of a run: saved results of a case (`save`), and its life (`life`)."""

from ...contracts.catalogue import CONDITION, NUMERICS, STARTS, Field, ranged
from . import KeyTable, NameList, Number, Section, Use, Word
from .joint_keys import add_numbers

CHANNELS = "save.channels"
_ORBITS_WORD = Word(
    ("none", "last", "all"), "time histories that are saved: none, the last revolutions, or all revolutions", "last"
)
_CHANNELS_LIST = NameList(
    "names of the saved time histories besides `t` and `crank_angle`; default: all; with `identify`: the compared ones",
    "a list of names",
    "[slider/a, crank/torque]",
)
_SAMPLES_TEXT = "number of samples per revolution; of an impact-pair: per run"
_SAMPLES_FIELD = ranged("samples", "1", _SAMPLES_TEXT, "[1, 1e7]", default=720, integer=True)
_SAVED_REVOLUTIONS_TEXT = "number of revolutions that `last` saves; default: 2, or all if the run has fewer"
_SAVED_REVOLUTIONS_FIELD = Field("revolutions", "1", _SAVED_REVOLUTIONS_TEXT, optional=True)
_WORST_TEXT = "number of cases with a saved peak revolution: those with the largest force_peak_ratio"
_WORST_FIELD = ranged("worst", "1", _WORST_TEXT, "[1, 1000]", optional=True, integer=True)


def add_save_keys(keys: KeyTable, *, has_turns: bool) -> None:
    """Add the keys for the saved results of a case; if it turns, also those for the saved revolutions."""
    keys["save"], keys["save.orbits"] = Section("results that are stored", "implied"), _ORBITS_WORD
    add_numbers(
        keys,
        "save",
        (_SAVED_REVOLUTIONS_FIELD, _SAMPLES_FIELD, _WORST_FIELD) if has_turns else (_SAMPLES_FIELD,),
        NUMERICS,
        sweep=False,
    )
    keys[CHANNELS] = _CHANNELS_LIST


LIFE = "life"
LIMITED_QUANTITIES = ("wear_depth_max", "clearance_growth")
TIME_BUDGET_PATH = "simulate.time_budget"
_TIME_BUDGET_TEXT = "largest process time of a case; unlimited by default with `life`; not part of `case_id`"
TIME_BUDGET_FIELD = ranged("time_budget", "s", _TIME_BUDGET_TEXT, "(0, 1e9]", default=600.0)
_LIFE_TOLERANCE_TEXT = (
    "accuracy of the life, 0.05 for about 5 %; smaller is slower: largest share of a jump's wear that may be in "
    "other bins at its end than at its start; four times the largest error of a profile by a jump, over its final "
    "depth; also the required relative half-width of the 95 % interval of a block's wear rate"
)
_LIFE_FIELDS = (
    Field("limit", "m", "largest acceptable value of the limited quantity"),
    ranged("tolerance", "1", _LIFE_TOLERANCE_TEXT, "[0.0001, 0.5]", default=0.05),
    ranged(
        "max_revolutions",
        "1",
        "largest number of revolutions of a block, `discard` included",
        "(0, 1e6]",
        default=500.0,
    ),
    ranged("blocks", "1", "largest number of blocks", "[2, 1e6]", default=200, integer=True),
    Field("longest_jump", "1", "largest number of revolutions between two blocks; default: unlimited", optional=True),
)


def add_life_keys(keys: KeyTable) -> None:
    """Add the keys of `life`, for mechanisms with wear and revolutions."""
    paths = (path.split(".") for path in keys)
    worn_joints = tuple(parts[1] for parts in paths if parts[0] == "joints" and parts[2:] == ["wear"])
    if not worn_joints or "simulate.revolutions" not in keys:
        return
    keys[LIFE] = Section(
        "life prediction: blocks of revolutions alternate with jumps of wear until a limit is reached", "optional"
    )
    keys[f"{LIFE}.joint"] = Word(worn_joints, "joint whose wear is limited; it needs a section `wear`")
    text = (
        "limited quantity; wear_depth_max: the depth of the deepest bin of either body; "
        "clearance_growth: the increase of the clearance by wear, the largest over all directions"
    )
    keys[f"{LIFE}.of"] = Word(LIMITED_QUANTITIES, text, LIMITED_QUANTITIES[0])
    for field in _LIFE_FIELDS:
        keys[f"{LIFE}.{field.name}"] = Number((Use(field),), CONDITION, field.name == "limit")


START, CARRIED = "simulate.start", "simulate.carried_axis"
DIRECTION, DRAW = STARTS
BRANCHES = ("carried", "random")  # starts of which the grid runs several at each point
_OF_CARRIED, _OF_RANDOM = (((START, frozenset({word})),) for word in BRANCHES)
_DRAW_TEXT = "number of a random start; `start: {random: 32}` sweeps 1 to 32"
_DRAW_FIELD = ranged("draw", "1", _DRAW_TEXT, "[1, 100000]", default=1, integer=True)
_SEED_FIELD = ranged(
    "seed", "1", "a whole number that determines the random starts", "[0, 2147483648]", default=0, integer=True
)
_START_FORMS = (
    {
        "type": "object",
        "required": ["random"],
        "additionalProperties": False,
        "properties": {"random": {"type": "integer", "minimum": 2}, "seed": {"type": "integer", "minimum": 0}},
    },
    {
        "type": "object",
        "required": ["carried"],
        "additionalProperties": False,
        "properties": {"carried": {"type": "string"}},
    },
)


def add_start_keys(keys: KeyTable) -> None:
    """Add the keys that say where journals start, for mechanisms that turn."""
    text = (
        "initial position of the journals in their bearings; seated: in contact; carried: as the case before it ended, "
        "up and down one axis, or {carried: PATH}; {random: N, seed: S}: N random positions and rates"
    )
    keys[START] = Word(("centred", "seated", *BRANCHES), text, "centred", other_forms=_START_FORMS)
    keys[CARRIED] = Word(("",), "the axis along which the state is carried", "", when=_OF_CARRIED, may_be_unused=True)
    text = "direction of the carried axis; both are swept unless one is written"
    keys[DIRECTION] = Word(("up", "down"), text, "up", sweep=True, when=_OF_CARRIED, role=CONDITION)
    keys[DRAW] = Number((Use(_DRAW_FIELD, _OF_RANDOM),), CONDITION)
    keys["simulate.seed"] = Number((Use(_SEED_FIELD, _OF_RANDOM),), NUMERICS, sweep=False)
