"""The checks that need several values of a grid at once, over all values that its axes reach."""

import math

from ..catalogue import Catalogue, Law
from ..errors import nearest
from .draft import Draft
from .keys import Section
from .values import exponent_values

_LARGEST_WEAR = 0.1  # dimensionless wear coefficient k * hardness; above, a body would lose what it touches


def check(read: Draft, catalogue: Catalogue) -> None:
    """Note what does not fit together."""
    for low, high, reason in read.mechanism.orders:
        _below(read, low, high, reason)
    _below(read, "simulate.discard", "simulate.revolutions", "nothing would be left")
    _below(read, "save.revolutions", "simulate.revolutions", "more cannot be saved than is run", equal=True)
    _until(read)
    joints = [path for path, node in read.shape.items() if isinstance(node, Section) and _is_joint(path)]
    if not joints and "joints" in read.shape and read.shape["joints"].need == "implied":
        text = f"no joint has clearance; name at least one of {', '.join(site.name for site in read.mechanism.joints)}"
        read.problems.add(read.place("joints"), "joints", text)
    for path in joints:
        _below(read, f"{path}.clearance", f"{path}.bearing_radius", "the journal would have no radius")
        _below(read, f"{path}.friction.v0", f"{path}.friction.v1", "friction grows from v0 to v1")
        _elastic(read, path, catalogue)
        if f"{path}.wear" in read.shape:
            _wear(read, path)
            _pressure(read, path, catalogue)


def _until(read: Draft) -> None:
    """Check that the figure that `until` judges is one of this grid, and that its longest run is not the shorter."""
    least, most = read.reached("simulate.revolutions"), read.reached("simulate.until.max_revolutions")
    if least and most and min(most) < max(least):
        path = "simulate.until.max_revolutions"
        sentence = (
            f"found {min(most):.15g}; allowed: at least {max(least):.15g}, the value of simulate.revolutions, the "
            "shortest run"
        )
        read.problems.add(read.place(path), path, sentence)
    path = "simulate.until.figure"
    figure = read.values.get(path)
    if figure and figure not in read.figures:
        names = [name for name in read.shape[path].options if name in read.figures]
        sentence = f"{figure} is no figure of this grid{nearest(figure, names)} (known: {', '.join(names)})"
        read.problems.add(read.place(path), path, sentence)


def _is_joint(path: str) -> bool:
    return path.startswith("joints.") and path.count(".") == 1


def _below(read: Draft, low: str, high: str, reason: str, *, equal: bool = False) -> None:
    """Note a problem unless every value of `low` is below every value of `high`; values left out are no problem."""
    lows, highs = read.reached(low), read.reached(high)
    if not lows or not highs or max(lows) < min(highs) or (equal and max(lows) == min(highs)):
        return
    if read.in_step(low, high):
        wrong = [(a, b) for a, b in zip(lows, highs, strict=False) if not (a < b or (equal and a == b))]
        if not wrong:
            return
        lows, highs = zip(*wrong[:1], strict=True)
    where = low if low in read.swept or low in read.written else high
    word = "at most" if equal else "below"
    read.problems.add(
        read.place(where),
        where,
        f"found {max(lows):.15g}; allowed: {word} {min(highs):.15g}, the value of {high}; {reason}",
    )


def _there(read: Draft, path: str) -> bool:
    """Return whether a value or a section is written, or swept."""
    return path in read.written or path in read.swept or path in read.sections


_EXAMPLES = {
    "length": "the joint's length along the pin, such as 20 mm",
    "bearing_radius": "the radius of the bearing, such as 10 mm",
    "contact.material": "both bodies' material, such as {young: 207 GPa, poisson: 0.3}",
}


def _elastic(read: Draft, joint: str, catalogue: Catalogue) -> None:
    """Check that the joint has what its stiffness laws need, in the range they hold for."""
    law, elastic = f"{joint}.contact.law", f"{joint}.contact.elastic"
    known = elastic in read.shape and read.unsure.isdisjoint((law, elastic))
    if not known or not read.shape[elastic].used(read.names):
        return
    for found in (catalogue.find("elastic", name) for name in sorted(read.names[elastic])):
        for path in _needed(read, joint, found):
            if not _there(read, f"{joint}.{path}"):
                sentence = f"is missing; elastic '{found.name}' needs {_EXAMPLES[path]}"
                read.problems.add(read.place(elastic), f"{joint}.{path}", sentence)
        for path, low, high, unit, reason in found.ranges:
            outside = [value for value in read.reached(f"{joint}.{path}") if not low <= value <= high]
            if outside:
                sentence = (
                    f"found {outside[0]:.15g}; elastic '{found.name}' allows {low:.15g} to {high:.15g}"
                    f"{'' if unit == '1' else f' ({unit})'}: {reason}"
                )
                read.problems.add(read.place(f"{joint}.{path}"), f"{joint}.{path}", sentence)


def _needed(read: Draft, joint: str, law: Law) -> tuple[str, ...]:
    """Return the paths within the joint of what an elastic law needs besides its own fields."""
    needed = tuple("contact.material" if name == "material" else name for name in law.needs)
    from_material = law.name == "power" and not _there(read, f"{joint}.contact.stiffness")
    sized = needed or (from_material and _there(read, f"{joint}.contact.material"))
    radius = read.shape[f"{joint}.bearing_radius"]
    return ("bearing_radius", *needed) if sized and radius.uses[0].field.optional else needed


def _wear(read: Draft, joint: str) -> None:
    """Check what wear needs of its joint, and that its coefficient is possible."""
    wear = f"{joint}.wear"

    def there(path: str) -> bool:
        return _there(read, path)

    if not there(f"{joint}.length"):
        sentence = "is missing; wear needs the joint's length along the pin, such as 20 mm"
        read.problems.add(read.place(wear), f"{joint}.length", sentence)
    overridden = there(f"{wear}.bearing_coefficient") and there(f"{wear}.journal_coefficient")
    if not there(f"{wear}.coefficient") and not overridden:
        sentence = (
            "is missing; write such as 2e-14 m^2/N for both bodies, or bearing_coefficient and journal_coefficient"
        )
        read.problems.add(read.place(wear), f"{wear}.coefficient", sentence)
    if f"{wear}.coefficient" in read.swept and overridden:
        sentence = "is swept but not in use: bearing_coefficient and journal_coefficient override it"
        read.problems.add(read.swept[f"{wear}.coefficient"], f"{wear}.coefficient", sentence)
    hardness = max(read.reached(f"{wear}.hardness"), default=0.0)
    for path in (f"{wear}.coefficient", f"{wear}.bearing_coefficient", f"{wear}.journal_coefficient"):
        largest = max(read.reached(path), default=0.0)
        if largest * hardness > _LARGEST_WEAR:
            sentence = (
                f"found {largest:.15g} m^2/N, times the hardness {hardness:.15g} Pa {largest * hardness:.3g}; allowed: "
                f"at most {_LARGEST_WEAR}; is the coefficient in mm^2/N? (1 mm^2/N is 1e-6 m^2/N)"
            )
            read.problems.add(read.place(path), path, sentence)


def _pressure(read: Draft, joint: str, catalogue: Catalogue) -> None:
    """Check that Young's modulus, where the pressure of wear needs it, follows from the material or the stiffness."""
    pressures = [catalogue.find("pressure", name) for name in read.names[f"{joint}.wear.pressure"]]
    if not any("modulus" in law.needs for law in pressures):
        return
    contact = f"{joint}.contact"
    law, elastic = f"{contact}.law", f"{contact}.elastic"
    if f"{contact}.material" in read.shape or elastic not in read.shape or not read.unsure.isdisjoint((law, elastic)):
        return
    ((_, with_elastic),) = read.shape[elastic].when
    exponents = exponent_values(read, f"{contact}.stiffness")
    power = read.names[law] <= with_elastic and read.names[elastic] == {"power"}
    if not power or any(not math.isclose(exponent, 1.5) for exponent in exponents):
        sentence = (
            "is missing; the pressure of wear needs Young's modulus: write material: {young: 207 GPa, poisson: 0.3} "
            "(the stiffness of a power law of exponent 1.5 also gives it)"
        )
        read.problems.add(read.place(contact), f"{contact}.material", sentence)
