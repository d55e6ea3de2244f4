"""What a grid file may contain: every key with its unit, range, default and meaning."""

from math import inf

from ..catalogue import Catalogue, Field, Law
from .keys import Condition, Flag, Number, Section, Shape, Use, Word

MECHANISMS = ("slider-crank", "impact-pair")
JOINTS = {"ground-crank": ("crank", "ground"), "crank-rod": ("rod", "crank"), "rod-slider": ("rod", "slider")}
_LENGTH = Field("length", "m", "distance between its pins")
_CENTER = Field(
    "center",
    "m",
    "distance of the centre of mass from the pin nearer the drive; default: half the length",
    -inf,
    optional=True,
)
_CRANK = (
    _LENGTH,
    Field("mass", "kg", "mass", low_open=False),
    Field("inertia", "kg*m^2", "moment of inertia about the centre of mass", low_open=False),
    _CENTER,
)
_ROD = (
    _LENGTH,
    Field("mass", "kg", "mass"),
    Field("inertia", "kg*m^2", "moment of inertia about the centre of mass"),
    _CENTER,
)
_COEFFICIENT = Field(
    "coefficient",
    "m^2/N",
    "wear coefficient of both bodies, depth per pressure and sliding distance",
    low_open=False,
    optional=True,
)
_WEAR = (
    _COEFFICIENT,
    _COEFFICIENT._replace(name="bearing_coefficient", text="wear coefficient of the bearing; overrides `coefficient`"),
    _COEFFICIENT._replace(name="journal_coefficient", text="wear coefficient of the journal; overrides `coefficient`"),
    Field(
        "hardness", "Pa", "hardness of the softer body; only checks that the coefficient is plausible", optional=True
    ),
)
_MATERIAL = (
    Field("young", "Pa", "Young's modulus of both bodies"),
    Field("poisson", "1", "Poisson's ratio of both bodies", -1.0, 0.5, high_open=False),
)
_LENGTH_OF_PIN = Field("length", "m", "length along the pin; wear and the laws of cylinders need it", optional=True)
_PAIR_SIZES = (
    Field("bearing_radius", "m", "radius of the bearing; the laws of cylinders need it", optional=True),
    _LENGTH_OF_PIN,
)
_TOLERANCE = Field("tolerance", "1", "relative local tolerance", 1e-13, 1e-2, False, False, 1e-8)
_BUDGETS = (
    Field(
        "step_budget",
        "1",
        "steps per revolution after which a case is given up",
        1,
        inf,
        False,
        True,
        1_000_000,
        whole=True,
    ),
    Field(
        "event_budget",
        "1",
        "contact events per revolution after which a case is given up",
        1,
        inf,
        False,
        True,
        100_000,
        whole=True,
    ),
)
_SIMULATE = (
    Field("revolutions", "1", "crank revolutions, `discard` included; with `until` the fewest", default=10.0),
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
    Field("max_revolutions", "1", "revolutions after which the run ends in any case", default=500.0),
)
_HORIZON = Flag("find the Lyapunov exponent and how far ahead the motion can be foretold, by a second run beside it")
_ERROR_CHECK = Flag("run each case again at a tenth of the tolerance and store how far every figure differs")
_IMPACTS = Field("impacts", "1", "impacts after which the run ends", 1, inf, False, True, 10, whole=True)
_SAMPLES = Field("samples", "1", "samples per revolution (impact-pair: in all)", 1, 1e7, False, False, 720, whole=True)
_SAVED = Field(
    "revolutions", "1", "the last revolutions that `last` saves; default 2, or all where there are fewer", optional=True
)
_ORBITS = Word(("none", "last", "all"), "which time histories are saved", "last")
_METHOD = Word(
    ("auto", "explicit", "implicit"),
    "explicit Runge-Kutta, implicit Radau IIA, or whichever the motion asks for",
    "auto",
)


def shape(mechanism: str, catalogue: Catalogue) -> Shape:
    """Return every dotted path that a grid of this mechanism may contain, sections before what they hold."""
    tree: Shape = {"mechanism": Section("the bodies"), "mechanism.type": Word(MECHANISMS, "which mechanism")}
    if mechanism == "impact-pair":
        tree["mechanism.masses"] = Section("masses of the two bodies", pair=True)
        _numbers(
            tree,
            "mechanism.masses",
            (Field("0", "kg", "mass of the first body"), Field("1", "kg", "mass of the second body")),
        )
        _numbers(tree, "mechanism", (Field("speed", "m/s", "speed at which the bodies approach each other"),))
        tree["joints"], tree["joints.pair"] = Section("the joint"), Section("the gap between the bodies")
        _numbers(tree, "joints.pair", (Field("clearance", "m", "half the gap in all"),))
        _contact(tree, "joints.pair", catalogue)
        for field in _PAIR_SIZES:
            tree[f"joints.pair.{field.name}"] = Number((Use(field, tree["joints.pair.contact.elastic"].when),))
        tree["simulate"] = Section("how long and how exactly", "implied")
        _numbers(tree, "simulate", (_IMPACTS, _TOLERANCE, *_BUDGETS))
        tree["simulate.method"] = _METHOD
        tree["simulate.error_check"] = _ERROR_CHECK
        tree["save"], tree["save.orbits"] = Section("what is kept", "implied"), _ORBITS
        _numbers(tree, "save", (_SAMPLES,), sweep=False)
        return tree
    for body, fields in (("crank", _CRANK), ("rod", _ROD), ("slider", (Field("mass", "kg", "mass"),))):
        tree[f"mechanism.{body}"] = Section(f"the {body}")
        _numbers(tree, f"mechanism.{body}", fields)
    _numbers(tree, "mechanism", (Field("gravity", "m/s^2", "gravity, along -y", -inf, default=0.0),))
    tree["drive"] = Section("the drive", "implied")
    _numbers(tree, "drive", (Field("speed", "rad/s", "constant crank speed"),))
    tree["joints"] = Section("the joints that have clearance; one that is not named is ideal", "implied")
    for joint, bodies in JOINTS.items():
        _joint(tree, f"joints.{joint}", bodies, catalogue)
    tree["simulate"] = Section("how long, how exactly and from where", "implied")
    _numbers(tree, "simulate", _SIMULATE)
    tree["simulate.start"] = Word(("centred", "seated"), "where the journals are at t = 0", "centred")
    tree["simulate.method"] = _METHOD
    _numbers(tree, "simulate", _BUDGETS)
    tree["simulate.error_check"], tree["simulate.horizon"] = _ERROR_CHECK, _HORIZON
    tree["simulate.until"] = Section("end a case when a figure has settled or its motion is periodic", "optional")
    tree["simulate.until.figure"] = Word(_settling(), "the column of the summary whose 95 % interval is judged")
    _numbers(tree, "simulate.until", _UNTIL, sweep=False)
    tree["save"], tree["save.orbits"] = Section("what is kept", "implied"), _ORBITS
    _numbers(tree, "save", (_SAVED, _SAMPLES), sweep=False)
    return tree


def _settling() -> tuple[str, ...]:
    """Return the figures that `until` can judge with clearance and wear in every joint."""
    from ..results import JointLayout, Layout, settling

    return settling(Layout("slider-crank", tuple(JointLayout(joint.replace("-", "_"), 1) for joint in JOINTS)))


def _numbers(tree: Shape, path: str, fields: tuple[Field, ...], *, sweep: bool = True) -> None:
    """Enter keys that are in use whatever laws are chosen."""
    for field in fields:
        tree[f"{path}.{field.name}"] = Number((Use(field),), sweep)


def _joint(tree: Shape, path: str, bodies: tuple[str, str], catalogue: Catalogue) -> None:
    """Enter a revolute joint with clearance; the journal sits on the first of its two bodies unless it is said."""
    tree[path] = Section("a revolute joint with clearance", "optional")
    _numbers(
        tree,
        path,
        (
            Field("clearance", "m", "radial clearance"),
            Field("bearing_radius", "m", "radius of the bearing; the journal's is smaller by the clearance"),
            _LENGTH_OF_PIN,
        ),
    )
    tree[f"{path}.journal"] = Word(bodies, "the body that the journal sits on", bodies[0])
    _contact(tree, path, catalogue)
    tree[f"{path}.friction"] = Section("friction; left out: none", "optional")
    tree[f"{path}.friction.law"] = Word(catalogue.names("friction"), "the friction law", law=True)
    _laws(tree, f"{path}.friction", "law", catalogue.of("friction"))
    wear = f"{path}.wear"
    tree[wear] = Section("wear; left out: none is computed", "optional")
    tree[f"{wear}.law"] = Word(catalogue.names("wear"), "the wear law", law=True)
    _numbers(tree, wear, _WEAR)
    _numbers(
        tree,
        wear,
        (Field("bins", "1", "angular bins round each body", 8, 1e6, False, False, 360, whole=True),),
        sweep=False,
    )
    tree[f"{wear}.pressure"] = Word(
        catalogue.names("pressure"), "the pressure over the contact arc", "hertz-line", law=True
    )
    _laws(tree, wear, "law", catalogue.of("wear"))
    _laws(tree, wear, "pressure", catalogue.of("pressure"))


def _contact(tree: Shape, path: str, catalogue: Catalogue) -> None:
    """Enter the normal force of a joint: its law, its elastic part, and the keys of both."""
    contact = f"{path}.contact"
    elastic = ((f"{contact}.law", frozenset(law.name for law in catalogue.of("law") if law.uses_elastic)),)
    tree[contact] = Section("the normal force")
    tree[f"{contact}.law"] = Word(catalogue.names("law"), "the hysteresis law", law=True)
    tree[f"{contact}.elastic"] = Word(catalogue.names("elastic"), "the stiffness law", "power", law=True, when=elastic)
    _laws(tree, contact, "elastic", catalogue.of("elastic"), elastic)
    _laws(tree, contact, "law", catalogue.of("law"))
    tree[f"{contact}.material"] = Section(
        "the material of both bodies; gives the stiffness where none is written", "optional"
    )
    for field in _MATERIAL:
        tree[f"{contact}.material.{field.name}"] = Number((Use(field, elastic),))


def _laws(tree: Shape, path: str, key: str, laws: tuple[Law, ...], when: tuple[Condition, ...] = ()) -> None:
    """Enter the keys of laws among which `key` chooses; a key that several have means what the chosen one says."""
    for law in laws:
        for field in law.fields:
            use = Use(field, (*when, (f"{path}.{key}", frozenset((law.name,)))))
            known = tree.get(f"{path}.{field.name}")
            if known is None or any(other.when for other in known.uses):
                tree[f"{path}.{field.name}"] = Number((*(known.uses if known else ()), use))
