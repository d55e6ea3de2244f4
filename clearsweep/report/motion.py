"""One case in pictures: journal orbit, force, slider beside the ideal mechanism, drive, contact onsets."""

from collections.abc import Mapping

import numpy as np

from .. import wording
from ..mechanics.mechanism.slider_crank.ideal import slider
from ..results import ELASTIC_ONSET
from ..store import StoredRun
from .draw import motion
from .picture import Picture
from .study import Joint, Study

TURN = 2.0 * np.pi
FLAT, SQUARE = (4.2, 3.3), (4.2, 3.05)  # inches; a square beside a colour bar is as wide as it is high, and fits
LEVELS = (("force_p99", "p99"), ("force_peak_ideal", "ideal peak"))  # drawn across the force of a joint


def history(run: StoredRun, case_id: str) -> Mapping | None:
    """Return the saved channels of a case by name, None where no history was saved."""
    path = run.orbit(case_id)
    return path if len(path) > 1 else None


def pictures(study: Study, case_id: str, path: Mapping) -> list[Picture]:
    """Return the pictures of one case from its channels, those that its mechanism has."""
    if "crank_angle" not in path:
        return _over_time(path, study.joints[0])
    angle = np.asarray(path["crank_angle"], float)
    angle = angle - TURN * np.floor(angle[0] / TURN + 1e-9)
    drawn = [picture for joint in study.joints for picture in _joint(study, case_id, joint, path, angle)]
    return [*drawn, *_slider(study, case_id, path, angle), _torque(path, angle)]


def onsets(study: Study, case_id: str, events: Mapping) -> list[Picture]:
    """Return the picture of the closing rates at the contact onsets; [] without events or crank."""
    speed = study.value(case_id, "drive.speed")
    kept = np.asarray(events["kind"]).astype(str) == "on"
    if speed is None or not kept.any():
        return []
    angle, rate = float(speed) * np.asarray(events["t"], float)[kept], np.asarray(events["rate"], float)[kept]
    return [
        Picture(
            "Contact onsets",
            "Closing rate at each onset, the whole run.",
            f"{int(kept.sum())} contact onsets, the fastest at {_most(rate, 'm/s')}.",
            lambda ax: motion.events(ax, angle, rate, ELASTIC_ONSET),
            FLAT,
        )
    ]


def _slider(study: Study, case_id: str, path: Mapping, angle: np.ndarray) -> list[Picture]:
    """Return the slider's acceleration and its position error, beside the ideal mechanism where that is known."""
    ideal_motion = _ideal(study, case_id, path)
    acceleration = np.asarray(path["slider/a"], float)
    without = None if ideal_motion is None else ideal_motion[2]
    alt = f"Slider acceleration, at most {_most(acceleration, 'm/s^2')}"
    alt += "." if without is None else f"; the ideal mechanism reaches {_most(without, 'm/s^2')}."
    drawn = [
        Picture(
            "Slider acceleration against the ideal mechanism",
            "",
            alt,
            lambda ax: motion.against_ideal(ax, angle, acceleration, without, "m/s^2", "slider acceleration"),
            FLAT,
        )
    ]
    if ideal_motion is None:
        return drawn
    error = np.asarray(path["slider/x"], float) - ideal_motion[0]
    return [
        *drawn,
        Picture(
            "Slider position error",
            "Slider position less that of the ideal mechanism.",
            f"Slider error, at most {_most(error, 'm')}.",
            lambda ax: motion.against_ideal(ax, angle, error, None, "m", "slider error"),
            FLAT,
        ),
    ]


def _torque(path: Mapping, angle: np.ndarray) -> Picture:
    torque = np.asarray(path["crank/torque"], float)
    return Picture(
        "Crank torque",
        "What the drive must give to hold the crank speed.",
        f"Crank torque, at most {_most(torque, 'N*m')}.",
        lambda ax: motion.against_ideal(ax, angle, torque, None, "N*m", "crank torque"),
        FLAT,
    )


def _joint(study: Study, case_id: str, joint: Joint, path: Mapping, angle: np.ndarray) -> list[Picture]:
    """Return the orbit of the journal, where its clearance is known, and the normal force."""
    x, y, force = (np.asarray(path[f"joints/{joint.name}/{name}"], float) for name in ("x", "y", "force_normal"))
    where = study.where(joint, ", joint {}")
    clearance = study.value(case_id, f"joints.{joint.title}.clearance")
    reach = wording.text(float(np.hypot(x, y).max()), "m")
    drawn = []
    if clearance is not None:
        drawn.append(
            Picture(
                f"Journal orbit{where}",
                "Circle: radial clearance. Outside it the bodies touch.",
                f"Path of the journal centre, at most {reach} from the bearing centre; clearance "
                f"{wording.text(float(clearance), 'm')}.",
                lambda ax: motion.orbit(ax, x, y, force, float(clearance)),
                SQUARE,
            )
        )
    levels = _levels(study, case_id, joint)
    drawn.append(
        Picture(
            f"Normal force{where}",
            "",
            f"Normal force over crank angle, at most {_most(force, 'N')} among the samples.",
            lambda ax: motion.force(ax, angle, force, levels),
            FLAT,
        )
    )
    return drawn


def _levels(study: Study, case_id: str, joint: Joint) -> list[tuple[str, float]]:
    """Return the forces of a case that its history is to be compared with: name, N."""
    if case_id not in study.cases.index:
        return []
    columns = [(name, joint.column(figure)) for figure, name in LEVELS]
    levels = [(name, float(study.cases.at[case_id, column])) for name, column in columns if study.has(column)]
    return [level for level in levels if np.isfinite(level[1])]


def _over_time(path: Mapping, joint: Joint) -> list[Picture]:
    """Return the pictures of two bodies on a line: displacement, phase portrait, force."""
    t, x, v = (np.asarray(path[name], float) for name in ("t", "pair/x", "pair/v"))
    force = np.asarray(path[f"joints/{joint.name}/force_normal"], float)
    return [
        Picture(
            "Relative displacement",
            "",
            f"Displacement over time, at most {_most(x, 'm')}.",
            lambda ax: motion.over_time(ax, t, x, "m", "displacement"),
            FLAT,
        ),
        Picture(
            "Phase portrait",
            "Relative rate over relative displacement.",
            "Phase portrait of the pair.",
            lambda ax: motion.phase(ax, x, v),
            SQUARE,
        ),
        Picture(
            "Normal force",
            "",
            f"Force over time, at most {_most(force, 'N')} among the samples.",
            lambda ax: motion.over_time(ax, t, force, "N", "normal force"),
            FLAT,
        ),
    ]


def _ideal(study: Study, case_id: str, path: Mapping) -> tuple | None:
    """Return position, velocity and acceleration of the ideal slider (m, m/s, m/s^2) at the samples of a case."""
    names = ("mechanism.crank.length", "mechanism.rod.length", "drive.speed")
    sizes = [float(value) for name in names if (value := study.value(case_id, name)) is not None]
    if len(sizes) < len(names):
        return None
    crank, rod, speed = sizes
    position, velocity, acceleration = slider(crank, rod, np.asarray(path["crank_angle"], float), speed)
    return position, velocity, acceleration


def _most(values: np.ndarray, unit: str) -> str:
    """Return the largest magnitude of a history with its unit."""
    return wording.text(float(np.abs(values).max()), unit)
