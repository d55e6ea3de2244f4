"""One case in pictures: journal orbit, force, slider beside the ideal mechanism, drive, contact onsets."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from .. import wording
from ..mechanics.mechanism.slider_crank import ideal
from . import draw, figures, findings
from .figures import Canvas, Picture
from .study import Joint, Study

TURN = 2.0 * np.pi


class Panel(NamedTuple):
    """One drawing of a case before it has a canvas: `paint(ax)` draws it."""

    title: str
    caption: str
    alt: str
    paint: Callable
    round: bool = False  # wants a square


class Chosen(NamedTuple):
    """A case shown in detail: why it was chosen, its id, its settings in words, its pictures."""

    why: str
    case_id: str
    setting: str
    figures: list[tuple[str, str]]  # name, value with unit
    pictures: list[Picture]


def detailed(study: Study, canvas: Canvas) -> list[Chosen]:
    """Return the hardest, the median and the mildest loaded case with a history, drawn; none where none was saved."""
    if study.cases.empty:
        return []
    column = study.hardest_joint().column(study.lead.figure)
    ids = study.cases[column].dropna().sort_values(ascending=False, kind="stable").index
    wanted = {"Hardest loaded": 0, "Median": len(ids) // 2, "Mildest loaded": len(ids) - 1}
    chosen, seen = [], set()
    for why, place in wanted.items():
        if place < 0 or place in seen or (why == "Median" and len(ids) < 3):
            continue
        seen.add(place)
        path = history(study.run, ids[place])
        if path is not None:
            onsets = impacts(study, ids[place], study.run.events(ids[place]))
            drawn = panels(study, ids[place], path) + ([onsets] if onsets else [])
            pictures = [picture(panel, canvas) for panel in drawn]
            chosen.append(
                Chosen(
                    f"{why} case" if len(ids) > 1 else "The case",
                    ids[place],
                    study.setting(ids[place]),
                    _figures(study, ids[place]),
                    pictures,
                )
            )
    return chosen


def history(run, case_id: str) -> Mapping | None:
    """Return the saved channels of a case by name, None where no history was saved."""
    path = run.orbit(case_id)
    return path if len(path) > 1 else None


def picture(panel: Panel, canvas: Canvas) -> Picture:
    """Return a panel drawn as a picture of its own."""
    size = (4.2, 3.05 if panel.round else 3.3)  # a square beside a colour bar is as wide as it is high, and fits
    return canvas.picture(panel.paint, panel.title, panel.caption, panel.alt, size=size)


def panels(study: Study, case_id: str, path: Mapping) -> list[Panel]:
    """Return the drawings of one case from its channels, those that its mechanism has."""
    if study.mechanism == "impact-pair":
        return _pair(path, study.joints[0])
    angle = np.asarray(path["crank_angle"], float)
    angle = angle - TURN * np.floor(angle[0] / TURN + 1e-9)
    found = [panel for joint in study.joints for panel in _joint(study, case_id, joint, path, angle)]
    wanted = _ideal(study, case_id, path)
    acceleration, without = np.asarray(path["slider/a"], float), None if wanted is None else wanted[2]
    said = f"Slider acceleration, at most {_most(acceleration, 'm/s^2')}"
    said += "." if without is None else f"; the ideal mechanism reaches {_most(without, 'm/s^2')}."
    found.append(
        Panel(
            "Slider acceleration against the ideal mechanism",
            "",
            said,
            lambda ax: draw.against_ideal(ax, angle, acceleration, without, "m/s^2", "slider acceleration"),
        )
    )
    if wanted is not None:
        error = np.asarray(path["slider/x"], float) - wanted[0]
        found.append(
            Panel(
                "Slider position error",
                "Slider position less that of the ideal mechanism.",
                f"Slider error, at most {_most(error, 'm')}.",
                lambda ax: draw.against_ideal(ax, angle, error, None, "m", "slider error"),
            )
        )
    torque = np.asarray(path["crank/torque"], float)
    found.append(
        Panel(
            "Crank torque",
            "What the drive must give to hold the crank speed.",
            f"Crank torque, at most {_most(torque, 'N*m')}.",
            lambda ax: draw.against_ideal(ax, angle, torque, None, "N*m", "crank torque"),
        )
    )
    return found


def _joint(study: Study, case_id: str, joint: Joint, path: Mapping, angle: np.ndarray) -> list[Panel]:
    x, y, force = (np.asarray(path[f"joints/{joint.name}/{name}"], float) for name in ("x", "y", "force_normal"))
    where = f", joint {joint.title}" if len(study.joints) > 1 else ""
    clearance = study.value(case_id, f"joints.{joint.title}.clearance")
    reach = wording.text(float(np.hypot(x, y).max()), "m")
    found = []
    if clearance is not None:
        found.append(
            Panel(
                f"Journal orbit{where}",
                "Circle: radial clearance. Outside it the bodies touch.",
                f"Path of the journal centre, at most {reach} from the bearing centre; clearance "
                f"{wording.text(clearance, 'm')}.",
                lambda ax: draw.orbit(ax, x, y, force, float(clearance)),
                round=True,
            )
        )
    levels = [
        (name, float(study.cases.at[case_id, joint.column(figure)]))
        for figure, name in (("force_p99", "p99"), ("force_peak_ideal", "ideal peak"))
        if case_id in study.cases.index and study.has(joint.column(figure))
    ]
    levels = [level for level in levels if np.isfinite(level[1])]
    found.append(
        Panel(
            f"Normal force{where}",
            "",
            f"Normal force over crank angle, at most {_most(force, 'N')} among the samples.",
            lambda ax: draw.force(ax, angle, force, levels),
        )
    )
    return found


def _pair(path: Mapping, joint: Joint) -> list[Panel]:
    t, x, v = (np.asarray(path[name], float) for name in ("t", "pair/x", "pair/v"))
    force = np.asarray(path[f"joints/{joint.name}/force_normal"], float)
    return [
        Panel(
            "Relative displacement",
            "",
            f"Displacement over time, at most {_most(x, 'm')}.",
            lambda ax: draw.over_time(ax, t, x, "m", "displacement"),
        ),
        Panel(
            "Phase portrait",
            "Relative rate over relative displacement.",
            "Phase portrait of the pair.",
            lambda ax: draw.phase(ax, x, v),
            round=True,
        ),
        Panel(
            "Normal force",
            "",
            f"Force over time, at most {_most(force, 'N')} among the samples.",
            lambda ax: draw.over_time(ax, t, force, "N", "normal force"),
        ),
    ]


def impacts(study: Study, case_id: str, events) -> Panel | None:
    """Return the drawing of the closing rates at the contact onsets; None without events or crank."""
    speed = study.value(case_id, "drive.speed")
    onsets = np.asarray(events["kind"]).astype(str) == "on"
    if speed is None or not onsets.any():
        return None
    angle, rate = float(speed) * np.asarray(events["t"], float)[onsets], np.asarray(events["rate"], float)[onsets]
    return Panel(
        "Contact onsets",
        "Closing rate at each onset, the whole run.",
        f"{int(onsets.sum())} contact onsets, the fastest at {_most(rate, 'm/s')}.",
        lambda ax: draw.events(ax, angle, rate, findings.ELASTIC_ONSET),
    )


def _ideal(study: Study, case_id: str, path: Mapping) -> tuple | None:
    """Return position, velocity and acceleration of the ideal slider (m, m/s, m/s^2) at the samples of a case."""
    names = ("mechanism.crank.length", "mechanism.rod.length", "drive.speed")
    crank, rod, speed = (study.value(case_id, name) for name in names)
    if None in (crank, rod, speed):
        return None
    return ideal.slider(float(crank), float(rod), np.asarray(path["crank_angle"], float), float(speed))


def _most(values: np.ndarray, unit: str) -> str:
    """Return the largest magnitude of a history with its unit."""
    return wording.text(float(np.abs(values).max()), unit)


def _figures(study: Study, case_id: str) -> list[tuple[str, str]]:
    joint = study.hardest_joint()
    wanted = [
        (name, joint.column(figure))
        for name, figure in (
            ("p99", "force_p99"),
            ("rms", "force_rms"),
            ("peak", "force_peak"),
            ("ideal peak", "force_peak_ideal"),
            (figures.impacts_name(study), "impacts_per_rev"),
            ("time in contact", "contact_fraction"),
            ("fastest onset", "onset_rate_max"),
        )
    ]
    wanted.append(("slider error", "slider_error_max"))
    return [(name, study.text(case_id, column)) for name, column in wanted if column in study.cases]
