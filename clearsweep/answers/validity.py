"""Remarks on cases outside the range of their laws, and on implausible figures of finished cases.

Yield and the range of a law have their own columns. The message of a case is a list of remarks, each of which begins
with a keyword. It includes the range of a law.
"""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..contracts.case import REFERENCE_TEMPERATURE, Joint
from ..language.wording import joint_name, short_id

#: Figures of a joint.  The first is compared with the second, the approach speed at first yield.
ONSET_RATE, YIELD_SPEED, LIMIT_SHARE = "onset_rate_max", "yield_speed", "law_limit_fraction"
_FIGURE_THRESHOLDS = {ONSET_RATE: 1.0, LIMIT_SHARE: 0.0}  # figure -> value above which there is a remark
#: Keywords of the remarks in a message: a law beyond its range, a contact that never ends and keeps its onset rate,
#: a window that begins before the motion is periodic, chaos without impacts, implausible results.
LAW_LIMIT, ONSET_KEPT, RUN_IN, SWING = "law-limit: ", "onset-kept: ", "run-in: ", "swing: "
MIN_PEAK_EXCESS = 0.02  # of a peak of the periodic motion: a larger excess of the run-in is a remark
WORN_AWAY, PV_HIGH, OVERLOADED, SKIDDING = "worn-away: ", "pv-high: ", "overloaded: ", "skidding: "
TOO_DEEP, WORN_THROUGH, IMBALANCE = "too-deep: ", "worn-through: ", "imbalance: "
FILM_LIMIT, FILM_BEYOND, FILM_FLOW, FILM_GAIN = "film-limit: ", "film-beyond: ", "film-flow: ", "film-fed: "
MIN_ENERGY_GAIN = 1e-3  # of a film's loss; a smaller gain counts as rounding
UNBALANCED = "film-heat: the heat balance of a joint did not converge; more revolutions, or a larger conductance, help"
FILM_UNCERTAIN = "film-unsure: "  # the temperature of its film is inaccurate
CRITICAL_TAYLOR = 41.3  # Taylor number above which vortices form at a rotating inner cylinder (Taylor 1923)
FRICTION_HEAT, MAX_HEATING, DEFAULT_CONDUCTANCE = "friction-heat: ", 100.0, 1.0  # K, W/K
FREE_BUSH, MIN_EXPANSION = "free-bush: ", 0.05  # share of the clearance
COARSE_LINK = "coarse-link: "  # an elastic link has too few segments for an impact at its pin
FEEDBACK = "frame-feedback: "  # of the motion of a frame on its mount, which is neglected
BALL_STIFFNESS = "ball-stiffness: "  # a stiffness from the material, for a ball in a socket
ERROR_CHECK_FAILED = "unchecked: "  # its error check failed
OWN_FIGURE = "own-figure: "  # a figure of one's own that failed
LIFE_UNREACHED = "unreached: "  # its life did not reach the limit
LIFE_FAILED = "life-failed: "  # a life at one end of the wear coefficients' intervals
CONFORMAL = "conformal: "  # its worn surfaces fit each other too closely for contact at one point
SEPARATOR = " | "  # between the remarks of a message
#: Of the bearing radius.  Beyond MAX_DEPTH a contact is not a small deformation.  Up to TOLERATED_DEPTH, a strain of
#: about 1 %, a penetration may exceed the clearance, as it does in tight fits.
MAX_DEPTH, TOLERATED_DEPTH = 0.1, 0.01
THOUSAND_HOURS = 3.6e6  # s
#: Mean pressure times speed (W/m^2) that a dry metal-backed PTFE bush withstands for short periods; 1.75 MPa m/s for
#: long: Neale, The Tribology Handbook, 'Dry rubbing bearings', and makers' sheets.
MAX_PV = 3.6e6
#: Energy residual over the tolerance, per onset and revolution, since errors of contacts add up; but at least the
#: tolerance itself.  Half of 1,300 random cases at tolerances of 1e-12 to 1e-3 had less than 0.01, none over 1.4.
#: Rounding alone stays below MIN_RESIDUAL; more than MAX_RESIDUAL is an error of the forces that counts.
EXPLAINED_RESIDUAL, MIN_RESIDUAL, MAX_RESIDUAL = 0.1, 1e-9, 1e-3


def required_columns(joints: Iterable[str], available: Collection[str]) -> list[str]:
    """Return the columns of the summary that the remarks on some joints ('rod_slider') need.

    available : all columns; a joint of unknown strength has no `yield_speed` and gets no remark on yield.
    """
    names = [f"{joint}_{figure}" for figure in (*_FIGURE_THRESHOLDS, YIELD_SPEED) for joint in joints]
    return ["case_id", "message", *(name for name in names if name in available)]


class _WorstCase(NamedTuple):
    """The case furthest beyond a threshold."""

    value: float  # the figure, SI; for impacts, relative to the speed at first yield
    joint: str  # in words
    case_id: str
    message: str
    yield_speed: float = math.nan  # m/s, speed at first yield


class Remarks:
    """Counts the cases outside the range of their laws, and keeps the worst of each kind."""

    def __init__(self, joints: Iterable[str]) -> None:
        """Prepare for joints ('rod_slider')."""
        self.joints = list(joints)
        self.cases = 0
        self.counts = dict.fromkeys((*_FIGURE_THRESHOLDS, *_REMARK_TEXTS), 0)
        self.examples: dict[str, tuple[str, str]] = {}  # keyword of _REMARKS -> case_id, remark
        self.example_ids: set[str] = set()  # identities of the cases in `examples`
        self.worst = dict.fromkeys(_FIGURE_THRESHOLDS, _WorstCase(0.0, "", "", ""))

    def add(self, cases: Mapping[str, Sequence[Any] | np.ndarray]) -> None:
        """Add finished cases: column of the summary -> its values, with at least those of `required_columns`."""
        ids, messages = cases["case_id"], cases["message"]
        self.cases += len(ids)
        for index in np.flatnonzero(np.asarray(messages, object)).tolist():
            for keyword in _REMARK_TEXTS:
                if remark := _find_remark(messages[index], keyword):
                    self.counts[keyword] += 1
                    if keyword not in self.examples:
                        self.examples[keyword] = short_id(ids[index]), remark
                        self.example_ids.add(ids[index])
        if not self.joints or not len(ids):
            return
        yield_speeds = np.array([_column_values(cases, f"{joint}_{YIELD_SPEED}", len(ids)) for joint in self.joints])
        for figure, threshold in _FIGURE_THRESHOLDS.items():
            values = np.array([_column_values(cases, f"{joint}_{figure}", len(ids)) for joint in self.joints])
            values = np.nan_to_num(values / yield_speeds if figure == ONSET_RATE else values)
            largest = values.max(axis=0)
            self.counts[figure] += int(np.count_nonzero(largest > threshold))
            index = int(np.argmax(largest))
            if largest[index] > max(threshold, self.worst[figure].value):
                joint_index = max(np.flatnonzero(values[:, index] == largest[index]), key=self.joints.__getitem__)
                self.worst[figure] = _WorstCase(
                    float(largest[index]),
                    joint_name(self.joints[joint_index]),
                    ids[index],
                    messages[index],
                    float(yield_speeds[joint_index, index]),
                )

    def replace_counts(self, counts: Mapping[str, int]) -> None:
        """Replace the counts of the added cases by those of all cases, with their number under `cases`."""
        self.cases = counts["cases"]
        self.counts = {name: counts.get(name, 0) for name in self.counts}

    def case_ids(self) -> set[str]:
        """Return the cases mentioned so far."""
        return {worst.case_id for worst in self.worst.values() if worst.case_id} | self.example_ids

    def sentences(self) -> list[str]:
        """Return the remarks on all cases, one or two sentences for each kind."""
        sentence_makers = {ONSET_RATE: self._yield_sentence, LIMIT_SHARE: self._law_limit_sentence}
        return [
            *(sentence_makers[figure](self.worst[figure]) for figure in _FIGURE_THRESHOLDS if self.counts[figure]),
            *(
                "{} in {}, such as case {}: {}.".format(text, self._count_text(keyword), *self.examples[keyword])
                for keyword, text in _REMARK_TEXTS.items()
                if keyword in self.examples
            ),
        ]

    def _yield_sentence(self, worst: _WorstCase) -> str:
        return (
            f"Impacts leave the elastic range in {self._count_text(ONSET_RATE)}: the fastest approaches at "
            f"{worst.value * worst.yield_speed:.3g} m/s, {worst.value:.2g} times the {worst.yield_speed:.3g} m/s at "
            f"which its contact first yields (case {short_id(worst.case_id)}, {worst.joint}). Beyond yield an elastic "
            "law overstates forces and understates losses."
        )

    def _law_limit_sentence(self, worst: _WorstCase) -> str:
        remark = _find_remark(worst.message, LAW_LIMIT) or f"{worst.joint}, {_percent_text(worst.value)} of the time"
        return (
            f"Contacts exceed the valid range of their elastic law in {self._count_text(LIMIT_SHARE)}, longest in case "
            f"{short_id(worst.case_id)}: {remark}. `clearsweep list NAME` describes the force beyond it."
        )

    def _count_text(self, figure: str) -> str:
        return f"{self.counts[figure]:,} of {self.cases:,} case{'s' * (self.cases != 1)}"


_REMARK_TEXTS = {
    ONSET_KEPT: "A contact never ends and keeps the onset rate of its first touch, so the start of the run affects all "
    "forces,",
    RUN_IN: "The window contains the run-in before a periodic motion, with larger force peaks,",
    SWING: "Disturbances grow without impacts",
    TOO_DEEP: "The penetration is implausibly large",
    OVERLOADED: "A rolling bearing carries more than its static rating",
    SKIDDING: "A rolling bearing may skid under too little load",
    WORN_THROUGH: "Wear is deeper than the clearance",
    WORN_AWAY: "At its wear rate a bearing is worn away within 1000 h",
    PV_HIGH: "Pressure times speed exceeds the limit of dry bushes",
    FILM_LIMIT: "A film is thinner than the valid range of its law",
    FILM_BEYOND: "A film is squeezed out, and no dry contact stops the journal",
    FILM_FLOW: "The flow in a film is no longer laminar",
    FILM_GAIN: "The law of a film generates energy",
    UNBALANCED.split(": ", maxsplit=1)[0] + ": ": "The temperature of a film or a warm joint is unknown",
    FRICTION_HEAT: f"Friction heats a dry joint by more than {MAX_HEATING:g} K, "
    f"at {DEFAULT_CONDUCTANCE:g} W/K or the value in thermal",
    FREE_BUSH: "A warm bearing expands freely, unlike a bush in a housing,",
    COARSE_LINK: "An elastic link has too few segments for its impacts",
    BALL_STIFFNESS: "The stiffness from the material is that of a ball in a socket",
    FEEDBACK: "The frame moves as one mass on its mount",
    FILM_UNCERTAIN: "The temperature of a film or a warm joint is uncertain by over a tenth of its rise above ambient",
    IMBALANCE: "The energy residual is larger than the tolerance explains",
    ERROR_CHECK_FAILED: "The error check failed",
    OWN_FIGURE: "A figure of one's own has no value",
    LIFE_UNREACHED: "A life does not reach its limit",
    LIFE_FAILED: "A further life, at an end of the uncertain wear coefficients, failed",
    CONFORMAL: "Worn surfaces fit each other too closely for a pressure from the curvatures at one point",
}


def _column_values(cases: Mapping[str, Any], column: str, count: int) -> np.ndarray:
    """Return the values of a column, (count,), nan if it is missing."""
    return np.array(cases[column], float) if column in cases else np.full(count, math.nan)


def join_remarks(*remarks: str) -> str:
    """Return the message of a finished case from its remarks, or '' if there are none."""
    return SEPARATOR.join(remark for remark in remarks if remark)


def _find_remark(message: str | None, keyword: str) -> str:
    """Return the remark in a message that begins with `keyword`, without it, or ''."""
    remarks = str(message or "").split(SEPARATOR)
    return next((remark.removeprefix(keyword) for remark in remarks if remark.startswith(keyword)), "")


def _listed(keyword: str, descriptions: Sequence[str], hint: str = "") -> str:
    """Return the remark with these descriptions, or '' if there are none."""
    return f"{keyword}{'; '.join(descriptions)}{hint}" if descriptions else ""


def penetration_remark(joints: Iterable[tuple[Joint, float]]) -> str:
    """Return the remark on penetrations (m) above clearance and TOLERATED_DEPTH, or above MAX_DEPTH."""
    remarks = []
    for joint, penetration in joints:
        clearance, radius = joint.clearance, joint.bearing_radius
        limit = min(max(clearance, TOLERATED_DEPTH * radius), MAX_DEPTH * radius) if radius else clearance
        if penetration > limit:
            sizes = f"a clearance of {_mm_text(clearance)}"
            sizes += f" and a bearing radius of {_mm_text(radius)}" if radius else ""
            remarks.append(f"{joint.name} is penetrated by {_mm_text(penetration)} at {sizes}")
    hint = "; no contact law is valid there: check the units of stiffness, mass and speed"
    return _listed(TOO_DEEP, remarks, hint)


def static_load_remark(joints: Iterable[tuple[Joint, float]]) -> str:
    """Return the remark on loads (N) of rolling bearings above their static rating, where it is known."""
    ratings = ((joint, load, joint.rolling and joint.rolling.capacity.static) for joint, load in joints)
    remarks = [
        f"{joint.name} carries {load:.4g} N, and its static rating is {rating:.4g} N"
        for joint, load, rating in ratings
        if rating and load > rating
    ]
    hint = "; rings and elements keep dents from there on (ISO 76): choose a larger bearing, or reduce load or speed"
    return _listed(OVERLOADED, remarks, hint)


def skidding_remark(joints: Iterable[tuple[str, float, float]]) -> str:
    """Return the remark on rolling bearings below their least load (N) for a share of the time."""
    remarks = [
        f"{joint} carries less than {load:.4g} N {_percent_text(share)} of the time" for joint, load, share in joints
    ]
    hint = "; elements may skid there and smear the rings: choose a smaller bearing or a preload"
    return _listed(SKIDDING, remarks, hint)


def wear_depth_remark(joints: Iterable[tuple[Joint, float]]) -> str:
    """Return the remark on wear (m, the deepest of the window) that is deeper than the clearance."""
    remarks = [
        f"{joint.name} is worn {_mm_text(depth)} deep at a clearance of {_mm_text(joint.clearance)}"
        for joint, depth in joints
        if depth > joint.clearance
    ]
    return _listed(WORN_THROUGH, remarks, "; is the coefficient in mm^2/N? (1 mm^2/N is 1e-6 m^2/N)")


def wear_rate_remark(joints: Iterable[tuple[Joint, float]]) -> str:
    """Return the remark on wear (m/s, of the deepest place) that reaches the bearing radius within 1000 h."""
    remarks = [
        f"{joint.name} wears by {_mm_text(THOUSAND_HOURS * rate)} in 1000 h, and its bearing radius is "
        f"{_mm_text(joint.bearing_radius or 0.0)}"
        for joint, rate in joints
        if THOUSAND_HOURS * rate > (joint.bearing_radius or 0.0)
    ]
    hint = (
        ". Wear coefficients of bronze on steel are 4e-16 to 4e-14 m^2/N greased and 1e-14 to 3e-13 dry, of dry mild "
        "steel up to 1.5e-11. Check the unit of the coefficient, or reduce load, speed or clearance"
    )
    return _listed(WORN_AWAY, remarks, hint)


def pv_remark(joints: Iterable[tuple[Joint, float]]) -> str:
    """Return the remark on a mean pressure times speed (W/m^2) beyond the limit of dry bushes.

    A film carries most of the load of its joint.
    """
    remarks = [
        f"{joint.name} has a mean pV of {1e-6 * pv:.3g} MPa m/s"
        for joint, pv in joints
        if pv > MAX_PV and not joint.film
    ]
    hint = f". Dry bushes allow 1 to 3 MPa m/s, and {1e-6 * MAX_PV:.2g} for a short time, so this joint needs oil"
    return _listed(PV_HIGH, remarks, hint)


def conformal_remark(joint: Joint, wear_depth: float, revolutions: float) -> str:
    """Return the remark on a joint that has worn to surfaces which fit each other.

    wear_depth : m, the largest of both bodies after so many revolutions, the last state in which they did not fit
    """
    assert joint.wear is not None  # only joints with wear
    in_slot = joint.slot_length is not None  # no other distribution is available there
    advice = "use a smaller life.limit" if in_slot else "set wear.pressure: winkler"
    return (
        f"{CONFORMAL}{joint.name} is worn {_mm_text(wear_depth)} deep after {revolutions:.6g} "
        f"revolutions. Beyond, the worn surfaces fit each other closely. wear.pressure: {joint.wear.pressure} takes "
        f"the arc of contact from the curvatures at one point, which no longer determine it: {advice}"
    )


class FilmState(NamedTuple):
    """State of the film of a joint in a case."""

    joint: str  # 'rod-slider'
    eccentricity_limit: float  # eccentricity ratio up to which its formula is valid
    share_beyond: float  # share of the window's time beyond the limit
    eccentricity_ratio: float  # largest eccentricity over clearance
    has_dry_contact: bool  # it has a dry contact
    taylor_number: float  # largest Taylor number
    energy_gain: float = 0.0  # energy gained from its pressure, over its loss
    passive_law: str = "reynolds"  # a passive film law that is valid for its length over diameter


def film_remarks(joints: Iterable[FilmState]) -> tuple[str, ...]:
    """Return the remarks on films: beyond their limit, squeezed out, not laminar, generating energy."""
    joints = list(joints)
    share_beyond = [
        f"{joint.joint} exceeds the eccentricity ratio {joint.eccentricity_limit:g} for "
        f"{_percent_text(joint.share_beyond)} of the "
        f"time and reaches {joint.eccentricity_ratio:.4g}; the film is then evaluated at {joint.eccentricity_limit:g}"
        for joint in joints
        if joint.share_beyond > 0.0
    ]
    beyond_limit = [
        f"{joint.joint} reaches {joint.eccentricity_ratio:.4g} clearances"
        for joint in joints
        if joint.eccentricity_ratio > 1.0 and not joint.has_dry_contact
    ]
    turbulent = [
        f"{joint.joint} has a Taylor number of {joint.taylor_number:.3g}, vortices begin at {CRITICAL_TAYLOR:g}; "
        "laminar laws understate its losses"
        for joint in joints
        if joint.taylor_number > CRITICAL_TAYLOR
    ]
    active = [
        f"the film of {joint.joint} returns {_percent_text(joint.energy_gain)} of the energy that it takes, which no "
        f"real film does; choose film.law: {joint.passive_law}"
        for joint in joints
        if joint.energy_gain > MIN_ENERGY_GAIN
    ]
    hint = "; add the section contact of the joint, or use more viscosity or less clearance"
    return (
        _listed(FILM_LIMIT, share_beyond),
        _listed(FILM_BEYOND, beyond_limit, hint),
        _listed(FILM_FLOW, turbulent),
        _listed(FILM_GAIN, active),
    )


def film_temperature_remark(joints: Iterable[tuple[str, float, float, float]]) -> str:
    """Return the remark on inaccurate film temperatures: (joint, temperature, half-width of 95 %, rise), in K."""
    descriptions = [
        f"{joint} is at {temperature:.2f} K, {rise:.3g} K above ambient, "
        + (f"uncertain by {error:.3g} K (95 %)" if math.isfinite(error) else "from too few revolutions for an interval")
        for joint, temperature, error, rise in joints
    ]
    return _listed(FILM_UNCERTAIN, descriptions, "; more revolutions narrow it")


def friction_heat_remark(joints: Iterable[tuple[str, float, float | None]]) -> str:
    """Return the remark on dry joints heated by friction by more than MAX_HEATING: (joint, W, W/K or None)."""
    remarks = [
        f"{joint}: friction power {power:.3g} W {'heats' if conductance else 'would heat'} a dry joint by "
        f"{'' if conductance else 'some '}{power / (conductance or DEFAULT_CONDUCTANCE):.3g} K at "
        f"{conductance or DEFAULT_CONDUCTANCE:g} W/K"
        for joint, power, conductance in joints
        if power > MAX_HEATING * (conductance or DEFAULT_CONDUCTANCE)
    ]
    return _listed(FRICTION_HEAT, remarks)


def free_bush_remark(joints: Iterable[Joint]) -> str:
    """Return the remark on bearings without a housing whose clearance heat changes by more than MIN_EXPANSION."""
    remarks = []
    for joint in joints:
        radius, temperature = joint.bearing_radius, joint.temperature
        if joint.thermal and temperature and radius and not joint.thermal.housing:
            cold_clearance = joint.clearance - joint.clearance_rate * (temperature - REFERENCE_TEMPERATURE)
            if abs(joint.clearance - cold_clearance) > MIN_EXPANSION * cold_clearance:
                remarks.append(
                    f"{joint.name} goes from {_mm_text(cold_clearance)} of clearance to {_mm_text(joint.clearance)} at "
                    f"{temperature:.4g} K because its bearing expands freely; a bush thinner than its radius of "
                    f"{_mm_text(radius)} does not where a housing grips it, and may close: write thermal.housing: "
                    "{material, wall}"
                )
    return _listed(FREE_BUSH, remarks)


def coarse_link_remark(impacts: Iterable[tuple[str, str, int, int]], most: int) -> str:
    """Return the remark on elastic links with too few segments: (link, joint, its segments, those it needs).

    most : segments that a link may have
    """
    remarks = [
        f"{link} has {count} segment{'s' * (count > 1)}, but the fastest impact in {joint} needs {needed}; "
        f"peaks may err by 5 % and more: write segments: {min(needed, most)}"
        + (", the most that is allowed" if needed > most else "")
        for link, joint, count, needed in impacts
        if count < needed and count < most
    ]
    return _listed(COARSE_LINK, remarks)


def ball_stiffness_remark(joints: Iterable[str]) -> str:
    """Return the remark on joints whose stiffness from the material assumes a ball in a socket."""
    names = ", ".join(joints)
    hint = (
        "has the stiffness of a ball in a socket (elastic: power with a material), 2 to 4 times too soft for "
        "a journal. Peaks of impacts are too low by a factor of 1.3 to 1.7. Use elastic: compatible for a journal"
    )
    return f"{BALL_STIFFNESS}{names} {hint}" if names else ""


def feedback_remark(velocity: float | None) -> str:
    """Return the remark on the velocity (m/s, rms) of a frame as one mass; None: no frame moves."""
    if velocity is None:
        return ""
    motion = f"the frame moves at {1e3 * velocity:.3g} mm/s rms in the band"
    return f"{FEEDBACK}{motion}; this does not act back on the mechanism"


def imbalance_remark(residual: float, tolerance: float, count: float) -> str:
    """Return the remark on an energy residual that the tolerance does not explain; count : onsets and revolutions."""
    explained = max(min(EXPLAINED_RESIDUAL * tolerance * count, MAX_RESIDUAL), tolerance, MIN_RESIDUAL)
    if residual <= explained:
        return ""
    return (
        f"{IMBALANCE}the energy residual is {residual:.2g}, but a tolerance of {tolerance:g} explains at most "
        f"{explained:.2g}; try a tighter tolerance, or less extreme masses, stiffness and damping"
    )


def _mm_text(length: float) -> str:
    return f"{1e3 * length:.4g} mm"


def law_range_remark(contacts: Iterable[tuple[str, str, float, float]]) -> str:
    """Return the remark on elastic laws beyond their range: (joint, law, limit in m, share of the time beyond it)."""
    descriptions = [
        f"{joint} exceeds {1e3 * limit:.4g} mm, the limit of {law}, for {_percent_text(share)} of the time"
        for joint, law, limit, share in contacts
        if share > 0.0
    ]
    return _listed(LAW_LIMIT, descriptions)


def onset_remark(joints: Iterable[tuple[str, float, bool]]) -> str:
    """Return the remark on contacts that never end and keep their onset rate.

    joints : name, onset rate in m/s, whether `contact.onset: renewed` is allowed
    """
    lasting = list(joints)
    descriptions = [
        f"{joint} stays in contact; its damping still depends on how the run started (first touch at {rate:.3g} m/s)"
        for joint, rate, _ in lasting
    ]
    remedy = "; `contact.onset: renewed` removes this" if any(allowed for *_, allowed in lasting) else ""
    return f"{ONSET_KEPT}{', '.join(descriptions)}{remedy}" if descriptions else ""


def run_in_remark(periodic_from: float, discard: float, joints: Iterable[tuple[str, float, float]]) -> str:
    """Return the remark on force peaks of a window that are larger than those of its periodic motion.

    periodic_from, discard : revolutions; joints : (name, peak of the window, peak of the periodic motion), N
    """
    descriptions = [
        f"{joint} {largest:.4g} N, once periodic {lasting:.4g} N"
        for joint, largest, lasting in joints
        if largest > (1.0 + MIN_PEAK_EXCESS) * lasting
    ]
    if periodic_from <= discard or not descriptions:
        return ""
    return (
        f"{RUN_IN}the motion is periodic from revolution {periodic_from:.6g} on, but the window of the figures begins "
        f"at {discard:.6g}. Force peaks: {', '.join(descriptions)}. Increase simulate.discard to {periodic_from:.6g}"
    )


def swing_remark(exponent: float | None, onsets: float) -> str:
    """Return the remark on chaos without impacts; exponent : 1/s, None if unknown; onsets : of the window."""
    if exponent is None or exponent <= 0.0 or onsets:
        return ""
    return (
        f"{SWING}the Lyapunov exponent is {exponent:.3g} 1/s although no surfaces separate. The journals swing along "
        "their bearings; friction and contact.restitution, the damping of lasting contact, decide whether this decays"
    )


def _percent_text(share: float) -> str:
    return f"{100.0 * share:{'.0f' if share > 0.1 else '.2g'}} %"
