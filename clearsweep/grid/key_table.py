"""What a grid file may contain: every key with its unit, range, default and meaning."""

from ..case import Materials
from ..catalogue import Catalogue, Field, JointSite, Keys, Law, Mechanism
from ..layout import settling
from ..outline import ANY, EVERYTHING
from . import film_keys
from .keys import Condition, Flag, Number, Section, Shape, Table, Use, Word, section_key, word_key

DIMENSIONLESS = "dimensionless"
_COEFFICIENT = Field(
    "coefficient",
    "m^2/N",
    "wear coefficient of both bodies, depth per pressure and sliding distance; of `energy` volume per work, m^3/J",
    low_open=False,
    optional=True,
)
_WEAR = (
    _COEFFICIENT,
    _COEFFICIENT._replace(name="bearing_coefficient", text="wear coefficient of the bearing; overrides `coefficient`"),
    _COEFFICIENT._replace(name="journal_coefficient", text="wear coefficient of the journal; overrides `coefficient`"),
)
_RUNNING_IN = (
    _COEFFICIENT._replace(name="initial", text="wear coefficient of both bodies at first"),
    _COEFFICIENT._replace(name="steady", text="wear coefficient of both bodies run in; `coefficient` by another name"),
    _COEFFICIENT._replace(name="bearing_initial", text="of the bearing; overrides `initial`"),
    _COEFFICIENT._replace(name="journal_initial", text="of the journal; overrides `initial`"),
)
_DISTANCE = Field("distance", "m", "way slid in contact over which what is left of the difference falls by e")
_HARDNESS = Field(
    "hardness",
    "Pa",
    "hardness of the softer body; checks a coefficient, or makes one of a bare number",
    optional=True,
)
_PV_LIMIT = Field(
    "pv_limit",
    "W/m^2",
    "pressure times sliding speed that the bearing stands; time beyond is counted",
    optional=True,
)
_BINS = Field(
    "bins", "1", "angular bins round each body", 8, 1e6, low_open=False, high_open=False, default=360, whole=True
)
_MATERIAL = (
    Field("young", "Pa", "Young's modulus"),
    Field("poisson", "1", "Poisson's ratio", -1.0, 0.5, high_open=False),
)
_LENGTH_OF_PIN = Field("length", "m", "length along the pin; wear and the laws of cylinders need it", optional=True)
_GAP_SIZES = (
    Field("bearing_radius", "m", "radius of the bearing; the laws of cylinders need it", optional=True),
    _LENGTH_OF_PIN,
)
_GUIDE = (
    Field("clearance", "m", "between the block and each of the walls, where it is in the middle"),
    Field("length", "m", "of the block along the guide"),
    Field("height", "m", "of the block across the guide"),
)
_TIME_LIMIT = Field(
    "time_limit",
    "s",
    "time after which a crank that is free is given up",
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
    "steps, rejected ones included, per revolution of the case after which it is given up",
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
        text="contact events per revolution of the case after which it is given up",
        default=100_000,
    ),
)
_TIME_BUDGET = (
    Field(
        "time_budget",
        "s",
        "process time after which a case is given up, however long it is; no part of its identity",
        0.0,
        1e9,
        high_open=False,
        default=600.0,
    ),
)
_SIMULATE = (
    Field(
        "revolutions",
        "1",
        "crank revolutions, `discard` included; with `until` the fewest",
        0.0,
        1e9,
        high_open=False,
        default=10.0,
    ),
    Field(
        "discard",
        "1",
        "revolutions before statistics and wear begin; default 2, or 0 where there are no more than 2",
        low_open=False,
        optional=True,
    ),
    _TOLERANCE,
)
_UNTIL = (
    Field("relative_ci", "1", "half-width of the figure's 95 % interval over the figure", 0.0, 1.0, default=0.05),
    Field(
        "max_revolutions",
        "1",
        "revolutions after which the run ends in any case",
        0.0,
        1e6,
        high_open=False,
        default=500.0,
    ),
)
_NO_INTERVAL = "maxima, minima and totals have no interval that narrows as a run goes on, so they cannot be judged"
_HORIZON = Flag("find the Lyapunov exponent and how far ahead the motion can be foretold, by a second run beside it")
_ERROR_CHECK = Flag("run each case again at a tenth of the tolerance and store how far every figure differs")
_IMPACTS = Field(
    "impacts", "1", "impacts after which the run ends", 1, 1e9, low_open=False, high_open=False, default=10, whole=True
)
_SAMPLES = Field(
    "samples",
    "1",
    "samples per revolution; in all where nothing turns",
    1,
    1e7,
    low_open=False,
    high_open=False,
    default=720,
    whole=True,
)
_SAVED = Field(
    "revolutions", "1", "the last revolutions that `last` saves; default 2, or all where there are fewer", optional=True
)
_ORBITS = Word(("none", "last", "all"), "which time histories are saved", "last")
_METHOD = Word(
    ("auto", "explicit", "implicit"),
    "explicit Runge-Kutta, implicit Radau IIA, or whichever the motion asks for",
    "auto",
)


_ONSET = Word(
    ("first", "renewed"),
    "how long the rate counts at which a contact began: as long as it lasts, or until it has proved lasting",
    "renewed",
    sweep=True,
    idle=True,
)


def shape(mechanism: Mechanism, catalogue: Catalogue) -> Shape:
    """Return every dotted path that a grid of this mechanism may contain, sections before what they hold."""
    kinds = tuple(each.name for each in catalogue.mechanisms)
    tree: Shape = {"mechanism": Section("the bodies"), "mechanism.type": Word(kinds, "which mechanism")}
    for keys in mechanism.keys:
        _keys(tree, keys, catalogue)
    always = [site for site in mechanism.joints if site.kind == "line"]
    if always:
        tree["joints"] = Section("the joint")
    else:
        tree["joints"] = Section("the joints that have clearance; one that is not named is ideal", "implied")
    for site in mechanism.joints:
        _SITES[site.kind](tree, f"joints.{site.name}", site, catalogue)
    if mechanism.turns:
        _revolutions(tree, settling(catalogue, mechanism), settling(catalogue, mechanism, settles=False))
    else:
        _impacts(tree)
    if mechanism.free:
        _numbers(tree, "simulate", (_TIME_LIMIT,), sweep=False)
        del tree["simulate.horizon"]  # disturbed, a free crank turns at another speed: the two are not compared
    return tree


def full_shape(mechanism: Mechanism, catalogue: Catalogue) -> Shape:
    """Return every dotted path that any grid of this mechanism may contain, NAME standing for what it names."""
    everything = mechanism.outlined(EVERYTHING)._replace(free=True) if mechanism.outlined else mechanism
    return shape(everything, catalogue)


def _keys(tree: Shape, keys: Keys, catalogue: Catalogue) -> None:
    """Enter a section of a mechanism."""
    if keys.path not in tree:
        tree[keys.path] = Section(keys.text, keys.need, pair=keys.pair)
    for choice in keys.words:
        tree[f"{keys.path}.{choice.name}"] = Word(choice.options, choice.text, choice.default)
    if keys.family:
        usable = tuple(law for law in catalogue.of(keys.family) if not law.remembers)
        names = tuple(law.name for law in usable)
        tree[f"{keys.path}.law"] = Word(names, f"the {keys.family} law", sweep=True, noun="law")
        _laws(tree, keys.path, "law", usable)
    _numbers(tree, keys.path, keys.fields)
    for columns in keys.tables:
        tree[f"{keys.path}.{columns.name}"] = Table(columns)


def _revolutions(tree: Shape, judged: tuple[str, ...], others: tuple[str, ...]) -> None:
    """Enter how long to run what turns, and what to save of it; `until` can judge some figures, and no `others`."""
    tree["simulate"] = Section("how long, how exactly and from where", "implied")
    _numbers(tree, "simulate", _SIMULATE)
    tree["simulate.start"] = Word(("centred", "seated"), "where the journals are at t = 0", "centred")
    tree["simulate.method"] = _METHOD
    _numbers(tree, "simulate", _BUDGETS)
    _numbers(tree, "simulate", _TIME_BUDGET, sweep=False)
    tree["simulate.error_check"], tree["simulate.horizon"] = _ERROR_CHECK, _HORIZON
    tree["simulate.until"] = Section("end a case when a figure has settled or its motion is periodic", "optional")
    text = "the column of the summary whose 95 % interval is judged"
    tree["simulate.until.figure"] = Word(judged, text, refused=dict.fromkeys(others, _NO_INTERVAL))
    _numbers(tree, "simulate.until", _UNTIL, sweep=False)
    tree["save"], tree["save.orbits"] = Section("what is kept", "implied"), _ORBITS
    _numbers(tree, "save", (_SAVED, _SAMPLES), sweep=False)


def _impacts(tree: Shape) -> None:
    """Enter how long to run what does not turn, and what to save of it."""
    tree["simulate"] = Section("how long and how exactly", "implied")
    _numbers(tree, "simulate", (_IMPACTS, _TOLERANCE, *_BUDGETS))
    _numbers(tree, "simulate", _TIME_BUDGET, sweep=False)
    tree["simulate.method"] = _METHOD
    tree["simulate.error_check"] = _ERROR_CHECK
    tree["save"], tree["save.orbits"] = Section("what is kept", "implied"), _ORBITS
    _numbers(tree, "save", (_SAMPLES,), sweep=False)


def _numbers(tree: Shape, path: str, fields: tuple[Field, ...], *, sweep: bool = True) -> None:
    """Enter keys that are in use whatever laws are chosen."""
    for field in fields:
        tree[f"{path}.{field.name}"] = Number((Use(field),), sweep)


def _gap(tree: Shape, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Enter a gap on a line, which has clearance always."""
    tree[path] = Section("the gap between the bodies")
    _numbers(tree, path, (Field("clearance", "m", "half the gap in all"),))
    _contact(tree, path, catalogue)
    _roughness(tree, path, catalogue)
    _film(tree, path, catalogue)
    elastic, film = (word_key(tree, f"{path}.{key}") for key in ("contact.elastic", "film.law"))
    for field in _GAP_SIZES:
        tree[f"{path}.{field.name}"] = Number(
            (Use(field, elastic.when), Use(field, ((f"{path}.film.law", frozenset(film.options)),)))
        )


def _revolute(tree: Shape, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Enter a revolute joint with clearance."""
    tree[path] = Section("a revolute joint with clearance", "optional")
    _numbers(
        tree,
        path,
        (
            Field("clearance", "m", "radial clearance, or a fit of ISO 286 as {fit: H7/f7}", fit=True),
            Field("bearing_radius", "m", "radius of the bearing; the journal's is smaller by the clearance"),
            _LENGTH_OF_PIN,
        ),
    )
    tree[f"{path}.journal"] = Word(site.journals, "the body that the journal sits on", site.journals[0])
    _contact(tree, path, catalogue)
    _roughness(tree, path, catalogue)
    _film(tree, path, catalogue)
    _friction(tree, path, catalogue)
    wear = f"{path}.wear"
    tree[wear] = Section("wear; left out: none is computed", "optional")
    tree[f"{wear}.law"] = Word(catalogue.names("wear"), "the wear law", sweep=True, noun="law")
    tree[f"{wear}.coefficient_unit"] = Word(
        ("m^2/N", DIMENSIONLESS),
        "what the coefficients are in; default dimensionless, k times the hardness, where bare numbers stand beside "
        "`hardness`",
        "m^2/N",
    )
    tree[f"{wear}.running_in"] = Section("a coefficient that falls as the surfaces run in", "optional")
    _coefficients(tree, wear, _WEAR)
    _coefficients(tree, f"{wear}.running_in", _RUNNING_IN)
    _numbers(tree, f"{wear}.running_in", (_DISTANCE,))
    _numbers(tree, wear, (_HARDNESS, _PV_LIMIT))
    _numbers(tree, wear, (_BINS,), sweep=False)
    tree[f"{wear}.pressure"] = Word(
        catalogue.names("pressure"),
        "the pressure over the contact arc; default hertz-line where there is a material or a pressure_modulus",
        "mean",
        sweep=True,
        noun="law",
        rather=("hertz-line", moduli(path)),
    )
    _laws(tree, wear, "law", catalogue.of("wear"))
    _laws(tree, wear, "pressure", catalogue.of("pressure"))


def _coefficients(tree: Shape, path: str, fields: tuple[Field, ...]) -> None:
    """Enter wear coefficients, which have a unit, or are dimensionless beside a hardness."""
    unit = f"{path.removesuffix('.running_in')}.coefficient_unit"
    for field in fields:
        number = field._replace(unit="1", low_open=False)
        uses = (Use(field, ((unit, frozenset(("m^2/N",))),)), Use(number, ((unit, frozenset((DIMENSIONLESS,))),)))
        tree[f"{path}.{field.name}"] = Number(uses)


def _guide(tree: Shape, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Enter a prismatic joint with clearance: a block between two walls."""
    tree[path] = Section("a prismatic joint with clearance, a block between two walls", "optional")
    _numbers(tree, path, _GUIDE)
    pointed = tuple(law for law in catalogue.laws if law.family != "elastic" or not law.needs)  # a corner has no radius
    _contact(tree, path, catalogue._replace(laws=pointed))
    for inner in [inner for inner in tree if inner.startswith(f"{path}.contact.material")]:
        del tree[inner]
    onset = word_key(tree, f"{path}.contact.onset")  # the mass that takes part in a corner's impact is not known
    tree[f"{path}.contact.onset"] = onset._replace(
        options=("first",),
        default="first",
        text="how long the rate counts at which a contact began: as long as it lasts",
    )
    _friction(tree, path, catalogue._replace(laws=tuple(law for law in catalogue.laws if not law.remembers)))


def _either(tree: Shape, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Enter a joint of which the grid says whether it is a pin or a guide: all keys of both."""
    _revolute(tree, path, site, catalogue)
    tree[path] = Section("a joint with clearance", "optional")
    _numbers(tree, path, tuple(field._replace(text=f"of a guide: {field.text}", optional=True) for field in _GUIDE[2:]))


_SITES = {"line": _gap, "revolute": _revolute, "guide": _guide, ANY: _either}


def _roughness(tree: Shape, path: str, catalogue: Catalogue) -> None:
    """Enter the roughness of the surfaces of a joint."""
    rough = f"{path}.roughness"
    tree[rough] = Section("rough surfaces, in series with the elastic law; left out: smooth ones", "optional")
    tree[f"{rough}.law"] = Word(catalogue.names("roughness"), "the roughness law", sweep=True, noun="law")
    _laws(tree, rough, "law", catalogue.of("roughness"))


def _film(tree: Shape, path: str, catalogue: Catalogue) -> None:
    """Enter the film of oil of a joint, which may do without a dry contact."""
    tree[f"{path}.contact"] = section_key(tree, f"{path}.contact")._replace(unless="film")
    film = f"{path}.film"
    tree[film] = Section("a film of oil; left out: none", "optional")
    tree[f"{film}.law"] = Word(catalogue.names("film"), "the law of the film's force", sweep=True, noun="law")
    _numbers(tree, film, (film_keys.VISCOSITY,))
    _numbers(tree, f"{film}.viscosity", film_keys.OIL)
    _numbers(tree, film, (film_keys.TEMPERATURE, *film_keys.FILM))
    tree[f"{film}.thermal"] = Section(
        "a heat balance gives the temperature: ambient + mean loss / conductance", "optional"
    )
    _numbers(tree, f"{film}.thermal", film_keys.THERMAL)
    tree[f"{film}.friction"] = Word(
        ("by-law", *catalogue.names("film-friction")),
        "the couple of the film's shear; by-law: butenschoen for finite, petroff for short, else sommerfeld",
        "by-law",
        sweep=True,
        noun="law",
    )
    tree[f"{film}.transition"] = Section("how the dry contact takes over", "implied", needs="contact")
    transition = f"{film}.transition"
    tree[f"{transition}.law"] = Word(
        catalogue.names("transition"), "how the dry contact takes over", "ramp", sweep=True, noun="law"
    )
    _numbers(tree, transition, film_keys.TRANSITION)
    _laws(tree, transition, "law", catalogue.of("transition"))


def _friction(tree: Shape, path: str, catalogue: Catalogue) -> None:
    """Enter the friction of a joint."""
    tree[f"{path}.friction"] = Section("friction; left out: none", "optional")
    tree[f"{path}.friction.law"] = Word(catalogue.names("friction"), "the friction law", sweep=True, noun="law")
    _laws(tree, f"{path}.friction", "law", catalogue.of("friction"))


def moduli(joint: str) -> tuple[str, ...]:
    """Return the paths of a joint that give the modulus of its wear's pressure."""
    return f"{joint}.contact.material", f"{joint}.wear.pressure_modulus"


def _contact(tree: Shape, path: str, catalogue: Catalogue) -> None:
    """Enter the normal force of a joint: its law, its elastic part, and the keys of both."""
    contact = f"{path}.contact"
    elastic = ((f"{contact}.law", frozenset(law.name for law in catalogue.of("law") if law.uses_elastic)),)
    tree[contact] = Section("the normal force")
    tree[f"{contact}.law"] = Word(catalogue.names("law"), "the law of the normal force", sweep=True, noun="law")
    tree[f"{contact}.elastic"] = Word(
        catalogue.names("elastic"), "the stiffness law", "power", sweep=True, noun="law", when=elastic
    )
    onset = ((f"{contact}.law", frozenset(law.name for law in catalogue.of("law") if law.uses_onset)),)
    tree[f"{contact}.onset"] = _ONSET._replace(when=onset)
    _laws(tree, contact, "elastic", catalogue.of("elastic"), elastic)
    _laws(tree, contact, "law", catalogue.of("law"))
    material = f"{contact}.material"
    tree[material] = Section("the material of both bodies; gives the stiffness where none is written", "optional")
    for field in _MATERIAL:
        both = field._replace(text=f"{field.text} of both bodies; required unless each has its own", optional=True)
        tree[f"{material}.{field.name}"] = Number((Use(both, elastic),))
    for body in Materials._fields:
        tree[f"{material}.{body}"] = Section(f"the {body}'s own material; write both bodies', or neither", "optional")
        for field in _MATERIAL:
            own = field._replace(text=f"{field.text} of the {body}")
            tree[f"{material}.{body}.{field.name}"] = Number((Use(own, elastic),))


def _laws(tree: Shape, path: str, key: str, laws: tuple[Law, ...], when: tuple[Condition, ...] = ()) -> None:
    """Enter the keys of laws among which `key` chooses; a key that several have means what the chosen one says."""
    for law in laws:
        for field in law.fields:
            use = Use(field, (*when, (f"{path}.{key}", frozenset((law.name,)))))
            known = tree.get(f"{path}.{field.name}")
            uses = known.uses if isinstance(known, Number) else ()
            if not uses or any(other.when for other in uses):
                tree[f"{path}.{field.name}"] = Number((*uses, use))
    tables = {
        columns: frozenset(law.name for law in laws if columns in law.tables) for law in laws for columns in law.tables
    }
    for columns, names in tables.items():
        tree[f"{path}.{columns.name}"] = Table(columns, (*when, (f"{path}.{key}", names)), optional=True)
