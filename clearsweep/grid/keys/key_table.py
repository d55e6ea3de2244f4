"""The key table of grid files: every key with its unit, range, default and meaning."""

from ...contracts.catalogue import Catalogue, Field, JointSite, Keys, Mechanism, sized
from ...contracts.layout import settling
from ...contracts.outline import ANY
from ..library import PAIRS
from .joint_keys import (
    GUIDE_PRELOAD_TEXT,
    add_contact,
    add_film,
    add_flanges,
    add_friction,
    add_laws,
    add_numbers,
    add_preload,
    add_roughness,
    add_spatial_revolute,
    add_thermal,
    laws_of_point_contacts,
    modulus_paths,
    onset_key_without_mass,
)
from .kinds import ConditionalDefault, Flag, KeyTable, Name, Number, Section, Table, Use, Word, word_key
from .library_names import DEFAULT_WEAR_LAW, PAIR
from .run_keys import TIME_BUDGET_FIELD, add_life_keys, add_save_keys

DIMENSIONLESS = "dimensionless"
_COEFFICIENT_FIELD = Field(
    "coefficient",
    "m^2/N",
    "wear coefficient of both bodies: depth per pressure and sliding distance; with `energy`: volume per work, m^3/J",
    low_open=False,
    optional=True,
)
_WEAR_FIELDS = (
    _COEFFICIENT_FIELD,
    _COEFFICIENT_FIELD._replace(
        name="bearing_coefficient", text="wear coefficient of the bearing; overrides `coefficient`"
    ),
    _COEFFICIENT_FIELD._replace(
        name="journal_coefficient", text="wear coefficient of the journal; overrides `coefficient`"
    ),
)
_RUNNING_IN_FIELDS = (
    _COEFFICIENT_FIELD._replace(name="initial", text="initial wear coefficient of both bodies"),
    _COEFFICIENT_FIELD._replace(
        name="steady", text="steady wear coefficient of both bodies; another name for `coefficient`"
    ),
    _COEFFICIENT_FIELD._replace(
        name="bearing_initial", text="initial wear coefficient of the bearing; overrides `initial`"
    ),
    _COEFFICIENT_FIELD._replace(
        name="journal_initial", text="initial wear coefficient of the journal; overrides `initial`"
    ),
)
_DISTANCE_FIELD = Field(
    "distance", "m", "sliding distance over which the difference from the steady coefficient falls by a factor e"
)
_HARDNESS_FIELD = Field(
    "hardness",
    "Pa",
    "hardness of the softer body; it checks a coefficient, or converts a bare number into a coefficient",
    optional=True,
)
_PV_LIMIT_FIELD = Field(
    "pv_limit",
    "W/m^2",
    "largest allowed product of pressure and sliding speed in the bearing; the run measures the time above it",
    optional=True,
)
_BINS_FIELD = Field(
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
_LENGTH_BINS_FIELD = _BINS_FIELD._replace(
    name="length_bins", text="number of bins along each body", low=1, high=1000, default=20
)
_PIN_LENGTH_FIELD = Field(
    "length", "m", "length of the joint along the pin; wear and the laws of cylinders need it", optional=True
)
_GAP_FIELDS = (
    Field("bearing_radius", "m", "radius of the bearing; the laws of cylinders need it", optional=True),
    _PIN_LENGTH_FIELD,
)
_GUIDE_FIELDS = (
    Field("clearance", "m", "clearance between the block and each wall, with the block in the middle"),
    Field("length", "m", "length of the block along the guide"),
    Field("height", "m", "height of the block across the guide"),
)
_SLOT_FIELDS = (
    Field("clearance", "m", "clearance between the pin and each wall, with the pin in the middle"),
    Field("bearing_radius", "m", "half the width of the slot; the radius of the pin is smaller by the clearance"),
    Field("slot_length", "m", "length of the slot between the centres of its rounded ends", low_open=False),
    Field("length", "m", "length of the joint along the pin; wear needs it", optional=True),
)
_FLAT_PRESSURE_LAW = "hertz-line"  # the pressure law of wear in a slot; others assume a journal in a bearing
_TIME_LIMIT_FIELD = Field(
    "time_limit",
    "s",
    "simulated time after which a case with a free crank ends",
    0.0,
    1e9,
    high_open=False,
    default=60.0,
)
_TOLERANCE_FIELD = Field(
    "tolerance", "1", "relative local tolerance", 1e-13, 1e-2, low_open=False, high_open=False, default=1e-8
)
_STEP_BUDGET_FIELD = Field(
    "step_budget",
    "1",
    "largest number of steps per revolution of the case, rejected steps included",
    1,
    1e12,
    low_open=False,
    high_open=False,
    whole=True,
)
_BUDGET_FIELDS = (
    _STEP_BUDGET_FIELD._replace(default=1_000_000),
    _STEP_BUDGET_FIELD._replace(
        name="event_budget",
        text="largest number of contact events per revolution of the case",
        default=100_000,
    ),
)
_SIMULATE_FIELDS = (
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
    _TOLERANCE_FIELD,
)
_UNTIL_FIELDS = (
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
_NO_INTERVAL_TEXT = "the intervals of maxima, minima and totals do not narrow as a run continues"
_HORIZON_FLAG = Flag("compute the Lyapunov exponent and the prediction horizon with a second run")
_ERROR_CHECK_FLAG = Flag("repeat each case with a tenth of the tolerance, and store the difference of every figure")
_IMPACTS_FIELD = _STEP_BUDGET_FIELD._replace(
    name="impacts", text="number of impacts after which the run ends", high=1e9, default=10
)
_METHOD_WORD = Word(
    ("auto", "explicit", "implicit"),
    "integration method: explicit collocation, implicit Radau IIA, or an automatic choice of the two",
    "auto",
)


def table_of_keys(mechanism: Mechanism, catalogue: Catalogue) -> KeyTable:
    """Return every dotted path that a grid of this mechanism may contain, sections before their keys."""
    mechanism_names = tuple(mechanism.name for mechanism in catalogue.mechanisms)
    key_table: KeyTable = {
        "mechanism": Section("type, bodies and dimensions of the mechanism"),
        "mechanism.type": Word(mechanism_names, "which mechanism"),
    }
    for keys in mechanism.keys:
        _add_section_keys(key_table, keys, catalogue)
    line_sites = [site for site in mechanism.joints if site.kind == "line"]
    if line_sites:
        key_table["joints"] = Section("the joint")
    else:
        key_table["joints"] = Section("joints with clearance; all others are ideal", "implied")
    for site in mechanism.joints:
        _ADD_JOINT_KEYS[site.kind](key_table, f"joints.{site.name}", site, catalogue)
    if mechanism.turns:
        _add_revolution_keys(key_table, settling(catalogue, mechanism), settling(catalogue, mechanism, settles=False))
    else:
        _add_impact_keys(key_table)
    if mechanism.spatial:
        start = word_key(key_table, "simulate.start")
        key_table["simulate.start"] = start._replace(
            options=("centred",), text="initial position of the journals: in the middle of their bearings"
        )
    else:
        add_life_keys(key_table)
    if mechanism.free:
        add_numbers(key_table, "simulate", (_TIME_LIMIT_FIELD,), sweep=False)
        del key_table[
            "simulate.horizon"
        ]  # a disturbed free crank turns at another speed, so two motions cannot be compared
    return key_table


def _add_section_keys(key_table: KeyTable, keys: Keys, catalogue: Catalogue) -> None:
    """Add the keys of a section of a mechanism."""
    if keys.path not in key_table:
        key_table[keys.path] = Section(keys.text, keys.need, keys.items, keys.scalar_factors)
    for name, text in keys.flags:
        key_table[f"{keys.path}.{name}"] = Flag(text)
    for choice in keys.words:
        key_table[f"{keys.path}.{choice.name}"] = Word(choice.options, choice.text, choice.default)
    if keys.family:
        laws = catalogue.of(keys.family)
        laws = tuple(sized(law, keys.given) for law in laws) if keys.given else laws
        names = tuple(law.name for law in laws)
        key_table[f"{keys.path}.law"] = Word(names, f"the {keys.family} law", sweep=True, noun="law")
        add_laws(key_table, keys.path, "law", laws)
    add_numbers(key_table, keys.path, keys.fields)
    for columns in keys.tables:
        key_table[f"{keys.path}.{columns.name}"] = Table(columns)


def _add_revolution_keys(key_table: KeyTable, figures: tuple[str, ...], refused_figures: tuple[str, ...]) -> None:
    """Add the keys of `simulate` and `save` for mechanisms that turn; `until` accepts `figures`, but no `others`."""
    key_table["simulate"] = Section("duration, tolerance and start of the motion", "implied")
    add_numbers(key_table, "simulate", _SIMULATE_FIELDS)
    key_table["simulate.start"] = Word(
        ("centred", "seated"), "initial position of the journals in their bearings; seated: in contact", "centred"
    )
    key_table["simulate.method"] = _METHOD_WORD
    add_numbers(key_table, "simulate", _BUDGET_FIELDS)
    add_numbers(key_table, "simulate", (TIME_BUDGET_FIELD,), sweep=False)
    key_table["simulate.error_check"], key_table["simulate.horizon"] = _ERROR_CHECK_FLAG, _HORIZON_FLAG
    key_table["simulate.until"] = Section(
        "criterion for the end of a case: a figure is accurate enough, or the motion is periodic", "optional"
    )
    text = "column of the summary whose 95 % interval determines the end of the case"
    key_table["simulate.until.figure"] = Word(figures, text, refused=dict.fromkeys(refused_figures, _NO_INTERVAL_TEXT))
    add_numbers(key_table, "simulate.until", _UNTIL_FIELDS, sweep=False)
    add_save_keys(key_table, has_turns=True)


def _add_impact_keys(key_table: KeyTable) -> None:
    """Add the keys of `simulate` and `save` for mechanisms that do not turn."""
    key_table["simulate"] = Section("duration and tolerance of the motion", "implied")
    add_numbers(key_table, "simulate", (_IMPACTS_FIELD, _TOLERANCE_FIELD, *_BUDGET_FIELDS))
    add_numbers(key_table, "simulate", (TIME_BUDGET_FIELD,), sweep=False)
    key_table["simulate.method"] = _METHOD_WORD
    key_table["simulate.error_check"] = _ERROR_CHECK_FLAG
    add_save_keys(key_table, has_turns=False)


def _add_line_gap(key_table: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a gap on a line, which always has clearance."""
    key_table[path] = Section("the gap between the bodies")
    add_numbers(key_table, path, (Field("clearance", "m", "half of the total gap"),))
    add_contact(key_table, path, catalogue)
    add_roughness(key_table, path, catalogue)
    add_film(key_table, path, catalogue)
    elastic, film = (word_key(key_table, f"{path}.{key}") for key in ("contact.elastic", "film.law"))
    for field in _GAP_FIELDS:
        key_table[f"{path}.{field.name}"] = Number(
            (Use(field, elastic.when), Use(field, ((f"{path}.film.law", frozenset(film.options)),)))
        )


def _add_revolute(key_table: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a revolute joint with clearance."""
    key_table[path] = Section("a revolute joint with clearance", "optional")
    add_numbers(
        key_table,
        path,
        (
            Field("clearance", "m", "radial clearance, or a fit of ISO 286 as {fit: H7/f7}", fit=True),
            Field(
                "bearing_radius", "m", "radius of the bearing; the radius of the journal is smaller by the clearance"
            ),
            _PIN_LENGTH_FIELD,
        ),
    )
    key_table[f"{path}.journal"] = Word(site.journals, "body that carries the journal", site.journals[0])
    add_contact(key_table, path, catalogue)
    add_roughness(key_table, path, catalogue)
    add_film(key_table, path, catalogue)
    add_friction(key_table, path, catalogue)
    add_preload(key_table, path, catalogue)
    add_thermal(key_table, path)
    _add_wear(key_table, path, catalogue)


def _add_wear(key_table: KeyTable, path: str, catalogue: Catalogue) -> None:
    """Add the keys of a joint's wear."""
    wear = f"{path}.wear"
    key_table[wear] = Section("wear of the joint. Without this section, no wear is computed", "optional")
    key_table[f"{wear}.law"] = Word(catalogue.names("wear"), "the wear law", sweep=True, noun="law")
    key_table[f"{wear}.{PAIR}"] = Name(
        tuple(PAIRS),
        f"wear pair from `clearsweep list pairs`; it determines the law `{DEFAULT_WEAR_LAW}` and, unless given, "
        "`coefficient`",
    )
    key_table[f"{wear}.coefficient_unit"] = Word(
        ("m^2/N", DIMENSIONLESS),
        "unit of the coefficients; default: dimensionless (k times the hardness) for bare numbers with `hardness`",
        "m^2/N",
    )
    key_table[f"{wear}.evolve"] = Flag("whether the worn shape acts on the contact")
    key_table[f"{wear}.running_in"] = Section("decrease of the wear coefficient as the surfaces run in", "optional")
    _add_coefficients(key_table, wear, _WEAR_FIELDS)
    _add_coefficients(key_table, f"{wear}.running_in", _RUNNING_IN_FIELDS)
    add_numbers(key_table, f"{wear}.running_in", (_DISTANCE_FIELD,))
    add_numbers(key_table, wear, (_HARDNESS_FIELD, _PV_LIMIT_FIELD))
    add_numbers(key_table, wear, (_BINS_FIELD,), sweep=False)
    key_table[f"{wear}.pressure"] = Word(
        catalogue.names("pressure"),
        "distribution of the pressure over the contact arc; default: hertz-line with a material or a pressure_modulus",
        "mean",
        sweep=True,
        noun="law",
        conditional_default=ConditionalDefault("hertz-line", one_of=modulus_paths(path)),
    )
    add_laws(key_table, wear, "law", catalogue.of("wear"))
    add_laws(key_table, wear, "pressure", catalogue.of("pressure"))


def _add_coefficients(key_table: KeyTable, path: str, fields: tuple[Field, ...]) -> None:
    """Add wear coefficients, which have a unit unless a hardness makes them dimensionless."""
    unit_path = f"{path.removesuffix('.running_in')}.coefficient_unit"
    for field in fields:
        dimensionless_field = field._replace(unit="1", low_open=False)
        uses = (
            Use(field, ((unit_path, frozenset(("m^2/N",))),)),
            Use(dimensionless_field, ((unit_path, frozenset((DIMENSIONLESS,))),)),
        )
        key_table[f"{path}.{field.name}"] = Number(uses)


def _add_guide(key_table: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a prismatic joint with clearance: a block between two walls."""
    key_table[path] = Section("a prismatic joint with clearance, a block between two walls", "optional")
    add_numbers(key_table, path, _GUIDE_FIELDS)
    add_contact(key_table, path, catalogue._replace(laws=laws_of_point_contacts(catalogue)))
    for inner in [inner for inner in key_table if inner.startswith(f"{path}.contact.material")]:
        del key_table[inner]
    key_table[f"{path}.contact.onset"] = onset_key_without_mass(key_table, f"{path}.contact")
    add_friction(key_table, path, catalogue)
    add_preload(key_table, path, catalogue, GUIDE_PRELOAD_TEXT)


def _add_slot(key_table: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a pin in a straight slot, which always has clearance."""
    key_table[path] = Section("a pin in a straight slot with rounded ends")
    add_numbers(key_table, path, _SLOT_FIELDS)
    add_contact(key_table, path, catalogue._replace(laws=laws_of_point_contacts(catalogue)))
    for inner in [inner for inner in key_table if inner.startswith(f"{path}.contact.material")]:
        del key_table[inner]
    key_table[f"{path}.contact.onset"] = onset_key_without_mass(key_table, f"{path}.contact")
    add_friction(key_table, path, catalogue)
    laws = tuple(law for law in catalogue.laws if law.family != "pressure" or law.name == _FLAT_PRESSURE_LAW)
    _add_wear(key_table, path, catalogue._replace(laws=laws))
    key_table[f"{path}.wear.pressure"] = Word(
        (_FLAT_PRESSURE_LAW,),
        "distribution of the pressure between the pin and a flat wall or a round end",
        _FLAT_PRESSURE_LAW,
    )


def _add_pin_or_guide(key_table: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a joint that the grid declares as a pin or a guide: all keys of both."""
    _add_revolute(key_table, path, site, catalogue)
    key_table[path] = Section("a joint with clearance", "optional")
    add_numbers(
        key_table,
        path,
        tuple(field._replace(text=f"of a guide: {field.text}", optional=True) for field in _GUIDE_FIELDS[2:]),
    )
    add_numbers(key_table, path, (_SLOT_FIELDS[2]._replace(text=f"of a slot: {_SLOT_FIELDS[2].text}", optional=True),))


def _add_worn_spatial_revolute(key_table: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a spatial revolute joint without flanges, and of its wear."""
    add_spatial_revolute(key_table, path, site, catalogue)
    _add_wear(key_table, path, catalogue)
    del key_table[f"{path}.wear.evolve"]  # worn shapes affect contact only in the plane
    add_numbers(key_table, f"{path}.wear", (_LENGTH_BINS_FIELD,), sweep=False)


def _add_flanged_revolute(key_table: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a spatial revolute joint with flanges."""
    _add_worn_spatial_revolute(key_table, path, site, catalogue)
    add_flanges(key_table, path, catalogue)


_ADD_JOINT_KEYS = {
    "line": _add_line_gap,
    "revolute": _add_revolute,
    "guide": _add_guide,
    "slot": _add_slot,
    "spatial": _add_flanged_revolute,
    "through": _add_worn_spatial_revolute,
    ANY: _add_pin_or_guide,
}
