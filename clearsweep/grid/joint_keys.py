"""Keys that several kinds of joint share: contact, friction and their laws."""

from ..contracts.case import Materials
from ..contracts.catalogue import Catalogue, Field, Law
from ..contracts.layout import PRELOAD
from .film_keys import THERMAL
from .keys import Condition, ConditionalDefault, Name, Number, Section, Shape, Table, Use, Word, word_key
from .library import MATERIALS
from .naming import MATERIAL

JOURNAL = "compatible"  # the elastic law of a journal in a bearing

_MATERIAL = (
    Field("young", "Pa", "Young's modulus"),
    Field("poisson", "1", "Poisson's ratio", -1.0, 0.5, high_open=False),
    Field(
        "yield_strength",
        "Pa",
        "yield strength, only for `J_yield_speed`; default: a hardness / 2.8",
        optional=True,
    ),
)

_ONSET = Word(
    ("first", "renewed"),
    "how long damping depends on the onset rate of a contact: to its end, or until the contact lasts",
    "renewed",
    sweep=True,
    idle=True,
)


def add_numbers(tree: Shape, path: str, fields: tuple[Field, ...], *, sweep: bool = True) -> None:
    """Add keys that are in use with any choice of laws."""
    for field in fields:
        tree[f"{path}.{field.name}"] = Number((Use(field),), sweep)


def add_friction(tree: Shape, path: str, catalogue: Catalogue) -> None:
    """Add the keys of friction in a joint."""
    tree[f"{path}.friction"] = Section("friction; left out: none", "optional")
    tree[f"{path}.friction.law"] = Word(catalogue.names("friction"), "the friction law", sweep=True, noun="law")
    add_laws(tree, f"{path}.friction", "law", catalogue.of("friction"))


_COUPLE = "constant force on the joint, such as a seal's; its friction acts as a couple, friction x bearing_radius"
ALONG = "constant force on the block, such as a seal's; its friction acts along the guide"


def add_preload(tree: Shape, path: str, catalogue: Catalogue, text: str = _COUPLE) -> None:
    """Add the keys of the preload of a pin, or of a guide, which also acts without contact."""
    laws = frozenset(law.name for law in catalogue.of("friction") if not law.sticks)
    use = Use(Field(PRELOAD, "N", text, optional=True), ((f"{path}.friction.law", laws),))
    tree[f"{path}.friction.{PRELOAD}"] = Number((use,))


def add_contact(tree: Shape, path: str, catalogue: Catalogue, contact: str = "") -> None:
    """Add the keys of a joint's normal force, or of that at `contact`: law, elastic part, and parameters."""
    contact = contact or f"{path}.contact"
    elastic = ((f"{contact}.law", frozenset(law.name for law in catalogue.of("law") if law.uses_elastic)),)
    tree[contact] = Section("the normal force")
    tree[f"{contact}.law"] = Word(catalogue.names("law"), "the law of the normal force", sweep=True, noun="law")
    tree[f"{contact}.elastic"] = _elastic(path, catalogue, contact)._replace(when=elastic)
    onset = ((f"{contact}.law", frozenset(law.name for law in catalogue.of("law") if law.uses_onset)),)
    tree[f"{contact}.onset"] = _ONSET._replace(when=onset)
    add_laws(tree, contact, "elastic", catalogue.of("elastic"), elastic)
    add_laws(tree, contact, "law", catalogue.of("law"))
    material = f"{contact}.material"
    tree[material] = Section(
        "the material of both bodies, or its name; gives the stiffness unless that is written", "optional"
    )
    add_material_name(tree, material, "of both bodies")
    for field in _MATERIAL:
        both = field._replace(text=f"{field.text} of both bodies; required unless each has its own", optional=True)
        tree[f"{material}.{field.name}"] = Number((Use(both, elastic),))
    for body in Materials._fields:
        tree[f"{material}.{body}"] = Section(
            f"the material of the {body}, or its name; write both bodies' materials or neither", "optional"
        )
        add_material_name(tree, f"{material}.{body}", f"of the {body}")
        for field in _MATERIAL:
            own = field._replace(text=f"{field.text} of the {body}")
            tree[f"{material}.{body}.{field.name}"] = Number((Use(own, elastic),))


def add_material_name(tree: Shape, path: str, whose: str) -> None:
    """Add the key that names a material; the name may also replace the section."""
    text = f"the name {whose}' material" if whose.endswith("s") else f"the name of the material {whose}"
    tree[f"{path}.{MATERIAL}"] = Name(
        tuple(MATERIALS), f"{text}, of `clearsweep list materials`; numbers next to it override its values"
    )


def _elastic(path: str, catalogue: Catalogue, contact: str) -> Word:
    """Return the key of the elastic law; it defaults to JOURNAL if no stiffness is given but all that it needs is."""
    names = catalogue.names("elastic")
    plain = Word(names, "the stiffness law", "power", sweep=True, noun="law")
    if JOURNAL not in names:
        return plain
    hertzian = frozenset(law.name for law in catalogue.of("law") if "hertz" in law.needs)
    rather = ConditionalDefault(
        JOURNAL,
        all_of=(f"{contact}.material", f"{path}.length", f"{path}.bearing_radius"),
        none_of=(f"{contact}.stiffness", f"{contact}.exponent"),
        unless=(f"{contact}.law", hertzian),
    )
    more = f"default {JOURNAL} with `material` and `length` but without `stiffness` and `exponent`"
    return plain._replace(text=f"{plain.text}; {more}", rather=rather)


def add_thermal(tree: Shape, path: str) -> None:
    """Add the keys of a dry joint's heat balance."""
    thermal = f"{path}.thermal"
    text = "heat balance of dry friction: temperature = ambient + mean friction power / conductance"
    tree[thermal] = Section(f"{text}; left out: the joint stays cold", "optional")
    add_numbers(tree, thermal, THERMAL)
    text = "thermal expansion, which changes the clearance; left out: none"
    tree[f"{thermal}.expansion"] = Section(text, "optional")
    for body in Materials._fields:
        field = Field(body, "1/K", f"expansion of the {body}; default: that of its named material", low_open=False)
        add_numbers(tree, f"{thermal}.expansion", (field,))


def add_laws(tree: Shape, path: str, key: str, laws: tuple[Law, ...], when: tuple[Condition, ...] = ()) -> None:
    """Add the keys of the laws that `key` chooses from; the chosen law decides the meaning of a shared key."""
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


def moduli(joint: str) -> tuple[str, ...]:
    """Return the paths in a joint that determine the modulus for wear pressure."""
    return f"{joint}.contact.material", f"{joint}.wear.pressure_modulus"


def point_laws(catalogue: Catalogue) -> tuple[Law, ...]:
    """Return the contact laws that suit a point without a radius."""
    return tuple(law for law in catalogue.laws if law.family != "elastic" or not law.needs)


def first_onset(tree: Shape, contact: str) -> Word:
    """Return the key `onset` for contacts whose effective impact mass is unknown."""
    text = "how long damping depends on the onset rate of a contact: to its end"
    return word_key(tree, f"{contact}.onset")._replace(options=("first",), default="first", text=text)
