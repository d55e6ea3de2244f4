"""Checks that need several values of a grid at once, over all values of its axes."""

import itertools
import math
from collections.abc import Iterator

from ...contracts.case import LARGEST_WEAR_NUMBER, LEAST_WEAR_NUMBER, Materials
from ...contracts.catalogue import Catalogue, Law, with_given_size
from ...contracts.vibration import FRAME, MAX_BAND_ORDERS, MAX_LINES, MIN_TURNS, NO_SEVERITY, UNCHECKED_STANDARD
from ...language.errors import did_you_mean
from ...language.expression import DEFINED, names_in
from ..keys import Number, Section, value_key, word_key
from ..keys.joint_keys import conflicts, modulus_paths
from ..keys.key_table import DIMENSIONLESS
from ..keys.run_keys import LIFE
from ..sections import Reader
from ..written.definitions import expression_of
from .machine_checks import check_below, check_film_joints, check_length, check_machine, refuse_sticking
from .values import COEFFICIENTS, exponent_values

MAX_RELATIVE_DEPTH = 0.1  # of the bearing radius; deeper wear is no longer a small change of shape
VIBRATION = "vibration"
WHOLE_TOLERANCE = 1e-9  # revolutions; tolerance on a whole number of them


def check_values(reader: Reader, catalogue: Catalogue) -> None:
    """Report values that conflict with each other."""
    for order in reader.mechanism.orders:
        check_below(reader, order.low, order.high, order.reason, equal=order.equal)
    for length, rest in (("revolutions", "at least one revolution"), ("cycles", "a cycle"), ("time", "some time")):
        check_below(reader, "simulate.discard", f"simulate.{length}", f"{rest} must remain for the figures")
    for length in ("revolutions", "cycles"):
        reason = f"a run cannot save more {length} than it simulates"
        check_below(reader, "save.revolutions", f"simulate.{length}", reason, equal=True)
    check_length(reader)
    _check_until(reader)
    _check_life(reader)
    if VIBRATION in reader.keys_in_use:
        _check_vibration(reader)
    check_machine(reader, catalogue)
    check_film_joints(reader, catalogue)
    _check_friction(reader, catalogue)
    sections = [path for path, key in reader.keys_in_use.items() if isinstance(key, Section)]
    joints = [path for path in sections if path.startswith("joints.") and path.count(".") == 1]
    joints_section = reader.keys_in_use.get("joints")
    is_implied = isinstance(joints_section, Section) and joints_section.need == "implied"
    if not joints and is_implied and not (reader.outline.elastic or reader.outline.mounts):
        names = ", ".join(site.name for site in reader.mechanism.joints)
        advice = f"name at least one of {names}" if names else "add one that can to mechanism.joints"
        reader.report("joints", f"no joint has clearance; {advice}, or let a link bend or a housing yield")
    for path in joints:
        if f"{path}.element_diameter" in reader.keys_in_use:
            _check_rolling(reader, path, catalogue)
        check_below(reader, f"{path}.clearance", f"{path}.bearing_radius", "the radius of the journal must be above 0")
        check_below(reader, f"{path}.stops.at.0", f"{path}.stops.at.1", "the lower stop comes first")
        for owner in (path, f"{path}.stops"):
            _check_material(reader, owner)
            _check_elastic_law(reader, owner, catalogue)
        if f"{path}.roughness" in reader.keys_in_use:
            _check_roughness(reader, path, catalogue)
        if f"{path}.wear" in reader.keys_in_use:
            _check_wear(reader, path, catalogue)
            _check_pressure(reader, path, catalogue)
        if f"{path}.thermal" in reader.keys_in_use:
            _check_heat_balance(reader, path)
        shapes = {f"{path}.profile": reader.keys_in_use, f"{path}.wear.evolve": reader.values}
        if given := [shape for shape, known in shapes.items() if shape in known]:
            _check_shape(reader, path, given, catalogue)


def _check_rolling(reader: Reader, joint: str, catalogue: Catalogue) -> None:
    """Check that the sizes of a rolling bearing fit together, and that the damping of its elements is given once."""
    for law in catalogue.of("law"):
        if law.name in reader.names.get(f"{joint}.contact.law", ()):
            _check_one_of(reader, f"{joint}.contact", law)
    if "ball" in reader.names.get(f"{joint}.kind", ()) and f"{joint}.groove" not in reader.keys_in_use:
        message = "is missing; write the radii of both grooves over the diameter of a ball, such as [0.52, 0.53]"
        reader.report(f"{joint}.groove", message, at=joint)
    names = ("elements", "element_diameter", "pitch_diameter", "bore", "outside_diameter", "clearance")
    values = {name: reader.values_of(f"{joint}.{name}") for name in names}
    given = {name for name in (*names, "length", "friction") if reader.is_given(f"{joint}.{name}")}
    given |= {"friction"} if f"{joint}.friction" in reader.keys_in_use else set()
    problems: dict[str, str] = {}
    for row in _rows_of(reader, joint, values):
        problems |= dict(conflicts(row, given))
    for name, message in problems.items():
        reader.report(f"{joint}.{name}", message)
    for name, pin in _shared_definitions(reader, joint):
        reader.warnings.append(
            f"{joint}.clearance and {pin}.clearance both follow from define.{name}. A rolling bearing's clearance is "
            "diametral, a pin's is radial, half of its play"
        )


def _rows_of(
    reader: Reader, joint: str, values: dict[str, tuple[float, ...]]
) -> Iterator[dict[str, tuple[float, ...]]]:
    """Yield the values of a joint's keys that occur together: row by row for those that vary in step."""
    varied = [name for name, present in values.items() if len(present) > 1]
    in_step = [name for name in varied if reader.vary_together(f"{joint}.{varied[0]}", f"{joint}.{name}")]
    if not in_step:
        yield values
        return
    for row in zip(*(values[name] for name in in_step), strict=False):
        yield values | {name: (value,) for name, value in zip(in_step, row, strict=True)}


def _shared_definitions(reader: Reader, joint: str) -> Iterator[tuple[str, str]]:
    """Yield each name on which the clearances of a rolling bearing and of a pin depend, with the path of the pin."""
    names_by_path = {
        path: names_in(expression_of(reader.written[path].expression), DEFINED)
        for path in reader.keys_in_use
        if path.endswith(".clearance") and path in reader.written and reader.written[path].expression
    }
    for path, names in names_by_path.items():
        pin = path.removesuffix(".clearance")
        if f"{pin}.bearing_radius" in reader.keys_in_use:
            yield from ((name, pin) for name in sorted(names & names_by_path.get(f"{joint}.clearance", set())))


def _check_heat_balance(reader: Reader, joint: str) -> None:
    """Check that a heat balance exists in a dry joint with friction."""
    thermal = f"{joint}.thermal"
    if f"{joint}.film" in reader.keys_in_use:
        reader.report(thermal, "applies to dry joints, but this joint has a film; use film.thermal instead")
    elif f"{joint}.friction" not in reader.keys_in_use:
        reader.report(thermal, "needs a heat source; add a friction law, or remove thermal")
    housing = f"{thermal}.housing"
    if housing in reader.keys_in_use and f"{thermal}.expansion" not in reader.keys_in_use:
        message = "needs the expansion of both bodies; add thermal.expansion, or name the materials of the contact"
        reader.report(housing, message)


def _check_friction(reader: Reader, catalogue: Catalogue) -> None:
    """Check that the keys of friction laws are in order, in joints and in loads."""
    given_by_path = {f"loads.{load.name}.friction": load.given for load in reader.outline.loads if load.given}
    for path in [path for path in reader.keys_in_use if path.endswith(".friction")]:
        for law in catalogue.of("friction"):
            if law.name in reader.names.get(f"{path}.law", ()):
                _check_order(reader, path, with_given_size(law, given_by_path[path]) if path in given_by_path else law)


def _check_vibration(reader: Reader) -> None:
    """Check the band, the zones, the mount and the length of the window of `vibration`."""
    at_frame = f"{VIBRATION}.at.{FRAME}"
    for pair in itertools.pairwise(f"{VIBRATION}.zones.{k}" for k in range(3)):
        check_below(reader, *pair, "each zone ends at a higher velocity than the one before")
    length = reader.outline.length
    if length == "revolutions" and reader.outline.drive == "angle-table":
        message = "analyses revolutions of one length, unlike those of a table of angles; write cycles with a period"
        reader.report(VIBRATION, message)
        return
    if length == "time" and reader.outline.vibration and reader.outline.vibration.orders:
        message = "need a motion that repeats, but the length of the run is a time; write cycles with their period"
        reader.report(f"{VIBRATION}.orders", message)
    severity = reader.values.get(f"{VIBRATION}.severity", NO_SEVERITY)
    if severity.startswith(UNCHECKED_STANDARD):
        text = "bounds of its zones are from memory, compared with no published text; compare them with the standard"
        reader.warnings.append(f"{VIBRATION}.severity: found {severity}; the {text}, or write `zones`")
    if f"{VIBRATION}.zones" in reader.keys_in_use and severity != NO_SEVERITY:
        message = "conflicts with severity, which has zones of its own; remove one of the two"
        reader.report(f"{VIBRATION}.zones", message)
    for name in ("mass", "mount") if reader.outline.mounts else ():
        if reader.is_given(f"{at_frame}.{name}") or f"{at_frame}.{name}.damping" in reader.keys_in_use:
            message = "conflicts with mechanism.mounts, with whose housing the frame moves; remove one of the two"
            reader.report(f"{at_frame}.{name}", message)
            return
    if f"{at_frame}.mount" in reader.keys_in_use and not reader.is_given(f"{at_frame}.mass"):
        message = "needs the mass of the frame that it carries; write vibration.at.frame.mass, or remove the mount"
        reader.report(f"{at_frame}.mount", message)
    path, least = f"simulate.{length}", 0 if length == "time" else MIN_TURNS
    windows = _windows(reader, path)
    if windows and min(windows) < least - WHOLE_TOLERANCE:
        message = (
            f"found {min(windows):.6g} {length} after simulate.discard; with vibration at least {least} are "
            f"needed, so that its spectrum separates the orders of the crank; simulate more {length}"
        )
        reader.report(path, message)
    elif windows:
        speeds = (speed for key in ("drive.speed", "drive.motor.no_load_speed") for speed in reader.values_of(key))
        rates = [abs(speed) for speed in speeds if isinstance(speed, float)]
        if length != "revolutions":
            periods = windows if length == "time" else reader.values_of("simulate.period")
            rates = [2.0 * math.pi / period for period in periods if period > 0.0]
        _check_band(reader, 1.0 if length == "time" else min(windows), rates)


def _windows(reader: Reader, path: str) -> list[float]:
    """Return what remains of the lengths of run at `path` after simulate.discard."""
    return [
        length - (discard if length > 2.0 or reader.is_given("simulate.discard") else 0.0)
        for length in reader.values_of(path)
        for discard in reader.values_of("simulate.discard") or (2.0,)
    ]


def _check_band(reader: Reader, turns: float, rates: list[float]) -> None:
    """Check that the band of `vibration` rises, is resolved, and contains a line; rates : rad/s, of turns or cycles."""
    path = f"{VIBRATION}.band"
    check_below(reader, f"{path}.0", f"{path}.1", "the band needs a width")
    lows, highs = reader.values_of(f"{path}.0"), reader.values_of(f"{path}.1")
    if not (lows and highs and rates):
        return
    orders = MAX_LINES if reader.outline.length == "time" else MAX_BAND_ORDERS
    limit = orders * min(rates)
    if max(highs) > limit:
        message = (
            f"found {reader.text(f'{path}.1', max(highs))}; a turn, a cycle or a window over time resolves at most "
            f"{orders:,} times its rate, {limit / (2.0 * math.pi):,.6g} Hz; end the band there"
        )
        reader.report(path, message, at=f"{path}.1")
    resolution = max(rates) / math.floor(turns + WHOLE_TOLERANCE)
    highest_line = resolution * math.floor(min(highs) / resolution * (1.0 + WHOLE_TOLERANCE))
    if min(lows) < min(highs) and highest_line < max(lows) * (1.0 - WHOLE_TOLERANCE):
        message = (
            f"contains no line of the window's spectrum, whose lines are {resolution / (2.0 * math.pi):.4g} Hz apart; "
            "widen the band, or simulate a longer run"
        )
        reader.report(path, message)


def _check_until(reader: Reader) -> None:
    """Check that the grid has the figure in `until` and that the longest run is long enough: for a revolution, too."""
    shortest, path = "simulate.revolutions", "simulate.until.max_revolutions"
    lengths, longest = reader.values_of(shortest), reader.values_of(path)
    is_long = check_below(reader, shortest, path, "it is the shortest run", equal=True, of_high=True)
    if is_long and lengths and longest:
        discarded = max(reader.values_of("simulate.discard") or (2.0 if max(lengths) > 2.0 else 0.0,))
        if min(longest) - discarded < 1.0 - WHOLE_TOLERANCE:
            message = (
                f"found {reader.text(path, min(longest))}; allowed: at least {discarded + 1.0:g}, one whole revolution "
                "after simulate.discard; the interval of a figure is that of whole revolutions"
            )
            reader.report(path, message)
    path = "simulate.until.figure"
    figure = str(reader.values.get(path, ""))
    if figure and figure not in reader.figures:
        names = [name for name in word_key(reader.keys_in_use, path).options if name in reader.figures]
        message = f"{figure} is not a column of this grid{did_you_mean(figure, names)} (known: {', '.join(names)})"
        reader.report(path, message)


def _check_order(reader: Reader, section: str, law: Law) -> None:
    """Check the order of two keys of a law where its description requires one."""
    for order in law.orders:
        check_below(reader, f"{section}.{order.low}", f"{section}.{order.high}", order.reason, equal=order.equal)


_KEY_EXAMPLES = {
    "length": "the joint's length along the pin, such as 20 mm",
    "bearing_radius": "the radius of the bearing, such as 10 mm",
    "contact.material": "both bodies' material, such as {young: 207 GPa, poisson: 0.3}",
}


def _check_material(reader: Reader, joint: str) -> None:
    """Check that materials are complete: one for both bodies, or one for each."""
    material, keys = f"{joint}.contact.material", reader.keys_in_use
    if material not in keys or not value_key(keys, f"{material}.young").is_used(reader.names):
        return
    shared = [key for key in ("young", "poisson") if reader.is_given(f"{material}.{key}")]
    given_bodies = [body for body in Materials._fields if f"{material}.{body}" in keys]
    if given_bodies and shared:
        message = f"conflicts with {' and '.join(given_bodies)}; write it within bearing and journal, or remove these"
        reader.report(f"{material}.{shared[0]}", message)
    elif len(given_bodies) == 1:
        (other_body,) = set(Materials._fields) - set(given_bodies)
        message = f"is missing; for example: {other_body}: {{young: 110 GPa, poisson: 0.34}}, or one material for both"
        reader.report(f"{material}.{other_body}", message, at=material)
    elif not given_bodies:
        message = "for each of bearing and journal"
        message = f"for example: {{young: 207 GPa, poisson: 0.3}} for both bodies, or one such section {message}"
        for key in ("young", "poisson"):
            reader.require(f"{material}.{key}", message, at=material)


def _check_elastic_law(reader: Reader, joint: str, catalogue: Catalogue) -> None:
    """Check that the joint has the values that its stiffness laws need, within their valid range."""
    law_path, elastic = f"{joint}.contact.law", f"{joint}.contact.elastic"
    is_known = elastic in reader.keys_in_use and reader.unread_laws.isdisjoint((law_path, elastic))
    if not is_known or not value_key(reader.keys_in_use, elastic).is_used(reader.names):
        return
    families = {law_path: catalogue.of("law"), elastic: catalogue.of("elastic")}
    candidates = [law for path, laws in families.items() for law in laws if law.name in reader.names[path]]
    has_spring = any(reader.is_given(f"{joint}.contact.{key}") for key in ("stiffness", "material"))
    for law in sorted(candidates, key=lambda law: law.name):
        if law.origin and law.notes and law.family == "law" and not has_spring:
            reader.report(law_path, f"'{law.name}': {law.notes}")
        for path in _needed_keys(reader, joint, law):
            reader.require(f"{joint}.{path}", f"{law.family} '{law.name}' needs {_KEY_EXAMPLES[path]}", at=elastic)
        _check_order(reader, f"{joint}.contact", law)
        _check_one_of(reader, f"{joint}.contact", law)
        if "hertz" in law.needs:
            _check_hertzian(reader, elastic, law)
        for path_of_body, low, high, unit, reason in law.ranges:
            path_of_both = path_of_body.replace(".bearing.", ".")
            path = path_of_body if f"{joint}.{path_of_body}" in reader.keys_in_use else path_of_both
            outside = [value for value in reader.values_of(f"{joint}.{path}") if not low <= value <= high]
            if outside:
                message = (
                    f"found {reader.text(f'{joint}.{path}', outside[0])}; elastic '{law.name}' allows {low:.15g} to "
                    f"{high:.15g}{'' if unit == '1' else f' ({unit})'}: {reason}"
                )
                reader.report(f"{joint}.{path}", message)


def _check_one_of(reader: Reader, section: str, law: Law) -> None:
    """Check that exactly one of the values is given where a law takes one of several."""
    given = [name for name in law.one_of if reader.is_given(f"{section}.{name}")]
    if len(given) > 1:
        path = f"{section}.{given[-1]}"
        message = f"replaces {given[0]}, which is given too; law '{law.name}' takes one of {', '.join(law.one_of)}"
        reader.report(path, message)
    elif law.one_of and not given:
        path = f"{section}.{law.one_of[0]}"
        reader.report(path, f"is missing; law '{law.name}' takes one of {', '.join(law.one_of)}", at=f"{section}.law")
    elastic = f"{section}.elastic"
    powers_only = [name for name in given if law.unit_of(name).endswith("^exponent+1")]
    if powers_only and elastic in reader.names and reader.names[elastic] != {"power"}:
        elastic_laws = ", ".join(sorted(reader.names[elastic] - {"power"}))
        path = f"{section}.{powers_only[0]}"
        message = f"needs elastic: power, not {elastic_laws}; with another elastic law write damping_factor, in s/m"
        reader.report(path, message)


def _check_hertzian(reader: Reader, elastic: str, law: Law) -> None:
    """Check that the elastic force is Hertz's, where a law of the normal force requires that."""
    other_laws = sorted(reader.names[elastic] - {"power"})
    exponents = [x for x in exponent_values(reader, elastic) if not math.isclose(x, 1.5)]
    culprit = other_laws[0] if other_laws else f"an exponent of {exponents[0]:.15g}" if exponents else ""
    if culprit:
        reader.report(elastic, f"found {culprit}; law '{law.name}' requires elastic: power with the exponent 1.5")


def _needed_keys(reader: Reader, joint: str, law: Law) -> tuple[str, ...]:
    """Return the further keys, as paths within the joint, that a contact law needs."""
    if any(reader.is_given(f"{joint}.contact.{columns.name}") for columns in law.tables):
        return ()  # the key table covers it
    needed_keys = tuple("contact.material" if name == "material" else name for name in law.needs if name != "hertz")
    is_from_material = law.name == "power" and not reader.is_given(f"{joint}.contact.stiffness")
    needs_radius = needed_keys or (is_from_material and reader.is_given(f"{joint}.contact.material"))
    radius = reader.keys_in_use.get(f"{joint}.bearing_radius")
    is_optional = isinstance(radius, Number) and radius.uses[0].field.optional
    return ("bearing_radius", *needed_keys) if needs_radius and is_optional else needed_keys


def _check_roughness(reader: Reader, joint: str, catalogue: Catalogue) -> None:
    """Check that rough surfaces have the joint's dimensions and a texture or a profile."""
    roughness = f"{joint}.roughness"
    for law in [law for law in catalogue.of("roughness") if law.name in reader.names[f"{roughness}.law"]]:
        for needed_key in law.needs:
            path = "contact.material" if needed_key == "material" else needed_key
            reader.require(f"{joint}.{path}", f"roughness '{law.name}' needs {_KEY_EXAMPLES[path]}", at=roughness)
        for columns in law.tables:
            table = f"{roughness}.{columns.name}"
            for field in [field for field in law.fields if field.optional]:
                path = f"{roughness}.{field.name}"
                if reader.is_given(path) and reader.is_given(table):
                    reader.report(path, f"conflicts with {columns.name}, which determines it; remove one of the two")
                elif not reader.is_given(path) and not reader.is_given(table):
                    message = f"is missing for {law.name} ({field.text}); write it, or {columns.name}: profile.csv"
                    reader.report(path, message)


def _check_wear(reader: Reader, joint: str, catalogue: Catalogue) -> None:
    """Check that the joint has the keys that wear needs, with plausible coefficients."""
    wear = f"{joint}.wear"
    reader.require(f"{joint}.length", "wear needs the joint's length along the pin, such as 20 mm", at=wear)
    is_dimensionless = reader.values.get(f"{wear}.coefficient_unit") == DIMENSIONLESS
    if all(law.origin for law in catalogue.of("wear") if law.name in reader.names[f"{wear}.law"]):
        for key in ("coefficient", "bearing_coefficient", "journal_coefficient", "running_in"):
            path = f"{wear}.{key}"
            if reader.is_given(path) or path in reader.sections:
                reader.report(path, "is not used by a wear law of one's own, which has only its own keys; leave it out")
        return
    work_laws = [
        law for law in catalogue.of("wear") if "friction" in law.needs and law.name in reader.names[f"{wear}.law"]
    ]
    if work_laws and f"{joint}.friction" not in reader.keys_in_use:
        message = f"is missing; the wear law '{work_laws[0].name}' needs the work of friction; write a friction law"
        reader.report(f"{joint}.friction", message, at=wear)
    if work_laws and is_dimensionless:
        message = (
            f"the wear law '{work_laws[0].name}' needs a coefficient in m^3/J; write this unit, also next to a hardness"
        )
        reader.report(f"{wear}.coefficient_unit", message)
        return
    if is_dimensionless:
        message = "a dimensionless wear coefficient is k times the hardness; for example: 2 GPa"
        reader.require(f"{wear}.hardness", message, at=wear)
    steady_key = "running_in.steady" if reader.is_given(f"{wear}.running_in.steady") else "coefficient"
    _check_common_or_each(reader, wear, steady_key, ("bearing_coefficient", "journal_coefficient"), "2e-14 m^2/N")
    if steady_key != "coefficient" and reader.is_given(f"{wear}.coefficient"):
        message = "conflicts with running_in.steady, which means the same; remove one of the two"
        reader.report(f"{wear}.coefficient", message)
    if f"{wear}.running_in" in reader.keys_in_use:
        overriding = ("running_in.bearing_initial", "running_in.journal_initial")
        _check_common_or_each(reader, wear, "running_in.initial", overriding, "1e-13 m^2/N")
    _check_wear_magnitude(reader, wear)


def _check_common_or_each(reader: Reader, wear: str, key: str, overriding: tuple[str, str], example: str) -> None:
    """Check that there is a common coefficient or one for each body, and that a varied one is used."""
    is_overridden = all(reader.is_given(f"{wear}.{overriding_key}") for overriding_key in overriding)
    if not reader.is_given(f"{wear}.{key}") and not is_overridden:
        message = f"is missing; for example: {example} for both bodies, or {' and '.join(overriding)}"
        reader.report(f"{wear}.{key}", message, at=wear)
    if f"{wear}.{key}" in reader.written_axes and is_overridden:
        message = f"is swept but not in use: {' and '.join(overriding)} override it"
        reader.problems.add(reader.written_axes[f"{wear}.{key}"], f"{wear}.{key}", message)


def _check_wear_magnitude(reader: Reader, wear: str) -> None:
    """Check that wear coefficients times hardness have a realistic magnitude."""
    is_dimensionless = reader.values.get(f"{wear}.coefficient_unit") == DIMENSIONLESS
    hardness = 1.0 if is_dimensionless else max(reader.values_of(f"{wear}.hardness"), default=0.0)
    for path in (f"{wear}.{key}" for key in COEFFICIENTS):
        numbers = [value * hardness for value in reader.values_of(path)]
        largest, smallest = max(numbers, default=0.0), min((value for value in numbers if value), default=1.0)
        if largest > LARGEST_WEAR_NUMBER or (is_dimensionless and smallest < LEAST_WEAR_NUMBER):
            description = (
                f"found {(largest if largest > LARGEST_WEAR_NUMBER else smallest):.15g} without a unit; allowed: "
                f"{LEAST_WEAR_NUMBER:g} to {LARGEST_WEAR_NUMBER:g}; if the coefficient is in m^2/N, write that unit"
                if is_dimensionless
                else f"found {reader.text(path, largest / hardness)}; its product with the hardness "
                f"{reader.text(f'{wear}.hardness', hardness)} is {largest:.3g}; "
                f"allowed: at most {LARGEST_WEAR_NUMBER}; is the coefficient in mm^2/N? (1 mm^2/N is 1e-6 m^2/N)"
            )
            reader.report(path, description)


def _check_shape(reader: Reader, joint: str, given: list[str], catalogue: Catalogue) -> None:
    """Check that a joint whose bearing is no circle has no conflicting key; given : paths of what shapes it."""
    if f"{joint}.film" in reader.keys_in_use:
        reader.report(given[0], "is not available with a film, whose formula assumes circles; remove one of the two")
    if len(given) > 1:
        reader.report(given[1], "is not available with a profile, as wear changes circles; remove one of the two")
    shape = "profile" if given[0].endswith(".profile") else "worn shape"
    refuse_sticking(reader, catalogue, f"the {shape} of {joint} acts on the contact")


def _check_pressure(reader: Reader, joint: str, catalogue: Catalogue) -> None:
    """Check that a pressure law that needs a modulus has one."""
    path, contact = f"{joint}.wear.pressure", f"{joint}.contact"
    modulus_laws = [
        law for law in catalogue.of("pressure") if "modulus" in law.needs and law.name in reader.names[path]
    ]
    if modulus_laws and not any(map(reader.is_given, modulus_paths(joint))):
        message = (
            f"is missing; wear pressure '{modulus_laws[0].name}' needs material: {{young: 207 GPa, poisson: 0.3}} or "
            "pressure_modulus; a stiffness does not determine it, and pressure: mean needs neither"
        )
        reader.report(f"{contact}.material", message, at=path)


def _check_life(reader: Reader) -> None:
    """Report keys that conflict with `life`."""
    if LIFE not in reader.keys_in_use:
        return
    joint = reader.values.get(f"{LIFE}.joint")
    if joint is not None:
        _check_limited_joint(reader, str(joint))
    for path, reason in (
        ("simulate.until", "a life determines the length of its blocks from the wear rate"),
        ("simulate.error_check", "the interval of a life contains its error"),
        ("save.worst", "the history of a life contains the peak of each block"),
    ):
        if path in reader.sections or path in reader.values:
            reader.report(path, f"has no effect with `life`, because {reason}; leave it out")
    _check_blocks(reader)
    _check_periodicity(reader)


def _check_limited_joint(reader: Reader, joint: str) -> None:
    """Check that the limited joint wears, and that its limit is a small change of shape."""
    path, joint_path = f"{LIFE}.joint", f"joints.{joint}"
    if joint_path not in reader.keys_in_use:
        paths = (name.split(".") for name in reader.keys_in_use)
        worn_joints = [parts[1] for parts in paths if parts[0] == "joints" and parts[2:] == ["wear"]]
        remedy = f"name one that wears ({', '.join(worn_joints)})" if worn_joints else "give it clearance and wear"
        reader.report(path, f"{joint} has no clearance in this grid; {remedy}")
        return
    if f"{joint_path}.wear" not in reader.keys_in_use:
        message = "is missing; life needs the wear of its joint; for example: {law: archard, coefficient: 2e-14 m^2/N}"
        reader.report(f"{joint_path}.wear", message, at=path)
    limits, radii = reader.values_of(f"{LIFE}.limit"), reader.values_of(f"{joint_path}.bearing_radius")
    if limits and radii and max(limits) > MAX_RELATIVE_DEPTH * min(radii):
        path = f"{LIFE}.limit"
        message = (
            f"found {reader.text(path, max(limits))}; allowed: at most {MAX_RELATIVE_DEPTH:g} of "
            f"{joint_path}.bearing_radius, "
            f"{reader.text(f'{joint_path}.bearing_radius', min(radii))}: wear must remain a small change of the shape"
        )
        reader.report(path, message)


def _check_blocks(reader: Reader) -> None:
    """Check that blocks are whole revolutions, and that the longest is not below the shortest."""
    longest = f"{LIFE}.max_revolutions"
    check_below(reader, "simulate.revolutions", longest, "it is the shortest block", equal=True, of_high=True)
    for window in _windows(reader, "simulate.revolutions"):
        if abs(window - round(window)) > WHOLE_TOLERANCE or round(window) < 1:
            message = (
                f"found {window:.6g} revolutions after simulate.discard; with life the number must be whole, "
                "as their wear is extrapolated to all revolutions"
            )
            reader.report("simulate.revolutions", message)
            return


def _check_periodicity(reader: Reader) -> None:
    """Check that drive and loads repeat every revolution."""
    tables = {path: values for path, values in reader.values.items() if isinstance(values, dict)}
    for path, table in tables.items():
        if path.startswith(("drive.", "loads.")) and "time" in table:
            message = (
                "depends on time, but `life` assumes a periodic drive: write a table over "
                "crank_angle, or a constant speed"
            )
            reader.report(path, message)
