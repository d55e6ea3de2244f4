"""Sentences on oil films: a combination that is safe under every condition, the range of the law, drivers and loss."""

from functools import partial
from typing import NamedTuple

import numpy as np

from ..language import wording
from . import designs, dominance, effects, labels
from .cases import FinishedCases

ROUGHNESSES = 3.0  # combined roughnesses of both surfaces that a film should exceed to separate them
NOT_MODELLED = "not modelled"
LISTED_OUTSIDE = LISTED_UNSAFE = 2  # cases outside the range of their law, unsafe combinations that a sentence names
LISTED_SAFE = 4  # other safe combinations that have a sentence
THICKNESS, DRY_SHARE, LOSS, LIMIT_FRACTION = "film_thickness_min", "dry_load_share", "film_loss", "film_limit_fraction"


class BestDesign(NamedTuple):
    """The combination of design values with the thickest film of those that are safe under every condition."""

    design_paths: tuple[str, ...]  # varied paths of a combination
    condition_paths: tuple[str, ...]  # the other varied paths
    thinnest_case: int  # index of the case with its thinnest film
    thickness: float  # m, its least film
    joint: str  # joint with this film
    loss: float  # W, its largest loss of all films; NaN: unknown
    has_least_loss: bool  # whether no other safe combination has a smaller largest loss
    safe_count: int  # number of safe combinations
    total_count: int  # number of combinations
    unsafe_examples: tuple[int, ...]  # index of a case of each unsafe combination
    others: tuple["SafeFilm", ...]  # the other safe combinations, the thickest film first


class SafeFilm(NamedTuple):
    """A safe combination of design values."""

    thinnest_case: int  # index of the case with its thinnest film
    thickness: float  # m, its least film
    joint: str  # joint with this film
    loss: float  # W, its largest loss of all films; NaN: unknown


def sentences(cases: FinishedCases) -> list[str]:
    """Return sentences on a safe combination, on the thinnest film and the range of its law, on drivers and on loss."""
    worst_case = cases.worst_case()
    if worst_case is None:
        return []
    index, (thinnest, *_), joint = worst_case
    thinnest_sentence = (
        f"Thinnest film{cases.joint_text(joint)}: "
        f"{cases.figure_text(thinnest, index)}{cases.setting_text(index)}{cases.case_text(index)}."
    )
    lines = [
        *_best_design_sentences(cases),
        " ".join([thinnest_sentence, *_law_range_sentences(cases, index, thinnest, joint)]),
    ]
    effect_sentences = effects.sentences(
        cases,
        cases.column_label(thinnest),
        cases.values_of(thinnest).astype(float),
        partial(cases.format_values, thinnest),
    )
    effect_sentences += dominance.sentences(cases, thinnest, f"{joint}_{LOSS}")
    lines += [" ".join(effect_sentences)] if effect_sentences else []
    lines += _loss_sentences(cases, joint)
    if not np.isnan(dry_share := float(cases.values_of(f"{joint}_{DRY_SHARE}")[index])):
        lines.append(f"Dry load share in the case of the thinnest film: {dry_share_text(dry_share)}.")
    return lines


def all_loss_sentences(cases: FinishedCases) -> list[str]:
    """Return sentences on the loss of each film, for a grid whose limits lead."""
    return [line for joint in _film_joints(cases) for line in _loss_sentences(cases, joint)]


def find_best_design(cases: FinishedCases) -> BestDesign | None:
    """Return the safe combination with the thickest film; None if no combination is safe, or only one was tried.

    A combination is safe if its film stays within the range of its law in all of its cases, and above ROUGHNESSES
    times the combined roughness of the surfaces if this is known.
    """
    joints, count = _film_joints(cases), len(cases.case_ids)
    if not joints or cases.record.get("sample"):
        return None
    paths, conditions = designs.split_axes(cases.varied_paths)
    groups = designs.group_cases(paths, cases.values_of, count)
    thicknesses = np.array([cases.values_of(f"{joint}_{THICKNESS}").astype(float) for joint in joints])
    least_thicknesses = np.where(np.isnan(thicknesses).any(axis=0), -np.inf, thicknesses.min(axis=0))
    is_safe = (least_thicknesses > 0.0) & ~_is_unsafe(cases, joints)
    loss_sums = sum(
        np.asarray(cases.values_of(f"{joint}_{LOSS}"), float) for joint in joints if cases.has_values(f"{joint}_{LOSS}")
    )
    losses = np.broadcast_to(np.nan if isinstance(loss_sums, int) else loss_sums, (count,))
    complete_size = max(map(len, groups))
    safe_groups = [group for group in groups if is_safe[group].all() and len(group) == complete_size]
    if not safe_groups or len(groups) == 1:
        return None
    ranked = sorted(safe_groups, key=lambda group: -float(least_thicknesses[group].min()))
    safe_films = []
    for group in ranked:
        thinnest_case = group[int(np.argmin(least_thicknesses[group]))]
        joint = joints[int(np.argmin(thicknesses[:, thinnest_case]))]
        safe_films.append(
            SafeFilm(thinnest_case, float(least_thicknesses[thinnest_case]), joint, float(losses[group].max()))
        )
    best_group, *others = safe_films
    return BestDesign(
        paths,
        conditions,
        *best_group,
        best_group.loss <= min(film.loss for film in safe_films),
        len(safe_groups),
        len(groups),
        tuple(group[0] for group in groups if group not in safe_groups),
        tuple(others),
    )


def design_text(cases: FinishedCases, best: BestDesign) -> str:
    """Return the values of a chosen combination in words."""
    return cases.values_text(best.thinnest_case, best.design_paths)


def conditions_text(best: BestDesign) -> str:
    """Return ' at every crank speed', or '' if no operating condition varies."""
    names = wording.sentence_list([wording.axis_name(path) for path in best.condition_paths])
    return f" at every {names}" if names else ""


def required_thickness(cases: FinishedCases, joint: str) -> np.ndarray | None:
    """Return ROUGHNESSES times the combined roughness (m) of a joint's surfaces in each case; None if it is unknown."""
    path = f"joints.{wording.joint_name(joint)}.film.transition.roughness"
    if path in cases.varied_paths:
        return ROUGHNESSES * cases.values_of(path).astype(float)
    value = _grid_value(cases, path)
    return np.full(len(cases.case_ids), ROUGHNESSES * value) if isinstance(value, float) else None


def law_end_thickness(cases: FinishedCases, joint: str) -> float | None:
    """Return the largest film (m) at which the law of a joint's film ends; None if the grid does not state it."""
    clearance_path, limit_path = (f"joints.{wording.joint_name(joint)}.{key}" for key in ("clearance", "film.limit"))
    clearances, limit_ratios = (
        cases.values_of(path).astype(float) if path in cases.varied_paths else _grid_value(cases, path)
        for path in (clearance_path, limit_path)
    )
    if clearances is None or limit_ratios is None:
        return None
    thicknesses = np.asarray(clearances, float) * (1.0 - np.asarray(limit_ratios, float))
    return float(np.nanmax(thicknesses)) if np.isfinite(thicknesses).any() else None


def find_cases_outside_law(cases: FinishedCases) -> tuple[np.ndarray, int]:
    """Return the indices of the cases outside the range of their film law, and the number of all cases."""
    is_outside = np.zeros(len(cases.case_ids), bool)
    for joint in _film_joints(cases):
        is_outside |= cases.values_of(f"{joint}_{LIMIT_FRACTION}").astype(float) > 0.0
    return np.flatnonzero(is_outside), len(is_outside)


def beyond_law_text(share: float) -> str:
    """Return the remark on a film that is thinner than its law covers for a share of the time."""
    return f"thinner than its law covers for {_percent_text(share)} of the time"


def dry_share_text(share: float) -> str:
    """Return a dry load share in words; NaN means that no contact behind the film is modelled."""
    return NOT_MODELLED if np.isnan(share) else _percent_text(share)


def _grid_value(cases: FinishedCases, path: str) -> object:
    value: object = cases.record
    for key in path.split("."):
        value = value.get(key) if isinstance(value, dict) else None
    return value


def _film_joints(cases: FinishedCases) -> list[str]:
    return [joint.name for joint in cases.layout.joints if cases.has_values(f"{joint.name}_{THICKNESS}")]


def is_unsafe(cases: FinishedCases) -> np.ndarray:
    """Return which cases (n,) have an unsafe film."""
    return _is_unsafe(cases, _film_joints(cases))


def _is_unsafe(cases: FinishedCases, joints: list[str]) -> np.ndarray:
    """Return which cases (n,) leave the range of a film law or are too thin for the surfaces' roughness."""
    is_unsafe = np.zeros(len(cases.case_ids), bool)
    is_unsafe[find_cases_outside_law(cases)[0]] = True
    for joint in joints:
        required = required_thickness(cases, joint)
        if required is not None:
            is_unsafe |= cases.values_of(f"{joint}_{THICKNESS}").astype(float) < required
    return is_unsafe


def _best_design_sentences(cases: FinishedCases) -> list[str]:
    """Return sentences on the safe combination with the thickest film, its loss, and the meaning of safe."""
    best = find_best_design(cases)
    if best is None:
        return _no_safe_design_sentences(cases)
    (film_text,) = cases.format_values(f"{best.joint}_{THICKNESS}", [best.thickness])
    text = f"{heading(best)}: {design_text(cases, best)}. Its film is at least {film_text}"
    if np.isfinite(best.loss):
        (loss_text,) = cases.format_values(f"{best.joint}_{LOSS}", [best.loss])
        text += f", its loss at most {loss_text}"
    text += "."
    if best.has_least_loss and best.safe_count > 1:
        text += " No other safe combination has a smaller largest loss."
    axes_at_end = _axes_at_range_end(cases, best)
    if axes_at_end:
        text += f" It is at the end of the range of {wording.sentence_list(axes_at_end)}: a better one may lie outside."
    criteria = safety_criteria_text(cases, best.joint)
    least_safe = min([best.thickness, *(film.thickness for film in best.others)])
    remarks = _premise_sentences(cases, best.joint, least_safe, "thinnest safe film")
    count_text = (
        f"{best.safe_count} of {wording.count_text(best.total_count, 'combination')} "
        f"{'is' if best.safe_count == 1 else 'are'} safe"
    )
    unsafe_texts = [
        f"{cases.values_text(index, best.design_paths)}{_unsafe_count_text(cases, index, best)}"
        for index in best.unsafe_examples
    ]
    unsafe_sentence = f" Unsafe: {'; '.join(unsafe_texts)}." if 0 < len(unsafe_texts) <= LISTED_UNSAFE else ""
    safe_text = f"{text} {count_text}{conditions_text(best)}: {criteria}.{unsafe_sentence}"
    return [safe_text, *_other_safe(cases, best), *remarks]


def _other_safe(cases: FinishedCases, best: BestDesign) -> list[str]:
    """Return a sentence on each of the other safe combinations, or [] if there is none."""
    sentences: list[str] = []
    for film in best.others[:LISTED_SAFE]:
        (thickness,) = cases.format_values(f"{film.joint}_{THICKNESS}", [film.thickness])
        loss_text = (
            f", loss at most {cases.format_values(f'{film.joint}_{LOSS}', [film.loss])[0]}"
            if np.isfinite(film.loss)
            else ""
        )
        setting = cases.values_text(film.thinnest_case, best.design_paths)
        sentences.append(
            f"{labels.capitalise(setting) if sentences else setting}: film at least {thickness}{loss_text}."
        )
    more = len(best.others) - LISTED_SAFE
    if more > 0:
        sentences.append(f"{more} more {'is' if more == 1 else 'are'} safe with thinner films.")
    return [" ".join(["Also safe:", *sentences])] if sentences else []


def heading(best: BestDesign) -> str:
    """Return the heading of a chosen combination: 'Thickest film at the worst crank speed'."""
    names = wording.sentence_list([wording.axis_name(path) for path in best.condition_paths])
    return f"Thickest film at the worst {names}" if names else "Thickest film"


def _axes_at_range_end(cases: FinishedCases, best: BestDesign) -> list[str]:
    """Return the names of the paths whose chosen value is the smallest or largest of at least two numbers."""
    names = []
    for path in best.design_paths:
        values = cases.values_of(path)
        if isinstance(values[best.thinnest_case], str) or len(set(values.tolist())) < 2:
            continue
        if float(values[best.thinnest_case]) in (float(np.min(values)), float(np.max(values))):
            names.append(wording.axis_name(path))
    return names


def _unsafe_count_text(cases: FinishedCases, index: int, best: BestDesign) -> str:
    """Return ' (1 of 3 cases)': how many cases of the combination of a case are unsafe; '' if all are."""
    groups = designs.group_cases(best.design_paths, cases.values_of, len(cases.case_ids))
    case_indices = next(group for group in groups if index in group)
    unsafe_count = int(_is_unsafe(cases, _film_joints(cases))[case_indices].sum())
    return f" ({unsafe_count} of {len(case_indices)} cases)" if unsafe_count < len(case_indices) else ""


def _no_safe_design_sentences(cases: FinishedCases) -> list[str]:
    """Return a sentence if no combination of several is safe; [] if there is only one combination or a sample."""
    joints = _film_joints(cases)
    if not joints or len(cases.case_ids) < 2 or cases.record.get("sample"):
        return []
    paths, conditions = designs.split_axes(cases.varied_paths)
    if len(designs.group_cases(paths, cases.values_of, len(cases.case_ids))) == 1:
        names = wording.sentence_list([wording.axis_name(path) for path in conditions])
        unsafe_count = int(_is_unsafe(cases, joints).sum())
        safety_text = (
            f"unsafe in {unsafe_count} of {wording.count_text(len(cases.case_ids), 'case')}"
            if unsafe_count
            else "safe in every case"
        )
        subject = f"Over {names}, the film is {safety_text}."
    else:
        subject = "No combination of the values is safe under every condition."
    joint, thickness = _thinnest(cases, joints)
    remarks = _premise_sentences(cases, joint, thickness, "thinnest film")
    return [f"{subject} Safe means {safety_criteria_text(cases, joint)}.", *remarks]


def _thinnest(cases: FinishedCases, joints: list[str]) -> tuple[str, float]:
    """Return the joint with the thinnest film of all cases, and this film (m)."""
    thicknesses = [float(np.nanmin(cases.values_of(f"{joint}_{THICKNESS}").astype(float))) for joint in joints]
    return joints[int(np.argmin(thicknesses))], min(thicknesses)


def safety_criteria_text(cases: FinishedCases, joint: str) -> str:
    """Return the criteria of a safe film: within its law, and thicker than the roughness if this is known."""
    if required_thickness(cases, joint) is None:
        return "within the range of the film law"
    return f"within the range of the film law and above {ROUGHNESSES:g} times the combined roughness"


def _premise_sentences(cases: FinishedCases, joint: str, thickness: float, name: str) -> list[str]:
    """Return what a safe film assumes, as one line: roughness, if the grid has none, and viscosity; [] if neither.

    thickness : m, of a film; name : of this film
    """
    lines, path = [], f"joints.{wording.joint_name(joint)}.film"
    if required_thickness(cases, joint) is None:
        column = f"{joint}_{THICKNESS}"
        film_text, roughness_text = cases.format_values(column, [thickness, thickness / ROUGHNESSES])
        lines += [
            f"No roughness is given: a film should exceed {ROUGHNESSES:g} times the combined roughness, the root of "
            "the summed squares of both surfaces.",
            f"The {name}, {film_text}, allows a combined roughness of {roughness_text}.",
        ]
    is_given = f"{path}.viscosity" in cases.varied_paths or isinstance(_grid_value(cases, f"{path}.viscosity"), float)
    if is_given and not _grid_value(cases, f"{path}.thermal"):
        lines.append("The viscosity is that of the warm oil in the running joint.")
    return [" ".join(lines)] if lines else []


def _law_range_sentences(cases: FinishedCases, index: int, thickness_column: str, joint: str) -> list[str]:
    """Return sentences on the cases that leave the range of their law, and on the thinnest film within it."""
    outside_cases, count = find_cases_outside_law(cases)
    if not len(outside_cases):
        return ["Every case is within the range of the film law."] if count > 1 else []
    share, lines = float(cases.values_of(f"{joint}_{LIMIT_FRACTION}")[index]), []
    if share > 0.0:
        lines.append(f"It is {beyond_law_text(share)}: do not rely on it.")
    total_text = wording.count_text(count, "case")
    lines.append(
        f"{count - len(outside_cases)} of {total_text} {'is' if count - len(outside_cases) == 1 else 'are'} within "
        "the law."
    )
    others = [other for other in outside_cases.tolist() if other != index]
    if others:
        settings_text = "; ".join(
            cases.setting_text(other).removeprefix(" at ").removeprefix(" in ") for other in others
        )
        lines.append(
            f"Outside, too: {settings_text}."
            if len(others) <= LISTED_OUTSIDE
            else _outside_sentence(cases, outside_cases)
        )
    thicknesses = cases.values_of(thickness_column).astype(float).copy()
    thicknesses[outside_cases] = np.nan
    if np.isfinite(thicknesses).any():
        thinnest_case = int(np.nanargmin(thicknesses))
        location = cases.difference_text(thinnest_case, index)
        lines.append(
            f"The thinnest that its law covers: {cases.figure_text(thickness_column, thinnest_case)}{location}."
        )
    return lines


def _outside_sentence(cases: FinishedCases, outside_cases: np.ndarray) -> str:
    """Return a sentence with the values that the cases outside the range of their law share, or with their number."""
    shared = [
        path for path in cases.varied_paths if len({str(cases.values_of(path)[case]) for case in outside_cases}) == 1
    ]
    if not shared:
        return f"The {len(outside_cases)} others leave it."
    return f"All {len(outside_cases)} outside have {cases.values_text(int(outside_cases[0]), shared)}."


def _loss_sentences(cases: FinishedCases, joint: str) -> list[str]:
    """Return sentences on the range of a film's loss and the effects on it."""
    loss_column = f"{joint}_{LOSS}"
    if not cases.has_values(loss_column):
        return []
    least_case, largest_case = cases.argmin_argmax(loss_column)
    least_text, largest_text = cases.figure_text(loss_column, least_case), cases.figure_text(loss_column, largest_case)
    name = labels.capitalise(cases.column_label(loss_column))
    if least_text == largest_text:
        return [f"{name}: {largest_text}."]
    text = f"{name}: {least_text} to {largest_text}. It is largest{cases.setting_text(largest_case)}."
    effect_sentences = effects.sentences(
        cases,
        cases.column_label(loss_column),
        cases.values_of(loss_column).astype(float),
        partial(cases.format_values, loss_column),
    )
    return [" ".join([text, *effect_sentences])]


def _percent_text(share: float) -> str:
    return f"{wording.short_number_text(100.0 * share, 3)}{wording.BLANK}%"
