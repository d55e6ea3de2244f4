"""The key table of grid files: every key with its unit, range, default and meaning."""

from ...contracts.catalogue import Catalogue, Field, JointSite, Keys, Mechanism, sized
from ...contracts.layout import settling
from ...contracts.outline import ANY
from ..library import PAIRS
from .joint_keys import (
    ALONG,
    add_contact,
    add_film,
    add_friction,
    add_laws,
    add_numbers,
    add_preload,
    add_roughness,
    add_thermal,
    first_onset,
    flanged,
    moduli,
    point_laws,
    through,
)
from .kinds import ConditionalDefault, Flag, Name, Number, Section, Shape, Table, Use, Word, word_key
from .library_names import LAW, PAIR
from .run_keys import TIME_BUDGET, add_life_keys, add_save_keys

DIMENSIONLESS = "dimensionless"
_COEFFICIENT = Field(
    "coefficient",
    "m^2/N",
    "wear coefficient of both bodies: depth per pressure and sliding distance; with `energy`: volume per work, m^3/J",
    low_open=False,
    optional=True,
)
_WEAR = (
    _COEFFICIENT,
    _COEFFICIENT._replace(name="bearing_coefficient", text="wear coefficient of the bearing; overrides `coefficient`"),
    _COEFFICIENT._replace(name="journal_coefficient", text="wear coefficient of the journal; overrides `coefficient`"),
)
_RUNNING_IN = (
    _COEFFICIENT._replace(name="initial", text="initial wear coefficient of both bodies"),
    _COEFFICIENT._replace(name="steady", text="steady wear coefficient of both bodies; another name for `coefficient`"),
    _COEFFICIENT._replace(name="bearing_initial", text="initial wear coefficient of the bearing; overrides `initial`"),
    _COEFFICIENT._replace(name="journal_initial", text="initial wear coefficient of the journal; overrides `initial`"),
)
_DISTANCE = Field(
    "distance", "m", "sliding distance over which the difference from the steady coefficient falls by a factor e"
)
_HARDNESS = Field(
    "hardness",
    "Pa",
    "hardness of the softer body; it checks a coefficient, or converts a bare number into a coefficient",
    optional=True,
)
_PV_LIMIT = Field(
    "pv_limit",
    "W/m^2",
    "largest allowed product of pressure and sliding speed in the bearing; the run measures the time above it",
    optional=True,
)
_BINS = Field(
    "bins",
    "1",
    "number of angular bins around each body",
    8,
    1e6,
    low_open=False,
    high_open=False,
    default=360,
    whole=True,
)
_LENGTH_BINS = _BINS._replace(name="length_bins", text="number of bins along each body", low=1, high=1000, default=20)
_LENGTH_OF_PIN = Field(
    "length", "m", "length of the joint along the pin; wear and the laws of cylinders need it", optional=True
)
_GAP_SIZES = (
    Field("bearing_radius", "m", "radius of the bearing; the laws of cylinders need it", optional=True),
    _LENGTH_OF_PIN,
)
_GUIDE = (
    Field("clearance", "m", "clearance between the block and each wall, with the block in the middle"),
    Field("length", "m", "length of the block along the guide"),
    Field("height", "m", "height of the block across the guide"),
)
_SLOT = (
    Field("clearance", "m", "clearance between the pin and each wall, with the pin in the middle"),
    Field("bearing_radius", "m", "half the width of the slot; the radius of the pin is smaller by the clearance"),
    Field("slot_length", "m", "length of the slot between the centres of its rounded ends", low_open=False),
    Field("length", "m", "length of the joint along the pin; wear needs it", optional=True),
)
_ON_FLAT = "hertz-line"  # the pressure law of wear in a slot; others assume a journal in a bearing
_TIME_LIMIT = Field(
    "time_limit",
    "s",
    "simulated time after which a case with a free crank ends",
    0.0,
    1e9,
    high_open=False,
    default=60.0,
)
_TOLERANCE = Field(
    "tolerance", "1", "relative local tolerance", 1e-13, 1e-2, low_open=False, high_open=False, default=1e-8
)
_BUDGET = Field(
    "step_budget",
    "1",
    "largest number of steps per revolution of the case, rejected steps included",
    1,
    1e12,
    low_open=False,
    high_open=False,
    whole=True,
)
_BUDGETS = (
    _BUDGET._replace(default=1_000_000),
    _BUDGET._replace(
        name="event_budget",
        text="largest number of contact events per revolution of the case",
        default=100_000,
    ),
)
_SIMULATE = (
    Field(
        "revolutions",
        "1",
        "number of crank revolutions, `discard` included; with `until`: the smallest number",
        0.0,
        1e9,
        high_open=False,
        default=10.0,
    ),
    Field(
        "discard",
        "1",
        "number of revolutions before statistics and wear begin; default: 2, or 0 if `revolutions` is at most 2",
        low_open=False,
        optional=True,
    ),
    _TOLERANCE,
)
_UNTIL = (
    Field(
        "relative_ci",
        "1",
        ("largest half-width of the figure's 95 % interval, relative to the figure"),
        0.0,
        1.0,
        default=0.05,
    ),
    Field(
        "max_revolutions",
        "1",
        "largest number of revolutions",
        0.0,
        1e6,
        high_open=False,
        default=500.0,
    ),
)
_NO_INTERVAL = "the intervals of maxima, minima and totals do not narrow as a run continues"
_HORIZON = Flag("compute the Lyapunov exponent and the prediction horizon with a second run")
_ERROR_CHECK = Flag("repeat each case with a tenth of the tolerance, and store the difference of every figure")
_IMPACTS = _BUDGET._replace(name="impacts", text="number of impacts after which the run ends", high=1e9, default=10)
_METHOD = Word(
    ("auto", "explicit", "implicit"),
    "integration method: explicit collocation, implicit Radau IIA, or an automatic choice of the two",
    "auto",
)


def shape(mechanism: Mechanism, catalogue: Catalogue) -> Shape:
    """Return every dotted path that a grid of this mechanism may contain, sections before their keys."""
    kinds = tuple(mechanism.name for mechanism in catalogue.mechanisms)
    tree: Shape = {
        "mechanism": Section("type, bodies and dimensions of the mechanism"),
        "mechanism.type": Word(kinds, "type of the mechanism"),
    }
    for keys in mechanism.keys:
        _keys(tree, keys, catalogue)
    always = [site for site in mechanism.joints if site.kind == "line"]
    if always:
        tree["joints"] = Section("the joint")
    else:
        tree["joints"] = Section("joints with clearance; all others are ideal", "implied")
    for site in mechanism.joints:
        _SITES[site.kind](tree, f"joints.{site.name}", site, catalogue)
    if mechanism.turns:
        _revolutions(tree, settling(catalogue, mechanism), settling(catalogue, mechanism, settles=False))
    else:
        _impacts(tree)
    if mechanism.spatial:
        start = word_key(tree, "simulate.start")
        tree["simulate.start"] = start._replace(
            options=("centred",), text="initial position of the journals: in the middle of their bearings"
        )
    else:
        add_life_keys(tree)
    if mechanism.free:
        add_numbers(tree, "simulate", (_TIME_LIMIT,), sweep=False)
        del tree["simulate.horizon"]  # a disturbed free crank turns at another speed, so two motions cannot be compared
    return tree


def _keys(tree: Shape, keys: Keys, catalogue: Catalogue) -> None:
    """Add the keys of a section of a mechanism."""
    if keys.path not in tree:
        tree[keys.path] = Section(keys.text, keys.need, keys.items, keys.scalar_factors)
    for name, text in keys.flags:
        tree[f"{keys.path}.{name}"] = Flag(text)
    for choice in keys.words:
        tree[f"{keys.path}.{choice.name}"] = Word(choice.options, choice.text, choice.default)
    if keys.family:
        laws = catalogue.of(keys.family)
        laws = tuple(sized(law, keys.given) for law in laws) if keys.given else laws
        names = tuple(law.name for law in laws)
        tree[f"{keys.path}.law"] = Word(names, f"the {keys.family} law", sweep=True, noun="law")
        add_laws(tree, keys.path, "law", laws)
    add_numbers(tree, keys.path, keys.fields)
    for columns in keys.tables:
        tree[f"{keys.path}.{columns.name}"] = Table(columns)


def _revolutions(tree: Shape, figures: tuple[str, ...], others: tuple[str, ...]) -> None:
    """Add the keys of `simulate` and `save` for mechanisms that turn; `until` accepts `figures`, but no `others`."""
    tree["simulate"] = Section("duration, tolerance and start of the motion", "implied")
    add_numbers(tree, "simulate", _SIMULATE)
    tree["simulate.start"] = Word(
        ("centred", "seated"), "initial position of the journals in their bearings; seated: in contact", "centred"
    )
    tree["simulate.method"] = _METHOD
    add_numbers(tree, "simulate", _BUDGETS)
    add_numbers(tree, "simulate", (TIME_BUDGET,), sweep=False)
    tree["simulate.error_check"], tree["simulate.horizon"] = _ERROR_CHECK, _HORIZON
    tree["simulate.until"] = Section(
        "criterion for the end of a case: a figure is accurate enough, or the motion is periodic", "optional"
    )
    text = "column of the summary whose 95 % interval determines the end of the case"
    tree["simulate.until.figure"] = Word(figures, text, refused=dict.fromkeys(others, _NO_INTERVAL))
    add_numbers(tree, "simulate.until", _UNTIL, sweep=False)
    add_save_keys(tree, has_turns=True)


def _impacts(tree: Shape) -> None:
    """Add the keys of `simulate` and `save` for mechanisms that do not turn."""
    tree["simulate"] = Section("duration and tolerance of the motion", "implied")
    add_numbers(tree, "simulate", (_IMPACTS, _TOLERANCE, *_BUDGETS))
    add_numbers(tree, "simulate", (TIME_BUDGET,), sweep=False)
    tree["simulate.method"] = _METHOD
    tree["simulate.error_check"] = _ERROR_CHECK
    add_save_keys(tree, has_turns=False)


def _gap(tree: Shape, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a gap on a line, which always has clearance."""
    tree[path] = Section("the gap between the bodies")
    add_numbers(tree, path, (Field("clearance", "m", "half of the total gap"),))
    add_contact(tree, path, catalogue)
    add_roughness(tree, path, catalogue)
    add_film(tree, path, catalogue)
    elastic, film = (word_key(tree, f"{path}.{key}") for key in ("contact.elastic", "film.law"))
    for field in _GAP_SIZES:
        tree[f"{path}.{field.name}"] = Number(
            (Use(field, elastic.when), Use(field, ((f"{path}.film.law", frozenset(film.options)),)))
        )


def _revolute(tree: Shape, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a revolute joint with clearance."""
    tree[path] = Section("a revolute joint with clearance", "optional")
    add_numbers(
        tree,
        path,
        (
            Field("clearance", "m", "radial clearance, or a fit of ISO 286 as {fit: H7/f7}", fit=True),
            Field(
                "bearing_radius", "m", "radius of the bearing; the radius of the journal is smaller by the clearance"
            ),
            _LENGTH_OF_PIN,
        ),
    )
    tree[f"{path}.journal"] = Word(site.journals, "body that carries the journal", site.journals[0])
    add_contact(tree, path, catalogue)
    add_roughness(tree, path, catalogue)
    add_film(tree, path, catalogue)
    add_friction(tree, path, catalogue)
    add_preload(tree, path, catalogue)
    add_thermal(tree, path)
    _wear(tree, path, catalogue)


def _wear(tree: Shape, path: str, catalogue: Catalogue) -> None:
    """Add the keys of a joint's wear."""
    wear = f"{path}.wear"
    tree[wear] = Section("wear of the joint. Without this section, no wear is computed", "optional")
    tree[f"{wear}.law"] = Word(catalogue.names("wear"), "the wear law", sweep=True, noun="law")
    tree[f"{wear}.{PAIR}"] = Name(
        tuple(PAIRS),
        f"wear pair from `clearsweep list pairs`; it determines the law `{LAW}` and, unless given, `coefficient`",
    )
    tree[f"{wear}.coefficient_unit"] = Word(
        ("m^2/N", DIMENSIONLESS),
        "unit of the coefficients; default: dimensionless (k times the hardness) for bare numbers with `hardness`",
        "m^2/N",
    )
    tree[f"{wear}.evolve"] = Flag("whether the worn shape acts on the contact")
    tree[f"{wear}.running_in"] = Section("decrease of the wear coefficient as the surfaces run in", "optional")
    _coefficients(tree, wear, _WEAR)
    _coefficients(tree, f"{wear}.running_in", _RUNNING_IN)
    add_numbers(tree, f"{wear}.running_in", (_DISTANCE,))
    add_numbers(tree, wear, (_HARDNESS, _PV_LIMIT))
    add_numbers(tree, wear, (_BINS,), sweep=False)
    tree[f"{wear}.pressure"] = Word(
        catalogue.names("pressure"),
        "distribution of the pressure over the contact arc; default: hertz-line with a material or a pressure_modulus",
        "mean",
        sweep=True,
        noun="law",
        conditional_default=ConditionalDefault("hertz-line", one_of=moduli(path)),
    )
    add_laws(tree, wear, "law", catalogue.of("wear"))
    add_laws(tree, wear, "pressure", catalogue.of("pressure"))


def _coefficients(tree: Shape, path: str, fields: tuple[Field, ...]) -> None:
    """Add wear coefficients, which have a unit unless a hardness makes them dimensionless."""
    unit = f"{path.removesuffix('.running_in')}.coefficient_unit"
    for field in fields:
        number = field._replace(unit="1", low_open=False)
        uses = (Use(field, ((unit, frozenset(("m^2/N",))),)), Use(number, ((unit, frozenset((DIMENSIONLESS,))),)))
        tree[f"{path}.{field.name}"] = Number(uses)


def _guide(tree: Shape, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a prismatic joint with clearance: a block between two walls."""
    tree[path] = Section("a prismatic joint with clearance, a block between two walls", "optional")
    add_numbers(tree, path, _GUIDE)
    add_contact(tree, path, catalogue._replace(laws=point_laws(catalogue)))
    for inner in [inner for inner in tree if inner.startswith(f"{path}.contact.material")]:
        del tree[inner]
    tree[f"{path}.contact.onset"] = first_onset(tree, f"{path}.contact")
    add_friction(tree, path, catalogue)
    add_preload(tree, path, catalogue, ALONG)


def _slot(tree: Shape, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a pin in a straight slot, which always has clearance."""
    tree[path] = Section("a pin in a straight slot with rounded ends")
    add_numbers(tree, path, _SLOT)
    add_contact(tree, path, catalogue._replace(laws=point_laws(catalogue)))
    for inner in [inner for inner in tree if inner.startswith(f"{path}.contact.material")]:
        del tree[inner]
    tree[f"{path}.contact.onset"] = first_onset(tree, f"{path}.contact")
    add_friction(tree, path, catalogue)
    laws = tuple(law for law in catalogue.laws if law.family != "pressure" or law.name == _ON_FLAT)
    _wear(tree, path, catalogue._replace(laws=laws))
    tree[f"{path}.wear.pressure"] = Word(
        (_ON_FLAT,), "distribution of the pressure between the pin and a flat wall or a round end", _ON_FLAT
    )


def _pin_or_guide(tree: Shape, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a joint that the grid declares as a pin or a guide: all keys of both."""
    _revolute(tree, path, site, catalogue)
    tree[path] = Section("a joint with clearance", "optional")
    add_numbers(
        tree, path, tuple(field._replace(text=f"of a guide: {field.text}", optional=True) for field in _GUIDE[2:])
    )
    add_numbers(tree, path, (_SLOT[2]._replace(text=f"of a slot: {_SLOT[2].text}", optional=True),))


def _spatial_revolute(tree: Shape, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a spatial revolute joint without flanges, and of its wear."""
    through(tree, path, site, catalogue)
    _wear(tree, path, catalogue)
    del tree[f"{path}.wear.evolve"]  # worn shapes affect contact only in the plane
    add_numbers(tree, f"{path}.wear", (_LENGTH_BINS,), sweep=False)


def _flanged_revolute(tree: Shape, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a spatial revolute joint with flanges."""
    _spatial_revolute(tree, path, site, catalogue)
    flanged(tree, path, catalogue)


_SITES = {
    "line": _gap,
    "revolute": _revolute,
    "guide": _guide,
    "slot": _slot,
    "spatial": _flanged_revolute,
    "through": _spatial_revolute,
    ANY: _pin_or_guide,
}
