"""Laws that lose energy by an indentation that stays until separation, or in a damper parallel to the elastic force."""

from typing import NamedTuple

from ...contracts.catalogue import Field, ranged
from ...tracing.compiled import calculus as math
from ...tracing.compiled.choosing import where
from ...tracing.compiled.dual import as_type_of
from ...tracing.compiled.family import kernel
from . import contract, loss
from .elastic import elastic_force, hardness_factor, plane_strain_modulus, relative_radius

MIN_DEPTH = 1e-12  # m, least recorded depth of a yielding contact
RELOAD_FACTOR = 1.0 + 1e-12  # times the root of the deepest penetration: keeps rounding from reaching it again
UNLOADING, RELOADING = 0, 1  # guards: unloading begins; reloading reaches the deepest point


class Plastic(NamedTuple):
    """F = F_elastic(pen) during loading, then along the same curve compressed towards the deepest point.

    Unloading and reloading: F = F_elastic((pen - residual) / e^2), where residual = (1 - e^2) deepest is the permanent
    indentation.  The fraction e^2 of the work of loading is returned.
    """

    returned_fraction: float  # e^2, 1
    yield_rate: float  # m/s, onset rate up to which the contact is elastic
    deepest: float = 0.0  # m, deepest penetration of the last loading; 0 during loading


@loss.register_contact_force(Plastic, pulls=False, times_elastic=True)
def _plastic(law, elastic, pen, rate, onset_rate):
    fraction = law.returned_fraction if onset_rate > law.yield_rate else 1.0
    if law.deepest < MIN_DEPTH:
        force = elastic_force(elastic, pen)
        return force, fraction * force
    recovered = (pen - (1.0 - fraction) * law.deepest) / fraction
    force = math.copysign(elastic_force(elastic, abs(recovered)), recovered)  # negative if the indentation is clear
    return force, max(force, 0.0)


loss.needs_onset_rate.member(Plastic)(loss.always_needs_onset_rate)


class YieldingSphere(NamedTuple):
    """F = F_hertz(pen), softened beyond the yield depth; unloading by the fit of Etsion, Kligerman & Kadin.

    Unloading and reloading: F = F_m ((pen - residual) / (deepest - residual))^n, where residual is the permanent
    indentation and F_m the force at the deepest point; see `unloading_fit`.
    """

    yield_depth: float  # w_c, m
    plastic_factor: float  # 3 / K: the force on a fully plastic contact over pen / w_c, in forces at the yield depth
    deepest: float = 0.0  # m, deepest penetration of the last loading; 0 during loading


#: Factor and power of the published fits of the force over Hertz's.
FIRST_FIT, SECOND_FIT = (1.03, -0.075), (1.40, -0.237)
#: Yield depths from which on the fits are used, and one follows the other.
FIRST_FIT_BEGIN = FIRST_FIT[0] ** (-1.0 / FIRST_FIT[1])
SECOND_FIT_BEGIN = (SECOND_FIT[0] / FIRST_FIT[0]) ** (1.0 / (FIRST_FIT[1] - SECOND_FIT[1]))
#: Powers of the deepest point in the published fits of the residual indentation and of the exponent of unloading.
RESIDUAL_POWERS, UNLOADING_POWER = (-0.28, -0.69), -0.0331
SMALLEST_SHARE = 1e-30  # of the recovered depth: keeps a negative power of it finite


@kernel
def force_ratio(law, x):
    """Return the force over Hertz's at `x` >= 1 yield depths, and its exponent in `x`: the least published fit."""
    ratio, power = FIRST_FIT[0] * x ** FIRST_FIT[1], FIRST_FIT[1]
    second_ratio = SECOND_FIT[0] * x ** SECOND_FIT[1]
    if second_ratio < ratio:
        ratio, power = second_ratio, SECOND_FIT[1]
    plastic_ratio = law.plastic_factor * x**-0.5
    if plastic_ratio < ratio:
        ratio, power = plastic_ratio, -0.5
    if ratio > 1.0:
        ratio, power = 1.0, 0.0
    return ratio, power


class Unloading(NamedTuple):
    """The published fit of the unloading from a depth."""

    recovered: float  # share of the depth that unloading recovers
    exponent: float  # of the force over the recovered depth
    energy_slope: float  # derivative of the returned energy by the depth, over the force


@kernel
def unloading_fit(x, force_power):
    """Return the Unloading from `x` >= 1 yield depths, where the force of loading varies as pen^force_power.

    residual / deepest = (1 - x^-0.28) (1 - x^-0.69), n = 1.5 x^-0.0331; the returned energy is F pen recovered / (n +
    1).
    """
    first, second = x ** RESIDUAL_POWERS[0], x ** RESIDUAL_POWERS[1]
    recovered, exponent = first + second - first * second, 1.5 * x**UNLOADING_POWER
    recovered_slope = (
        RESIDUAL_POWERS[0] * first
        + RESIDUAL_POWERS[1] * second
        - (RESIDUAL_POWERS[0] + RESIDUAL_POWERS[1]) * (first * second)
    )  # times x, as the next line
    exponent_slope = UNLOADING_POWER * exponent
    if x <= 1.0:
        exponent_slope = 0.0 * exponent
    share = recovered / (exponent + 1.0)
    share_slope = (recovered_slope - share * exponent_slope) / (exponent + 1.0)
    return Unloading(recovered, exponent, (force_power + 1.0) * share + share_slope)


@loss.register_contact_force(YieldingSphere, pulls=False, times_elastic=True)
def _yielding_sphere(law, elastic, pen, rate, onset_rate):
    is_loading = law.deepest < MIN_DEPTH
    deepest_now = pen if is_loading else as_type_of(law.deepest, pen)
    x = max(deepest_now / law.yield_depth, 1.0)
    force_factor, power_change = force_ratio(law, x)
    unloading = unloading_fit(x, 1.5 + power_change)
    if is_loading:
        force = force_factor * elastic_force(elastic, pen)
        return force, unloading.energy_slope * force
    share = 1.0 + (pen / deepest_now - 1.0) / unloading.recovered  # of the recovered depth
    # of Hertz's exponent; by exp and log, as the exponent has a derivative, too
    change = math.exp((unloading.exponent - 1.5) * math.log(max(abs(share), SMALLEST_SHARE)))
    force = force_factor * change * elastic_force(elastic, deepest_now * abs(share))
    force = math.copysign(force, share)  # negative if the indentation is clear
    return force, max(force, 0.0)


@contract.kinks.member(YieldingSphere)
def _kinks_yielding_sphere(law):
    plastic_ratio = (law.plastic_factor / SECOND_FIT[0]) ** (1.0 / (0.5 + SECOND_FIT[1]))
    depth_ratios = 1.0, FIRST_FIT_BEGIN, SECOND_FIT_BEGIN, plastic_ratio
    return tuple([law.yield_depth * depth_ratio for depth_ratio in depth_ratios])


contract.kink_variable.member(YieldingSphere)(contract.depth_variable)
contract.guards.member(YieldingSphere)(lambda law: (*_guards_plastic(law), contract.Guard(contract.TOUCHING)))


@contract.guard_values.member(YieldingSphere)
def _guard_values_yielding_sphere(law, start, contact, root):
    if law.deepest == 0.0:
        distance_past_kink, _ = contract.distances_past_kinks(contract.kinks(law), start.contact.depth, contact.depth)
        return -contact.rate, contract.NEVER, distance_past_kink
    return contract.NEVER, root - RELOAD_FACTOR * math.sqrt(law.deepest), contract.NEVER


@contract.guards.member(Plastic)
def _guards_plastic(law):
    return contract.Guard(contract.TOUCHING), contract.Guard(contract.TOUCHING)


@contract.guard_values.member(Plastic)
def _guard_values_plastic(law, start, contact, root):
    if law.deepest == 0.0:
        return -contact.rate, contract.NEVER
    return contract.NEVER, root - RELOAD_FACTOR * math.sqrt(law.deepest)


@contract.latched.member(YieldingSphere, Plastic)
def _latched_yielding_sphere_or_plastic(law, event, contact, root):
    if event == UNLOADING:
        return (max(root * root, MIN_DEPTH),)
    return (0.0,)


contract.register(
    "law lankarani-nikravesh-plastic: yields during loading, unloads elastically from an indentation",
    "F = F_elastic(pen) while pen deepens; below the deepest, pen_m, where it last turned back: F = F_elastic((pen - "
    "pen_p) / e^2), pen_p = (1 - e^2) pen_m, 0 below pen_p; for a power n that is F = F_m ((pen - pen_p) / (pen_m - "
    "pen_p))^n, F_m = K pen_m^n",
    "after Lankarani & Nikravesh 1994, Nonlinear Dyn. 5:193; pen_p such that a free impact loses (1 - e^2) m v0^2 / 2",
    (
        loss.RESTITUTION,
        ranged("yield_rate", "m/s", "onset rate up to which the contact is elastic", "[0, inf)", default=0.0),
    ),
    types=(Plastic,),
    make=lambda joint: Plastic(joint.contact.values["restitution"] ** 2, joint.contact.values["yield_rate"]),
    notes="For impacts that leave the elastic range.  Left out, yield_rate is 0: every contact yields.  With a law "
    "that does not yield, the column J_yield_speed of the joint is the speed of first yield.  At separation (pen < 0) "
    "pen_m is reset, so the next contact meets a fresh surface.  A journal that moves along the wall within one "
    "contact carries its indentation along.  There pen < pen_p counts as contact without force, each entry into it as "
    "a clip.  A contact that stays shakes down to an elastic one.",
    yields=True,
    free_restitution=lambda e: e,
)


def yield_depth(joint) -> float:
    """Return the penetration (m) at first yield of a ball in a socket: (pi K H / (2 E*))^2 R."""
    pressure = math.pi * hardness_factor(joint.contact.material.bearing.poisson) * joint.contact.values["hardness"]
    return (pressure / (2.0 * plane_strain_modulus(joint.contact.material))) ** 2 * relative_radius(joint)


contract.register(
    "law kogut-etsion: a ball in a socket that yields as a finite-element model of a sphere, from a hardness",
    "F = F_elastic least(1, 1.03 x^-0.075, 1.40 x^-0.237, (3 / K) x^-0.5) while pen deepens, x = max(1, pen / w_c), "
    "w_c = (pi K H / (2 E*))^2 R, K = 0.454 + 0.41 nu, R = R_b R_j / (R_b - R_j); below the deepest, pen_m, where it "
    "last turned back: F = F_m ((pen - pen_p) / (pen_m - pen_p))^n, n = 1.5 x_m^-0.0331, 0 below pen_p = pen_m (1 - "
    "x_m^-0.28) (1 - x_m^-0.69)",
    "after Kogut & Etsion 2002, J. Appl. Mech. 69:657 (loading; coefficients as in public programs that quote it) and "
    "Etsion, Kligerman & Kadin 2005, Int. J. Solids Struct. 42:3716 (unloading; coefficients remembered)",
    (Field("hardness", "Pa", "hardness H of the softer body"),),
    types=(YieldingSphere,),
    make=lambda joint: YieldingSphere(
        yield_depth(joint), 3.0 / hardness_factor(joint.contact.material.bearing.poisson)
    ),
    needs=("material", "hertz"),
    notes="The restitution decreases with speed: no energy is lost up to w_c.  Three pieces are published, F / "
    "F_elastic = 1.03 x^-0.075 for x = 1 to 6, 1.40 x^-0.237 to 110 and full plasticity, 2 pi R pen H, beyond.  They "
    "do not meet; here the least of them and Hertz's force acts, which is continuous: at most 3 % below the first "
    "piece, up to x = 1.48, 2 % below the second, up to 6.7, and 8 % below the third, up to some 150 (nu = 0.3).  A "
    "Hertzian contact of the flattened radius would return more energy: restitutions up to 0.04 higher.  Made for a "
    "sphere and a rigid flat; nu is the bearing's.  In a close-fitting socket R and therefore w_c are large: where "
    "the derived contact.yield_depth passes the clearance nothing yields.  At separation pen_m is reset, so the next "
    "contact meets a fresh surface.  Within a contact pen < pen_p counts as contact without force, each entry into it "
    "as a clip.",
    yields=True,
    derived=lambda joint: {"contact.yield_depth": (yield_depth(joint), "m")},
)


# ---------------------------------------------------------------------------------------------- dampers


MASS = Field("mass", "kg", "effective mass of the impact, m1 m2 / (m1 + m2)")
SPRING = Field("stiffness", "N/m", "stiffness of the spring")
DAMPER = ranged("damping", "N*s/m", "coefficient of the damper", "[0, inf)")

# ---------------------------------------------------------------------------------------------- root of the stiffness


class RootDamper(NamedTuple):
    """F = F_elastic + d sqrt(F_elastic / pen) rate; it pulls before the separation."""

    damping: float  # d, kg^0.5: sqrt(F_elastic / pen) is the root of a stiffness


@loss.register_contact_force(RootDamper, pulls=True, times_elastic=False)
def _root_damper(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    root_stiffness = (
        math.sqrt(force / pen) if pen > 0.0 else 0.0
    )  # the limit, except for a linear spring, where a single point does not matter
    return force + law.damping * root_stiffness * rate, force


def _make_tsuji(joint):
    parameters = joint.contact.values
    # Hertz's exponent if the elastic force is not a power law
    alpha = math.sqrt(2.0 * (parameters.get("exponent", 1.5) + 1.0)) * loss.damping_ratio(parameters["restitution"])
    return RootDamper(alpha * math.sqrt(parameters["mass"]))


contract.register(
    "law tsuji: damped Hertzian spring with exactly the specified restitution",
    "F = F_elastic + alpha sqrt(mass F_elastic / pen) rate, alpha = -sqrt(2 (n + 1)) ln e / sqrt(pi^2 + ln(e)^2); for "
    "n = 1.5: F = K pen^1.5 + alpha sqrt(mass K) pen^0.25 rate with sqrt(5) in alpha",
    "Tsuji, Tanaka & Ishida 1992, Powder Technol. 71:239; alpha by Antypov & Elliott 2011, EPL 94:50004",
    (loss.RESTITUTION, MASS),
    types=(RootDamper,),
    make=_make_tsuji,
    notes="Pulls before the surfaces part, and is not clipped: the restitution applies for a release at zero "
    "penetration.  Exact for elastic: power; elsewhere n = 1.5 is in alpha.",
    free_restitution=lambda e: e,
)


class ApproachRootDamper(NamedTuple):
    """A RootDamper during approach; only the elastic force during rebound."""

    damping: float  # kg^0.5
    piece: float = contract.UNKNOWN


contract.register_pieces(ApproachRootDamper, contract.rate_variable, contract.zero_kink)


@loss.register_contact_force(ApproachRootDamper, pulls=False, times_elastic=False)
def _approach_root_damper(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    root_stiffness = math.sqrt(force / pen) if pen > 0.0 else 0.0
    return force + law.damping * root_stiffness * loss.approach_rate(law.piece, rate), force


def jankowski_ratio(e: float) -> float:
    """Return xi = (9 sqrt(5) / 2) (1 - e^2) / (e (e (9 pi - 16) + 16))."""
    return 4.5 * math.sqrt(5.0) * (1.0 - e * e) / (e * (e * (9.0 * math.pi - 16.0) + 16.0))


contract.register(
    "law jankowski: Hertzian spring, damped only during the approach",
    "F = F_elastic + 2 xi sqrt(mass F_elastic / pen) rate while rate > 0, else F_elastic; xi = (9 sqrt(5) / 2) (1 - "
    "e^2) / (e (e (9 pi - 16) + 16))",
    "after Jankowski 2005, Earthq. Eng. Struct. Dyn. 34:595, and 2006, 35:517",
    (loss.RESTITUTION, MASS),
    types=(ApproachRootDamper,),
    make=lambda joint: ApproachRootDamper(
        2.0 * jankowski_ratio(joint.contact.values["restitution"]) * math.sqrt(joint.contact.values["mass"])
    ),
    notes="Made for an exponent of 1.5; within 7 % of the specified restitution from 0.1 on, 1.1 % from 0.5 on.",
    free_restitution=lambda e: loss.approach_damping_rebound(2.0 * jankowski_ratio(e) / math.sqrt(5.0)),
)

# ---------------------------------------------------------------------------------------------- constant damping


def _viscous_spring(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force + law.damping * rate, force


class PullingSpring(NamedTuple):
    """F = F_elastic + c rate; it pulls before the separation."""

    damping: float  # c, N s/m


loss.register_contact_force(PullingSpring, pulls=True, times_elastic=False)(_viscous_spring)


def _make_anagnostopoulos(joint):
    parameters = joint.contact.values
    zeta = loss.damping_ratio(parameters["restitution"])
    return PullingSpring(2.0 * zeta * math.sqrt(parameters["stiffness"] * parameters["mass"]))


contract.register(
    "law anagnostopoulos: linear spring and damper from the restitution",
    "F = k pen + c rate, c = 2 zeta sqrt(k mass), zeta = -ln e / sqrt(pi^2 + ln(e)^2)",
    "Anagnostopoulos 1988, Earthq. Eng. Struct. Dyn. 16:443, and 2004, 33:897",
    (SPRING, loss.RESTITUTION, MASS),
    types=(PullingSpring,),
    make=_make_anagnostopoulos,
    uses_elastic=False,
    notes="The force jumps to c times the onset rate at contact, pulls before the surfaces part and is not clipped.  "
    "The restitution applies for a release at zero penetration.  The law kelvin-voigt with the same damping, clipped, "
    "has a larger restitution.",
    free_restitution=lambda e: e,
)


contract.register(
    "law kelvin-voigt-unclipped: linear spring and damper that pulls until the surfaces part",
    "F = k pen + c rate",
    "Kelvin-Voigt",
    (SPRING, DAMPER),
    types=(PullingSpring,),
    uses_elastic=False,
    notes="The force jumps to c times the onset rate at contact and pulls before the surfaces part.  The restitution "
    "of a free impact is exp(-pi zeta / sqrt(1 - zeta^2)), zeta = c / (2 sqrt(k m)) < 1; from zeta = 1 on the "
    "surfaces never part.  A pulling force causes no friction.",
)


class ViscousSpring(NamedTuple):
    """A PullingSpring whose force is clipped at 0."""

    damping: float  # c, N s/m


loss.register_contact_force(ViscousSpring, pulls=False, times_elastic=False)(_viscous_spring)


contract.register(
    "law kelvin-voigt: linear spring and damper, clipped",
    "F = max(0, k pen + c rate)",
    "Kelvin-Voigt; clipped at zero",
    (SPRING, DAMPER),
    types=(ViscousSpring,),
    uses_elastic=False,
    notes="The force jumps to c times the onset rate at contact and is clipped where it would pull.  The restitution "
    "of a free impact is exp(-(zeta / w) atan2(2 zeta w, 2 zeta^2 - 1)), zeta = c / (2 sqrt(k m)) < 1, w = sqrt(1 - "
    "zeta^2): more than exp(-pi zeta / w), which applies without clipping.  With zeta > 1 it is exp(-2 zeta "
    "arcosh(zeta) / sqrt(zeta^2 - 1)), below exp(-2) = 0.135.",
)


contract.register(
    "law ristow: elastic force and a constant damper, clipped",
    "F = max(0, F_elastic + damping rate)",
    "after Ristow 1992, J. Phys. I France 2:649",
    (DAMPER,),
    types=(ViscousSpring,),
    notes="The restitution depends on the speed.  The force jumps to damping times the onset rate at contact.",
)

# ---------------------------------------------------------------------------------------------- damping over depth


class RootViscous(NamedTuple):
    """F = F_elastic + g sqrt(pen) rate."""

    damping: float  # g, N s/m^1.5


@loss.register_contact_force(RootViscous, pulls=False, times_elastic=False)
def _root_viscous(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force + law.damping * math.sqrt(pen) * rate, force


contract.register(
    "law kuwabara-kono: viscoelastic spheres, clipped",
    "F = max(0, F_elastic + damping sqrt(pen) rate)",
    "Kuwabara & Kono 1987, Jpn. J. Appl. Phys. 26:1230",
    (ranged("damping", "N*s/m^1.5", "coefficient of the damper per square root of the penetration", "[0, inf)"),),
    types=(RootViscous,),
    notes="The restitution depends on the speed and tends to 1 at low speed.  Made for an exponent of 1.5.",
)


class SteppedDamper(NamedTuple):
    """F = F_elastic + c step(pen) rate, with step growing as 3 x^2 - 2 x^3 of x = pen / depth from 0 to 1."""

    damping: float  # c, N s/m
    depth: float  # m
    piece: float = contract.UNKNOWN


contract.register_pieces(SteppedDamper, contract.penetration_variable, lambda law: (law.depth,))


@loss.register_contact_force(SteppedDamper, pulls=False, times_elastic=False)
def _stepped_damper(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    x = where(contract.current_piece(law.piece, contract.kinks(law), pen) == 0.0, pen / law.depth, 1.0)
    return force + law.damping * x * x * (3.0 - 2.0 * x) * rate, force


contract.register(
    "law adams-impact: the IMPACT function of MSC Adams",
    "F = max(0, F_elastic + damping step(pen) rate), step = 3 x^2 - 2 x^3 of x = min(1, pen / depth)",
    "MSC Adams/Solver, functions IMPACT and STEP",
    (DAMPER, Field("depth", "m", "penetration from which the full damping acts")),
    types=(SteppedDamper,),
    notes="With elastic: power its K and e are `stiffness` and `exponent`, c_max is `damping`, d is `depth`.  The "
    "restitution depends on the speed.",
)
