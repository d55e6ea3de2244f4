"""Laws of the normal force: what loss they add to the elastic force."""

import math
from collections.abc import Mapping

from ....catalogue import Field
from ..loss.dampers import ApproachRootDamper, PullingSpring, RootDamper, RootViscous, SteppedDamper, ViscousSpring
from ..loss.hysteresis import ApproachHysteresis, Hysteresis, Lossless
from ..loss.plastic import Plastic
from .rebound import (
    approach_damping_rebound,
    approach_hysteresis_rebound,
    damping_ratio,
    exact_factor,
    hysteresis_rebound,
)
from .recipe import enter

MASS = Field("mass", "kg", "effective mass of the impact, m1 m2 / (m1 + m2)")
SPRING = Field("stiffness", "N/m", "of the spring")


def restitution(*, zero: bool) -> Field:
    """Return the field of the restitution; `zero`: a law that can be asked for none."""
    return Field("restitution", "1", "wanted ratio of rebound to approach speed", 0.0, 1.0, not zero, False)


def factor_law(name, summary, chi_text, source, chi, *, zero=False, notes=""):
    """Enter a law F = F_elastic (1 + chi rate / onset_rate) with its chi(restitution)."""
    enter(
        "law",
        name,
        summary,
        f"F = F_elastic (1 + chi rate / onset_rate), chi = {chi_text}",
        source,
        lambda joint: Hysteresis(float(chi(joint.contact.values["restitution"]))),
        restitution(zero=zero),
        returned=lambda e: hysteresis_rebound(chi(e)),
        notes=notes,
    )


enter(
    "law",
    "hertz",
    "no loss",
    "F = F_elastic",
    "Hertz 1881, J. reine angew. Math. 92:156",
    lambda joint: Lossless(),
)
factor_law(
    "hunt-crossley",
    "the oldest of its form, for restitution near 1",
    "3 (1 - e) / 2",
    "Hunt & Crossley 1975, J. Appl. Mech. 42:440",
    lambda e: 1.5 * (1.0 - e),
    zero=True,
    notes="First-order exact as e -> 1; never gives back less than 0.488.  Marhefka & Orin use the same.",
)
factor_law(
    "herbert-mcwhannell",
    "for restitution near 1",
    "6 (1 - e) / ((2 e - 1)^2 + 3)",
    "after Herbert & McWhannell 1977, J. Eng. Ind. 99:513",
    lambda e: 6.0 * (1.0 - e) / ((2.0 * e - 1.0) ** 2 + 3.0),
    zero=True,
    notes="Second-order exact as e -> 1; never gives back less than 0.488.",
)
factor_law(
    "lee-wang",
    "half the loss of hunt-crossley",
    "3 (1 - e) / 4",
    "after Lee & Wang 1983, J. Mech. Transm. Autom. Des. 105:534",
    lambda e: 0.75 * (1.0 - e),
    zero=True,
    notes="Half as dissipative as it should be as e -> 1; never gives back less than 0.663.",
)
factor_law(
    "lankarani-nikravesh",
    "hysteresis for restitution near 1",
    "3 (1 - e^2) / 4",
    "Lankarani & Nikravesh 1990, J. Mech. Des. 112:369",
    lambda e: 0.75 * (1.0 - e * e),
    zero=True,
    notes="First-order exact as e -> 1; below about 0.9 it gives back more than asked for, never less than 0.663.",
)
factor_law(
    "gonthier",
    "for the whole range of restitution, in its approximate form",
    "(1 - e^2) / e",
    "Gonthier, McPhee, Lange & Piedboeuf 2004, Multibody Syst. Dyn. 11:209, approximate form",
    lambda e: (1.0 - e * e) / e,
    notes="Off by up to 4.3 %, a third too dissipative as e -> 1; gonthier-exact is not.",
)
factor_law(
    "gonthier-exact",
    "gives back exactly the restitution asked for",
    "the root of (1 + chi) / (1 - e chi) = exp(chi (1 + e))",
    "Gonthier, McPhee, Lange & Piedboeuf 2004, Multibody Syst. Dyn. 11:209, before its approximation",
    exact_factor,
    notes="The same as `exact`.",
)
factor_law(
    "zhiying-qishao",
    "the loss of lankarani-nikravesh, raised for small restitution",
    "(3/4) (1 - e^2) exp(2 (1 - e))",
    "after Zhiying & Qishao 2006, J. Dyn. Control 4:294",
    lambda e: 0.75 * (1.0 - e * e) * math.exp(2.0 * (1.0 - e)),
    zero=True,
    notes="First-order exact as e -> 1; never gives back less than 0.179.",
)
factor_law(
    "flores",
    "for the whole range of restitution",
    "8 (1 - e) / (5 e)",
    "Flores, Machado, Silva & Martins 2011, Multibody Syst. Dyn. 25:357",
    lambda e: 1.6 * (1.0 - e) / e,
    notes="6.7 % too dissipative as e -> 1.",
)
factor_law(
    "hu-guo",
    "close to what is asked for above 0.6",
    "3 (1 - e) / (2 e)",
    "after Hu & Guo 2015, Multibody Syst. Dyn. 35:131",
    lambda e: 1.5 * (1.0 - e) / e,
    notes="Second-order exact as e -> 1.  Half this chi, 3 (1 - e) / (4 e), is also in circulation; it gives back "
    "about (1 + e) / 2.",
)
factor_law(
    "safaeifar-farshidianfar",
    "for small restitution",
    "5 (1 - e) / (4 e)",
    "after Safaeifar & Farshidianfar 2020, Multibody Syst. Dyn. 50",
    lambda e: 1.25 * (1.0 - e) / e,
    notes="A sixth too little loss as e -> 1; not compared with the paper.",
)
factor_law(
    "carvalho-martins",
    "a fraction that is all but exact above 0.4",
    "3 (1 - e) (11 - e) / (2 (1 + 9 e))",
    "after Carvalho & Martins 2019, Mech. Mach. Theory 139:174",
    lambda e: 1.5 * (1.0 - e) * (11.0 - e) / (1.0 + 9.0 * e),
    zero=True,
    notes="Within 0.04 % of what is asked for at 0.5 and above; not for less than 0.2, and never less than 0.061.",
)
factor_law(
    "ye",
    "hu-guo's loss, made for a linear spring",
    "3 (1 - e) / (2 e)",
    "after Ye, Li & Zhu 2009, Earthq. Eng. Eng. Vib. 8:433",
    lambda e: 1.5 * (1.0 - e) / e,
    notes="The paper's elastic force is linear: write `exponent: 1` with the stiffness in N/m.  What it gives back "
    "does not depend on the exponent.",
)
factor_law(
    "exact",
    "gives back exactly the restitution asked for",
    "the root of ln((1 + chi) / (1 - e chi)) = chi (1 + e)",
    "phase curve of the free impact; the exact form of Gonthier et al. 2004, Multibody Syst. Dyn. 11:209",
    exact_factor,
    notes="The recommended law: whatever the elastic force, mass and speed, a free impact gives back what was "
    "asked for.",
)


def approach_only_factor(e: float) -> float:
    """Return chi = 3 (1 - e^2) / (2 e^2)."""
    return 1.5 * (1.0 - e * e) / (e * e)


enter(
    "law",
    "pant-wijeyewickrema",
    "a loss on the approach alone, made for a linear spring",
    "F = F_elastic (1 + chi rate / onset_rate) while rate > 0, else F_elastic; chi = 3 (1 - e^2) / (2 e^2)",
    "after Pant & Wijeyewickrema 2012, Earthq. Eng. Struct. Dyn. 41:1709",
    lambda joint: ApproachHysteresis(approach_only_factor(joint.contact.values["restitution"])),
    restitution(zero=False),
    returned=lambda e: approach_hysteresis_rebound(approach_only_factor(e)),
    notes="Damped while the bodies approach only: damped in both phases, as also found, it would give back 0.22 "
    "where 0.5 is asked for.  The paper's elastic force is linear: write `exponent: 1`.",
)

# ---------------------------------------------------------------------------------------------- yielding

enter(
    "law",
    "lankarani-nikravesh-plastic",
    "yields while it deepens, springs back from an indentation",
    "F = F_elastic(pen) while pen deepens; below the deepest, pen_m, where it last turned back: "
    "F = F_elastic((pen - pen_p) / e^2), pen_p = (1 - e^2) pen_m, 0 below pen_p; for a power n that is "
    "F = F_m ((pen - pen_p) / (pen_m - pen_p))^n, F_m = K pen_m^n",
    "after Lankarani & Nikravesh 1994, Nonlinear Dyn. 5:193; pen_p such that a free impact loses (1 - e^2) m v0^2 / 2",
    lambda joint: Plastic(joint.contact.values["restitution"] ** 2, joint.contact.values["yield_rate"]),
    restitution(zero=False),
    Field("yield_rate", "m/s", "onset rate up to which the contact is elastic", low_open=False, default=0.0),
    returned=lambda e: e,
    notes="For impacts that leave the elastic range.  Left out, yield_rate is 0: every contact yields; for steel about "
    "0.05 m/s is where it begins.  pen_m is forgotten when the surfaces part (pen < 0): the next contact meets a "
    "fresh surface, but a journal that wanders within one contact takes its indentation along.  There pen < pen_p "
    "counts as contact without force, each entry into it as a clip.  A contact that stays shakes down to an elastic "
    "one.",
)

# ---------------------------------------------------------------------------------------------- with a mass


def exponent_of(contact: Mapping[str, float]) -> float:
    """Return the exponent of a contact's elastic force, Hertz's where it is no power."""
    return contact.get("exponent", 1.5)


def _make_tsuji(joint):
    contact = joint.contact.values
    alpha = math.sqrt(2.0 * (exponent_of(contact) + 1.0)) * damping_ratio(contact["restitution"])
    return RootDamper(alpha * math.sqrt(contact["mass"]))


def jankowski_ratio(e: float) -> float:
    """Return xi = (9 sqrt(5) / 2) (1 - e^2) / (e (e (9 pi - 16) + 16))."""
    return 4.5 * math.sqrt(5.0) * (1.0 - e * e) / (e * (e * (9.0 * math.pi - 16.0) + 16.0))


def _make_jankowski(joint):
    contact = joint.contact.values
    return ApproachRootDamper(2.0 * jankowski_ratio(contact["restitution"]) * math.sqrt(contact["mass"]))


def _make_anagnostopoulos(joint):
    contact = joint.contact.values
    zeta = damping_ratio(contact["restitution"])
    return PullingSpring(2.0 * zeta * math.sqrt(contact["stiffness"] * contact["mass"]))


enter(
    "law",
    "tsuji",
    "damped Hertzian spring that gives back exactly the restitution asked for",
    "F = F_elastic + alpha sqrt(mass F_elastic / pen) rate, alpha = -sqrt(2 (n + 1)) ln e / sqrt(pi^2 + ln(e)^2); for "
    "n = 1.5: F = K pen^1.5 + alpha sqrt(mass K) pen^0.25 rate with sqrt(5) in alpha",
    "Tsuji, Tanaka & Ishida 1992, Powder Technol. 71:239; alpha by Antypov & Elliott 2011, EPL 94:50004",
    _make_tsuji,
    restitution(zero=False),
    MASS,
    returned=lambda e: e,
    pulls=True,
    notes="Pulls before the surfaces part, and is not clipped: the restitution holds for a release at zero "
    "penetration.  Exact for elastic: power; elsewhere n = 1.5 stands in alpha.",
)
enter(
    "law",
    "jankowski",
    "damped Hertzian spring, damped on the approach alone",
    "F = F_elastic + 2 xi sqrt(mass F_elastic / pen) rate while rate > 0, else F_elastic; "
    "xi = (9 sqrt(5) / 2) (1 - e^2) / (e (e (9 pi - 16) + 16))",
    "after Jankowski 2005, Earthq. Eng. Struct. Dyn. 34:595, and 2006, 35:517",
    _make_jankowski,
    restitution(zero=False),
    MASS,
    returned=lambda e: approach_damping_rebound(2.0 * jankowski_ratio(e) / math.sqrt(5.0)),
    notes="Made for an exponent of 1.5; within 7 % of what is asked for from 0.1 on, 1.1 % from 0.5 on.",
)
enter(
    "law",
    "anagnostopoulos",
    "linear spring and damper from the restitution",
    "F = k pen + c rate, c = 2 zeta sqrt(k mass), zeta = -ln e / sqrt(pi^2 + ln(e)^2)",
    "Anagnostopoulos 1988, Earthq. Eng. Struct. Dyn. 16:443, and 2004, 33:897",
    _make_anagnostopoulos,
    SPRING,
    restitution(zero=False),
    MASS,
    uses_elastic=False,
    returned=lambda e: e,
    pulls=True,
    notes="The force jumps to c times the onset rate at contact, pulls before the surfaces part and is not "
    "clipped: the restitution holds for a release at zero penetration.  kelvin-voigt with the same damping, "
    "clipped, gives back more.",
)

# ---------------------------------------------------------------------------------------------- no restitution

DAMPER = Field("damping", "N*s/m", "of the damper", low_open=False)

enter(
    "law",
    "kelvin-voigt",
    "linear spring and damper, clipped",
    "F = max(0, k pen + c rate)",
    "Kelvin-Voigt; clipped at zero",
    lambda joint: ViscousSpring(joint.contact.values["damping"]),
    SPRING,
    DAMPER,
    uses_elastic=False,
    notes="The force jumps to c times the onset rate at contact and is clipped where it would pull.  A free impact "
    "gives back exp(-(zeta / w) atan2(2 zeta w, 2 zeta^2 - 1)), zeta = c / (2 sqrt(k m)) < 1, w = sqrt(1 - "
    "zeta^2): more than exp(-pi zeta / w), which holds without clipping.",
)
enter(
    "law",
    "kelvin-voigt-unclipped",
    "linear spring and damper that pulls until the surfaces part",
    "F = k pen + c rate",
    "Kelvin-Voigt",
    lambda joint: PullingSpring(joint.contact.values["damping"]),
    SPRING,
    DAMPER,
    uses_elastic=False,
    pulls=True,
    notes="The force jumps to c times the onset rate at contact and pulls before the surfaces part.  A free impact "
    "gives back exp(-pi zeta / sqrt(1 - zeta^2)), zeta = c / (2 sqrt(k m)) < 1; from zeta = 1 on the "
    "surfaces never part.  Friction takes a pulling force for none.",
)
enter(
    "law",
    "ristow",
    "elastic force and a constant damper, clipped",
    "F = max(0, F_elastic + damping rate)",
    "after Ristow 1992, J. Phys. I France 2:649",
    lambda joint: ViscousSpring(joint.contact.values["damping"]),
    DAMPER,
    notes="What it gives back depends on the speed.  The force jumps to damping times the onset rate at contact.",
)
enter(
    "law",
    "kuwabara-kono",
    "viscoelastic spheres, clipped",
    "F = max(0, F_elastic + damping sqrt(pen) rate)",
    "Kuwabara & Kono 1987, Jpn. J. Appl. Phys. 26:1230",
    lambda joint: RootViscous(joint.contact.values["damping"]),
    Field("damping", "N*s/m^1.5", "of the damper, over the root of the penetration", low_open=False),
    notes="What it gives back depends on the speed: all of it as the speed goes to zero.  Made for an exponent of 1.5.",
)
enter(
    "law",
    "adams-impact",
    "the IMPACT function of MSC Adams",
    "F = max(0, F_elastic + damping step(pen) rate), step = 3 x^2 - 2 x^3 of x = min(1, pen / depth)",
    "MSC Adams/Solver, functions IMPACT and STEP",
    lambda joint: SteppedDamper(joint.contact.values["damping"], joint.contact.values["depth"]),
    DAMPER,
    Field("depth", "m", "penetration from which on all damping acts"),
    notes="With elastic: power its K and e are `stiffness` and `exponent`, c_max is `damping`, d is `depth`.  What "
    "it gives back depends on the speed.",
)
