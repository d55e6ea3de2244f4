"""Converts the joints of a case to compiled form, and answers questions about their laws.

To add a law, add a block, with a new type if necessary, to a file of its kind; a new file needs an
import below.

The contact of a joint first yields at an approach speed that follows from its elastic law.
Two cylinders yield below their surface at a largest pressure p0 of 1.67 times the yield strength, a ball and a socket
at 1.6 times it (Johnson 1985, Contact Mechanics, section 6.1).  The load that gives this pressure is Hertz's for a
narrow contact.  For a wide contact it is the load of the wide arc of `compatible`, and for a ball the
load 2/3 pi R_b^2 p0 of a pressure p0 cos(angle) over half of the bore.  An impact reaches this load if
the elastic energy W there equals that of the approach, v = sqrt(2 W / m).
"""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from ...contracts.case import Case, Joint, Rolling
from ...contracts.catalogue import Law
from ...contracts.machine import Mesh as Gearing
from ...contracts.machine import Stops
from ...language.errors import InputError
from ...tracing.compiled.vector import Vector
from ..laws.bearings import elastic_of_elements
from ..laws.contract import OWN_RECIPES, RECIPES, Recipe, compile_law, recipe_of
from ..laws.cylinders import END_DEPTH, END_FORCE, END_Q
from ..laws.elastic import (
    Foundation,
    Linear,
    derived_stiffness,
    elastic_energy,
    elastic_force,
    line_modulus,
    plane_strain_modulus,
    relative_radius,
    static_penetration,
)
from ..laws.film import DEFAULT_SHEAR_LAW, transition_depths
from ..laws.friction import Frictionless, as_contact_friction
from ..laws.loss import lowest_force, renewed_law
from ..laws.own import enter_laws
from ..laws.roughness import Surface
from ..laws.series import ArcParameters, Series, combine_in_series
from ..wear import NoWear, Worn
from ..wear.shape import KNOTS, Shape, bin_means, conformal_profiles, point_profiles, shape_of
from . import dry, guide, lubricated, mesh, rolling, slot, spatial, worn
from .foundation import Overlap
from .spatial.strips import spread_over

# Each import registers its laws, which are listed in this order; those of the imports above come before them.
# isort: off
from ..laws import hysteresis, plastic, cylinders, bristles, reynolds  # noqa: F401
from ..wear import laws as wear_laws  # noqa: F401
from .spatial import forces, slices  # noqa: F401
# isort: on

SHARE_OF_STOPS = 1e-3  # of the motion between two stops: the length that tolerances refer to

__all__ = ["RECIPES", "enter_laws"]  # of the laws, offered here to what knows only joints


def all_laws() -> tuple[Law, ...]:
    """Return the descriptions of all laws that a grid can name."""
    return tuple(recipe.law for recipe in RECIPES.values())


def has_laws(joint: Joint) -> bool:
    """Return whether this process has the laws of a joint: those of one's own in a results directory do not run."""
    return not joint.laws or joint.laws in OWN_RECIPES


def _elastic_recipe(joint: Joint) -> Recipe | None:
    """Return the elastic law of a joint, or None if the contact law brings its own spring."""
    uses_elastic = joint.is_dry and not joint.rolling and recipe_of("law", joint.contact.law, joint).law.uses_elastic
    return recipe_of("elastic", joint.contact.elastic, joint) if uses_elastic else None


def compile_mesh(joint: Joint, gear: Gearing | Stops) -> mesh.Mesh:
    """Return the compiled form of a joint with play in rotation, or of stops."""
    law, elastic = compile_contact(joint)
    if isinstance(gear, Stops):
        ends = SHARE_OF_STOPS * joint.clearance, 1.0, 0.0 if gear.guide else 1.0, 0.0 if gear.guide else -1.0
        return mesh.Mesh(
            *ends, 0.0, joint.clearance, 0.5 * sum(joint.stops), law, elastic, Frictionless(), (), (), NoWear()
        )
    # backlash is along the pitch circle, drag relative to the second body
    half_play = joint.clearance * abs(gear.across) if gear.pins else joint.clearance
    teeth: tuple = ()
    if joint.friction or joint.wear or joint.mesh_stiffness:
        lever = gear.arm * gear.apart / gear.across
        teeth = mesh.Teeth(2.0 * math.pi * gear.arm / gear.teeth, gear.approach, lever, lever * gear.ratio)
    return mesh.Mesh(
        clearance=half_play,
        side=1.0,
        arm_proximal=gear.arm,
        arm_distal=gear.arm * gear.ratio,
        drag=joint.drag / (gear.arm * gear.ratio) ** 2,
        reach=half_play,
        middle=0.0,
        law=law,
        elastic=elastic,
        friction=as_contact_friction(compile_friction(joint)),
        teeth=teeth,
        stiffness=mesh.stiffness_of(joint.mesh_stiffness, joint.name),
        wear=compile_wear(joint),
    )


def compile_joint(joint: Joint, distal: str, earlier_wear: Worn | None = None) -> tuple:
    """Return the compiled form of a joint; `distal` is its body further from the drive.  Chooses the kind of joint.

    `earlier_wear` is the earlier wear of its bodies.
    """
    side = 1.0 if joint.journal in (None, distal) else -1.0
    radius = joint.bearing_radius or 2.0 * joint.clearance  # unused if a grid need not give it
    if joint.film and not joint.is_dry:
        film, shear = compile_film(joint)
        return lubricated.Film(
            clearance=joint.clearance,
            bearing_radius=radius,
            journal_radius=radius - joint.clearance,
            side=side,
            film=film,
            shear=shear,
            limit=joint.film.limit,
            wear=NoWear(),
            corners=lubricated.corners_of(joint.clearance, joint.film.limit),
        )
    law, elastic = compile_contact(joint)
    friction = as_contact_friction(compile_friction(joint))  # of a planar contact, whose sliding speed has a sign
    if joint.rolling:
        return _compile_rolling(joint, joint.rolling, side, (law, elastic))
    if joint.is_guide:
        return guide.Guide(joint.clearance, 1.0, joint.length, joint.height, law, elastic, friction)
    if joint.slot_length is not None:
        half_slot, mean_radius = 0.5 * joint.slot_length, radius + joint.slot_length / math.pi
        later_fields = law, elastic, friction, mean_radius, compile_wear(joint)
        unworn_slot = slot.SlotJoint(joint.clearance, radius - joint.clearance, 1.0, half_slot, *later_fields)
        return (
            slot.WornSlot(*unworn_slot, *slot.slot_shapes(unworn_slot, *_depths(joint, earlier_wear))[:2])
            if _has_evolving_shape(joint)
            else unworn_slot
        )
    if joint.is_spatial:
        return _compile_spatial_joint(joint)
    dry_joint = dry.Joint(
        clearance=joint.clearance,
        bearing_radius=radius,
        journal_radius=radius - joint.clearance,
        side=side,
        law=law,
        elastic=elastic,
        friction=friction,
        wear=compile_wear(joint),
    )
    if joint.profile:
        return worn.WornJoint(*dry_joint, compile_law("profile", joint.profile.law, joint), shape_of(np.zeros(KNOTS)))
    if _has_evolving_shape(joint):
        if not _wears_by_overlap(joint):
            return worn.WornJoint(*dry_joint, *_point_shapes(joint, earlier_wear)[:2])
        worn_type = worn.WornOnFoundation if isinstance(elastic, Foundation) else worn.WornJoint
        conformal = [shape_of(x) for x in conformal_profiles(*_depths(joint, earlier_wear), joint.clearance)]
        dry_joint = dry_joint._replace(wear=dry_joint.wear._replace(pressure=Overlap(*conformal)))
        is_at_point = worn_type is worn.WornJoint
        return worn_type(*dry_joint, *(_point_shapes(joint, earlier_wear)[:2] if is_at_point else conformal))
    if joint.film is None:
        return dry_joint
    film, film_shear = compile_film(joint)
    film_transition = compile_law("transition", joint.film.transition, joint)
    corners = lubricated.corners_of(joint.clearance, joint.film.limit, *transition_depths(film_transition))
    return lubricated.Lubricated(*dry_joint, film, film_shear, joint.film.limit, film_transition, corners)


def _compile_rolling(joint: Joint, bearing: Rolling, side: float, contact: tuple) -> rolling.Rolling:
    """Return the compiled form of a rolling bearing whose elements have the (law, elastic) `contact`."""
    ratio = bearing.element_diameter / bearing.pitch_diameter
    return rolling.Rolling(
        clearance=max(abs(joint.clearance), rolling.LEAST_SCALE * bearing.element_diameter),
        side=side,
        radial_clearance=joint.clearance,
        inner_share=0.5 * (1.0 - ratio),
        outer_share=0.5 * (1.0 + ratio),
        phase=bearing.phase,
        friction_radius=0.5 * (bearing.bore or 0.0),
        law=contact[0],
        elastic=contact[1],
        friction=compile_friction(joint),
        elements=rolling.element_directions(bearing.elements),
    )


def _has_evolving_shape(joint: Joint) -> bool:
    """Return whether the worn shape of a joint acts."""
    return joint.wear is not None and joint.wear.evolve


def _wears_by_overlap(joint: Joint) -> bool:
    """Return whether the wear of a joint is distributed like the overlap of its worn surfaces."""
    return joint.wear is not None and joint.wear.pressure == "winkler" and joint.slot_length is None


def _depths(joint: Joint, worn: Worn | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean depths (bins,) m of bearing and journal."""
    assert joint.wear is not None  # only joints with wear
    zero_depths = np.zeros(joint.wear.bins)
    return worn[:2] if worn else (zero_depths, zero_depths)


def _point_shapes(joint: Joint, worn: Worn | None) -> tuple[Shape, Shape, float]:
    """Return the shapes of bearing and journal on which a force acts at one point, and the smoothing width (rad)."""
    (bearing, journal), width = point_profiles(*_depths(joint, worn), joint.clearance)
    return shape_of(bearing), shape_of(journal), width


def smoothing_width(joint: Joint, worn: Worn) -> float | None:
    """Return the standard deviation (rad) of the Gaussian that smooths the shapes for a pressure at one point.

    None if shapes have no effect, or the arc of contact may have any width.
    """
    if not _has_evolving_shape(joint) or _wears_by_overlap(joint):
        return None
    if joint.slot_length is not None:
        return slot.slot_shapes(compile_joint(joint, "", worn), *_depths(joint, worn))[2]
    return _point_shapes(joint, worn)[2]


def acting_wear(joint: Joint, worn: Worn) -> Worn | None:
    """Return the wear (bins) of the shapes that decide where a joint wears, or None if they have no effect.

    In a slot they are those without smoothing.
    """
    if not _has_evolving_shape(joint):
        return None
    if joint.slot_length is not None:
        return worn
    profiles = (
        conformal_profiles(worn.bearing, worn.journal, joint.clearance)
        if _wears_by_overlap(joint)
        else point_profiles(worn.bearing, worn.journal, joint.clearance)[0]
    )
    bearing, journal = (bin_means(profile, len(worn.bearing)) for profile in profiles)
    return Worn(bearing, journal, worn.sliding_distance)


def compile_film(joint: Joint) -> tuple:
    """Return the compiled form of (film, shear) of a joint that has a film."""
    assert joint.film is not None  # only joints with one
    shear_name = DEFAULT_SHEAR_LAW if joint.film.friction == "by-law" else joint.film.friction
    return compile_law("film", joint.film.law, joint), compile_law("film-friction", shear_name, joint)


def _compile_spatial_joint(joint: Joint) -> spatial.Through | spatial.Flanged:
    """Return the compiled form of a spatial joint; its journal is on the rod."""
    law, elastic = compile_contact(joint)
    assert None not in (joint.bearing_radius, joint.length, joint.journal_length)  # the grid requires them
    tilt_vector = np.array([*joint.tilt, 0.0])
    angle = float(np.linalg.norm(tilt_vector))
    sinc = math.sin(angle) / angle if angle else 1.0
    versine_factor = 0.5 * (math.sin(0.5 * angle) / (0.5 * angle)) ** 2 if angle else 0.5  # (1 - cos) / angle^2
    a, b = joint.tilt
    through = spatial.Through(
        clearance=joint.clearance,
        side=1.0,
        bearing_radius=joint.bearing_radius,
        journal_radius=joint.bearing_radius - joint.clearance,
        half_length=0.5 * joint.length,
        journal_half_length=0.5 * joint.journal_length,
        offset=Vector(*joint.offset),
        axis=Vector(sinc * b, -sinc * a, math.cos(angle)),
        end_type=spatial.InBore() if joint.flange else spatial.Overlapping(),
        walls=spread_over(elastic) if joint.walls == "spread" else spatial.EndContacts(),
        law=law,
        elastic=elastic,
        friction=compile_friction(joint),
        wear=compile_wear(joint),
        across=Vector(math.cos(angle) + versine_factor * a * a, versine_factor * a * b, -sinc * b),
        wear_rows=float(joint.wear.length_bins) if joint.wear else 0.0,
    )
    if not joint.flange:
        return through
    axial = compile_contact(joint._replace(contact=joint.axial)) if joint.axial else (law, elastic)
    return spatial.Flanged(*through, joint.axial_clearance, *axial)


def jam_angle(joint: Joint) -> float:
    """Return the tilt (rad) at which the journal of a spatial joint jams, or inf if it cannot."""
    return spatial.jam_angle(_compile_spatial_joint(joint))


def compile_contact(joint: Joint) -> tuple:
    """Return (law, elastic) of a joint in compiled form."""
    contact = joint.contact
    law, rough = compile_law("law", contact.law, joint), _rough_series(joint)
    elastic = rough.compiled if rough else _compile_bulk_elastic(joint)
    if contact.onset != "renewed" or not _elastic_recipe(joint):
        return law, elastic
    restitution_of_law = restitution(joint)
    return (law if restitution_of_law is None else renewed_law(law, elastic, restitution_of_law)), elastic


def _compile_bulk_elastic(joint: Joint) -> tuple:
    """Return the compiled elastic law of a joint's bodies, without roughness."""
    if joint.rolling:
        return elastic_of_elements(joint)
    if not _elastic_recipe(joint):
        spring = recipe_of("law", joint.contact.law, joint).spring
        return spring(joint) if spring else Linear(joint.contact.values["stiffness"])
    return compile_law("elastic", joint.contact.elastic, joint)


def _rough_series(joint: Joint) -> Series | None:
    """Return the elastic law of a joint with rough surfaces in series, or None if they are smooth."""
    surface = compile_law("roughness", joint.roughness.law, joint) if joint.roughness else None
    if not isinstance(surface, Surface):
        return None
    arc = ArcParameters(line_modulus(joint) * joint.clearance, 2.0 * joint.bearing_radius * joint.length)
    return combine_in_series(_compile_bulk_elastic(joint), surface, arc)


def penetration_limit(joint: Joint) -> float:
    """Return the largest valid penetration (m) of a joint's elastic law, rough or not; inf if there is no limit."""
    elastic_law, rough = _elastic_recipe(joint), _rough_series(joint)
    limit = elastic_law.limit(joint) if elastic_law else math.inf
    return min(rough.flattening_depth, rough.total_depth(limit)) if rough else limit


def elastic_forces(joint: Joint, depths) -> list[float]:
    """Return the elastic forces (N) in a joint at penetrations (m)."""
    elastic = compile_contact(joint)[1]
    return [float(elastic_force(elastic, depth)) for depth in depths]


def elastic_choices(joint: Joint) -> dict[str, Joint]:
    """Return, by name, a joint with each elastic law that its radii, length and material allow.

    Rough surfaces are kept; the law in use is also combined with other roughness laws.
    """
    if joint.contact.material is None or _elastic_recipe(joint) is None:
        return {}
    allowed_joints = [candidate for candidate, obstacle in elastic_candidates(joint).values() if not obstacle]
    return {candidate.elastic_name: candidate for candidate in allowed_joints} | _other_surfaces(joint)


def _other_surfaces(joint: Joint) -> dict[str, Joint]:
    """Return, by name, a rough joint with smooth surfaces and with those of each other roughness law."""
    rough = joint.roughness
    if not rough or not rough.values:
        return {}
    laws = [law for law in all_laws() if law.family == "roughness" and law.name != rough.law]
    rough_joints = [joint._replace(roughness=rough._replace(law=law.name)) for law in laws]
    return {rough_joint.elastic_name: rough_joint for rough_joint in rough_joints}


def elastic_candidates(joint: Joint) -> dict[str, tuple[Joint, str]]:
    """Return, by name, a joint with each elastic law, and the reason why the joint cannot have it, or ''.

    The result is empty if the law of its normal force has its own stiffness.
    """
    contact, candidates = joint.contact, {}
    if _elastic_recipe(joint) is None:
        return candidates
    dimensions = {key: value for key, value in joint._asdict().items() if isinstance(value, float)}
    materials = contact.material._asdict() if contact.material else {}
    material = {
        f"contact.material.{body}.{key}": value
        for body, material_of_body in materials.items()
        for key, value in material_of_body._asdict().items()
    }
    known_keys = {*dimensions, *(("material",) if material else ())}
    for law in (law for law in all_laws() if law.family == "elastic"):
        defaults = {field.name: field.default for field in law.fields if field.default is not None}
        is_chosen = law.name == contact.elastic  # keys of other laws may have the same names, such as `exponent`
        values = defaults | contact.values if is_chosen else contact.values | defaults
        available = {*values, *(("stiffness",) if material else ())}
        missing = [name for name in law.needs if name not in known_keys]
        missing += [field.name for field in law.fields if field.name not in available]
        violated_ranges = [
            law_range
            for law_range in law.ranges
            if not missing and not law_range.contains((dimensions | material)[law_range.path])
        ]
        obstacle = f"needs {' and '.join(missing)}" if missing else ""
        obstacle = obstacle or "; ".join(
            f"{law_range.path} {law_range.allowed()}: {law_range.reason}" for law_range in violated_ranges
        )
        candidates[law.name] = joint._replace(contact=contact._replace(elastic=law.name, values=values)), obstacle
    return candidates


def restitution(joint: Joint) -> float | None:
    """Return the restitution of a free impact in a joint, or None if it depends on mass and speed or does not exist."""
    formula = joint.is_dry and recipe_of("law", joint.contact.law, joint).free_restitution
    value = formula(joint.contact.values.get("restitution")) if formula else None
    return None if value is None else float(value)


def departs_from_hertz(joint: Joint) -> bool:
    """Return whether the contact law of a joint assumes Hertz's force, which rough surfaces change."""
    return "hertz" in recipe_of("law", joint.contact.law, joint).law.needs and _rough_series(joint) is not None


def uses_ball_stiffness(joint: Joint) -> bool:
    """Return whether the stiffness of a joint is that of a ball in a socket and another law could replace it."""
    contact = joint.contact
    if contact.elastic != "power" or contact.material is None or "stiffness" in contact.values or joint.is_guide:
        return False
    return _elastic_recipe(joint) is not None and "hertz" not in recipe_of("law", contact.law, joint).law.needs


def can_pull(joint: Joint) -> bool:
    """Return whether the normal force of a joint can be negative."""
    return joint.is_dry and lowest_force(compile_contact(joint)[0]) < 0.0


def derived_values(joint: Joint) -> dict[str, tuple[float, str]]:
    """Return the derived values of a joint's contact: path within the joint -> (value, unit)."""
    elastic_law, limit = _elastic_recipe(joint), penetration_limit(joint)
    values = recipe_of("law", joint.contact.law, joint).derived(joint) if joint.is_dry else {}
    if joint.rolling:
        elastic = elastic_of_elements(joint)
        values = derived_stiffness(elastic.stiffness, elastic.exponent) | values
        for kind, factor in (("radial", 1.0), ("diametral", 2.0)):
            values[f"clearance (of the rings, {kind})"] = factor * joint.clearance, "m"
    if elastic_law:
        values = elastic_law.derived(joint) | values
    if joint.roughness:
        values = values | recipe_of("roughness", joint.roughness.law, joint).derived(joint)
    return values | ({"contact.penetration_limit": (limit, "m")} if math.isfinite(limit) else {})


def own_law_remarks(case: Case) -> Iterator[str]:
    """Yield remarks on the laws of one's own of a case; raise InputError if one cannot be used."""
    for path, family, name, owner in _chosen_laws(case):
        if name and (family, name) not in RECIPES:
            try:
                yield from (f"{path}: {remark}" for remark in recipe_of(family, name, owner).check(owner))
            except InputError as error:
                raise InputError(f"{path}: {error}") from None


def _chosen_laws(case: Case) -> Iterator[tuple[str, str, str | None, Any]]:
    """Yield path, family, name and owner of every law of a case that may be one of one's own."""
    for joint in case.joints:
        for key, contact in (("contact", joint.contact), ("axial", joint.axial)):
            if contact:
                owner, path = joint._replace(contact=contact), f"joints.{joint.name}.{key}"
                yield from (
                    (f"{path}.law", "law", contact.law, owner),
                    (f"{path}.elastic", "elastic", contact.elastic, owner),
                )
        for key in ("friction", "wear", "film", "profile"):
            if section := getattr(joint, key):
                yield f"joints.{joint.name}.{key}.law", key, section.law, joint
    for load in case.loads:
        if load.friction:
            yield f"loads.{load.name}.friction.law", "friction", load.friction.law, load
        if load.form == "own":
            yield f"loads.{load.name}.law", "load", load.values["law"], load
    if case.drive and case.drive.law:
        yield "drive.motor.law", "motor", case.drive.law, case.drive


def compile_friction(joint: Joint):
    """Return the compiled form of the friction of a joint."""
    return compile_law("friction", joint.friction.law, joint) if joint.friction else Frictionless()


def compile_wear(joint: Joint):
    """Return the compiled form of the wear of a joint."""
    return compile_law("wear", joint.wear.law, joint) if joint.wear else NoWear()


# ---------------------------------------------------------------------------------------------- first yield


LINE, BALL = "line", "ball"
LINE_PRESSURE, BALL_PRESSURE = 1.67, 1.6  # largest pressure over yield strength at first yield
END_PRESSURE = (1.0 + END_DEPTH) * math.sqrt(END_Q)  # p0 R_b / (E* c) at the end of the wide arc's formula


def contact_kind(joint: Joint) -> str:
    """Return the kind of a joint's contact, line or ball, or '' if its laws are neither or plastic."""
    law = recipe_of("law", joint.contact.law, joint).law if joint.is_dry else None
    if law is None or law.yields or not law.uses_elastic or joint.is_guide or joint.is_spatial:
        return ""
    return recipe_of("elastic", joint.contact.elastic, joint).law.contact if joint.contact.elastic else ""


def load_at_pressure(kind: str, pressure: float, joint: Joint, modulus: float) -> float:
    """Return the load (N) of a joint at a largest pressure (Pa) in a contact of this kind; modulus : E*, Pa."""
    radius = relative_radius(joint)
    assert joint.bearing_radius is not None  # it determines the relative radius
    if kind == BALL:
        narrow_load = math.pi**3 * radius**2 * pressure**3 / (6.0 * modulus**2)
        return min(narrow_load, 2.0 / 3.0 * math.pi * joint.bearing_radius**2 * pressure)
    assert joint.length is not None  # line contacts have a length
    ratio = pressure * joint.bearing_radius / (modulus * joint.clearance)
    scale_force = modulus * joint.length * joint.clearance
    if ratio >= END_PRESSURE:  # beyond, the pressure keeps its shape, nearly a cosine
        return 0.5 * math.pi * END_FORCE * scale_force * ratio / END_PRESSURE
    low, high = 0.0, END_Q
    for _ in range(200):
        midpoint = 0.5 * (low + high)
        low, high = (midpoint, high) if math.sqrt(midpoint) * _radius_ratio(midpoint) < ratio else (low, midpoint)
    return 0.5 * math.pi * scale_force * _radius_ratio(high) * high * (2.0 - high)


def _radius_ratio(q: float) -> float:
    """Return (c + pen) / c at `q`, see `compatible`; 1 at 0."""
    return 1.0 / (1.0 - q * (math.log(4.0 / q) - 1.0)) if q else 1.0


def yield_energy(joint: Joint, elastic: Any) -> float | None:
    """Return the elastic energy (J) at first yield of a joint's contact, or None if unknown.

    elastic : its compiled elastic law, including rough surfaces
    """
    kind, strength, radius = contact_kind(joint), joint.strength, joint.bearing_radius
    if not kind or strength is None or radius is None or (kind == LINE and joint.length is None):
        return None
    modulus = _modulus(joint, kind)
    if modulus is None:
        return None
    load = load_at_pressure(kind, (BALL_PRESSURE if kind == BALL else LINE_PRESSURE) * strength, joint, modulus)
    return float(elastic_energy(elastic, static_penetration(elastic, load)))


def _modulus(joint: Joint, kind: str) -> float | None:
    """Return E* (Pa) of a joint, from Hertz's stiffness if no material is given, or None if unknown."""
    contact = joint.contact
    if contact.material:
        return plane_strain_modulus(contact.material)
    stiffness = contact.values.get("stiffness")
    if kind == BALL and stiffness and contact.values.get("exponent") == 1.5:
        return 0.75 * stiffness / math.sqrt(relative_radius(joint))
    return None


def largest_mass(masses: np.ndarray) -> float | None:
    """Return the largest effective mass (kg) over all directions from those (3,) at 0, 45 and 90 degrees, or None.

    1 / m = n^T Y n of a symmetric Y, whose smaller eigenvalue belongs to the largest mass.
    """
    if not np.all(masses > 0.0):
        return None
    x, diagonal, y = 1.0 / masses
    coupling = diagonal - 0.5 * (x + y)
    smallest_inverse = 0.5 * (x + y) - math.hypot(0.5 * (x - y), coupling)
    return float(1.0 / smallest_inverse) if smallest_inverse > 1e-12 * (x + y) else None
