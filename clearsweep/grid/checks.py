"""The checks that need several values of a grid at once, over all values that its axes reach."""

import math

from ..contracts.case import LARGEST_WEAR_NUMBER, LEAST_WEAR_NUMBER, Materials
from ..contracts.catalogue import Catalogue, Law, sized
from ..language.errors import nearest
from . import film_checks, life_keys, machine_checks
from .draft import Draft
from .joint_keys import moduli
from .key_table import DIMENSIONLESS
from .keys import Number, Section, value_key, word_key
from .values import exponent_values
from .wear_unit import COEFFICIENTS


def check(draft: Draft, catalogue: Catalogue) -> None:
    """Note what does not fit together."""
    for order in draft.mechanism.orders:
        _below(draft, order.low, order.high, order.reason, equal=order.equal)
    _below(draft, "simulate.discard", "simulate.revolutions", "nothing would be left")
    _below(draft, "save.revolutions", "simulate.revolutions", "more cannot be saved than is run", equal=True)
    _until(draft)
    life_keys.check(draft)
    machine_checks.check(draft, catalogue)
    film_checks.check(draft, catalogue)
    _friction(draft, catalogue)
    joints = [path for path, node in draft.shape.items() if isinstance(node, Section) and _is_joint(path)]
    whole = draft.shape.get("joints")
    if not joints and isinstance(whole, Section) and whole.need == "implied":
        text = f"no joint has clearance; name at least one of {', '.join(site.name for site in draft.mechanism.joints)}"
        draft.problems.add(draft.place("joints"), "joints", text)
    for path in joints:
        _below(draft, f"{path}.clearance", f"{path}.bearing_radius", "the journal would have no radius")
        _material(draft, path)
        _elastic(draft, path, catalogue)
        if f"{path}.roughness" in draft.shape:
            _roughness(draft, path, catalogue)
        if f"{path}.wear" in draft.shape:
            _wear(draft, path, catalogue)
            _pressure(draft, path, catalogue)
        if f"{path}.thermal" in draft.shape:
            _thermal(draft, path)
        if f"{path}.wear.evolve" in draft.values:
            _evolving(draft, path, catalogue)


def _thermal(draft: Draft, joint: str) -> None:
    """Check that a heat balance stands in a dry joint with friction."""
    thermal = f"{joint}.thermal"
    if f"{joint}.film" in draft.shape:
        sentence = "is the balance of a dry joint, but this one has a film; write film.thermal"
        draft.problems.add(draft.place(thermal), thermal, sentence)
    elif f"{joint}.friction" not in draft.shape:
        sentence = "has nothing that heats the joint; write a friction law, or leave it out"
        draft.problems.add(draft.place(thermal), thermal, sentence)


def _friction(draft: Draft, catalogue: Catalogue) -> None:
    """Check that the keys of friction laws are in order, in joints and in loads."""
    given = {f"loads.{load.name}.friction": load.given for load in draft.outline.loads if load.given}
    for path in [path for path in draft.shape if path.endswith(".friction")]:
        for law in catalogue.of("friction"):
            if law.name in draft.names.get(f"{path}.law", ()):
                _in_order(draft, path, sized(law, given[path]) if path in given else law)


def _until(draft: Draft) -> None:
    """Check that the figure that `until` judges is one of this grid, and that its longest run is not the shorter."""
    least, most = draft.reached("simulate.revolutions"), draft.reached("simulate.until.max_revolutions")
    if least and most and min(most) < max(least):
        path = "simulate.until.max_revolutions"
        sentence = (
            f"found {draft.said(path, min(most))}; allowed: at least "
            f"{draft.said('simulate.revolutions', max(least))}, the value of simulate.revolutions, the shortest run"
        )
        draft.problems.add(draft.place(path), path, sentence)
    path = "simulate.until.figure"
    figure = str(draft.values.get(path, ""))
    if figure and figure not in draft.figures:
        names = [name for name in word_key(draft.shape, path).options if name in draft.figures]
        sentence = f"{figure} is no figure of this grid{nearest(figure, names)} (known: {', '.join(names)})"
        draft.problems.add(draft.place(path), path, sentence)


def _is_joint(path: str) -> bool:
    return path.startswith("joints.") and path.count(".") == 1


def _below(draft: Draft, low: str, high: str, reason: str, *, equal: bool = False) -> None:
    """Note a problem unless every value of `low` is below every value of `high`; values left out are no problem."""
    lows, highs = draft.reached(low), draft.reached(high)
    if not lows or not highs or max(lows) < min(highs) or (equal and max(lows) == min(highs)):
        return
    if draft.in_step(low, high):
        wrong = [(a, b) for a, b in zip(lows, highs, strict=False) if not (a < b or (equal and a == b))]
        if not wrong:
            return
        lows, highs = zip(*wrong[:1], strict=True)
    where = low if low in draft.swept or low in draft.written else high
    word = "at most" if equal else "below"
    draft.problems.add(
        draft.place(where),
        where,
        f"found {draft.said(low, max(lows))}; allowed: {word} {draft.said(high, min(highs))}, the value of {high}; "
        f"{reason}",
    )


def _in_order(draft: Draft, section: str, law: Law) -> None:
    """Check that of two keys of a law the one is below the other where its description says so."""
    for order in law.orders:
        _below(draft, f"{section}.{order.low}", f"{section}.{order.high}", order.reason, equal=order.equal)


_EXAMPLES = {
    "length": "the joint's length along the pin, such as 20 mm",
    "bearing_radius": "the radius of the bearing, such as 10 mm",
    "contact.material": "both bodies' material, such as {young: 207 GPa, poisson: 0.3}",
}


def _material(draft: Draft, joint: str) -> None:
    """Check that a material is whole: of both bodies in one, or of each of them."""
    material = f"{joint}.contact.material"
    if material not in draft.shape or not value_key(draft.shape, f"{material}.young").used(draft.names):
        return
    shared = [key for key in ("young", "poisson") if draft.there(f"{material}.{key}")]
    own = [body for body in Materials._fields if f"{material}.{body}" in draft.shape]
    if own and shared:
        sentence = f"conflicts with {' and '.join(own)}; write it within bearing and journal, or remove these"
        draft.problems.add(draft.place(f"{material}.{shared[0]}"), f"{material}.{shared[0]}", sentence)
    elif len(own) == 1:
        (other,) = set(Materials._fields) - set(own)
        sentence = f"is missing; for example: {other}: {{young: 110 GPa, poisson: 0.34}}, or one material for both"
        draft.problems.add(draft.place(material), f"{material}.{other}", sentence)
    elif not own:
        for key in ("young", "poisson"):
            if key not in shared:
                sentence = (
                    "is missing; for example: {young: 207 GPa, poisson: 0.3} for both bodies, or a section like it "
                    "for each, bearing and journal"
                )
                draft.problems.add(draft.place(material), f"{material}.{key}", sentence)


def _elastic(draft: Draft, joint: str, catalogue: Catalogue) -> None:
    """Check that the joint has what its stiffness laws need, in the range they hold for."""
    law, elastic = f"{joint}.contact.law", f"{joint}.contact.elastic"
    known = elastic in draft.shape and draft.unsure.isdisjoint((law, elastic))
    if not known or not value_key(draft.shape, elastic).used(draft.names):
        return
    families = {law: catalogue.of("law"), elastic: catalogue.of("elastic")}
    tried = [each for path, laws in families.items() for each in laws if each.name in draft.names[path]]
    for chosen in sorted(tried, key=lambda law: law.name):
        for path in _needed(draft, joint, chosen):
            if not draft.there(f"{joint}.{path}"):
                sentence = f"is missing; {chosen.family} '{chosen.name}' needs {_EXAMPLES[path]}"
                draft.problems.add(draft.place(elastic), f"{joint}.{path}", sentence)
        _in_order(draft, f"{joint}.contact", chosen)
        if "hertz" in chosen.needs:
            _hertzian(draft, elastic, chosen)
        for own, low, high, unit, reason in chosen.ranges:
            path = own if f"{joint}.{own}" in draft.shape else own.replace(".bearing.", ".")  # of both bodies
            outside = [value for value in draft.reached(f"{joint}.{path}") if not low <= value <= high]
            if outside:
                sentence = (
                    f"found {draft.said(f'{joint}.{path}', outside[0])}; elastic '{chosen.name}' allows {low:.15g} to "
                    f"{high:.15g}{'' if unit == '1' else f' ({unit})'}: {reason}"
                )
                draft.problems.add(draft.place(f"{joint}.{path}"), f"{joint}.{path}", sentence)


def _hertzian(draft: Draft, elastic: str, law: Law) -> None:
    """Check that the elastic force is Hertz's, which a law of the normal force is made for."""
    others = sorted(draft.names[elastic] - {"power"})
    exponents = [x for x in exponent_values(draft, elastic) if not math.isclose(x, 1.5)]
    found = others[0] if others else f"an exponent of {exponents[0]:.15g}" if exponents else ""
    if found:
        sentence = f"found {found}; law '{law.name}' allows power with the exponent 1.5, a ball in a socket"
        draft.problems.add(draft.place(elastic), elastic, sentence)


def _needed(draft: Draft, joint: str, law: Law) -> tuple[str, ...]:
    """Return the paths within the joint of what a law of its contact needs besides its own fields."""
    if any(draft.there(f"{joint}.contact.{columns.name}") for columns in law.tables):
        return ()  # the table says it all
    needed = tuple("contact.material" if name == "material" else name for name in law.needs if name != "hertz")
    from_material = law.name == "power" and not draft.there(f"{joint}.contact.stiffness")
    sized = needed or (from_material and draft.there(f"{joint}.contact.material"))
    radius = draft.shape.get(f"{joint}.bearing_radius")
    optional = isinstance(radius, Number) and radius.uses[0].field.optional
    return ("bearing_radius", *needed) if sized and optional else needed


def _roughness(draft: Draft, joint: str, catalogue: Catalogue) -> None:
    """Check that rough surfaces have what they follow from: the joint's sizes, and a texture or a profile of it."""
    rough = f"{joint}.roughness"
    for law in [law for law in catalogue.of("roughness") if law.name in draft.names[f"{rough}.law"]]:
        for needed in law.needs:
            path = "contact.material" if needed == "material" else needed
            if not draft.there(f"{joint}.{path}"):
                sentence = f"is missing; roughness '{law.name}' needs {_EXAMPLES[path]}"
                draft.problems.add(draft.place(rough), f"{joint}.{path}", sentence)
        for columns in law.tables:
            table = f"{rough}.{columns.name}"
            for field in [field for field in law.fields if field.optional]:
                path = f"{rough}.{field.name}"
                if draft.there(path) and draft.there(table):
                    sentence = f"conflicts with {columns.name}, which determines it; remove one of the two"
                    draft.problems.add(draft.place(path), path, sentence)
                elif not draft.there(path) and not draft.there(table):
                    sentence = f"is missing for {law.name} ({field.text}); write it, or {columns.name}: profile.csv"
                    draft.problems.add(draft.place(path), path, sentence)


def _wear(draft: Draft, joint: str, catalogue: Catalogue) -> None:
    """Check what wear needs of its joint, and that its coefficients are there and possible."""
    wear = f"{joint}.wear"
    if not draft.there(f"{joint}.length"):
        sentence = "is missing; wear needs the joint's length along the pin, such as 20 mm"
        draft.problems.add(draft.place(wear), f"{joint}.length", sentence)
    bare = draft.values.get(f"{wear}.coefficient_unit") == DIMENSIONLESS
    by_work = [
        law for law in catalogue.of("wear") if "friction" in law.needs and law.name in draft.names[f"{wear}.law"]
    ]
    if by_work and f"{joint}.friction" not in draft.shape:
        sentence = f"is missing; the wear law '{by_work[0].name}' needs the work of friction; write a friction law"
        draft.problems.add(draft.place(wear), f"{joint}.friction", sentence)
    if by_work and bare:
        sentence = f"the wear law '{by_work[0].name}' takes m^3/J, whatever the hardness: write the unit"
        draft.problems.add(draft.place(f"{wear}.coefficient_unit"), f"{wear}.coefficient_unit", sentence)
        return
    if bare and not draft.there(f"{wear}.hardness"):
        sentence = "is missing; a dimensionless wear coefficient is k times the hardness; for example: 2 GPa"
        draft.problems.add(draft.place(wear), f"{wear}.hardness", sentence)
    there = "running_in.steady" if draft.there(f"{wear}.running_in.steady") else "coefficient"
    _of_both(draft, wear, there, ("bearing_coefficient", "journal_coefficient"), "2e-14 m^2/N")
    if there != "coefficient" and draft.there(f"{wear}.coefficient"):
        sentence = "conflicts with running_in.steady, which means the same; remove one of the two"
        draft.problems.add(draft.place(f"{wear}.coefficient"), f"{wear}.coefficient", sentence)
    if f"{wear}.running_in" in draft.shape:
        overriding = ("running_in.bearing_initial", "running_in.journal_initial")
        _of_both(draft, wear, "running_in.initial", overriding, "1e-13 m^2/N")
    _wear_numbers(draft, wear)


def _of_both(draft: Draft, wear: str, key: str, overriding: tuple[str, str], example: str) -> None:
    """Check that a coefficient of both bodies is there unless each has its own, and that it is of use if it varies."""
    overridden = all(draft.there(f"{wear}.{own}") for own in overriding)
    if not draft.there(f"{wear}.{key}") and not overridden:
        sentence = f"is missing; for example: {example} for both bodies, or {' and '.join(overriding)}"
        draft.problems.add(draft.place(wear), f"{wear}.{key}", sentence)
    if f"{wear}.{key}" in draft.swept and overridden:
        sentence = f"is swept but not in use: {' and '.join(overriding)} override it"
        draft.problems.add(draft.swept[f"{wear}.{key}"], f"{wear}.{key}", sentence)


def _wear_numbers(draft: Draft, wear: str) -> None:
    """Check that wear coefficients, times the hardness, are such as there are."""
    bare = draft.values.get(f"{wear}.coefficient_unit") == DIMENSIONLESS
    hardness = 1.0 if bare else max(draft.reached(f"{wear}.hardness"), default=0.0)
    for path in (f"{wear}.{key}" for key in COEFFICIENTS):
        numbers = [value * hardness for value in draft.reached(path)]
        largest, least = max(numbers, default=0.0), min((value for value in numbers if value), default=1.0)
        if largest > LARGEST_WEAR_NUMBER or (bare and least < LEAST_WEAR_NUMBER):
            what = (
                f"found {(largest if largest > LARGEST_WEAR_NUMBER else least):.15g}, dimensionless; allowed: "
                f"{LEAST_WEAR_NUMBER:g} to {LARGEST_WEAR_NUMBER:g}; write the unit, m^2/N, of one that has it"
                if bare
                else f"found {draft.said(path, largest / hardness)}, times the hardness "
                f"{draft.said(f'{wear}.hardness', hardness)} {largest:.3g}; "
                f"allowed: at most {LARGEST_WEAR_NUMBER}; is the coefficient in mm^2/N? (1 mm^2/N is 1e-6 m^2/N)"
            )
            draft.problems.add(draft.place(path), path, what)


def _evolving(draft: Draft, joint: str, catalogue: Catalogue) -> None:
    """Check that nothing stands beside a shape that acts that is not known with it."""
    evolve = f"{joint}.wear.evolve"
    if f"{joint}.film" in draft.shape:
        sentence = "is not available with a film, whose formula assumes circles; remove one of the two"
        draft.problems.add(draft.place(evolve), evolve, sentence)
    sticking = {law.name for law in catalogue.of("friction") if law.sticks}
    for path in (path for path in draft.names if path.endswith(".friction.law")):
        for law in sorted(draft.names[path] & sticking):
            sentence = f"{law} sticks, which is not available with the worn shape of {joint}; choose another"
            draft.problems.add(draft.place(path), path, sentence)


def _pressure(draft: Draft, joint: str, catalogue: Catalogue) -> None:
    """Check that a pressure of wear that needs a modulus has one."""
    path, contact = f"{joint}.wear.pressure", f"{joint}.contact"
    needing = [law for law in catalogue.of("pressure") if "modulus" in law.needs and law.name in draft.names[path]]
    if needing and not any(map(draft.there, moduli(joint))):
        sentence = (
            f"is missing; the pressure '{needing[0].name}' of wear needs material: {{young: 207 GPa, poisson: 0.3}} or "
            "pressure_modulus beside it: it does not follow from a stiffness; without either write pressure: mean"
        )
        draft.problems.add(draft.place(path), f"{contact}.material", sentence)
