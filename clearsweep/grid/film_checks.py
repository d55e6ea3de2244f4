"""The checks of joints with a film of oil."""

from collections.abc import Sequence

from ..contracts.catalogue import Catalogue, Law
from .draft import Draft
from .keys import Section


def check(draft: Draft, catalogue: Catalogue) -> None:
    """Note what does not fit together."""
    films = [path for path, node in draft.shape.items() if isinstance(node, Section) and _is_film(path)]
    for film in films:
        joint = film.removesuffix(".film")
        _sizes(draft, joint, catalogue)
        _heat(draft, film)
        _modulus(draft, joint)
        if f"{joint}.contact" not in draft.shape and f"{joint}.contact" not in draft.broken:
            _nothing_behind(draft, joint)
    if films:
        _beside_films(draft, films[0].removesuffix(".film"), catalogue)


def _is_film(path: str) -> bool:
    return path.startswith("joints.") and path.endswith(".film") and path.count(".") == 2


def _sizes(draft: Draft, joint: str, catalogue: Catalogue) -> None:
    """Check that length and radius are there, and that the film's laws hold for them."""
    length, radius, law = f"{joint}.length", f"{joint}.bearing_radius", f"{joint}.film.law"
    for path, example in ((length, "length along the pin, such as 40 mm"), (radius, "bearing's radius, such as 20 mm")):
        if not draft.there(path):
            draft.problems.add(draft.place(f"{joint}.film"), path, f"is missing; a film needs the {example}")
    lengths, radii = draft.reached(length), draft.reached(radius)
    if law in draft.unsure or not lengths or not radii:
        return
    pairs = list(zip(lengths, radii, strict=False)) if draft.in_step(length, radius) else _extremes(lengths, radii)
    for chosen in (chosen for chosen in catalogue.of("film") if chosen.name in draft.names[law]):
        _slenderness(draft, joint, chosen, [along / (2.0 * across) for along, across in pairs])


def _extremes(lengths: Sequence[float], radii: Sequence[float]) -> list[tuple[float, float]]:
    """Return length and radius of the most and of the least slender bearing among all combinations."""
    return [(max(lengths), min(radii)), (min(lengths), max(radii))]


def _slenderness(draft: Draft, joint: str, law: Law, reached: list[float]) -> None:
    """Check that a law holds for lengths over the diameter."""
    limits = ((limit, value) for limit in law.ranges for value in reached if not limit.holds(value))
    limit, value = next(limits, (None, 0.0))
    if limit:
        left_out = not draft.there(f"{joint}.film.law")
        named = f"film '{law.name}'{', the law where none is written,' if left_out else ''}"
        allowed = f"{limit.low:g} to {limit.high:g}" if limit.low else f"at most {limit.high:g}"
        draft.problems.add(
            draft.place(f"{joint}.length"),
            f"{joint}.length",
            f"found {value:.4g} bearing diameters; {named} allows {allowed}: {limit.reason}",
        )


def _heat(draft: Draft, film: str) -> None:
    """Check that viscosities at two temperatures fall, and that there is a temperature for them alone."""
    if f"{film}.thermal" in draft.sections and not draft.mechanism.turns:
        sentence = "is a balance over revolutions, of which there are none; write a temperature"
        draft.problems.add(draft.place(f"{film}.thermal"), f"{film}.thermal", sentence)
    oil, balance, temperature = f"{film}.viscosity", f"{film}.thermal", f"{film}.temperature"
    if oil not in draft.sections:
        for path in (balance, temperature):
            if draft.there(path):
                sentence = (
                    "is of no use to a viscosity that does not depend on it; write viscosity: {at_40C: 46 mm^2/s, "
                    "at_100C: 6.8 mm^2/s, density: 870 kg/m^3}"
                )
                draft.problems.add(draft.place(path), path, sentence)
        return
    cold, warm = draft.reached(f"{oil}.at_40C"), draft.reached(f"{oil}.at_100C")
    if cold and warm and max(warm) >= min(cold):
        sentence = f"found {max(warm):.4g} m^2/s; allowed: below {min(cold):.4g}, at_40C: oil thins as it warms up"
        draft.problems.add(draft.place(f"{oil}.at_100C"), f"{oil}.at_100C", sentence)
    if draft.there(balance) == draft.there(temperature):
        sentence = "is missing; for example: temperature: 60 degC, or thermal: {conductance: 20 W/K, ambient: 40 degC}"
        if draft.there(balance):
            sentence = "conflicts with `thermal`, which determines it; remove one of the two"
        draft.problems.add(draft.place(film), temperature, sentence)


def _modulus(draft: Draft, joint: str) -> None:
    """Check that asperities have a modulus."""
    law, modulus = f"{joint}.film.transition.law", f"{joint}.film.transition.modulus"
    known = draft.there(modulus) or draft.there(f"{joint}.contact.material")
    if law in draft.shape and "greenwood-tripp" in draft.names[law] and not known:
        sentence = "is missing; write E* of both bodies, such as 114 GPa for steel, or contact.material"
        draft.problems.add(draft.place(f"{joint}.film"), modulus, sentence)


def _nothing_behind(draft: Draft, joint: str) -> None:
    """Check that nothing is written of a dry contact where there is none."""
    for part in ("friction", "wear", "film.transition"):
        if f"{joint}.{part}" in draft.sections and draft.there(f"{joint}.{part}"):
            path = f"{joint}.{part}"
            if part == "film.transition" and not _written(draft, joint):
                continue
            sentence = (
                "belongs to the dry contact behind a film, of which there is none; write contact, or leave it out"
            )
            draft.problems.add(draft.place(path), path, sentence)


def _written(draft: Draft, joint: str) -> bool:
    film = draft.sections[f"{joint}.film"].value
    return isinstance(film, dict) and "transition" in film


def _beside_films(draft: Draft, joint: str, catalogue: Catalogue) -> None:
    """Check that nothing stands beside a film that is not known there."""
    sticking = {law.name for law in catalogue.of("friction") if law.sticks}
    for path in (path for path in draft.names if path.endswith(".friction.law")):
        for law in sorted(draft.names[path] & sticking):
            sentence = f"{law} sticks, which is not available with the film of {joint}; choose another"
            draft.problems.add(draft.place(path), path, sentence)
    if "seated" in draft.reached("simulate.start"):
        sentence = (
            f"cannot be seated in the film of {joint}, which bears nothing at rest; leave it out, or write centred"
        )
        draft.problems.add(draft.place("simulate.start"), "simulate.start", sentence)
