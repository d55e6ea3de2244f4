"""Checks of joints with an oil film."""

from collections.abc import Sequence

from ..contracts.catalogue import Catalogue, Law
from .keys import Section
from .reader import Reader


def check(reader: Reader, catalogue: Catalogue) -> None:
    """Report values that conflict with each other."""
    films = [path for path, node in reader.shape.items() if isinstance(node, Section) and _is_film(path)]
    for film in films:
        joint = film.removesuffix(".film")
        _sizes(reader, joint, catalogue)
        _heat(reader, film)
        _modulus(reader, joint)
        if f"{joint}.contact" not in reader.shape and f"{joint}.contact" not in reader.broken:
            _nothing_behind(reader, joint)
    if films:
        _beside_films(reader, films[0].removesuffix(".film"), catalogue)


def _is_film(path: str) -> bool:
    return path.startswith("joints.") and path.endswith(".film") and path.count(".") == 2


def _sizes(reader: Reader, joint: str, catalogue: Catalogue) -> None:
    """Check that length and radius are given and that the film's laws are valid for them."""
    length, radius, law = f"{joint}.length", f"{joint}.bearing_radius", f"{joint}.film.law"
    for path, example in ((length, "length along the pin, such as 40 mm"), (radius, "bearing's radius, such as 20 mm")):
        if not reader.there(path):
            reader.problems.add(reader.place(f"{joint}.film"), path, f"is missing; a film needs the {example}")
    lengths, radii = reader.reached(length), reader.reached(radius)
    if law in reader.unsure or not lengths or not radii:
        return
    pairs = list(zip(lengths, radii, strict=False)) if reader.in_step(length, radius) else _extremes(lengths, radii)
    for chosen in (chosen for chosen in catalogue.of("film") if chosen.name in reader.names[law]):
        _slenderness(reader, joint, chosen, [axial_length / (2.0 * across) for axial_length, across in pairs])


def _extremes(lengths: Sequence[float], radii: Sequence[float]) -> list[tuple[float, float]]:
    """Return length and radius of the most and the least slender bearing of all combinations."""
    return [(max(lengths), min(radii)), (min(lengths), max(radii))]


def _slenderness(reader: Reader, joint: str, law: Law, reached: list[float]) -> None:
    """Check that a law is valid for the ratios of length to diameter."""
    limits = ((limit, value) for limit in law.ranges for value in reached if not limit.contains(value))
    limit, value = next(limits, (None, 0.0))
    if limit:
        left_out = not reader.there(f"{joint}.film.law")
        named = f"film '{law.name}'{', the law where none is written,' if left_out else ''}"
        allowed = f"{limit.low:g} to {limit.high:g}" if limit.low else f"at most {limit.high:g}"
        reader.problems.add(
            reader.place(f"{joint}.length"),
            f"{joint}.length",
            f"found {value:.4g} bearing diameters; {named} allows {allowed}: {limit.reason}",
        )


def _heat(reader: Reader, film: str) -> None:
    """Check that viscosity falls with temperature, and that a temperature is given only with an oil."""
    if f"{film}.thermal" in reader.sections and not reader.mechanism.turns:
        sentence = "needs a mechanism with revolutions; give a temperature instead"
        reader.problems.add(reader.place(f"{film}.thermal"), f"{film}.thermal", sentence)
    oil, balance, temperature = f"{film}.viscosity", f"{film}.thermal", f"{film}.temperature"
    if oil not in reader.sections:
        for path in (balance, temperature):
            if reader.there(path):
                sentence = (
                    "has no effect, because the viscosity is constant; use viscosity: {at_40C: 46 mm^2/s, "
                    "at_100C: 6.8 mm^2/s, density: 870 kg/m^3}"
                )
                reader.problems.add(reader.place(path), path, sentence)
        return
    cold, warm = reader.reached(f"{oil}.at_40C"), reader.reached(f"{oil}.at_100C")
    if cold and warm and max(warm) >= min(cold):
        sentence = f"found {max(warm):.4g} m^2/s; allowed: below {min(cold):.4g}, at_40C: oil thins as it warms up"
        reader.problems.add(reader.place(f"{oil}.at_100C"), f"{oil}.at_100C", sentence)
    if reader.there(balance) == reader.there(temperature):
        sentence = "is missing; for example: temperature: 60 degC, or thermal: {conductance: 20 W/K, ambient: 40 degC}"
        if reader.there(balance):
            sentence = "conflicts with `thermal`, which determines it; remove one of the two"
        reader.problems.add(reader.place(film), temperature, sentence)


def _modulus(reader: Reader, joint: str) -> None:
    """Check that asperity contact has a modulus."""
    law, modulus = f"{joint}.film.transition.law", f"{joint}.film.transition.modulus"
    known = reader.there(modulus) or reader.there(f"{joint}.contact.material")
    if law in reader.shape and "greenwood-tripp" in reader.names[law] and not known:
        sentence = "is missing; write E* of both bodies, such as 114 GPa for steel, or contact.material"
        reader.problems.add(reader.place(f"{joint}.film"), modulus, sentence)


def _nothing_behind(reader: Reader, joint: str) -> None:
    """Check that a joint without dry contact has no keys of a dry contact."""
    for part in ("friction", "wear", "film.transition"):
        if f"{joint}.{part}" in reader.sections and reader.there(f"{joint}.{part}"):
            path = f"{joint}.{part}"
            if part == "film.transition" and not _written(reader, joint):
                continue
            sentence = (
                "applies to the dry contact under a film, but the joint has no contact; add contact, or remove the key"
            )
            reader.problems.add(reader.place(path), path, sentence)


def _written(reader: Reader, joint: str) -> bool:
    film = reader.sections[f"{joint}.film"].value
    return isinstance(film, dict) and "transition" in film


def _beside_films(reader: Reader, joint: str, catalogue: Catalogue) -> None:
    """Check that a joint with a film has no key that conflicts with it."""
    sticking = {law.name for law in catalogue.of("friction") if law.sticks}
    for path in (path for path in reader.names if path.endswith(".friction.law")):
        for law in sorted(reader.names[path] & sticking):
            sentence = f"{law} sticks, which is not available with the film of {joint}; choose another"
            reader.problems.add(reader.place(path), path, sentence)
    if "seated" in reader.reached("simulate.start"):
        sentence = (
            f"cannot be seated in the film of {joint}, which carries no load at rest; remove the key, or use centred"
        )
        reader.problems.add(reader.place("simulate.start"), "simulate.start", sentence)
