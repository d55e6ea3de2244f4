"""Remarks on a finished case: laws beyond their range, films beyond their limit, implausible figures.

And warnings about values of a case before it runs.
"""

import functools
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from ..answers import validity
from ..contracts.case import DOUBTFUL_WEAR_NUMBER, Case, Joint, column_name
from ..contracts.layout import FRICTION_POWER, JointLayout
from ..contracts.machine import Body, Elastic, Machine
from ..mechanics.joints import registry
from ..mechanics.joints.dry import Gap
from ..mechanics.joints.registry import largest_mass, yield_energy
from ..mechanics.laws import reynolds
from ..mechanics.machines import planar
from ..mechanics.machines.contract import impact_masses, pose_at
from ..mechanics.machines.described import MAX_SEGMENTS
from ..tracing.compiled.family import Identity
from .figures.window import Window
from .machine import ideal as ideal_machine
from .machine.ideal import machine_of, max_drive_speed, mechanism_of
from .setup.scene import Scene

MIN_SKIDDING_SHARE = 0.05  # of the time below the least load; every joint that changes contact passes it

# The approach speed at which the contacts of a scene first yield.

DIRECTIONS = tuple(math.radians(angle) for angle in (0.0, 45.0, 90.0))  # see `largest_mass`


def yield_speeds(scene: Scene) -> dict[str, float | None]:
    """Return the approach speed (m/s) at first yield of each joint of known strength, by column; None if undefined.

    The speed is sqrt(2 W / m), with W the elastic energy at first yield and m the largest effective mass at the start.
    """
    elastic_joints = [
        (index, case_joint)
        for index, (case_joint, joint) in enumerate(zip(scene.case.joints, scene.layout.joints, strict=True))
        if joint.strength
    ]
    if not elastic_joints:
        return {}
    masses = largest_masses(Identity(scene.value.mechanism), scene.start.tobytes(), len(scene.case.joints))
    speeds: dict[str, float | None] = {}
    for index, joint in elastic_joints:
        mass = masses[index]
        energy = None if mass is None else yield_energy(joint, registry.compile_contact(joint)[1])
        speeds[f"{joint.column}_yield_speed"] = math.sqrt(2.0 * energy / mass) if energy is not None and mass else None
    return speeds


@functools.lru_cache(maxsize=256)  # the cases of a sweep share mechanisms and starts
def largest_masses(mechanism: Identity, start: bytes, joint_count: int) -> list[float | None]:
    """Return the largest effective mass (kg) of each joint over all directions at a start, or None if unknown.

    mechanism : compiled; start : the initial state of the scene, as bytes of float64.
    """
    pose = pose_at(mechanism.value, np.frombuffer(start))
    gaps = [Gap(math.cos(angle), math.sin(angle), 0.0, 0.0, 0.0, 0.0) for angle in DIRECTIONS]
    by_direction = [impact_masses(mechanism.value, pose, (gap,) * joint_count) for gap in gaps]
    return [largest_mass(np.array(masses, float)) for masses in zip(*by_direction, strict=True)]


def remarks(scene: Scene, window: Window, summary: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the remarks on a finished case; '' replaces each remark that does not apply."""
    pairs = list(zip(scene.layout.joints, scene.case.joints, strict=True))

    def figures(name: str, applies: Callable[[JointLayout, Joint], Any]) -> list[tuple[Joint, Any]]:
        """Return the joints to which a figure applies, each with its value."""
        return [(joint, summary[f"{layout.name}_{name}"]) for layout, joint in pairs if applies(layout, joint)]

    beyond_limit = [
        (joint.name, joint.elastic_name, registry.penetration_limit(joint), share)
        for joint, share in figures("law_limit_fraction", lambda layout, joint: True)
        if share
    ]
    rubbing = figures(FRICTION_POWER, lambda layout, joint: layout.friction and not layout.film)
    rubbing_powers = [(joint.name, power, joint.thermal and joint.thermal.conductance) for joint, power in rubbing]
    skidding = [
        (joint.name, joint.rolling.least_load, share)
        for joint, share in figures("light_load_fraction", lambda layout, joint: layout.is_rolling and layout.dynamic)
        if joint.rolling and share and share > MIN_SKIDDING_SHARE
    ]
    worn = figures("wear_rate_max", lambda layout, joint: layout.wear_bins and not layout.flanked)
    has_film = any(joint.film for joint in scene.layout.joints)
    settings = scene.case.simulate
    return (
        validity.law_range_remark(beyond_limit),
        validity.onset_remark(_lasting_contacts(scene, window)),
        _run_in(window),
        validity.swing_remark(summary.get("lyapunov_exponent"), sum(totals.onsets for totals in window.totals.joint)),
        *(validity.film_remarks(_film_states(scene, window, summary)) if has_film else ()),
        validity.friction_heat_remark([*rubbing_powers, *_powers_without_clearance(scene, summary)]),
        validity.free_bush_remark(scene.case.joints),
        validity.coarse_link_remark(_impacts_on_links(scene, summary), MAX_SEGMENTS),
        validity.ball_stiffness_remark(
            joint.name for joint in scene.case.joints if scene.mechanism.turns and registry.uses_ball_stiffness(joint)
        ),
        validity.feedback_remark(None if scene.case.outline.mounts else summary.get("frame_velocity_rms")),
        validity.penetration_remark(
            figures("penetration_max", lambda layout, joint: joint.is_dry and not (joint.flanked or joint.rolling))
        ),
        validity.static_load_remark(figures("force_peak", lambda layout, joint: joint.rolling)),
        validity.skidding_remark(skidding),
        validity.wear_depth_remark(figures("wear_depth_max", lambda layout, joint: layout.wear_bins)),
        validity.wear_rate_remark(worn),
        validity.pv_remark(figures("pv_mean", lambda layout, joint: layout.wear_bins and not layout.flanked)),
        validity.imbalance_remark(
            summary["energy_residual"], settings.tolerance, 0.5 * window.events + max(settings.revolutions, 1.0)
        ),
    )


def _powers_without_clearance(scene: Scene, summary: Mapping[str, Any]) -> list[tuple[str, float, None]]:
    """Return the name and the friction power (W) of joints without clearance; their conductance (None) is unknown."""
    names = dict.fromkeys([load.values["on"] for load in scene.case.loads if load.friction])
    return [
        (name, summary[f"{column_name(name)}_{FRICTION_POWER}"], None)
        for name in names
        if column_name(name) in scene.layout.rubbing
    ]


def _impacts_on_links(scene: Scene, summary: Mapping[str, Any]) -> Iterator[tuple[str, str, int, int]]:
    """Yield link, joint, its segments and those that the fastest impact in the joint needs."""
    for link in elastic_links(scene.case):
        for joint in scene.case.joints:
            names = (f"{joint.column}_{figure}" for figure in ("force_peak", "penetration_max", "onset_rate_max"))
            peak, depth, rate = map(summary.get, names)
            if joint.name in link.joints and joint.is_dry and peak and depth and rate:
                yield link.name, joint.name, link.segments, segments_to_resolve(link, peak, depth, rate)


def _lasting_contacts(scene: Scene, window: Window) -> Iterator[tuple[str, float, bool]]:
    """Yield joint, onset rate (m/s), and whether that may be renewed, of contacts that last for the whole window."""
    for index, joint in enumerate(scene.case.joints):
        rate = float(window.onset_rate[index])
        if joint.contact.onset == "first" and not math.isnan(rate) and window.totals.joint[index].onsets == 0.0:
            can_renew = joint.slot_length is None and not joint.rolling
            yield joint.name, rate, can_renew


def _run_in(window: Window) -> str:
    """Return the remark on force peaks before the motion of the window is periodic, or ''."""
    if window.repetition is None:
        return ""
    peaks = zip(window.case.joints, window.totals.joint, window.spreads, strict=True)
    return validity.run_in_remark(
        window.repetition.begin,
        window.case.simulate.discard,
        [
            (joint.name, float(totals.force_max), spread.of_million.value)
            for joint, totals, spread in peaks
            if spread.of_million.value is not None
        ],
    )


def _film_states(scene: Scene, window: Window, summary: Mapping[str, Any]) -> Iterator[validity.FilmState]:
    """Yield the state of every film."""
    for index, joint in enumerate(scene.case.joints):
        if joint.film:
            totals = window.totals.joint[index]
            generated, dissipated = totals.generated_energy, totals.film_energy
            yield validity.FilmState(
                joint.name,
                joint.film.limit,
                summary[f"{joint.column}_film_limit_fraction"],
                summary[f"{joint.column}_eccentricity_max"] / joint.clearance,
                joint.is_dry,
                summary[f"{joint.column}_film_taylor"],
                float(generated / max(dissipated, generated)) if generated > 0.0 else 0.0,
                passive_film(joint),
            )


def passive_film(joint: Joint) -> str:
    """Return a passive film law that is valid at the length / diameter of a joint."""
    if joint.length is None or joint.bearing_radius is None:
        return "reynolds"
    slenderness = 0.5 * joint.length / joint.bearing_radius
    if slenderness < reynolds.SHORTEST:
        return "short"
    return "reynolds" if slenderness <= reynolds.LONGEST else "long"


# Warnings about values of a case, before it runs.
_MAX_WEAR_COEFFICIENT = 2e-11  # m^2/N: dry mild steel reaches 1.5e-11


def warnings(case: Case) -> list[str]:
    """Return warnings about values of a case that may be unintended."""
    sentences = [*ideal_machine.size_warnings(case), *link_warnings(case), *_change_points(case)]
    sentences += [*ideal_machine.start_warnings(case), *ideal_machine.servo_warnings(case)]
    sentences += registry.own_law_remarks(case)
    for joint in case.joints:
        if registry.can_pull(joint):
            sentences.append(
                f"joints.{joint.name}.contact.law: {joint.contact.law} pulls before the surfaces part, as published; "
                "its normal force can be negative and is not clipped"
            )
        if joint.contact.law and registry.departs_from_hertz(joint):  # a film may have no dry contact
            sentences.append(
                f"joints.{joint.name}.contact.law: {joint.contact.law} is made for Hertz's force; with rough surfaces "
                "in series the restitution of a free impact differs from the specified one"
            )
        if joint.wear is None or not any(joint.wear.coefficients().values()):
            continue
        if "hardness" not in joint.wear.values:
            sentences += _unchecked_wear(joint)
            continue
        hardness = joint.wear.values["hardness"]
        for body, coefficients in joint.wear.coefficients().items():
            ratio = max(coefficients) * hardness
            if ratio > DOUBTFUL_WEAR_NUMBER:
                sentences.append(
                    f"joints.{joint.name}.wear: {body} coefficient times hardness is {ratio:.2g}; it is the share of "
                    f"contacts that shed a particle and should be far below 1"
                )
    return sentences


def _change_points(case: Case) -> list[str]:
    """Return a warning if the machine of a case passes change points without clearance."""
    machine = machine_of(mechanism_of(case), case)
    if machine is None:
        return []
    if machine.visited == (-math.inf, math.inf) and (reach := planar.ideal_of(machine).stations.reach()):
        start = planar.ideal_of(machine).revolution.angles[0]
        low, high = (math.degrees(start + angle) for angle in reach)
        return [
            f"mechanism: without clearance the crank can turn from {low:.4g} to {high:.4g} deg only; beyond them "
            "there is no ideal machine, so that errors and ideal forces mean nothing"
        ]
    if not planar.ideal_of(machine).change_points:
        return []
    degrees = {round(math.degrees(angle)) % 360 for angle in planar.ideal_of(machine).change_points}
    return [
        "mechanism: without clearance it passes a change point, where its loops may branch, at a crank angle of about "
        f"{' and '.join(map(str, sorted(degrees)))} deg; the ideal machine, with which the case is compared, goes "
        "straight on there, and its forces have no limit; joints with clearance may take the other branch"
    ]


def _unchecked_wear(joint: Joint) -> list[str]:
    """Return a warning if a joint's wear coefficient, unchecked by a hardness, exceeds those of all metals."""
    assert joint.wear is not None  # only joints with wear
    largest = max(map(max, joint.wear.coefficients().values()))
    if largest <= _MAX_WEAR_COEFFICIENT:
        return []
    return [
        f"joints.{joint.name}.wear: the coefficient {largest:.2g} m^2/N is above {_MAX_WEAR_COEFFICIENT:g}, which "
        "metals do not reach; is it in mm^2/N? (1 mm^2/N is 1e-6 m^2/N); add `hardness` to check it"
    ]


# --------------------------------------------------------------------------------------- links that are elastic or bend


STEEL_MODULUS = 210e9  # Pa; a softer metal needs a larger section, so steel bends most
#: Drive speed over first bending frequency at which dynamic bending exceeds static bending by 4 %.
BENDING_LIMIT = 0.2
BENT_RATIO = 0.5  # drive speed over the first bending rate, beyond which a link that bends leaves its model
MANY_MODES = 6
MASS_TOLERANCE = 0.1  # by which a mass may differ from that of section and density
#: Segments that a wave front has to cross for an error of the peak below 3 % (table in docs/model.md), where the peak
#: is below or above FRONT_SHARE of that of the front.
SEGMENTS_OF_FRONT, SEGMENTS_OF_RINGING_FRONT, FRONT_SHARE = 1.7, 4.0, 0.65


class ElasticLink(NamedTuple):
    """A link that is elastic along the line of its pins."""

    name: str
    stiffness: float  # N/m, E A / l
    segments: int
    first_mode: float  # rad/s, axial, both ends free: pi sqrt(k / m)
    impedance: float  # N s/m, wave impedance at a pin: sqrt(k m)
    bending: float  # largest drive speed over the first bending frequency of a round steel bar of this stiffness
    joints: tuple[str, ...]  # at its two pins


def elastic_links(case: Case) -> tuple[ElasticLink, ...]:
    """Return the links of a case that are elastic along the line of their pins."""
    machine = machine_of(mechanism_of(case), case) if case.outline.elastic else None
    bodies = machine.bodies.items() if machine else ()
    return tuple(
        _link(machine, name, body, body.elastic)
        for name, body in bodies
        if machine and body.elastic and body.elastic.segments
    )


class BendingLink(NamedTuple):
    """A link that bends."""

    name: str
    modes: int
    rate: float  # rad/s, first mode between pins
    ratio: float  # largest drive speed over this rate
    mass_ratio: float  # given mass over that of its section and density; nan: unknown


def bending_links(case: Case) -> tuple[BendingLink, ...]:
    """Return the links of a case that bend."""
    machine, links = machine_of(mechanism_of(case), case) if case.outline.elastic else None, []
    section = "bodies." if case.outline.bodies else ""
    for name, body in machine.bodies.items() if machine else ():
        elastic = body.elastic
        if machine and elastic and elastic.bending:
            rate, length = planar.first_rate(body, elastic), planar.line_of(body, elastic).length
            density = case.mechanism.values.get(f"{section}{name}.elastic.density", math.nan)
            mass_ratio = body.mass / (density * elastic.bending.area * length)
            links.append(BendingLink(name, elastic.bending.modes, rate, max_drive_speed(machine) / rate, mass_ratio))
    return tuple(links)


def segments_to_resolve(link: ElasticLink, peak: float, depth: float, rate: float) -> int:
    """Return the number of segments that an impact at a link's pin needs: peak (N), depth (m) and approach (m/s).

    A wave front is as long as the rise of the contact, depth / rate.  Where the peak is that of the front, impedance x
    rate, the masses behind it ring, and it has to cross more segments.
    """
    front = depth / rate * link.stiffness / link.impedance  # length over that of the link
    is_peak_of_front = peak > FRONT_SHARE * link.impedance * rate
    return math.ceil((SEGMENTS_OF_RINGING_FRONT if is_peak_of_front else SEGMENTS_OF_FRONT) / front)


def _link(machine: Machine, name: str, body: Body, elastic: Elastic) -> ElasticLink:
    length = math.dist(body.points[elastic.near], body.points[elastic.far])
    speed_of_sound = length * math.sqrt(elastic.stiffness / body.mass)
    diameter = math.sqrt(4.0 * elastic.stiffness * length / (math.pi * STEEL_MODULUS))
    first_bending = math.pi**2 * speed_of_sound * diameter / (4.0 * length**2)  # see `Elastic links` in docs/model.md
    pins = {(name, elastic.near), (name, elastic.far)}
    return ElasticLink(
        name,
        elastic.stiffness,
        elastic.segments,
        math.pi * math.sqrt(elastic.stiffness / body.mass),
        math.sqrt(elastic.stiffness * body.mass),
        0.0 if elastic.bending else max_drive_speed(machine) / first_bending,
        tuple(joint.name for joint in machine.joints if pins & {tuple(joint.proximal), tuple(joint.distal)}),
    )


def link_warnings(case: Case) -> list[str]:
    """Return warnings on elastic links: single springs, bending that would matter, or that exceeds its model."""
    bodies = "mechanism.bodies" if case.outline.bodies else "mechanism"
    return [
        *(f"{bodies}.{link.name}.elastic{text}" for link in bending_links(case) for text in _bending_warnings(link)),
        *(f"{bodies}.{link.name}.elastic{text}" for link in elastic_links(case) for text in _axial_warnings(link)),
    ]


def _axial_warnings(link: ElasticLink) -> Iterator[str]:
    """Yield what is doubtful in a link that is elastic along its line."""
    if link.segments == 1:
        yield (
            ".segments: a single spring between two masses is no bar; peaks of impacts err by up to 27 % in a steel "
            "rod, and by more in a softer one; use 4 or more"
        )
    if link.bending > BENDING_LIMIT:
        yield (
            f": the drive turns at {link.bending:.2g} of the first bending mode of a round steel bar of this "
            f"stiffness. Above {BENDING_LIMIT:g} bending matters, but the model neglects it; use a shorter or thicker "
            "link, or let it bend"
        )


def _bending_warnings(link: BendingLink) -> Iterator[str]:
    """Yield what is doubtful in a link that bends."""
    if link.ratio > BENT_RATIO:
        yield (
            f": the drive turns at {link.ratio:.2g} of the first bending rate; above {BENT_RATIO:g} the deflections "
            "leave the second-order model; use a shorter or thicker link"
        )
    if link.modes > MANY_MODES:
        yield (
            f".bending: {link.modes} modes are more than {MANY_MODES}; the highest ones make every step short, and the "
            "model neglects shear and rotary inertia, which matter to them; 2 or 3 are enough"
        )
    if abs(link.mass_ratio - 1.0) > MASS_TOLERANCE:
        yield (
            f".density: the mass is {link.mass_ratio:.3g} times that of the section with this density; the given mass "
            "counts, evenly distributed over the length"
        )
