"""Life of joints: hours to the limit over the swept values, and figures until then."""

from functools import partial

import numpy as np

from ...language import wording
from ..blocks.picture import Picture
from ..blocks.section import Gallery, Section, without_empty
from ..data.study import Joint, Study
from ..draw import life
from ..draw.life import LifeCurve
from . import maps

NOTE = (
    "Curves: the cases with the shortest, median and longest life. Points: starts of the simulated blocks. Bars: 95 % "
    "interval of the number of revolutions to the limit, numerical error only. Dotted line: the limit. The map shows, "
    "for each cell, the shortest life of its cases."
)


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if no case has a life or none finished."""
    joint = next((joint for joint in study.joints if joint.name == study.run.layout.life), None)
    if joint is None or study.cases.empty:
        return []
    return [Section("life", "Life", without_empty([Gallery(NOTE, _pictures(study, joint))]))]


def _pictures(study: Study, joint: Joint) -> list[Picture]:
    hours, limited_figure = joint.column("life_hours"), study.run.grid["life"]["of"]
    ids = study.cases.representative_cases(hours)[::-1] if study.has(hours) else ()
    names = {1: ("the case",), 2: ("shortest", "longest"), 3: ("shortest", "median", "longest")}.get(len(ids), ())
    histories = {name: (case_id, study.run.history(case_id)) for name, case_id in zip(names, ids, strict=True)}
    caption = "; ".join(f"{name}: {study.setting(case_id) or case_id}" for name, (case_id, _) in histories.items())
    limit = study.run.grid["life"].get("limit")
    pictures: list[Picture] = []
    for figure, unit, title in (
        ("wear_depth_max", "m", "wear depth"),
        ("clearance_growth", "m", "growth of the clearance"),
        ("force_peak", "N", "force peak"),
    ):
        curves = [_life_curve(study, joint, name, *history, figure) for name, history in histories.items()]
        if curves:
            end_texts = wording.texts_in_common_unit((float(history.values[-1]) for history in curves), unit)
            curve_texts = ", ".join(f"{history.name} {end}" for history, end in zip(curves, end_texts, strict=True))
            text = f"{title} over revolutions; at the end: {curve_texts}."
            figure_limit = limit if figure == limited_figure and isinstance(limit, float) else None
            paint = partial(life.draw_over_revolutions, curves=curves, unit=unit, name=title, limit=figure_limit)
            pictures.append(Picture(f"{title.capitalize()} over revolutions", "" if pictures else caption, text, paint))
    return maps.pictures_over_axes(study, joint, "life_hours", "life") + pictures


def _life_curve(study: Study, joint: Joint, name: str, case_id: str, history: dict, figure: str) -> LifeCurve:
    """Return a figure of a case over revolutions; the limited figure has the interval of its end."""
    key = f"{joint.name}/{'clearance' if figure == 'clearance_growth' else figure}"
    values = np.asarray(history[key], float)
    interval = None
    if figure == study.run.grid["life"]["of"]:
        low, high = (float(study.cases.at[case_id, joint.column(f"life_{end}")]) for end in ("low", "high"))
        interval = (low, high) if np.isfinite(low) and np.isfinite(high) else None
    plotted = values - values[0] if figure == "clearance_growth" else values
    return LifeCurve(name, np.asarray(history["revolutions"], float), plotted, interval)
