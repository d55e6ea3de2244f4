"""The key table of grid files: every key with its unit, range, default and meaning."""

from collections.abc import Sequence

from ...contracts.catalogue import (
    ANY,
    CHOICE,
    NUMERICS,
    ROLES,
    Catalogue,
    Columns,
    Field,
    JointSite,
    Keys,
    Law,
    Mechanism,
    ranged,
    torsional,
    with_given_size,
)
from ...contracts.layout import converging_columns
from ..library import MATERIALS, PAIRS
from . import (
    ConditionalDefault,
    Flag,
    KeyTable,
    Number,
    Section,
    Table,
    Use,
    Word,
    joint_keys,
    section_key,
    word_key,
)
from .library_names import DEFAULT_WEAR_LAW, PAIR
from .run_keys import TIME_BUDGET_FIELD, add_life_keys, add_save_keys, add_start_keys

DIMENSIONLESS = "dimensionless"
_COEFFICIENT = ranged(
    "coefficient",
    "m^2/N",
    "wear coefficient of both bodies: depth per pressure and sliding distance; with `energy`: volume per work, m^3/J",
    "[0, inf)",
    optional=True,
)
_WEAR_FIELDS = (
    _COEFFICIENT,
    _COEFFICIENT._replace(name="bearing_coefficient", text="wear coefficient of the bearing; overrides `coefficient`"),
    _COEFFICIENT._replace(name="journal_coefficient", text="wear coefficient of the journal; overrides `coefficient`"),
)
_RUNNING_IN_FIELDS = (
    _COEFFICIENT._replace(name="initial", text="initial wear coefficient of both bodies"),
    _COEFFICIENT._replace(name="steady", text="steady wear coefficient of both bodies; another name for `coefficient`"),
    _COEFFICIENT._replace(name="bearing_initial", text="initial wear coefficient of the bearing; overrides `initial`"),
    _COEFFICIENT._replace(name="journal_initial", text="initial wear coefficient of the journal; overrides `initial`"),
)
_RUNNING_IN_DISTANCE = Field(
    "distance", "m", "sliding distance over which the difference from the steady coefficient falls by a factor e"
)
_HARDNESS_TEXT = "hardness of the softer body; it checks a coefficient, or converts a bare number into a coefficient"
_HARDNESS = Field("hardness", "Pa", _HARDNESS_TEXT, optional=True)
_PRESSURE_VELOCITY_LIMIT = Field(
    "pv_limit",
    "W/m^2",
    "largest allowed product of pressure and sliding speed in the bearing; the run measures the time above it",
    optional=True,
)
_BINS = ranged("bins", "1", "number of angular bins around each body", "[8, 1e6]", default=360, integer=True)
_LENGTH_BINS = _BINS._replace(name="length_bins", text="number of bins along each body", low=1, high=1000, default=20)
_PIN_LENGTH = Field(
    "length", "m", "length of the joint along the pin; wear and the laws of cylinders need it", optional=True
)
_BEARING_RADIUS_TEXT = "radius of the bearing; the laws of cylinders need it"
_GAP_FIELDS = (Field("bearing_radius", "m", _BEARING_RADIUS_TEXT, optional=True), _PIN_LENGTH)
_GUIDE_HEIGHT = Field("height", "m", "height of the block across the guide")
_GUIDE_FIELDS = (
    Field("clearance", "m", "clearance between the block and each wall, with the block in the middle"),
    Field("length", "m", "length of the block along the guide"),
    _GUIDE_HEIGHT,
)
_SLOT_LENGTH = ranged("slot_length", "m", "length of the slot between the centres of its rounded ends", "[0, inf)")
_SLOT_FIELDS = (
    Field("clearance", "m", "clearance between the pin and each wall, with the pin in the middle"),
    Field("bearing_radius", "m", "half the width of the slot; the radius of the pin is smaller by the clearance"),
    _SLOT_LENGTH,
    Field("length", "m", "length of the joint along the pin; wear needs it", optional=True),
)
_SLOT_PRESSURE_LAW = "hertz-line"  # the pressure law of wear in a slot; others assume a journal in a bearing
_TIME_LIMIT = ranged(
    "time_limit", "s", "simulated time after which a case with a free crank ends", "(0, 1e9]", default=60.0
)
_TOLERANCE = ranged("tolerance", "1", "relative local tolerance", "[1e-13, 0.01]", default=1e-8)
_STEP_BUDGET_TEXT = "largest number of steps per revolution of the case, rejected steps included"
_STEP_BUDGET = ranged("step_budget", "1", _STEP_BUDGET_TEXT, "[1, 1e12]", integer=True)
_BUDGET_FIELDS = (
    _STEP_BUDGET._replace(default=1_000_000),
    _STEP_BUDGET._replace(
        name="event_budget", text="largest number of contact events per revolution of the case", default=100_000
    ),
)
_DISCARD_TEXT = "number of revolutions before statistics and wear begin; default: 2, or 0 if `revolutions` is at most 2"
_REVOLUTIONS_TEXT = "number of crank revolutions, `discard` included; with `until`: the smallest number"
_SIMULATE_FIELDS = (
    ranged("revolutions", "1", _REVOLUTIONS_TEXT, "(0, 1e9]", default=10.0),
    ranged("discard", "1", _DISCARD_TEXT, "[0, inf)", optional=True),
    _TOLERANCE,
)
_CYCLE_FIELDS = (
    ranged("cycles", "1", "number of cycles, `discard` included", "(0, 1e9]"),
    _SIMULATE_FIELDS[1]._replace(
        text="number of cycles before statistics begin; default: 2, or 0 if `cycles` is at most 2"
    ),
    ranged("period", "s", "length of a cycle", "(0, 1e9]"),
    _TOLERANCE,
)
_TIME_FIELDS = (
    ranged("time", "s", "length of the run, `discard` included", "(0, 1e9]"),
    ranged("discard", "s", "time before statistics begin", "[0, inf)", default=0.0),
    _TOLERANCE,
)
#: Fields of `simulate` by what the length of a run is measured in.
_LENGTH_FIELDS = {"revolutions": _SIMULATE_FIELDS, "cycles": _CYCLE_FIELDS, "time": _TIME_FIELDS}
#: The same in lists of keys.
_EVERY_LENGTH = (
    *_SIMULATE_FIELDS,
    _CYCLE_FIELDS[0]._replace(text="in place of revolutions: number of cycles, `discard` included", optional=True),
    _CYCLE_FIELDS[2]._replace(text="with `cycles`: length of a cycle", optional=True),
    _TIME_FIELDS[0]._replace(
        text="in place of revolutions: length of the run; `discard` is then a time (s), 0 by default", optional=True
    ),
)
_INTERVAL_TEXT = "largest half-width of the figure's 95 % interval, relative to the figure"
_UNTIL_FIELDS = (
    ranged("relative_ci", "1", _INTERVAL_TEXT, "(0, 1)", default=0.05),
    ranged("max_revolutions", "1", "largest number of revolutions", "(0, 1e6]", default=500.0),
)
_NO_INTERVAL_TEXT = "the intervals of maxima, minima and totals do not narrow as a run continues"
_PREDICTION_HORIZON = Flag("compute the Lyapunov exponent and the prediction horizon with a second run")
_ERROR_CHECK = Flag("repeat each case with a tenth of the tolerance, and store the difference of every figure")
_IMPACT_COUNT = _STEP_BUDGET._replace(
    name="impacts", text="number of impacts after which the run ends", high=1e9, default=10
)
_METHOD_TEXT = "integration method: explicit collocation, implicit Radau IIA, or an automatic choice of the two"
_METHOD = Word(("auto", "explicit", "implicit"), _METHOD_TEXT, "auto")


def table_of_keys(mechanism: Mechanism, catalogue: Catalogue, figures: Sequence[str] = ()) -> KeyTable:
    """Return every dotted path that a grid of this mechanism may contain, sections before their keys.

    figures : names of the columns of figures of one's own
    """
    mechanism_names = tuple(mechanism.name for mechanism in catalogue.mechanisms)
    text = "type, bodies and dimensions of the mechanism"
    keys: KeyTable = {"mechanism": Section(text), "mechanism.type": Word(mechanism_names, "type of the mechanism")}
    for section in mechanism.keys:
        _add_section_keys(keys, section, catalogue)
    line_sites = [site for site in mechanism.joints if site.kind == "line"]
    if line_sites:
        keys["joints"] = Section("the joint")
    else:
        keys["joints"] = Section("joints with clearance; all others are ideal", "implied")
    for site in mechanism.joints:
        _ADD_JOINT_KEYS[site.kind](keys, f"joints.{site.stopped or site.name}", site, catalogue)
    if mechanism.turns:
        _add_revolution_keys(
            keys,
            mechanism.length,
            converging_columns(catalogue, mechanism),
            converging_columns(catalogue, mechanism, settles=False),
        )
    else:
        _add_impact_keys(keys)
    if mechanism.spatial:
        start_key = word_key(keys, "simulate.start")
        text = "initial position of the journals: in the middle of their bearings"
        keys["simulate.start"] = start_key._replace(options=("centred",), text=text, other_forms=())
    else:
        add_life_keys(keys)
    if mechanism.free:
        if mechanism.length in ("revolutions", ANY):
            joint_keys.add_numbers(keys, "simulate", (_TIME_LIMIT,), NUMERICS, sweep=False)
        del keys["simulate.horizon"]  # a disturbed free crank turns at another speed, so two motions cannot be compared
    _add_own_figures(keys, figures, catalogue)
    for path, key in keys.items():
        if isinstance(key, Number | Word) and key.sweep and key.role not in ROLES:
            raise LookupError(f"{path}: its entry in the key table has no role; give it one of {', '.join(ROLES)}")
    return keys


def _add_own_figures(keys: KeyTable, names: Sequence[str], catalogue: Catalogue) -> None:
    """Add the keys of the figures of one's own that a grid names."""
    if names:
        keys["figures"] = Section("figures of one's own")
    for path in [f"figures.{name}" for name in names]:
        keys[path] = Section("a figure of one's own")
        keys[f"{path}.law"] = Word(catalogue.names("figure"), "the figure, as a law file declares it", noun="figure")
        joint_keys.add_laws(keys, path, "law", catalogue.of("figure"))


def _add_section_keys(keys: KeyTable, section: Keys, catalogue: Catalogue) -> None:
    """Add the keys of a section of a mechanism."""
    if section.path not in keys:
        keys[section.path] = Section(section.text, section.need, section.items, section.scalar_factors)
    for name, *text_and_default in section.flags:
        keys[f"{section.path}.{name}"] = Flag(*text_and_default)
    for choice in section.words:
        keys[f"{section.path}.{choice.name}"] = Word(choice.options, choice.text, choice.default)
    if section.family:
        laws = catalogue.of(section.family)
        laws = tuple(with_given_size(law, section.given_size_key) for law in laws) if section.given_size_key else laws
        names = tuple(law.name for law in laws)
        keys[f"{section.path}.law"] = joint_keys.law_key(names, f"the {section.family} law")
        joint_keys.add_laws(keys, section.path, "law", laws, role=section.role)
    for material in section.materials:
        joint_keys.add_name(keys, section.path, material.name, MATERIALS, material.text)
    joint_keys.add_numbers(keys, section.path, section.fields, section.role)
    for columns in section.tables:
        keys[f"{section.path}.{columns.name}"] = Table(columns)


def _add_revolution_keys(
    keys: KeyTable, length: str, figures: tuple[str, ...], refused_figures: tuple[str, ...]
) -> None:
    """Add the keys of `simulate` and `save` for mechanisms that turn; `until` accepts only `figures`.

    length : what the length of a run is measured in, as in Outline, or ANY
    """
    keys["simulate"] = Section("duration, tolerance and start of the motion", "implied")
    joint_keys.add_numbers(keys, "simulate", _LENGTH_FIELDS.get(length, _EVERY_LENGTH), NUMERICS)
    add_start_keys(keys)
    keys["simulate.method"] = _METHOD
    joint_keys.add_numbers(keys, "simulate", _BUDGET_FIELDS, NUMERICS)
    joint_keys.add_numbers(keys, "simulate", (TIME_BUDGET_FIELD,), NUMERICS, sweep=False)
    keys["simulate.error_check"], keys["simulate.horizon"] = _ERROR_CHECK, _PREDICTION_HORIZON
    if length in ("revolutions", ANY):
        keys["simulate.until"] = Section(
            "criterion for the end of a case: a figure is accurate enough, or the motion is periodic", "optional"
        )
        text = "column of the summary whose 95 % interval determines the end of the case"
        keys["simulate.until.figure"] = Word(figures, text, refused=dict.fromkeys(refused_figures, _NO_INTERVAL_TEXT))
        joint_keys.add_numbers(keys, "simulate.until", _UNTIL_FIELDS, NUMERICS, sweep=False)
    add_save_keys(keys, has_turns=length != "time")


def _add_impact_keys(keys: KeyTable) -> None:
    """Add the keys of `simulate` and `save` for mechanisms that do not turn."""
    keys["simulate"] = Section("duration and tolerance of the motion", "implied")
    joint_keys.add_numbers(keys, "simulate", (_IMPACT_COUNT, _TOLERANCE, *_BUDGET_FIELDS), NUMERICS)
    joint_keys.add_numbers(keys, "simulate", (TIME_BUDGET_FIELD,), NUMERICS, sweep=False)
    keys["simulate.method"] = _METHOD
    keys["simulate.error_check"] = _ERROR_CHECK
    add_save_keys(keys, has_turns=False)


def _add_line_gap(keys: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a gap on a line, which always has clearance."""
    keys[path] = Section("the gap between the bodies")
    joint_keys.add_numbers(keys, path, (Field("clearance", "m", "half of the total gap"),), CHOICE)
    joint_keys.add_contact(keys, path, catalogue)
    joint_keys.add_roughness(keys, path, catalogue)
    joint_keys.add_film(keys, path, catalogue)
    elastic, film = (word_key(keys, f"{path}.{key}") for key in ("contact.elastic", "film.law"))
    for field in _GAP_FIELDS:
        keys[f"{path}.{field.name}"] = Number(
            (Use(field, elastic.when), Use(field, ((f"{path}.film.law", frozenset(film.options)),))), CHOICE
        )


def _add_revolute(keys: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a revolute joint with clearance."""
    keys[path] = Section("a revolute joint with clearance", "optional")
    joint_keys.add_numbers(
        keys,
        path,
        (
            Field("clearance", "m", "radial clearance, or a fit of ISO 286 as {fit: H7/f7}; not diametral", fit="fit"),
            Field(
                "bearing_radius", "m", "radius of the bearing; the radius of the journal is smaller by the clearance"
            ),
            _PIN_LENGTH,
        ),
        CHOICE,
    )
    keys[f"{path}.journal"] = Word(site.journals, "body that carries the journal", site.journals[0])
    joint_keys.add_contact(keys, path, catalogue)
    joint_keys.add_roughness(keys, path, catalogue)
    joint_keys.add_film(keys, path, catalogue)
    joint_keys.add_friction(keys, path, catalogue)
    joint_keys.add_preload(keys, path, catalogue)
    joint_keys.add_thermal(keys, path)
    joint_keys.add_profile(keys, path, catalogue)
    _add_wear(keys, path, catalogue)


def _add_wear(keys: KeyTable, path: str, catalogue: Catalogue) -> None:
    """Add the keys of a joint's wear."""
    wear_path = f"{path}.wear"
    keys[wear_path] = Section("wear of the joint. Without this section, no wear is computed", "optional")
    keys[f"{wear_path}.law"] = joint_keys.law_key(catalogue.names("wear"), "the wear law")
    text = (
        f"wear pair from `clearsweep list pairs`; it determines the law `{DEFAULT_WEAR_LAW}` and, unless given, "
        "`coefficient`; of unlike materials only the softer body wears, the bearing where they are not named"
    )
    joint_keys.add_name(keys, wear_path, PAIR, PAIRS, text)
    text = "unit of the coefficients; default: dimensionless (k times the hardness) for bare numbers with `hardness`"
    keys[f"{wear_path}.coefficient_unit"] = Word(("m^2/N", DIMENSIONLESS), text, "m^2/N")
    keys[f"{wear_path}.evolve"] = Flag("whether the worn shape acts on the contact")
    keys[f"{wear_path}.running_in"] = Section("decrease of the wear coefficient as the surfaces run in", "optional")
    _add_coefficients(keys, wear_path, _WEAR_FIELDS)
    _add_coefficients(keys, f"{wear_path}.running_in", _RUNNING_IN_FIELDS)
    joint_keys.add_numbers(keys, f"{wear_path}.running_in", (_RUNNING_IN_DISTANCE,), CHOICE)
    joint_keys.add_numbers(keys, wear_path, (_HARDNESS, _PRESSURE_VELOCITY_LIMIT), CHOICE)
    joint_keys.add_numbers(keys, wear_path, (_BINS,), NUMERICS, sweep=False)
    text = "distribution of the pressure over the contact arc; default: hertz-line with a material or a"
    keys[f"{wear_path}.pressure"] = joint_keys.law_key(
        catalogue.names("pressure"),
        f"{text} pressure_modulus",
        "mean",
        conditional_default=ConditionalDefault("hertz-line", one_of=joint_keys.modulus_paths(path)),
    )
    joint_keys.add_laws(keys, wear_path, "law", catalogue.of("wear"))
    joint_keys.add_laws(keys, wear_path, "pressure", catalogue.of("pressure"))


def _add_coefficients(keys: KeyTable, path: str, fields: tuple[Field, ...]) -> None:
    """Add wear coefficients, which have a unit unless a hardness makes them dimensionless."""
    unit_path = f"{path.removesuffix('.running_in')}.coefficient_unit"
    for field in fields:
        dimensionless_field = field._replace(unit="1", low_open=False)
        uses = (
            Use(field, ((unit_path, frozenset(("m^2/N",))),)),
            Use(dimensionless_field, ((unit_path, frozenset((DIMENSIONLESS,))),)),
        )
        keys[f"{path}.{field.name}"] = Number(uses, CHOICE)


def _add_guide(keys: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a prismatic joint with clearance: a block between two walls."""
    keys[path] = Section("a prismatic joint with clearance, a block between two walls", "optional")
    joint_keys.add_numbers(keys, path, _GUIDE_FIELDS, CHOICE)
    _add_contact_without_material(keys, path, joint_keys.laws_of_point_contacts(catalogue), catalogue)
    keys[f"{path}.contact.onset"] = joint_keys.onset_key_without_mass(keys, f"{path}.contact")
    joint_keys.add_friction(keys, path, catalogue)
    joint_keys.add_preload(keys, path, catalogue, joint_keys.GUIDE_PRELOAD_TEXT)


def _add_slot(keys: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a pin in a straight slot, which always has clearance."""
    keys[path] = Section("a pin in a straight slot with rounded ends")
    joint_keys.add_numbers(keys, path, _SLOT_FIELDS, CHOICE)
    _add_contact_without_material(keys, path, joint_keys.laws_of_point_contacts(catalogue), catalogue)
    keys[f"{path}.contact.onset"] = joint_keys.onset_key_without_mass(keys, f"{path}.contact")
    joint_keys.add_friction(keys, path, catalogue)
    laws = tuple(law for law in catalogue.laws if law.family != "pressure" or law.name == _SLOT_PRESSURE_LAW)
    _add_wear(keys, path, catalogue._replace(laws=laws))
    text = "distribution of the pressure between the pin and a flat wall or a round end"
    keys[f"{path}.wear.pressure"] = Word((_SLOT_PRESSURE_LAW,), text, _SLOT_PRESSURE_LAW)


_BACKLASH = Field("backlash", "m", "play between the teeth on the pitch circle, from flank to flank")
_MESH_STIFFNESS = Columns(
    "mesh_stiffness",
    "stiffness of the teeth along their path of contact, a periodic cubic spline through the rows; default: constant",
    (ranged("pitch", "1", "share of the base pitch that a pair of teeth has carried: 0 to 1", "[0, 1]"),),
    (Field("factor", "1", "stiffness over contact.stiffness, which is its mean where the mean of the factors is 1"),),
)
_PLAY = Field("play", "rad", "angle by which the second body can turn if the first does not")
_DRAG_TEXT = "viscous torque per rate of the second body relative to the first, which also acts without contact"
_DRAG = ranged("drag", "N*m*s/rad", _DRAG_TEXT, "[0, inf)", default=0.0)


def _add_gear(keys: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of the play between the teeth of two wheels."""
    keys[path] = Section("play between the teeth of two wheels", "optional")
    joint_keys.add_numbers(keys, path, (_BACKLASH, _DRAG), CHOICE)
    _add_contact_of_flanks(keys, path, catalogue)
    springs = [law for law in catalogue.of("law") if not law.yields and (law.uses_elastic or not law.origin)]
    is_spring = f"{path}.contact.law", frozenset(law.name for law in springs)
    keys[f"{path}.mesh_stiffness"] = Table(_MESH_STIFFNESS, (is_spring,), optional=True)
    joint_keys.add_friction(keys, path, catalogue, "needs surfaces that stay in contact, and teeth follow each other")
    joint_keys.add_numbers(keys, path, (_PIN_LENGTH._replace(text="face width of the teeth; wear needs it"),), CHOICE)
    of_flanks = {"pressure": "mean", "wear": DEFAULT_WEAR_LAW}
    laws = (law for law in catalogue.laws if law.name == of_flanks.get(law.family, law.name))
    _add_wear(keys, path, catalogue._replace(laws=tuple(laws)))
    shaped = (key for key in keys if key.startswith(f"{path}.wear.running_in") or key.endswith(("evolve", "pv_limit")))
    for key in [key for key in shaped if key.startswith(f"{path}.wear.")]:
        del keys[key]


def _add_coupling(keys: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of the play of a coupling, whose contact laws take angles and torques."""
    keys[path] = Section("play of a coupling", "optional")
    joint_keys.add_numbers(keys, path, (_PLAY, _DRAG), CHOICE)
    _add_contact_of_flanks(keys, path, catalogue._replace(laws=tuple(map(torsional, catalogue.laws))))


def _add_stops(keys: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of the stops of a pin, or of a guide, which take lengths and forces."""
    quantity, unit = "travel of the second point from the first along the guide", "m"
    if site.kind != "guide_stops":
        quantity, unit = "angle of the second body relative to the first", "rad"
        catalogue = catalogue._replace(laws=tuple(map(torsional, catalogue.laws)))
    keys.setdefault(path, Section("a joint without clearance whose motion ends at stops", "optional"))
    keys[f"{path}.stops"] = Section("the stops of a joint, which may have a clearance, too")
    keys[f"{path}.stops.at"] = Section(f"{quantity} at both stops, the lower one first", "required", 2)
    ends = (
        ranged(str(k), unit, f"{quantity} at the {end} stop", "(-inf, inf)") for k, end in enumerate(("lower", "upper"))
    )
    joint_keys.add_numbers(keys, f"{path}.stops.at", tuple(ends), CHOICE)
    _add_contact_of_flanks(keys, f"{path}.stops", catalogue)


def _add_contact_of_flanks(keys: KeyTable, path: str, catalogue: Catalogue) -> None:
    """Add the keys of the contact of two flanks or stops; a power of the penetration is linear by default."""
    laws = []
    for law in joint_keys.laws_of_point_contacts(catalogue):
        if "material" not in law.needs:
            fields = (field._replace(default=1.0) if field.name == "exponent" else field for field in law.fields)
            laws.append(law._replace(fields=tuple(fields)))
    _add_contact_without_material(keys, path, tuple(laws), catalogue)


def _add_contact_without_material(keys: KeyTable, path: str, laws: tuple[Law, ...], catalogue: Catalogue) -> None:
    """Add the keys of a contact whose laws take no material."""
    joint_keys.add_contact(keys, path, catalogue._replace(laws=laws))
    for child_path in [child_path for child_path in keys if child_path.startswith(f"{path}.contact.material")]:
        del keys[child_path]


def _add_pin_or_guide(keys: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a joint that the grid declares as a pin or a guide: all keys of both."""
    _add_revolute(keys, path, site, catalogue)
    keys[path] = Section("a joint with clearance", "optional")
    for owner, field in (("a guide", _GUIDE_HEIGHT), ("a slot", _SLOT_LENGTH)):
        further = field._replace(text=f"of {owner}: {field.text}", optional=True)
        joint_keys.add_numbers(keys, path, (further,), CHOICE)
    _add_stops(keys, path, site, catalogue)
    keys[path] = Section("a joint with clearance, or with stops", "optional")
    for nested in [nested for nested in keys if nested.startswith(f"{path}.stops.contact")]:
        keys[nested] = keys[nested.replace(".stops", "")]
    for section in ("stops", "contact"):
        keys[f"{path}.{section}"] = section_key(keys, f"{path}.{section}")._replace(need="optional")
    for owner, field in (("a gear", _BACKLASH), ("a coupling", _PLAY), ("a gear or a coupling", _DRAG)):
        text = f"of {owner}: {field.text}"
        joint_keys.add_numbers(keys, path, (field._replace(text=text, optional=True, default=None),), CHOICE)


def _add_spatial_revolute(keys: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a spatial revolute joint, of its wear, and of its flanges if it has any."""
    joint_keys.add_spatial_revolute(keys, path, catalogue)
    _add_wear(keys, path, catalogue)
    del keys[f"{path}.wear.evolve"]  # worn shapes affect contact only in the plane
    joint_keys.add_numbers(keys, f"{path}.wear", (_LENGTH_BINS,), NUMERICS, sweep=False)
    if site.kind == "spatial":
        joint_keys.add_flanges(keys, path, catalogue)


_ADD_JOINT_KEYS = {
    "line": _add_line_gap,
    "revolute": _add_revolute,
    joint_keys.ROLLING: joint_keys.add_rolling,
    "guide": _add_guide,
    "slot": _add_slot,
    "gear": _add_gear,
    "coupling": _add_coupling,
    "stops": _add_stops,
    "guide_stops": _add_stops,
    "spatial": _add_spatial_revolute,
    "through": _add_spatial_revolute,
    ANY: _add_pin_or_guide,
}
