"""A revolute joint with oil between its surfaces: a film and, optionally, a dry joint.

The film acts at any journal position.  Its force acts through the centres of journal and bearing, its shear as a couple
on each body.  The film's formula is valid up to the eccentricity ratio `limit`; above it the ratio is clamped, but the
velocities are not.  Where the surfaces touch, the total force is (1 - w) film + w dry, with the dry fraction w of the
transition law.  Onset and separation are where the eccentricity equals the clearance, as in a dry joint.
"""

from typing import NamedTuple

from ...tracing.compiled import calculus as math
from ...tracing.compiled.dual import as_type_of
from ...tracing.compiled.family import family_with_default, kernel
from ..laws import film as films
from ..laws.contract import ACTS, PRESSED, touches
from ..laws.friction import friction_force
from ..observe import FILM_WIDTH
from . import contract, dry


class Film(NamedTuple):
    """A film without a dry joint: the journal is never stopped."""

    clearance: float  # m, radial
    bearing_radius: float  # m
    journal_radius: float  # m
    side: float  # +1: the journal sits on the distal body, -1: on the proximal one
    film: tuple  # film_force
    shear: tuple  # film_couples
    limit: float  # eccentricity ratio up to which the film's formula is valid
    wear: tuple  # NoWear
    corners: films.Corners


Lubricated = NamedTuple(
    "Lubricated",
    [
        *dry.Joint.__annotations__.items(),
        ("film", tuple),  # film_force
        ("shear", tuple),  # film_couples
        ("limit", float),  # eccentricity ratio up to which the film's formula is valid
        ("transition", tuple),  # dry_fraction
        ("corners", films.Corners),
    ],
)
Lubricated.__doc__ = "A film combined with a dry joint, whose fields come first."


FilmContact = NamedTuple(
    "FilmContact",
    [
        *contract.CONTACT_FIELDS,  # of film and dry joint together; elastic and raw: of the dry joint
        ("lost_power", float),  # W, dissipated by the film and the dry normal force
        ("dry_friction_power", float),  # W, dissipated by dry friction
        ("film_power", float),  # W, dissipated by the film
        ("pressure_power", float),  # W, by its pressure only, without shear
        ("dry", float),  # N, the dry part of the normal force
        ("pressure_inputs", tuple),  # (law, FilmMotion), which determine the pressure
        ("speed", float),  # m/s, of the journal's surface over the bearing's from spins only
    ],
)
FilmContact.__doc__ = "Observables of a contact with a film; a normal force towards the centre may be negative."


class FilmLoad(NamedTuple):
    """Forces and powers of a film, in the frame of the line of centres."""

    radial: float  # N, on the journal
    tangential: float  # N
    journal_couple: float  # N m
    bearing_couple: float  # N m
    lost_power: float  # W
    pressure_power: float  # W, of this by pressure
    motion: films.FilmMotion
    nx: float  # direction of the line of centres
    ny: float
    rate: float  # m/s
    depth: float  # m
    speed: float  # m/s, of the surfaces from spins


@kernel
def film_load(joint, gap):
    """Return the FilmLoad of a film; a concentric journal has no direction and no force."""
    x, y, vx, vy = joint.side * gap.x, joint.side * gap.y, joint.side * gap.vx, joint.side * gap.vy
    journal_spin, bearing_spin = gap.spin_distal, gap.spin_proximal
    if joint.side < 0.0:
        journal_spin, bearing_spin = bearing_spin, journal_spin
    square, speed = x * x + y * y, abs(journal_spin - bearing_spin) * joint.bearing_radius
    if square == 0.0:
        zero = as_type_of(0.0, square)
        journal_couple, bearing_couple = films.film_couples(
            joint.shear, films.FilmMotion(zero, zero, zero, zero, zero), journal_spin - bearing_spin, zero
        )
        return FilmLoad(
            radial=zero,
            tangential=zero,
            journal_couple=journal_couple,
            bearing_couple=bearing_couple,
            lost_power=-journal_couple * journal_spin - bearing_couple * bearing_spin,
            pressure_power=zero,
            motion=films.FilmMotion(zero, zero, zero, zero, zero),
            nx=as_type_of(1.0, square),
            ny=zero,
            rate=as_type_of(math.sqrt(vx * vx + vy * vy), square),
            depth=as_type_of(-joint.clearance, square),
            speed=as_type_of(speed, square),
        )
    eccentricity = math.sqrt(square)
    nx, ny = x / eccentricity, y / eccentricity
    rate, tangential_rate = vx * nx + vy * ny, vy * nx - vx * ny
    motion = films.FilmMotion(
        ratio=min(eccentricity / joint.clearance, as_type_of(joint.limit, eccentricity)),
        squeeze_rate=rate / joint.clearance,
        spin=journal_spin + bearing_spin - 2.0 * tangential_rate / eccentricity,
        eccentricity=min(eccentricity, as_type_of(joint.limit * joint.clearance, eccentricity)),
        rate=rate,
    )
    radial, tangential = films.film_force(joint.film, motion)
    journal_couple, bearing_couple = films.film_couples(
        joint.shear, motion, journal_spin - bearing_spin, eccentricity * tangential
    )
    lost_power = (
        -radial * rate - tangential * tangential_rate - journal_couple * journal_spin - bearing_couple * bearing_spin
    )
    return FilmLoad(
        radial=radial,
        tangential=tangential,
        journal_couple=journal_couple,
        bearing_couple=bearing_couple,
        lost_power=lost_power,
        pressure_power=0.5 * eccentricity * tangential * motion.spin - radial * rate,
        motion=motion,
        nx=nx,
        ny=ny,
        rate=rate,
        depth=eccentricity - joint.clearance,
        speed=as_type_of(speed, square),
    )


@kernel
def film_only_load(joint, film, speed):
    """Return the Load of a film only; `speed` (m/s) is reported as sliding speed."""
    fx = film.radial * film.nx - film.tangential * film.ny
    fy = film.radial * film.ny + film.tangential * film.nx
    zero = as_type_of(0.0, film.depth)
    contact = FilmContact(
        normal=-film.radial,
        tangential=film.tangential,
        slip=speed,
        rate=film.rate,
        depth=film.depth,
        elastic=zero,
        raw=zero,
        lost_power=film.lost_power,
        dry_friction_power=zero,
        film_power=film.lost_power,
        pressure_power=film.pressure_power,
        dry=zero,
        pressure_inputs=(joint.film, film.motion),
        speed=film.speed,
    )
    return dry.load_on_journal(joint, fx, fy, (film.bearing_couple, film.journal_couple), (contact,))


@kernel
def blend_loads(film_only, dry_load, fraction):
    """Return the Load that is the `fraction` of the dry joint's plus 1 - `fraction` of the film's."""
    film_contact, dry_contact, film_fraction = film_only.contacts[0], dry_load.contacts[0], 1.0 - fraction
    contact = FilmContact(
        normal=film_fraction * film_contact.normal + fraction * dry_contact.normal,
        tangential=film_fraction * film_contact.tangential + fraction * dry_contact.tangential,
        slip=dry_contact.slip,
        rate=dry_contact.rate,
        depth=dry_contact.depth,
        elastic=film_fraction * film_contact.elastic + fraction * dry_contact.elastic,
        raw=dry_contact.raw,
        lost_power=film_fraction * film_contact.lost_power
        + fraction * (dry_contact.normal - dry_contact.elastic) * dry_contact.rate,
        dry_friction_power=film_fraction * film_contact.dry_friction_power
        - fraction * dry_contact.tangential * dry_contact.slip,
        film_power=film_fraction * film_contact.film_power,
        pressure_power=film_fraction * film_contact.pressure_power,
        dry=film_fraction * film_contact.dry + fraction * dry_contact.normal,
        pressure_inputs=film_contact.pressure_inputs,
        speed=film_contact.speed,
    )
    return contract.Load(
        fx=film_fraction * film_only.fx + fraction * dry_load.fx,
        fy=film_fraction * film_only.fy + fraction * dry_load.fy,
        moment_proximal=film_fraction * film_only.moment_proximal + fraction * dry_load.moment_proximal,
        moment_distal=film_fraction * film_only.moment_distal + fraction * dry_load.moment_distal,
        contacts=(contact,),
    )


@family_with_default
def with_asperity_contact(transition, joint, gap, film, load):
    """Return the Load of a film with asperity contact, if any, before its surfaces touch."""
    return load


@with_asperity_contact.member(films.GreenwoodTripp)
def _with_asperity_contact_greenwood_tripp(transition, joint, gap, film, load):
    """Return the Load of a film and of asperity contact through it, with friction."""
    asperity_force = films.asperity_load(joint.transition, film.depth)
    contact = load.contacts[0]
    slip = dry.surface_speed(joint, gap, -film.ny, film.nx)
    friction = as_type_of(friction_force(joint.friction, asperity_force, slip), slip)
    fx, fy = -asperity_force * film.nx - friction * film.ny, -asperity_force * film.ny + friction * film.nx
    bearing_moment, journal_moment = -joint.bearing_radius * friction, joint.journal_radius * friction
    if joint.side < 0.0:
        fx, fy, bearing_moment, journal_moment = -fx, -fy, journal_moment, bearing_moment
    return contract.Load(
        fx=load.fx + fx,
        fy=load.fy + fy,
        moment_proximal=load.moment_proximal + bearing_moment,
        moment_distal=load.moment_distal + journal_moment,
        contacts=(
            contact._replace(
                normal=contact.normal + asperity_force,
                tangential=contact.tangential + friction,
                elastic=asperity_force,
                dry_friction_power=-friction * slip,
                dry=asperity_force,
            ),
        ),
    )


@kernel
def relative_speed(gap):
    """Return the relative speed (m/s) of the centres, which bounds a search for an onset."""
    return math.sqrt(gap.vx * gap.vx + gap.vy * gap.vy)


def film_depths(joint) -> tuple[float, float]:
    """Return the depths (m) beyond which dry contact carries load and the film's formula is constant; inf for never."""
    if not isinstance(joint, (Film, Lubricated)):
        return math.inf, math.inf
    dry_depth = films.asperity_depth(joint.transition) if isinstance(joint, Lubricated) else math.inf
    return dry_depth, joint.corners.clamped


def corners_of(clearance: float, limit: float, begin: float = math.inf, end: float = math.inf) -> films.Corners:
    """Return the Corners of a film kept constant beyond `limit` (ratio), with a dry transition between depths (m)."""
    return films.Corners((limit - 1.0) * clearance, begin, end, films.MARGIN * clearance)


# ---------------------------------------------------------------------------------------------- the film alone


contract.contact_modes.member(Film)(lambda joint: (contract.ContactModes(ACTS, ACTS),))


@contract.parts.member(Film)
def _parts_film(joint):
    """Return the parts that end steps at corners of the film's force."""
    if type(joint.film) in films.has_reversal_corners.members:
        return contract.Part(joint.corners, 0), contract.Part(films.Reversals(joint.corners.end), 0)
    return (contract.Part(joint.corners, 0),)


@contract.load.member(Film)
def _load_film(joint, gap, offsets, state):
    return film_only_load(joint, film_load(joint, gap), relative_speed(gap))


# ---------------------------------------------------------------------------------------------- with a dry joint


contract.contact_modes.member(Lubricated)(lambda joint: (contract.ContactModes(films.AFLOAT, PRESSED),))


@contract.parts.member(Lubricated)
def _parts_lubricated(joint):
    return *dry.dry_parts(joint.friction, joint.law), *dry.elastic_parts(joint), *_parts_film(joint)


@contract.load.member(Lubricated)
def _load_lubricated(joint, gap, offsets, state):
    mode = state.mode[offsets.contact]
    film = film_load(joint, gap)
    film_only = film_only_load(joint, film, relative_speed(gap))
    film_and_asperities = with_asperity_contact(joint.transition, joint, gap, film, film_only)
    if not touches(mode):
        return film_and_asperities
    root = state.y[state.roots + offsets.contact]
    current = contract.with_current_laws(joint, offsets, state)
    dry_load = dry.joint_load(current, gap, mode, root * abs(root), state.latched[offsets.contact])
    fraction = films.dry_fraction(joint.transition, film.depth)
    return blend_loads(film_and_asperities, dry_load, fraction)


# ---------------------------------------------------------------------------------------------- observables


contract.extra_columns.member(Film, Lubricated)(lambda joint: FILM_WIDTH)


@contract.power_lost.member(FilmContact)
def _power_lost_film_contact(contact):
    return contact.lost_power + contact.dry_friction_power + contact.tangential * contact.slip


@contract.guard_quantity.member(FilmContact)
def _guard_quantity_of_film(contact):
    """Return the spin, infinite at the centre of the bearing, times a factor that makes it smooth there."""
    _, motion = contact.pressure_inputs
    return motion.ratio * motion.ratio * motion.spin


@contract.extra_observables.member(FilmContact)
def _extra_observables_film_contact(contact, is_converged):
    law, motion = contact.pressure_inputs
    pressure = films.film_pressure(law, motion) if is_converged else 0.0
    return contact.dry, contact.film_power, contact.dry_friction_power, pressure, contact.speed, contact.pressure_power


contract.extra_channels.member(FilmContact)(lambda contact: (contact.dry,))
