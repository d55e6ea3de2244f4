"""The cards at the top of the page: the largest figures of the run, each with a reference for comparison."""

import numpy as np

from ...answers import designs, films, fits, lifetime, probability, sampled, start_up, verdict, wear
from ...answers.case_ranking import Candidate
from ...answers.validity import YIELD_SPEED
from ...language import wording
from ..blocks.section import Cards, Section
from ..data.answered import answer_cases
from ..data.comparable import comparable_values, excludes_cut_off_starts
from ..data.leading import PEAK
from ..data.study import WEAR_PER_1000_HOURS, Joint, Study
from ..data.worst_case import case_ranking_of, worst_case
from ..samples import counts
from ..statistics import elastic_range
from . import identified, optimised, seek

ONSET_FIGURE = "onset_rate_max"
WEAR_NOTE = "of one body, at the wear rate of the window"
THINNEST_FILM_NOTE = "in the case of the thinnest film"
MAX_LISTED_DESIGNS = 2
MAX_LISTED_VALUES = 4  # swept values of a case up to which a card has them all


def sections(study: Study) -> list[Section]:
    """Return the cards of a run."""
    return [Section("summary", "", [Cards(_cards(study))])]


def _cards(study: Study) -> list[tuple[str, str, str]]:
    """Return name, value with unit, and reference of each card; the worst joint of a figure is named."""
    finished, failed = counts.finished_and_failed(study)
    missing = study.run.grid.get("counts", {}).get("missing", 0)
    note = (f"{failed} failed" if failed else "none failed") + (f", {missing} not run yet" if missing else "")
    cards = [] if study.cases.empty else _answer_cards(study)
    finished_card = ("Cases finished", f"{finished} of {finished + failed + missing}", note)
    is_complete = not (failed or missing)
    cards += [] if is_complete else [finished_card]
    if study.run.marks():
        sample_note = "a random sample, and the cases with the smallest and the largest value of each figure"
        cards.append(("Shown on this page", f"{len(study.cases) + len(study.failed)} cases", sample_note))
    if study.cases.empty:
        return cards
    if case_ranking_of(study).question in ("identify", "optimise"):  # others would be of machines that were only tried
        return [*cards, finished_card] if is_complete else cards
    wear_card = (WEAR_PER_1000_HOURS, "Deepest wear in 1000 h", WEAR_NOTE)
    figures = (
        *(() if case_ranking_of(study).question == "force" else ((PEAK.figure, "Largest normal force", ""),)),
        ("force_peak_ratio", "Load over ideal peak", "relative to the mechanism without clearance"),
        *((("force_rms", "Largest force rms", ""),) if case_ranking_of(study).question == "force" else ()),
        (ONSET_FIGURE, "Fastest onset", ""),
        ("error_max", f"Largest {study.run.layout.output} error", "from the ideal position"),
        ("restitution", "Measured restitution", "largest of all cases"),
        *(() if case_ranking_of(study).question == "life" else (wear_card,)),
    )
    limited_columns = [limit.column for limit in study.limits] if sampled.is_one_sample(study.run.grid) else []
    cards += [
        card
        for figure in figures
        if _worst_column(study, figure[0])[0] not in limited_columns  # the answer has its spread
        for card in _largest_cards(study, *figure)
    ]
    return [*cards, finished_card] if is_complete else cards


def _largest_cards(study: Study, figure: str, name: str, suffix: str) -> list[tuple[str, str, str]]:
    """Return the card on the largest value of a figure; [] if it is null or 0."""
    column, joint = _worst_column(study, figure)
    if not study.cases.largest(column) > 0.0:
        return []
    joint_text = study.joint_text(joint, "joint {}") if joint else ""
    values = comparable_values(study, column)
    row = int(np.nanargmax(values))
    worst = study.cases.index[row]
    if (
        figure == WEAR_PER_1000_HOURS
        and joint
        and (hours := _clearance_hours_text(study, joint, row, float(values[row])))
    ):
        return [
            (
                "Wear equals the clearance",
                f"after {hours}".replace(" ", wording.BLANK),
                "in the worst case, at the wear rate of the window" + _worn_away_note(study, joint, values),
            )
        ]
    start_note = "of the started cases" if excludes_cut_off_starts(study, column) else ""
    if figure == PEAK.figure and joint and case_ranking_of(study).question == "start-up":
        force_until_start = start_up.start_force_text(start_up.started_cases(answer_cases(study)), joint.name)
        until_note = force_until_start and f"until the start: {force_until_start}"
        cut_off_text = start_up.force_of_cut_off(answer_cases(study), column) if start_note else ""
        unknown_note = cut_off_text.partition(":")[0]  # the answer gives the rest
        location_note = _setting_text(study, str(worst)) + start_up.within_revolutions_text(answer_cases(study))
        can_rise = start_up.may_peak_later(start_up.started_cases(answer_cases(study)))
        later_note = "higher peaks possible in longer runs" if can_rise else ""
        name += " of the started cases" if start_note else ""
        start_note = "; ".join(filter(None, (location_note, until_note, unknown_note, later_note)))
    elastic_note = ""
    if joint and figure == ONSET_FIGURE:
        if not study.has(joint.column(YIELD_SPEED)):
            return []  # without the speed of first yield it has no reference
        elastic_note = elastic_range.first_yield_text(study, joint, worst)
    note = "; ".join(filter(None, (joint_text, suffix, start_note, elastic_note))) or (
        f"joint {joint.title}" if joint else ""
    )
    return [(name, study.text(worst, column), note)]


def _worn_away_note(study: Study, joint: Joint, depths: np.ndarray) -> str:
    """Return the remark on bearings that are worn away within 1000 hours, or ''; depths : (n,) m in 1000 hours."""
    layout = next(joint_layout for joint_layout in study.run.layout.joints if joint_layout.name == joint.name)
    count = wear.worn_away_count(answer_cases(study), layout, depths)
    return f"; worn away within 1000 h in {count} of {len(depths)}" if count else ""


def _clearance_hours_text(study: Study, joint: Joint, row: int, depth: float) -> str:
    """Return the hours after which the wear of a case equals its clearance, '' beyond 1000 h; depth : m in 1000 h."""
    layout = next(joint_layout for joint_layout in study.run.layout.joints if joint_layout.name == joint.name)
    return wear.clearance_hours_text(answer_cases(study), layout, row, depth)


def _answer_cards(study: Study) -> list[tuple[str, str, str]]:
    """Return the cards with the figures of the worst case, which answer the question of the grid."""
    ranking = case_ranking_of(study)
    if ranking.question == "identify":
        return identified.parameter_cards(study)
    return [*start_up.start_up_cards(answer_cases(study)), *_worst_case_cards(study)]


def _worst_case_cards(study: Study) -> list[tuple[str, str, str]]:
    """Return the cards on the worst case by the question of the grid."""
    worst, ranking = worst_case(study), case_ranking_of(study)
    if worst is None:
        return []
    case_id, candidate = worst
    value = float(study.cases.at[case_id, candidate.columns[0]])
    setting_text = _setting_text(study, case_id)
    if ranking.question == "life":
        faster = lifetime.faster_wear_text(value)
        condition_note = f"; for the given wear coefficient; {faster} if wear is {lifetime.FASTER_WEAR} as fast"
        condition_note = "" if study.run.grid.get("uncertain") else condition_note
        return [
            (
                "Shortest life",
                f"{wording.number_text(value)}{wording.BLANK}h",
                f"{setting_text}{condition_note}".removeprefix("; "),
            ),
            *_end_of_life_cards(study),
        ]
    if ranking.question == "start-up":
        return []
    if ranking.question in ("seek", "limits"):
        exceeded = study.cases.at[case_id, verdict.EXCEEDED]
        limits = counts.limit_counts(study)
        margin, _, times = verdict.margin_text(value, study.limits, exceeded).partition(" (")
        return [
            *seek.answer_cards(study),
            *_probability_cards(study),
            *_design_cards(study),
            *(
                sampled.driver_cards(answer_cases(study))
                if sampled.is_one_sample(study.run.grid)
                else [("Within the limits", f"{limits.cases - limits.exceeding} of {limits.cases}", "finished cases")]
            ),
            ("Smallest margin", margin, "; ".join(filter(None, (times.strip("( )"), setting_text)))),
        ]
    if ranking.question == "optimise":
        return [
            (f"Best {answer_cases(study).column_label(name)}", study.text(best, name), _setting_text(study, best))
            for name, best in optimised.best_by_objective(study)
        ]
    if ranking.question == "force":
        return [("Largest normal force", study.text(case_id, candidate.columns[0]), setting_text)]
    return _film_cards(study, case_id, candidate)


def _film_cards(study: Study, case_id: str, candidate: Candidate) -> list[tuple[str, str, str]]:
    """Return the cards on the safe combination, its loss, the range of the law, and the thinnest film."""
    cases, thinnest = answer_cases(study), candidate.columns[0]
    cards, best = [], films.find_best_design(cases)
    if best is not None:
        (thickness_text,) = cases.format_values(f"{best.joint}_{films.THICKNESS}", [best.thickness])
        setting = films.design_text(cases, best)
        cards.append((films.heading(best), thickness_text, setting))
        if np.isfinite(best.loss):
            (loss_text,) = cases.format_values(f"{best.joint}_{films.LOSS}", [best.loss])
            cards.append(("Its film loss", f"up to {loss_text}", setting))
    outside_cases, count = films.find_cases_outside_law(cases)
    range_note = (
        f"outside:{cases.setting_text(int(outside_cases[0])).removeprefix(' at')}"
        if len(outside_cases) == 1
        else "range of the film law"
    )
    cards.append(("Cases within the film law", f"{count - len(outside_cases)} of {count}", range_note))
    outside_share = float(study.cases.at[case_id, f"{candidate.joint}_{films.LIMIT_FRACTION}"])
    remark = f"; {films.beyond_law_text(outside_share)}" if outside_share > 0.0 else ""
    cards.append(("Thinnest film of all", study.text(case_id, thinnest), f"{_setting_text(study, case_id)}{remark}"))
    dry_share = float(study.cases.at[case_id, f"{candidate.joint}_{films.DRY_SHARE}"])
    return (
        cards
        if np.isnan(dry_share)
        else [*cards, ("Dry load share", films.dry_share_text(dry_share), THINNEST_FILM_NOTE)]
    )


def _end_of_life_cards(study: Study) -> list[tuple[str, str, str]]:
    """Return the card on the limits at the end of lives, or [] without limits."""
    if not study.limits:
        return []
    counted = counts.limit_counts(study)
    note = ""
    if study.has(verdict.MARGIN):
        worst = str(study.cases[verdict.MARGIN].idxmin())
        exceeded = study.cases.at[worst, verdict.EXCEEDED]
        margin = verdict.margin_text(float(study.cases.at[worst, verdict.MARGIN]), study.limits, exceeded)
        only = " only" if verdict.small_margin_sentences(float(study.cases.at[worst, verdict.MARGIN])) else ""
        note = f"cases; smallest margin{only} {margin}, {_setting_text(study, worst)}".removesuffix(", ")
    return [("Limits met at the end of life", f"{counted.cases - counted.exceeding} of {counted.cases}", note)]


def _design_cards(study: Study) -> list[tuple[str, str, str]]:
    """Return the card on designs that meet the limits under every condition, or [] without designs."""
    cases = answer_cases(study)
    design_groups = designs.designs_of(cases.varied_paths, cases.values_of, len(cases.case_ids))
    if design_groups is None or sampled.is_one_sample(study.run.grid):
        return []
    accepted = sum(margin >= 0.0 for margin in design_groups.smallest_margins)
    names = wording.sentence_list([wording.axis_name(path) for path in design_groups.condition_paths])
    classified = fits.classify_fits(cases)
    if classified is not None:
        accepted_names, open_names = (
            wording.sentence_list([fit["name"] for fit in group])
            for group in (classified.accepted, classified.undecided)
        )
        parts = (accepted_names, open_names and f"open: {open_names}", f"at every {names}")
        loads = wording.sentence_list(fits.accepted_loads(cases, classified))
        note = "; ".join(filter(None, [*parts, loads and f"at their mean clearances {loads}"]))
        return [("Fits within the limits", f"{len(classified.accepted)} of {classified.total}", note)]
    accepted_cases = design_groups.worst_cases[:accepted]
    settings = [cases.values_text(index, design_groups.design_paths) for index in accepted_cases]
    listed = "; ".join(settings) if accepted <= MAX_LISTED_DESIGNS else ""
    note = "; ".join(filter(None, (listed, f"at every {names}")))
    return [("Designs within the limits", f"{accepted} of {len(design_groups.smallest_margins)}", note)]


def _probability_cards(study: Study) -> list[tuple[str, str, str]]:
    """Return the card on the probability of exceeding a limit, or [] if the cases are not one random sample."""
    limits = counts.limit_counts(study)
    if not sampled.is_one_sample(study.run.grid) or not limits.cases:
        return []
    value, _, interval = probability.percentage_text(
        probability.binomial_interval(limits.exceeding, limits.cases)
    ).partition(" (")
    window = probability.window_text(study.run.grid).strip()
    if sampled.longer_run_warning(answer_cases(study), [limit.column for limit in study.limits]):
        value = f"at least {value}"
        window += "; longer runs exceed limits more often"
    note = f"{window}; {interval.removesuffix(')')}, from the number of cases only"
    return [("Probability of exceeding a limit", value, note.replace(" %", f"{wording.BLANK}%"))]


def _setting_text(study: Study, case_id: str) -> str:
    """Return the swept values of a case, or its identity if there are many."""
    return study.setting(case_id) if len(study.swept()) <= MAX_LISTED_VALUES else f"case {wording.short_id(case_id)}"


def _worst_column(study: Study, figure: str) -> tuple[str, Joint | None]:
    """Return the column with the largest value of a figure, and its joint, or None for a figure of the mechanism."""
    of_mechanism = study.column(figure)
    if of_mechanism:
        return of_mechanism, None
    joint = max(study.joints, key=lambda joint: np.nan_to_num(study.cases.largest(joint.column(figure))))
    return joint.column(figure), joint
