"""Keys of varied user-defined quantities, and checks of the numbers that depend on them."""

import math

from ..contracts.catalogue import Field
from .defined import DEFINE, START, TEXT, Definitions
from .document import WrittenValue
from .keys import Number, Section, Shape, Use
from .reader import Reader


def keys_of(definitions: Definitions) -> Shape:
    """Return the keys of the user-defined quantities that an axis varies."""
    if not definitions.varied:
        return {}
    names = [name for name in definitions.texts if name in definitions.varied]
    fields = {name: Field(name, definitions.units[name], "defined by the grid", low=-math.inf) for name in names}
    numbers = {f"{START}{name}": Number((Use(field),)) for name, field in fields.items()}
    return {DEFINE: Section(TEXT, need="optional"), **numbers}


def check(reader: Reader) -> None:
    """Report numbers that cannot depend on a varied name, and dependent values out of range."""
    for path, text in reader.defined.follow.items():
        node, name = reader.shape.get(path), min(reader.defined.varied_in(text))
        whose = f"depends on {START}{name}, which varies"
        fields = node.fields(reader.names) if isinstance(node, Number) else ()
        if not isinstance(node, Number) or not node.sweep or path.endswith(".exponent"):
            reader.problems.add(reader.place(path), path, f"{whose}; this value cannot: write it without that name")
            continue
        if any(field.whole for field in fields):
            sentence = f"{whose}; a whole number cannot: use names that are not varied"
            reader.problems.add(reader.place(path), path, sentence)
            continue
        wrong = [(field, value) for value in reader.reached(path) for field in fields if not field.contains(value)]
        for field, value in wrong[:1]:
            sentence = f"= {text} comes to {value:.6g}, out of range; allowed: {field.allowed(value)}"
            reader.problems.add(reader.swept[f"{START}{name}"], path, sentence)


def refuse_columns(reader: Reader, section: WrittenValue | None) -> None:
    """Report names in `define` that are also columns of the summary."""
    for name in reader.defined.texts:
        if section is not None and name in reader.figures:
            sentence = "is the name of a column of the summary; give the quantity another name"
            reader.problems.add(section.key_place(name), f"{START}{name}", sentence)
