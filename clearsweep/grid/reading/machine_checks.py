"""Checks of user-defined machines, of their drives and loads, and of joints with an oil film."""

from itertools import pairwise

from ...contracts.case import column_name
from ...contracts.catalogue import GROUND, Catalogue, JointOutline, Law, LoadOutline
from ..keys import Section
from ..sections import Reader

FREEZING = 273.15  # K, 0 degC
OIL_TEMPERATURES = 200.0, 700.0  # K, beyond those of ASTM D341, at which oils are solid or burn

_UNCONNECTED_TEXT = "no chain of joints connects it with the ground; connect it with a joint, or remove it"


def check_below(
    reader: Reader, low: str, high: str, reason: str, *, equal: bool = False, of_high: bool = False
) -> bool:
    """Return whether every value of `low` is below every value of `high`, or one is missing; report it if not.

    of_high : the mistake is one of `high`, else of `low` if that is written
    """
    lows, highs = reader.values_of(low), reader.values_of(high)
    if not lows or not highs or max(lows) < min(highs) or (equal and max(lows) == min(highs)):
        return True
    if reader.vary_together(low, high):
        invalid = [(a, b) for a, b in zip(lows, highs, strict=False) if not (a < b or (equal and a == b))]
        if not invalid:
            return True
        lows, highs = zip(*invalid[:1], strict=True)
    low_text, high_text = reader.text(low, max(lows)), reader.text(high, min(highs))
    if of_high:
        comparison = "at least" if equal else "above"
        reader.report(high, f"found {high_text}; allowed: {comparison} {low_text}, the value of {low}; {reason}")
    else:
        comparison, place = "at most" if equal else "below", low if reader.is_given(low) else high
        reader.report(place, f"found {low_text}; allowed: {comparison} {high_text}, the value of {high}; {reason}")
    return False


def refuse_sticking(reader: Reader, catalogue: Catalogue, reason: str) -> None:
    """Report laws of friction by which surfaces can stick, wherever they are."""
    sticking = {law.name for law in catalogue.of("friction") if law.sticks}
    for path in (path for path in reader.names if path.endswith(".friction.law")):
        for law in sorted(reader.names[path] & sticking):
            reader.report(path, f"{law} cannot stick, because {reason}; choose another law")


def check_machine(reader: Reader, catalogue: Catalogue) -> None:
    """Report values that conflict with each other."""
    if reader.outline.inclined and reader.outline.elastic and any(reader.values_of("mechanism.gravity.0")):
        message = "acts along x, too, which an elastic link does not take; write a single value, which acts along -y"
        reader.report("mechanism.gravity", message)
    if reader.outline.bodies and "mechanism.bodies" in reader.keys_in_use:
        _check_bodies(reader)
        _check_drive(reader)
        _check_initial(reader)
        _check_gears(reader)
    _check_servo(reader)
    for load in reader.outline.loads:
        path = f"loads.{load.name}"
        if path not in reader.keys_in_use:
            continue
        if load.form == "force" and not (reader.is_given(f"{path}.force") or reader.is_given(f"{path}.torque")):
            message = "has no force and no torque; for example: force: [-2 kN, 0 N] or torque: -3 N*m, or a table"
            reader.report(path, message)
        if load.form == "table":
            _check_pressure(reader, path)
        ends = [reader.values.get(f"{path}.between.{k}") for k in range(2)]
        if load.form == "torsion" and ends[0] == ends[1] is not None:
            reader.report(f"{path}.between", f"joins {ends[0]} with itself; name two bodies", at=path)
        if load.form == "friction":
            _check_friction_load(reader, catalogue, path, load)
    for site in reader.mechanism.joints:
        if site.kind == "spatial" and f"joints.{site.name}" in reader.keys_in_use:
            _check_flanges(reader, f"joints.{site.name}")
    for body in sorted(reader.outline.elastic):
        _check_elastic_link(reader, body)
    for joint in reader.outline.mounts:
        _check_mount(reader, joint)
    _check_guides(reader)


def _check_mount(reader: Reader, joint: str) -> None:
    """Check that a housing has one damping, and carries no wheel of a gear, whose centre would move."""
    path = f"mechanism.mounts.{joint}"
    if path not in reader.keys_in_use:
        return
    dampings = [value for k in range(2) for value in reader.values_of(f"{path}.damping.{k}")]
    if any(dampings) and reader.is_given(f"{path}.damping_ratio.0"):
        message = "conflicts with `damping`; write one of them, or `damping` in N*s/m or in %"
        reader.report(f"{path}.damping_ratio", message, at=f"{path}.damping_ratio.0")
    wheels = {body for other in reader.outline.joints if other.name == joint for body in other.bodies} - {GROUND}
    for gear in reader.outline.joints:
        if gear.type == "gear" and wheels & set(gear.bodies):
            message = f"carries a wheel of the gear {gear.name}, whose centre has to stay; remove the mount or the gear"
            reader.report(path, message)


def _check_pressure(reader: Reader, path: str) -> None:
    """Check that a table of pressures has a bore and no forces, and that only such a table has a piston."""
    columns = reader.values.get(f"{path}.table")
    if columns is None:
        return
    pistons = [key for key in ("bore", "ambient", "direction") if reader.is_given(f"{path}.{key}")]
    if "pressure" not in columns:
        for key in pistons:
            message = "is not used: the table has no column `pressure [bar]`; add it, or leave this key out"
            reader.report(f"{path}.{key}", message)
    elif "fx" in columns or "fy" in columns:
        reader.report(f"{path}.table", "has a pressure and a force; keep one of them, or write two loads")
    else:
        message = "the pressure of the table acts on a piston of this diameter, such as 60 mm"
        reader.require(f"{path}.bore", message, at=path)


def _bodies_of_joint(reader: Reader, joint: JointOutline) -> tuple[str, str] | None:
    """Return the bodies that a joint connects, or None if they were unreadable and are already reported."""
    known = {body.name for body in reader.outline.bodies}
    return joint.bodies if known.issuperset(joint.bodies) else None


def _check_bodies(reader: Reader) -> None:
    """Check that there is a ground, that no joint connects a body with itself, and that every body is connected."""
    outline, path_of_bodies = reader.outline, "mechanism.bodies"
    if GROUND not in {body.name for body in outline.bodies}:
        message = "is missing; add the body that does not move, such as ground: {points: {main: [0 mm, 0 mm]}}"
        reader.report(f"{path_of_bodies}.{GROUND}", message, at=path_of_bodies)
        return
    links = []
    for joint in outline.joints if outline.spatial else ():
        if joint.type in ("slot", "gear", "coupling") or joint.stops:
            path = f"mechanism.joints.{joint.name}"
            message = (
                f"a mechanism in space cannot have {'stops' if joint.stops else f'a {joint.type}'}; write a planar "
                "mechanism"
            )
            reader.report(f"{path}.type", message, at=path)
    stopped = {column_name(site.name): site.stopped for site in reader.mechanism.joints if site.stopped}
    for joint in outline.joints:
        bodies = _bodies_of_joint(reader, joint)
        path = f"mechanism.joints.{joint.name}"
        if owner := stopped.get(column_name(joint.name)):
            reader.report(path, f"has the columns of the stops of {owner}; rename it")
        if bodies is None:
            return
        if bodies[0] == bodies[1]:
            reader.report(f"{path}.between", f"joins {bodies[0]} with itself; name two bodies", at=path)
        links.append(set(bodies))
    connected, count_before = {GROUND}, 0
    while len(connected) > count_before:
        count_before = len(connected)
        connected |= {body for link in links if link & connected for body in link}
    for body in outline.bodies:
        if body.name not in connected:
            path = f"{path_of_bodies}.{body.name}"
            reader.report(path, f"is not connected: {_UNCONNECTED_TEXT}")


def check_length(reader: Reader) -> None:
    """Check that a run whose length is a number of revolutions has a crank that makes them."""
    if "simulate" not in reader.keys_in_use or "simulate.revolutions" not in reader.keys_in_use:
        return
    for path in ("drive.speed.table", "drive.angle.table"):
        table = reader.values.get(path)
        if not isinstance(table, dict):
            continue
        steps = table["speed"] if path.startswith("drive.speed") else [b - a for a, b in pairwise(table["angle"])]
        if min(steps) < 0.0 < max(steps):
            end = f"{max(table['time'][-1], 0.0):.6g} s"
            message = (
                "the crank turns back here, so revolutions do not measure its run; write the length as "
                f"simulate: {{time: {end}}}, or as cycles: simulate: {{cycles: 3, period: {end}}}"
            )
            reader.report("simulate.revolutions", message)
        elif not any(steps):
            message = "the angle is the same in every row, so the crank makes no revolution; write simulate.time"
            reader.report("simulate.revolutions", message)
    if reader.outline.drive == "servo":
        message = "a servo follows its target, so revolutions do not measure its run; write simulate.time, or cycles"
        reader.report("simulate.revolutions", f"{message} with their period")


def _check_servo(reader: Reader) -> None:
    """Check that a servo with a tracking time has an integral part and a limit."""
    path = "drive.servo.tracking_time"
    for key in ("integral", "torque_limit") if reader.is_given(path) else ():
        if not reader.is_given(f"drive.servo.{key}"):
            message = f"is the time in which the integral gives way at the limit; write {key}, too, or leave it out"
            reader.report(path, message)


def _check_drive(reader: Reader) -> None:
    """Check that the driven body is on the ground, in a joint without clearance."""
    path = "mechanism.driven"
    joint = next((joint for joint in reader.outline.joints if joint.name == reader.values.get(path)), None)
    bodies = _bodies_of_joint(reader, joint) if joint else None
    if joint is None or bodies is None:
        return
    if bodies[0] != GROUND:
        message = (
            f"{joint.name} joins {bodies[0]} and {bodies[1]}; a drive must turn a joint whose first body is the ground"
        )
        reader.report(path, message)
    if joint.name in reader.outline.clearances:
        message = f"{joint.name} is the driven joint, which has no clearance; leave joints.{joint.name} out"
        reader.report(f"joints.{joint.name}", message)


def _check_initial(reader: Reader) -> None:
    """Check that a body with a given initial state is determined by no ideal joint and nothing else.

    A body on an ideal pin may turn if a gear or coupling with play, or a torsion spring, reaches it.
    """
    for body in reader.outline.bodies:
        path = f"mechanism.bodies.{body.name}.initial"
        if not reader.is_given(path):
            continue
        turns, driven = _turns_on_pin(reader, body.name), reader.values.get("mechanism.driven")
        for joint in reader.outline.joints:
            if joint.name == driven and body.name in joint.bodies:
                message = f"{driven} is driven, so the drive determines how {body.name} starts; leave initial out"
                reader.report(path, message)
                continue
            if turns and joint.type == "revolute":
                continue
            if body.name in joint.bodies and joint.name not in reader.outline.clearances:
                message = _undriven_text(reader, body.name, joint) or (
                    f"{joint.name} is ideal and fixes {body.name}, which determines how {body.name} starts; leave "
                    f"initial out, or give {joint.name} clearance"
                )
                reader.report(path, message)
        for key in ("x", "y", "vx", "vy") if turns else ():
            if any(reader.values_of(f"{path}.{key}")):  # 0 is the default, which a resolved grid contains
                message = f"is fixed by the pin on which {body.name} turns; write angle and rate only"
                reader.report(f"{path}.{key}", message)
        if "seated" in reader.values_of("simulate.start"):
            message = f"seated conflicts with {path}, which says where {body.name} starts; remove one of the two"
            reader.report("simulate.start", message)


def _undriven_text(reader: Reader, body: str, pin: JointOutline) -> str:
    """Return the message on a body with an initial state whose only joint is an undriven ideal pin, or ''."""
    attached = [joint for joint in reader.outline.joints if body in joint.bodies]
    if attached != [pin] or pin.type != "revolute" or pin.name == reader.values.get("mechanism.driven"):
        return ""
    return (
        f"{body} turns on {pin.name}, but nothing drives it; connect it with a gear or a coupling that has play, or "
        "with a torsion spring, or remove the body"
    )


def _check_gears(reader: Reader) -> None:
    """Check that the wheels of a gear without play turn on pins without clearance: its teeth would push them aside."""
    open_pins = [
        joint for joint in reader.outline.joints if joint.type == "revolute" and joint.name in reader.outline.clearances
    ]
    for gear in reader.outline.joints:
        followers = ("friction", "wear", "mesh_stiffness") if gear.type == "gear" else ()
        for path in (f"joints.{gear.name}.{key}" for key in followers):
            if reader.is_given(path) and not reader.is_given(f"mechanism.joints.{gear.name}.teeth"):
                message = f"follows the teeth along their path of contact; write mechanism.joints.{gear.name}.teeth"
                reader.report(path, message)
        if gear.type != "gear" or gear.name in reader.outline.clearances:
            continue
        for path in (f"mechanism.joints.{gear.name}.{wheel}_eccentricity" for wheel in ("first", "second")):
            if any(reader.values_of(path)):
                message = f"a wheel out of centre needs teeth with play; write joints.{gear.name} with a backlash"
                reader.report(path, message)
        carriers = [
            {
                body
                for joint in reader.outline.joints
                if joint.type == "revolute"
                for body in joint.bodies
                if wheel in joint.bodies and body != wheel
            }
            for wheel in gear.bodies
        ]
        for pin in open_pins:
            if set(pin.bodies) & set(gear.bodies) and set(pin.bodies) & carriers[0] & carriers[1]:
                message = (
                    f"has clearance, so {gear.name} needs its own: the teeth push the wheel in its bearing; write "
                    f"joints.{gear.name} with a backlash, or remove the clearance of {pin.name}"
                )
                reader.report(f"joints.{pin.name}", message)


def _turns_on_pin(reader: Reader, body: str) -> bool:
    """Return whether a body turns on an ideal pin, driven through play in rotation or by a torsion spring."""
    on_pin = any(
        joint.type == "revolute" and body in joint.bodies and joint.name not in reader.outline.clearances
        for joint in reader.outline.joints
    )
    through_play = any(
        joint.type in ("gear", "coupling") and body in joint.bodies and joint.name in reader.outline.clearances
        for joint in reader.outline.joints
    )
    springs = (f"loads.{load.name}.between" for load in reader.outline.loads if load.form == "torsion")
    by_spring = any(body in (reader.values.get(f"{path}.{k}") for k in range(2)) for path in springs)
    return on_pin and (through_play or by_spring)


def _check_friction_load(reader: Reader, catalogue: Catalogue, path: str, load: LoadOutline) -> None:
    """Check that friction acts in a joint without clearance and, in a pin, has a radius or a couple.

    It cannot stick if the friction of a clearance joint can, too.
    """
    joint, given_quantity = load.on, load.given
    law, sticking = f"{path}.friction.law", {law.name for law in catalogue.of("friction") if law.sticks}
    laws = {key: names for key, names in reader.names.items() if key.endswith(".friction.law") and names & sticking}
    if law in laws and any(key.startswith("joints.") for key in laws):
        message = "cannot stick, because a joint with clearance has a law that sticks, too; choose another"
        reader.report(law, f"{message} law for one of them")
    site = next((site for site in reader.mechanism.joints if site.name == joint), None)
    if site is None:
        return
    if joint in reader.outline.clearances:
        remedy = f"write the friction as joints.{joint}.friction"
        if given_quantity and site.kind in ("revolute", "guide"):
            remedy += ": {law, coefficient, ...}, and give it `preload`"
        reader.report(f"{path}.on", f"{joint} has clearance; {remedy}")
    radius = f"{path}.friction.radius"
    is_guide = site.kind in ("guide", "guide_stops")
    expected = "force" if is_guide else "torque"
    if given_quantity and given_quantity != expected:
        kind = "guide, in which friction is a force" if is_guide else "pin, in which friction is a couple"
        message = f"{joint} is a {kind}; write {expected}"
        reader.report(f"{path}.friction.{given_quantity}", message, at=f"{path}.friction")
    if given_quantity:
        return
    if site.kind in ("revolute", "stops"):
        message = "friction in a pin is a torque, coefficient x reaction x radius; for example: 10 mm"
        reader.require(radius, message, at=f"{path}.friction")
    if is_guide and reader.is_given(radius):
        reader.report(radius, f"{joint} is a guide, in which friction is a force; leave it out")


def _check_elastic_link(reader: Reader, body: str) -> None:
    """Check that an elastic link has a mass and pins at two different points.

    A link that does not bend has nothing else attached; one that does has no guide, and is not driven.
    """
    section = f"mechanism.{'bodies.' if reader.outline.bodies else ''}{body}"
    path = f"{section}.elastic"
    if path not in reader.keys_in_use:
        return
    if 0.0 in reader.values_of(f"{section}.mass"):
        reader.report(f"{section}.mass", "found 0; an elastic link needs a mass above 0: write it, or remove `elastic`")
    pins = [f"{body}.{reader.values.get(f'{path}.between.{k}')}" for k in range(2)]
    if pins[0] == pins[1] and reader.outline.bodies:
        reader.report(f"{path}.between", f"lies between {pins[0]} and itself; name the points of its two pins", at=path)
    if reader.outline.bending_of(body):
        _check_bending_link(reader, body, path, pins)
        return
    for joint in reader.outline.joints:
        attached_point = _point_on(joint, body)
        if attached_point is not None and (joint.type != "revolute" or attached_point not in pins):
            attachment = {"prismatic": "a guide", "slot": "a slot"}.get(joint.type, f"at {attached_point}")
            message = (
                f"{joint.name}, {attachment}, is on this elastic link, which may have only two pins; remove `elastic`"
            )
            reader.report(path, message)
    for load in reader.outline.loads:
        points = (reader.values.get(f"loads.{load.name}.{key}") for key in ("point", "between.0"))
        load_point, anchor_point = (f"{body}.{value}" for value in points)
        is_at_pin = load_point in pins and reader.outline.bodies
        if anchor_point == f"{body}.{body}" or (load.form != "friction" and load.on == body and not is_at_pin):
            message = (
                f"acts on {body}, an elastic link, away from its pins, which is not available; use the point of a pin"
            )
            reader.report(f"loads.{load.name}", message)


def _point_on(joint: JointOutline, body: str) -> str | None:
    """Return the point of a body, 'body.point', that a joint connects, or None."""
    return next((point for point in (joint.proximal, joint.distal) if point.partition(".")[0] == body), None)


def _check_bending_link(reader: Reader, body: str, path: str, pins: list[str]) -> None:
    """Check that the section and the material of a link that bends are known, and what is attached to it."""
    sides, numbers = f"{path}.section", [f"{path}.{name}" for name in ("area", "second_moment", "edge")]
    given = [number for number in numbers if reader.is_given(number)]
    if reader.is_given(sides) and given:
        name = given[0].rpartition(".")[2]
        message = f"conflicts with `{name}`, which it determines; write the section, or area, second_moment and edge"
        reader.report(sides, message)
    elif not reader.is_given(sides) and len(given) < len(numbers):
        missing = next(number for number in numbers if number not in given) if given else sides
        message = "is missing; write section: [8 mm, 8 mm] (across, in the plane), or area, second_moment and edge"
        reader.report(missing, message, at=path)
    message = "write young: 210 GPa, or material: S355 (`clearsweep list materials` has their names)"
    reader.require(f"{path}.young", message, at=path)
    driven = reader.values.get("mechanism.driven")
    joint = next((joint for joint in reader.outline.joints if joint.name == driven), None)
    if body == (joint.bodies[1] if joint else "crank"):
        message = (
            f"{body} is driven: its shaft clamps it, so it does not bend in the modes of a bar between two pins; let a "
            "link between two pins bend, and give the driven body at most axial_stiffness"
        )
        reader.report(path, message)
    pinned = set()
    for joint in reader.outline.joints:
        attached_point = _point_on(joint, body)
        if attached_point is not None and joint.type != "revolute":
            message = (
                f"{joint.name}, a {'slot' if joint.type == 'slot' else 'guide'}, is on this body; only a link between "
                "pins bends: leave `elastic` out"
            )
            reader.report(path, message)
        pinned.add(attached_point)
    for k, pin in enumerate(pins if reader.outline.bodies else ()):
        if pin not in pinned and pins[0] != pins[1]:
            message = f"no joint is at {pin}; name the two points at which pins carry the link"
            reader.report(f"{path}.between.{k}", message, at=path)


def _check_flanges(reader: Reader, joint: str) -> None:
    """Check that a journal fits between its flanges."""
    sizes = [reader.values_of(f"{joint}.{key}") for key in ("length", "axial_clearance", "journal_length")]
    length, clearance, journal_length = (
        min(sizes[0], default=0.0),
        min(sizes[1], default=0.0),
        max(sizes[2], default=0.0),
    )
    if all(sizes) and journal_length >= length + 2.0 * clearance:
        message = (
            f"found {journal_length:.15g}; allowed: below {length + 2.0 * clearance:.15g}, the length of the bearing "
            "and its axial clearance on both sides, between its flanges; shorten the journal, or write flange: false"
        )
        reader.report(f"{joint}.journal_length", message)


def _check_guides(reader: Reader) -> None:
    """Check that a body in an open guide can turn, and that it does not start seated."""
    for site in reader.mechanism.joints:
        path = f"joints.{site.name}"
        if site.kind not in ("guide", "slot") or not isinstance(reader.keys_in_use.get(path), Section):
            continue
        inertia = "mechanism.slider.inertia"
        if site.kind == "guide" and inertia in reader.keys_in_use:
            message = f"with clearance in {site.name} the slider turns; for example: 1e-4 kg*m^2"
            reader.require(inertia, message, at="mechanism.slider")
        if "seated" in reader.values_of("simulate.start"):
            message = f"cannot be seated with clearance in {site.name}; leave it out, or write centred"
            reader.report("simulate.start", message)


def check_film_joints(reader: Reader, catalogue: Catalogue) -> None:
    """Report values that conflict with each other."""
    names = [path.split(".") for path in reader.keys_in_use]  # a joint may have the name film, too
    films = [".".join(parts) for parts in names if parts[0] == "joints" and parts[2:] == ["film"]]
    for film in films:
        joint = film.removesuffix(".film")
        _check_film_size(reader, joint, catalogue)
        _check_temperature(reader, film)
        law, modulus = f"{joint}.film.transition.law", f"{joint}.film.transition.modulus"
        is_known = reader.is_given(modulus) or reader.is_given(f"{joint}.contact.material")
        if law in reader.keys_in_use and "greenwood-tripp" in reader.names[law] and not is_known:
            message = "write E* of both bodies, such as 114 GPa for steel, or contact.material"
            reader.require(modulus, message, at=f"{joint}.film")
        if f"{joint}.contact" not in reader.keys_in_use and f"{joint}.contact" not in reader.unread_sections:
            _check_unused_contact_keys(reader, joint)
    for joint in [film.removesuffix(".film") for film in films[:1]]:
        refuse_sticking(reader, catalogue, f"{joint} has a film")
        if "seated" in reader.values_of("simulate.start"):
            message = f"cannot be seated in the film of {joint}, which carries no load at rest; remove the key, or use"
            reader.report("simulate.start", f"{message} centred")


def _check_film_size(reader: Reader, joint: str, catalogue: Catalogue) -> None:
    """Check that length and radius are given and that the film's laws are valid for them."""
    length, radius, law = f"{joint}.length", f"{joint}.bearing_radius", f"{joint}.film.law"
    for path, example in ((length, "length along the pin, such as 40 mm"), (radius, "bearing's radius, such as 20 mm")):
        reader.require(path, f"a film needs the {example}", at=f"{joint}.film")
    lengths, radii = reader.values_of(length), reader.values_of(radius)
    if law in reader.unread_laws or not lengths or not radii:
        return
    pairs = (
        list(zip(lengths, radii, strict=False))
        if reader.vary_together(length, radius)
        else [(max(lengths), min(radii)), (min(lengths), max(radii))]
    )
    for film_law in (film_law for film_law in catalogue.of("film") if film_law.name in reader.names[law]):
        _check_slenderness(reader, joint, film_law, [axial_length / (2.0 * radius) for axial_length, radius in pairs])


def _check_slenderness(reader: Reader, joint: str, law: Law, ratios: list[float]) -> None:
    """Check that a law is valid for the ratios of length to diameter."""
    limits = ((limit, ratio) for limit in law.ranges for ratio in ratios if not limit.contains(ratio))
    limit, ratio = next(limits, (None, 0.0))
    if limit:
        is_default = not reader.is_given(f"{joint}.film.law")
        law_text = f"film '{law.name}'{', the law where none is written,' if is_default else ''}"
        range_text = f"{limit.low:g} to {limit.high:g}" if limit.low else f"at most {limit.high:g}"
        message = f"found {ratio:.4g} bearing diameters; {law_text} allows {range_text}: {limit.reason}"
        reader.report(f"{joint}.length", message)


def _check_temperature(reader: Reader, film: str) -> None:
    """Check that viscosity falls with temperature, and that a temperature is given only with an oil."""
    if f"{film}.thermal" in reader.sections and not reader.mechanism.turns:
        reader.report(f"{film}.thermal", "needs a mechanism with revolutions; give a temperature instead")
    viscosity, balance, temperature = f"{film}.viscosity", f"{film}.thermal", f"{film}.temperature"
    if viscosity not in reader.sections:
        for path in (balance, temperature):
            if reader.is_given(path):
                message = (
                    "has no effect, because the viscosity is constant; use viscosity: {at_40C: 46 mm^2/s, "
                    "at_100C: 6.8 mm^2/s, density: 870 kg/m^3}"
                )
                reader.report(path, message)
        return
    check_below(reader, f"{viscosity}.at_100C", f"{viscosity}.at_40C", "oil thins as it warms up")
    coldest, hottest = OIL_TEMPERATURES
    for path in (temperature, f"{balance}.ambient"):
        outside = [value for value in reader.values_of(path) if not coldest <= value <= hottest]
        for value in outside[:1]:  # perhaps a number in degC without its unit
            meant = f"; did you mean {value:g} degC?" if coldest <= value + FREEZING <= hottest else ""
            text = f"found {value:g} K ({value - FREEZING:.4g} degC)"
            reader.report(path, f"{text}; allowed for an oil: {coldest:g} K to {hottest:g} K{meant}")
    if reader.is_given(balance) == reader.is_given(temperature):
        message = "is missing; for example: temperature: 60 degC, or thermal: {conductance: 20 W/K, ambient: 40 degC}"
        if reader.is_given(balance):
            message = "conflicts with `thermal`, which determines it; remove one of the two"
        reader.report(temperature, message, at=film)


def _check_unused_contact_keys(reader: Reader, joint: str) -> None:
    """Check that a joint without dry contact has no keys of a dry contact."""
    film = reader.sections[f"{joint}.film"].value
    is_transition_written = isinstance(film, dict) and "transition" in film
    of_contact = ("friction", "wear", *(("film.transition",) if is_transition_written else ()))
    for path in (f"{joint}.{key}" for key in of_contact):
        if path in reader.sections:
            message = "applies to the dry contact under a film, but the joint has none; add contact, or remove the key"
            reader.report(path, message)
