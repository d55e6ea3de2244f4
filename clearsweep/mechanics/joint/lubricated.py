"""A revolute joint with oil between its surfaces: a film and, optionally, a dry joint.

The film acts at any journal position.  Its force acts through the centres of journal and bearing, its shear as a couple
on each body.  The film's formula is valid up to the eccentricity ratio `limit`; above it the ratio is clamped, but the
velocities are not.  Where the surfaces touch, the total force is (1 - share) film + share dry, with the share from the
transition law.  Onset and separation are where the eccentricity equals the clearance, as in a dry joint.
"""

from typing import NamedTuple

from ..compiled import calculus as math
from ..compiled.dual import as_type_of
from ..compiled.family import family, kernel
from ..observe.observables import FILM_WIDTH
from . import dry
from .contract import (
    ContactModes,
    Load,
    Part,
    contact_modes,
    extra_channels,
    extra_columns,
    extra_observables,
    guard_quantity,
    load,
    parts,
    power_lost,
)
from .film.contract import FilmMotion, asperity_load, dry_share, film_couples, film_force, film_pressure
from .film.corners import AFLOAT, MARGIN, Corners, Reversals, has_reversal_corners
from .film.transition import GreenwoodTripp, bears_from
from .friction.contract import friction_force
from .modes import ACTS, PRESSED, touches
from .offsets import with_current_laws


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
    corners: Corners


Lubricated = NamedTuple(
    "Lubricated",
    [
        *dry.Joint.__annotations__.items(),
        ("film", tuple),  # film_force
        ("shear", tuple),  # film_couples
        ("limit", float),  # eccentricity ratio up to which the film's formula is valid
        ("transition", tuple),  # dry_share
        ("corners", Corners),
    ],
)
Lubricated.__doc__ = "A film and the dry joint behind it, whose fields come first."


class FilmContact(NamedTuple):
    """Observables of a contact with a film; the first fields are those of a Contact."""

    normal: float  # N, film and dry, towards the centre; may be negative
    tangential: float  # N, film and dry, on the journal
    slip: float  # m/s, as in a dry joint
    rate: float  # m/s, of the eccentricity
    depth: float  # m, eccentricity less clearance
    elastic: float  # N, the elastic part of the dry share
    raw: float  # N, dry force before clipping, minus the least force of its law
    lost: float  # W, dissipated by the film and the dry share's normal force
    rubbed: float  # W, dissipated by the dry share's friction
    drained: float  # W, dissipated by the film
    pumped: float  # W, by its pressure only, without shear
    dry: float  # N, the dry share of the normal force
    highest: tuple  # (law, FilmMotion), which determine the pressure
    speed: float  # m/s, of the journal's surface over the bearing's from spins only


class FilmLoad(NamedTuple):
    """Forces and powers of a film, in the frame of the line of centres."""

    radial: float  # N, on the journal
    tangential: float  # N
    on_journal: float  # N m
    on_bearing: float  # N m
    lost: float  # W
    pumped: float  # W, of this by pressure
    motion: FilmMotion
    nx: float  # direction of the line of centres
    ny: float
    rate: float  # m/s
    depth: float  # m
    speed: float  # m/s, of the surfaces from spins


@kernel
def film_load(joint, gap):
    """Return the FilmLoad of a film; a concentric journal has no direction and no force."""
    x, y, vx, vy = joint.side * gap.x, joint.side * gap.y, joint.side * gap.vx, joint.side * gap.vy
    journal, bearing = gap.spin_distal, gap.spin_proximal
    if joint.side < 0.0:
        journal, bearing = bearing, journal
    square, speed = x * x + y * y, abs(journal - bearing) * joint.bearing_radius
    if square == 0.0:
        zero = as_type_of(0.0, square)
        on_journal, on_bearing = film_couples(joint.shear, FilmMotion(zero, zero, zero), journal - bearing, zero)
        return FilmLoad(
            radial=zero,
            tangential=zero,
            on_journal=on_journal,
            on_bearing=on_bearing,
            lost=-on_journal * journal - on_bearing * bearing,
            pumped=zero,
            motion=FilmMotion(zero, zero, zero),
            nx=as_type_of(1.0, square),
            ny=zero,
            rate=as_type_of(math.sqrt(vx * vx + vy * vy), square),
            depth=as_type_of(-joint.clearance, square),
            speed=as_type_of(speed, square),
        )
    eccentricity = math.sqrt(square)
    nx, ny = x / eccentricity, y / eccentricity
    rate, tangential_rate = vx * nx + vy * ny, vy * nx - vx * ny
    motion = FilmMotion(
        ratio=min(eccentricity / joint.clearance, as_type_of(joint.limit, eccentricity)),
        squeeze_rate=rate / joint.clearance,
        spin=journal + bearing - 2.0 * tangential_rate / eccentricity,
    )
    radial, tangential = film_force(joint.film, motion)
    on_journal, on_bearing = film_couples(joint.shear, motion, journal - bearing, eccentricity * tangential)
    power_lost_ = -radial * rate - tangential * tangential_rate - on_journal * journal - on_bearing * bearing
    return FilmLoad(
        radial=radial,
        tangential=tangential,
        on_journal=on_journal,
        on_bearing=on_bearing,
        lost=power_lost_,
        pumped=0.5 * eccentricity * tangential * motion.spin - radial * rate,
        motion=motion,
        nx=nx,
        ny=ny,
        rate=rate,
        depth=eccentricity - joint.clearance,
        speed=as_type_of(speed, square),
    )


@kernel
def load_of(joint, film, speed):
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
        lost=film.lost,
        rubbed=zero,
        drained=film.lost,
        pumped=film.pumped,
        dry=zero,
        highest=(joint.film, film.motion),
        speed=film.speed,
    )
    bearing, journal = film.on_bearing, film.on_journal
    if joint.side < 0.0:
        return Load(fx=-fx, fy=-fy, moment_proximal=journal, moment_distal=bearing, contacts=(contact,))
    return Load(fx=fx, fy=fy, moment_proximal=bearing, moment_distal=journal, contacts=(contact,))


@kernel
def with_dry(afloat, dry_load, share):
    """Return the combined Load: `share` of the dry joint, the rest of the film."""
    a, b, film_share = afloat.contacts[0], dry_load.contacts[0], 1.0 - share
    contact = FilmContact(
        normal=film_share * a.normal + share * b.normal,
        tangential=film_share * a.tangential + share * b.tangential,
        slip=b.slip,
        rate=b.rate,
        depth=b.depth,
        elastic=film_share * a.elastic + share * b.elastic,
        raw=b.raw,
        lost=film_share * a.lost + share * (b.normal - b.elastic) * b.rate,
        rubbed=film_share * a.rubbed - share * b.tangential * b.slip,
        drained=film_share * a.drained,
        pumped=film_share * a.pumped,
        dry=film_share * a.dry + share * b.normal,
        highest=a.highest,
        speed=a.speed,
    )
    return Load(
        fx=film_share * afloat.fx + share * dry_load.fx,
        fy=film_share * afloat.fy + share * dry_load.fy,
        moment_proximal=film_share * afloat.moment_proximal + share * dry_load.moment_proximal,
        moment_distal=film_share * afloat.moment_distal + share * dry_load.moment_distal,
        contacts=(contact,),
    )


@kernel
def with_asperities(joint, gap, film, load):
    """Return the Load of a film and of asperity contact through it, with friction."""
    borne = asperity_load(joint.transition, film.depth)
    contact = load.contacts[0]
    slip = dry.surface_speed(joint, gap, -film.ny, film.nx)
    rubbing = as_type_of(friction_force(joint.friction, borne, slip), slip)
    fx, fy = -borne * film.nx - rubbing * film.ny, -borne * film.ny + rubbing * film.nx
    bearing, journal = -joint.bearing_radius * rubbing, joint.journal_radius * rubbing
    if joint.side < 0.0:
        fx, fy, bearing, journal = -fx, -fy, journal, bearing
    return Load(
        fx=load.fx + fx,
        fy=load.fy + fy,
        moment_proximal=load.moment_proximal + bearing,
        moment_distal=load.moment_distal + journal,
        contacts=(
            FilmContact(
                normal=contact.normal + borne,
                tangential=contact.tangential + rubbing,
                slip=contact.slip,
                rate=contact.rate,
                depth=contact.depth,
                elastic=borne,
                raw=contact.raw,
                lost=contact.lost,
                rubbed=-rubbing * slip,
                drained=contact.drained,
                pumped=contact.pumped,
                dry=borne,
                highest=contact.highest,
                speed=contact.speed,
            ),
        ),
    )


@family
def with_asperity_contact(transition, joint, gap, film, load):
    """Return the Load of a film with asperity contact, if any, before its surfaces touch."""


@with_asperity_contact.member(None)
def _default_with_asperity_contact(transition, joint, gap, film, load):
    return load


@with_asperity_contact.member(GreenwoodTripp)
def _with_asperity_contact_greenwood_tripp(transition, joint, gap, film, load):
    return with_asperities(joint, gap, film, load)


@kernel
def relative_speed(gap):
    """Return the relative speed (m/s) of the centres, which bounds a search for an onset."""
    return math.sqrt(gap.vx * gap.vx + gap.vy * gap.vy)


def film_depths(joint) -> tuple[float, float]:
    """Return the depths (m) beyond which dry contact carries load and the film's formula is constant; inf for never."""
    if not isinstance(joint, (Film, Lubricated)):
        return math.inf, math.inf
    begins = bears_from(joint.transition) if isinstance(joint, Lubricated) else math.inf
    return begins, joint.corners.clamped


def corners_of(clearance: float, limit: float, begin: float = math.inf, end: float = math.inf) -> Corners:
    """Return the Corners of a film kept constant beyond `limit` (ratio), with a dry transition between depths (m)."""
    return Corners((limit - 1.0) * clearance, begin, end, MARGIN * clearance)


# ---------------------------------------------------------------------------------------------- the film alone


@contact_modes.member(Film)
def _contact_modes_film(joint):
    return (ContactModes(ACTS, ACTS),)


@kernel
def _parts_of_film(joint):
    """Return the parts that end steps at corners of the film's force."""
    if type(joint.film) in has_reversal_corners.members:
        return Part(joint.corners, 0), Part(Reversals(joint.corners.end), 0)
    return (Part(joint.corners, 0),)


@parts.member(Film)
def _parts_film(joint):
    return _parts_of_film(joint)


@load.member(Film)
def _load_film(joint, gap, offsets, state):
    return load_of(joint, film_load(joint, gap), relative_speed(gap))


# ---------------------------------------------------------------------------------------------- with a dry joint


@contact_modes.member(Lubricated)
def _contact_modes_lubricated(joint):
    return (ContactModes(AFLOAT, PRESSED),)


@parts.member(Lubricated)
def _parts_lubricated(joint):
    return Part(dry.Clip(), 0), Part(joint.law, 0), Part(joint.friction, 0), *_parts_of_film(joint)


@load.member(Lubricated)
def _load_lubricated(joint, gap, offsets, state):
    mode = state.mode[offsets.contact]
    film = film_load(joint, gap)
    film_only = load_of(joint, film, relative_speed(gap))
    afloat = with_asperity_contact(joint.transition, joint, gap, film, film_only)
    if not touches(mode):
        return afloat
    root = state.y[state.roots + offsets.contact]
    current = with_current_laws(joint, offsets, state)
    dry_load = dry.joint_load(current, gap, mode, root * abs(root), state.latched[offsets.contact])
    share = dry_share(joint.transition, film.depth)
    return with_dry(afloat, dry_load, share)


# ---------------------------------------------------------------------------------------------- what is seen


@extra_columns.member(Film)
@extra_columns.member(Lubricated)
def _extra_columns_film_or_lubricated(joint):
    return FILM_WIDTH, 1


@power_lost.member(FilmContact)
def _power_lost_film_contact(contact):
    return contact.lost + contact.rubbed + contact.tangential * contact.slip


@guard_quantity.member(FilmContact)
def _guard_quantity_of_film(contact):
    """Return the spin, infinite at the centre of the bearing, times a factor that makes it smooth there."""
    _, motion = contact.highest
    return motion.ratio * motion.ratio * motion.spin


@extra_observables.member(FilmContact)
def _extra_observables_film_contact(contact, accurate):
    law, motion = contact.highest
    pressure = film_pressure(law, motion) if accurate else 0.0
    return contact.dry, contact.drained, contact.rubbed, pressure, contact.speed, contact.pumped


@extra_channels.member(FilmContact)
def _extra_channels_film_contact(contact):
    return (contact.dry,)
