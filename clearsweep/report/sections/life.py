"""Life of joints: hours to the limit over the swept values, and figures until then."""

from functools import partial

import numpy as np

from ...answers import lifetime
from ...language import wording
from ..blocks.picture import Picture
from ..blocks.section import Gallery, Points, Section, without_empty
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
    return [
        Section(
            "life",
            "Life",
            without_empty([Points(_extreme_life_sentences(study, joint)), Gallery(NOTE, _pictures(study, joint))]),
        )
    ]


def life_sentences(study: Study) -> list[str]:
    """Return the shortest and the longest life in one sentence each, or [] if no case has a life."""
    joint = next((joint for joint in study.joints if joint.name == study.run.layout.life), None)
    return [] if joint is None or study.cases.empty else _extreme_life_sentences(study, joint)


def _extreme_life_sentences(study: Study, joint: Joint) -> list[str]:
    """Return the shortest and the longest life, and the number of cases that did not reach their limit."""
    life_section, hours = study.run.grid["life"], joint.column("life_hours")
    criterion_text = lifetime.criterion_text(life_section | study.base.get("life", {}))
    points: list[str] = []
    if study.has(hours):
        hours_by_case = study.cases[hours]
        extreme_ids = dict.fromkeys((hours_by_case.idxmin(), hours_by_case.idxmax()))
        for case_id, lead_in in zip(extreme_ids, ("Shortest life", "Longest life"), strict=False):
            setting_text = f" at {study.setting(case_id)}" if study.swept() else ""
            life = _lifetime(study, joint, case_id)
            criterion = "" if points else f" of joint {joint.title}, {criterion_text}"
            life_sentence = f"{lead_in}{criterion}: {lifetime.hours_text(life)}{setting_text}."
            points.append(" ".join([life_sentence, *lifetime.remarks(life)]))
        column, is_known = joint.column("wear_smoothing"), hours_by_case.notna().to_numpy()
        widths = study.cases[column].to_numpy(float)[is_known] if column in study.cases else ()
        points += lifetime.smoothing_sentences(widths)
    unreached_count = int(study.cases[hours].isna().sum())
    if unreached_count:
        points.append(
            f"{wording.count_text(unreached_count, 'case')} did not reach the limit. The life is at least as long as "
            "the "
            "run."
        )
    return points


def _lifetime(study: Study, joint: Joint, case_id: str) -> lifetime.Lifetime:
    """Return the life of a case."""
    column_by_name = {
        name: joint.column(name) for name in lifetime.FIELD_BY_COLUMN if joint.column(name) in study.cases
    }
    return lifetime.read_lifetime(
        {name: float(study.cases.at[case_id, column]) for name, column in column_by_name.items()}
    )


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
