"""Laws that multiply the elastic force by a function of the rate over the onset rate.

A new law of the form F = F_elastic (1 + chi rate / onset_rate) is one block with its chi.
"""

from collections.abc import Callable
from typing import NamedTuple

from ...contracts.case import Joint
from ...contracts.catalogue import Field, Merit, ranged
from ...tracing.compiled import calculus as math
from . import loss
from .bearings import elastic_of_elements
from .contract import UNKNOWN, compile_law, rate_variable, register, register_pieces, zero_kink
from .elastic import elastic_force


class Lossless(NamedTuple):
    """Only the elastic force."""


@loss.register_contact_force(Lossless, pulls=False, times_elastic=True)
def _lossless(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force, force


register(
    "law hertz: no loss",
    "F = F_elastic",
    "Hertz 1881, J. reine angew. Math. 92:156",
    types=(Lossless,),
    free_restitution=lambda e: 1.0,
)


class Hysteresis(NamedTuple):
    """F = F_elastic (1 + chi rate / onset_rate); laws of this form differ only in chi(restitution)."""

    factor: float  # chi, 1


@loss.register_contact_force(Hysteresis, pulls=False, times_elastic=True)
def _hysteresis(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force + force * (law.factor / onset_rate) * rate, force


loss.needs_onset_rate.member(Hysteresis)(loss.always_needs_onset_rate)
FORCE_FORMULA = "F = F_elastic (1 + chi rate / onset_rate), chi = "


def register_factor_law(
    name: str, summary: str, chi_text: str, source: str, field: Field, chi: Callable[[float], float], **further
) -> None:
    """Register a law of this form with its chi(restitution), a function and its text; `further` goes to its Law."""
    register(
        f"law {name}: {summary}",
        f"{FORCE_FORMULA}{chi_text}",
        source,
        (field,),
        types=(Hysteresis,),
        make=lambda joint: Hysteresis(float(chi(joint.contact.values["restitution"]))),
        free_restitution=lambda e: loss.hysteresis_rebound(chi(e)),
        uses_onset=True,
        **further,
    )


class RateFactor(NamedTuple):
    """F = F_elastic (1 + factor rate): a damper of given size, without an onset rate."""

    factor: float  # s/m


@loss.register_contact_force(RateFactor, pulls=False, times_elastic=True)
def _rate_factor(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force + force * law.factor * rate, force


def damping_factor(joint: Joint) -> float | None:
    """Return D / K (s/m) of F = K pen^n + D pen^n rate, or None if the loss follows from a restitution."""
    values = joint.contact.values
    if "damping" in values:
        elastic = elastic_of_elements(joint) if joint.rolling else compile_law("elastic", "power", joint)
        return float(values["damping"] / elastic.stiffness)
    return values.get("damping_factor")


def _make_hunt_crossley(joint: Joint) -> Hysteresis | RateFactor:
    factor = damping_factor(joint)
    return Hysteresis(_hunt_crossley_chi(joint.contact.values["restitution"])) if factor is None else RateFactor(factor)


def _hunt_crossley_chi(e: float) -> float:
    return 1.5 * (1.0 - e)


def _restitution_by_speed(joint: Joint) -> dict[str, tuple[float, str]]:
    """Return the restitution of free impacts at PRINTED_SPEEDS: chi = D v / K, see `hysteresis_rebound`."""
    factor = damping_factor(joint)
    if factor is None:
        return {}
    return {
        f"contact.restitution at {speed:g} m/s": (loss.hysteresis_rebound(factor * speed), "1")
        for speed in PRINTED_SPEEDS
    }


PRINTED_SPEEDS = (0.1, 1.0)  # m/s
GIVEN_DAMPER = ranged(
    "damping_factor",
    "s/m",
    "",
    "[0, inf)",
    optional=True,
    refusal="with a given damper every law of the form F_elastic (1 + chi rate / onset_rate) equals hunt-crossley",
)
DAMPING_TEXT = "in place of `restitution`: the damper of F = K pen^n + D pen^n rate"

register(
    "law hunt-crossley: the oldest of its form, for restitution near 1, or with a given damper",
    f"{FORCE_FORMULA}3 (1 - e) / 2; or F = F_elastic (1 + (damping / stiffness) rate)",
    "Hunt & Crossley 1975, J. Appl. Mech. 42:440, eqs. 6 and 9",
    (
        loss.ANY_RESTITUTION._replace(optional=True),
        GIVEN_DAMPER._replace(name="damping", unit="N*s/m^exponent+1", text=f"{DAMPING_TEXT}; `elastic: power`"),
        GIVEN_DAMPER._replace(text=f"{DAMPING_TEXT}, over K"),
    ),
    types=(Hysteresis, RateFactor),
    make=_make_hunt_crossley,
    notes="First-order exact as e -> 1; the restitution is never below 0.488.  Marhefka & Orin use the same.  With a "
    "given damper every law of the form F_elastic (1 + chi rate / onset_rate) is this one; the restitution then falls "
    "with the speed.",
    uses_onset=True,
    one_of=("restitution", "damping", "damping_factor"),
    free_restitution=lambda e: None if e is None else loss.hysteresis_rebound(_hunt_crossley_chi(e)),
    derived=_restitution_by_speed,
)


register_factor_law(
    "herbert-mcwhannell",
    "for restitution near 1",
    "6 (1 - e) / ((2 e - 1)^2 + 3)",
    "after Herbert & McWhannell 1977, J. Eng. Ind. 99:513",
    loss.ANY_RESTITUTION,
    lambda e: 6.0 * (1.0 - e) / ((2.0 * e - 1.0) ** 2 + 3.0),
    notes="Second-order exact as e -> 1; the restitution is never below 0.488.",
)


register_factor_law(
    "lee-wang",
    "half the loss of hunt-crossley",
    "3 (1 - e) / 4",
    "after Lee & Wang 1983, J. Mech. Transm. Autom. Des. 105:534",
    loss.ANY_RESTITUTION,
    lambda e: 0.75 * (1.0 - e),
    notes="Half of the correct dissipation as e -> 1; the restitution is never below 0.663.",
)


register_factor_law(
    "lankarani-nikravesh",
    "hysteresis for restitution near 1",
    "3 (1 - e^2) / 4",
    "Lankarani & Nikravesh 1990, J. Mech. Des. 112:369",
    loss.ANY_RESTITUTION,
    lambda e: 0.75 * (1.0 - e * e),
    notes="First-order exact as e -> 1; below about 0.9 the restitution is too large, never below 0.663.",
)


register_factor_law(
    "gonthier",
    "for the whole range of restitution, in its approximate form",
    "(1 - e^2) / e",
    "Gonthier, McPhee, Lange & Piedboeuf 2004, Multibody Syst. Dyn. 11:209, approximate form",
    loss.RESTITUTION,
    lambda e: (1.0 - e * e) / e,
    notes="Off by up to 4.3 %, a third too dissipative as e -> 1; gonthier-exact is not.",
)


register_factor_law(
    "gonthier-exact",
    "has exactly the specified restitution",
    "the root of (1 + chi) / (1 - e chi) = exp(chi (1 + e))",
    "Gonthier, McPhee, Lange & Piedboeuf 2004, Multibody Syst. Dyn. 11:209, before its approximation",
    loss.RESTITUTION,
    loss.exact_factor,
    notes="The same as `exact`.",
)


register_factor_law(
    "zhiying-qishao",
    "the loss of lankarani-nikravesh, raised for small restitution",
    "(3/4) (1 - e^2) exp(2 (1 - e))",
    "after Zhiying & Qishao 2006, J. Dyn. Control 4:294",
    loss.ANY_RESTITUTION,
    lambda e: 0.75 * (1.0 - e * e) * math.exp(2.0 * (1.0 - e)),
    notes="First-order exact as e -> 1; the restitution is never below 0.179.",
)


register_factor_law(
    "flores",
    "for the whole range of restitution",
    "8 (1 - e) / (5 e)",
    "Flores, Machado, Silva & Martins 2011, Multibody Syst. Dyn. 25:357",
    loss.RESTITUTION,
    lambda e: 1.6 * (1.0 - e) / e,
    notes="6.7 % too dissipative as e -> 1.",
)


register_factor_law(
    "hu-guo",
    "accurate for a restitution above 0.6",
    "3 (1 - e) / (2 e)",
    "after Hu & Guo 2015, Multibody Syst. Dyn. 35:131",
    loss.RESTITUTION,
    lambda e: 1.5 * (1.0 - e) / e,
    notes="Second-order exact as e -> 1.  Half this chi, 3 (1 - e) / (4 e), is also in use; its restitution is "
    "about (1 + e) / 2.",
)


register_factor_law(
    "safaeifar-farshidianfar",
    "for small restitution",
    "5 (1 - e) / (4 e)",
    "after Safaeifar & Farshidianfar 2020, Multibody Syst. Dyn. 50",
    loss.RESTITUTION,
    lambda e: 1.25 * (1.0 - e) / e,
    notes="Its loss is a sixth too small as e -> 1; not compared with the paper.",
)


register_factor_law(
    "carvalho-martins",
    "a rational function, nearly exact above 0.4",
    "3 (1 - e) (11 - e) / (2 (1 + 9 e))",
    "after Carvalho & Martins 2019, Mech. Mach. Theory 139:174",
    loss.ANY_RESTITUTION,
    lambda e: 1.5 * (1.0 - e) * (11.0 - e) / (1.0 + 9.0 * e),
    notes="Within 0.04 % of the specified restitution at 0.5 and above; not valid below 0.2; the restitution is "
    "never below 0.061.",
)


register_factor_law(
    "ye",
    "hu-guo's loss, made for a linear spring",
    "3 (1 - e) / (2 e)",
    "after Ye, Li & Zhu 2009, Earthq. Eng. Eng. Vib. 8:433",
    loss.RESTITUTION,
    lambda e: 1.5 * (1.0 - e) / e,
    notes="The paper's elastic force is linear: write `exponent: 1` with the stiffness in N/m.  The restitution "
    "does not depend on the exponent.",
)


register_factor_law(
    "gharib-hurmuzlu",
    "for small restitution",
    "1 / e",
    "after Gharib & Hurmuzlu 2012, J. Appl. Mech. 79:064506; as reported by others, not compared with the paper",
    loss.RESTITUTION,
    lambda e: 1.0 / e,
    notes="Within 1.5 % of the specified restitution up to 0.2, 18 % too small at 0.5, and never above 0.594, even "
    "if 1 is specified.",
)


register_factor_law(
    "exact",
    "has exactly the specified restitution",
    "the root of ln((1 + chi) / (1 - e chi)) = chi (1 + e)",
    "phase curve of the free impact; the exact form of Gonthier et al. 2004, Multibody Syst. Dyn. 11:209",
    loss.RESTITUTION,
    loss.exact_factor,
    notes="The recommended law: a free impact has the specified restitution for any elastic force, mass and speed.",
    merit=Merit(1, "a free impact has the specified restitution for any elastic law, mass and speed"),
)


class ApproachHysteresis(NamedTuple):
    """Hysteresis during approach; only the elastic force during rebound."""

    factor: float  # chi, 1
    piece: float = UNKNOWN


register_pieces(ApproachHysteresis, rate_variable, zero_kink)


@loss.register_contact_force(ApproachHysteresis, pulls=False, times_elastic=True)
def _approach_hysteresis(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force + force * (law.factor / onset_rate) * loss.approach_rate(law.piece, rate), force


loss.needs_onset_rate.member(ApproachHysteresis)(loss.always_needs_onset_rate)


def approach_only_factor(e: float) -> float:
    """Return chi = 3 (1 - e^2) / (2 e^2)."""
    return 1.5 * (1.0 - e * e) / (e * e)


register(
    "law pant-wijeyewickrema: loss only during the approach, made for a linear spring",
    "F = F_elastic (1 + chi rate / onset_rate) while rate > 0, else F_elastic; chi = 3 (1 - e^2) / (2 e^2)",
    "after Pant & Wijeyewickrema 2012, Earthq. Eng. Struct. Dyn. 41:1709",
    (loss.RESTITUTION,),
    types=(ApproachHysteresis,),
    make=lambda joint: ApproachHysteresis(approach_only_factor(joint.contact.values["restitution"])),
    notes="Damped only while the bodies approach.  With damping in both phases, as also published, the restitution "
    "would be 0.22 instead of 0.5.  The paper's elastic force is linear: write `exponent: 1`.",
    uses_onset=True,
    free_restitution=lambda e: loss.approach_hysteresis_rebound(approach_only_factor(e)),
)
