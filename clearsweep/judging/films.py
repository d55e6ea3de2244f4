"""Sentences on oil films: a combination that is safe under every condition, the range of the law, drivers and loss."""

from functools import partial
from typing import NamedTuple

import numpy as np

from ..language import wording
from . import designs, dominance, effects, labels
from .cases import Cases

ROUGHNESSES = 3.0  # combined roughnesses of both surfaces that a film should exceed to separate them
NOT_MODELLED = "not modelled"
LISTED_OUTSIDE = LISTED_UNSAFE = 2  # cases outside the range of their law, unsafe combinations that a sentence names
LISTED_SAFE = 4  # other safe combinations that have a sentence
THICKNESS, SHARE, LOSS, OUTSIDE = "film_thickness_min", "dry_load_share", "film_loss", "film_limit_fraction"


class Choice(NamedTuple):
    """The combination of design values with the thickest film of those that are safe under every condition."""

    paths: tuple[str, ...]  # varied paths of a combination
    conditions: tuple[str, ...]  # the other varied paths
    thinnest: int  # index of the case with its thinnest film
    thickness: float  # m, its least film
    joint: str  # joint with this film
    loss: float  # W, its largest loss of all films; NaN: unknown
    has_least_loss: bool  # whether no other safe combination has a smaller largest loss
    safe: int  # number of safe combinations
    total: int  # number of combinations
    unsafe: tuple[int, ...]  # index of a case of each unsafe combination
    others: tuple["SafeFilm", ...]  # the other safe combinations, the thickest film first


class SafeFilm(NamedTuple):
    """A safe combination of design values."""

    thinnest: int  # index of the case with its thinnest film
    thickness: float  # m, its least film
    joint: str  # joint with this film
    loss: float  # W, its largest loss of all films; NaN: unknown


def sentences(cases: Cases) -> list[str]:
    """Return sentences on a safe combination, on the thinnest film and the range of its law, on drivers and on loss."""
    worst = cases.worst()
    if worst is None:
        return []
    index, (thinnest, *_), joint = worst
    head = (
        f"Thinnest film{cases.joint_text(joint)}: "
        f"{cases.text(thinnest, index)}{cases.setting_text(index)}{cases.case_text(index)}."
    )
    lines = [*_chosen(cases), " ".join([head, *_range_of_law(cases, index, thinnest, joint)])]
    moved = effects.sentences(
        cases, cases.label(thinnest), cases.column(thinnest).astype(float), partial(cases.texts, thinnest)
    )
    lines += [" ".join(moved)] if moved else []
    lines += [*dominance.sentences(cases, thinnest, f"{joint}_{LOSS}"), *_loss(cases, joint)]
    if not np.isnan(figure := float(cases.column(f"{joint}_{SHARE}")[index])):
        lines.append(f"Dry load share in the case of the thinnest film: {share_words(figure)}.")
    return lines


def losses(cases: Cases) -> list[str]:
    """Return sentences on the loss of each film, for a grid whose limits lead."""
    return [line for joint in _joints(cases) for line in _loss(cases, joint)]


def choice(cases: Cases) -> Choice | None:
    """Return the safe combination with the thickest film; None if no combination is safe, or only one was tried.

    A combination is safe if its film stays within the range of its law in all of its cases, and above ROUGHNESSES
    times the combined roughness of the surfaces if this is known.
    """
    joints, count = _joints(cases), len(cases.case_ids)
    if not joints or cases.record.get("sample"):
        return None
    paths, conditions = designs.divided(cases.axes)
    groups = designs.groups(paths, cases.column, count)
    films = np.array([cases.column(f"{joint}_{THICKNESS}").astype(float) for joint in joints])
    least = np.where(np.isnan(films).any(axis=0), -np.inf, films.min(axis=0))
    is_safe = (least > 0.0) & ~_unsafe(cases, joints)
    lossy = sum(np.asarray(cases.column(f"{joint}_{LOSS}"), float) for joint in joints if cases.has(f"{joint}_{LOSS}"))
    loss = np.broadcast_to(np.nan if isinstance(lossy, int) else lossy, (count,))
    complete = max(map(len, groups))
    safe = [group for group in groups if is_safe[group].all() and len(group) == complete]
    if not safe or len(groups) == 1:
        return None
    ranked = sorted(safe, key=lambda group: -float(least[group].min()))
    safe_films = []
    for group in ranked:
        thinnest = group[int(np.argmin(least[group]))]
        joint = joints[int(np.argmin(films[:, thinnest]))]
        safe_films.append(SafeFilm(thinnest, float(least[thinnest]), joint, float(loss[group].max())))
    best, *others = safe_films
    return Choice(
        paths,
        conditions,
        *best,
        best.loss <= min(film.loss for film in safe_films),
        len(safe),
        len(groups),
        tuple(group[0] for group in groups if group not in safe),
        tuple(others),
    )


def setting_of(cases: Cases, chosen: Choice) -> str:
    """Return the values of a chosen combination in words."""
    return cases.setting(chosen.thinnest, chosen.paths)


def every_condition(chosen: Choice) -> str:
    """Return ' at every crank speed', or '' if no operating condition varies."""
    names = wording.sentence_list([wording.axis_name(path) for path in chosen.conditions])
    return f" at every {names}" if names else ""


def needed(cases: Cases, joint: str) -> np.ndarray | None:
    """Return ROUGHNESSES times the combined roughness (m) of a joint's surfaces in each case; None if it is unknown."""
    path = f"joints.{wording.joint_name(joint)}.film.transition.roughness"
    if path in cases.axes:
        return ROUGHNESSES * cases.column(path).astype(float)
    value = _at(cases, path)
    return np.full(len(cases.case_ids), ROUGHNESSES * value) if isinstance(value, float) else None


def end_of_law(cases: Cases, joint: str) -> float | None:
    """Return the largest film (m) at which the law of a joint's film ends; None if the grid does not state it."""
    clearance, limit = (f"joints.{wording.joint_name(joint)}.{key}" for key in ("clearance", "film.limit"))
    sizes, ratios = (
        cases.column(path).astype(float) if path in cases.axes else _at(cases, path) for path in (clearance, limit)
    )
    if sizes is None or ratios is None:
        return None
    ends = np.asarray(sizes, float) * (1.0 - np.asarray(ratios, float))
    return float(np.nanmax(ends)) if np.isfinite(ends).any() else None


def outside_law(cases: Cases) -> tuple[np.ndarray, int]:
    """Return the indices of the cases outside the range of their film law, and the number of all cases."""
    outside = np.zeros(len(cases.case_ids), bool)
    for joint in _joints(cases):
        outside |= cases.column(f"{joint}_{OUTSIDE}").astype(float) > 0.0
    return np.flatnonzero(outside), len(outside)


def beyond_law(share: float) -> str:
    """Return the remark on a film that is thinner than its law covers for a share of the time."""
    return f"thinner than its law covers for {_percent(share)} of the time"


def share_words(share: float) -> str:
    """Return a dry load share in words; NaN means that no contact behind the film is modelled."""
    return NOT_MODELLED if np.isnan(share) else _percent(share)


def _at(cases: Cases, path: str) -> object:
    value: object = cases.record
    for key in path.split("."):
        value = value.get(key) if isinstance(value, dict) else None
    return value


def _joints(cases: Cases) -> list[str]:
    return [joint.name for joint in cases.layout.joints if cases.has(f"{joint.name}_{THICKNESS}")]


def _unsafe(cases: Cases, joints: list[str]) -> np.ndarray:
    """Return which cases (n,) leave the range of a film law or are too thin for the surfaces' roughness."""
    unsafe = np.zeros(len(cases.case_ids), bool)
    unsafe[outside_law(cases)[0]] = True
    for joint in joints:
        least = needed(cases, joint)
        if least is not None:
            unsafe |= cases.column(f"{joint}_{THICKNESS}").astype(float) < least
    return unsafe


def _chosen(cases: Cases) -> list[str]:
    """Return sentences on the safe combination with the thickest film, its loss, and the meaning of safe."""
    chosen = choice(cases)
    if chosen is None:
        return _none_safe(cases)
    (film,) = cases.texts(f"{chosen.joint}_{THICKNESS}", [chosen.thickness])
    text = f"{title(chosen)}: {setting_of(cases, chosen)}. Its film is at least {film}"
    if np.isfinite(chosen.loss):
        (loss,) = cases.texts(f"{chosen.joint}_{LOSS}", [chosen.loss])
        text += f", its loss at most {loss}"
    text += "."
    if chosen.has_least_loss and chosen.safe > 1:
        text += " No other safe combination has a smaller largest loss."
    edges = _edges(cases, chosen)
    if edges:
        text += f" It is at the end of the range of {wording.sentence_list(edges)}: a better one may lie outside."
    meaning = _meaning(cases, chosen.joint)
    count = f"{chosen.safe} of {wording.count(chosen.total, 'combination')} {'is' if chosen.safe == 1 else 'are'} safe"
    unsafe = [f"{cases.setting(index, chosen.paths)}{_unsafe_where(cases, index, chosen)}" for index in chosen.unsafe]
    others = f" Unsafe: {'; '.join(unsafe)}." if 0 < len(unsafe) <= LISTED_UNSAFE else ""
    return [f"{text} {count}{every_condition(chosen)}: {meaning}.{others}", *_other_safe(cases, chosen)]


def _other_safe(cases: Cases, chosen: Choice) -> list[str]:
    """Return a sentence on each of the other safe combinations, or [] if there is none."""
    sentences: list[str] = []
    for film in chosen.others[:LISTED_SAFE]:
        (thickness,) = cases.texts(f"{film.joint}_{THICKNESS}", [film.thickness])
        loss_text = (
            f", loss at most {cases.texts(f'{film.joint}_{LOSS}', [film.loss])[0]}" if np.isfinite(film.loss) else ""
        )
        setting = cases.setting(film.thinnest, chosen.paths)
        sentences.append(f"{labels.capital(setting) if sentences else setting}: film at least {thickness}{loss_text}.")
    more = len(chosen.others) - LISTED_SAFE
    if more > 0:
        sentences.append(f"{more} more {'is' if more == 1 else 'are'} safe with thinner films.")
    return [" ".join(["Also safe:", *sentences])] if sentences else []


def title(chosen: Choice) -> str:
    """Return the heading of a chosen combination: 'Thickest film at the worst crank speed'."""
    names = wording.sentence_list([wording.axis_name(path) for path in chosen.conditions])
    return f"Thickest film at the worst {names}" if names else "Thickest film"


def _edges(cases: Cases, chosen: Choice) -> list[str]:
    """Return the names of the paths whose chosen value is the smallest or largest of at least two numbers."""
    edges = []
    for path in chosen.paths:
        values = cases.column(path)
        if isinstance(values[chosen.thinnest], str) or len(set(values.tolist())) < 2:
            continue
        if float(values[chosen.thinnest]) in (float(np.min(values)), float(np.max(values))):
            edges.append(wording.axis_name(path))
    return edges


def _unsafe_where(cases: Cases, index: int, chosen: Choice) -> str:
    """Return ' (1 of 3 cases)': how many cases of the combination of a case are unsafe; '' if all are."""
    groups = designs.groups(chosen.paths, cases.column, len(cases.case_ids))
    members = next(group for group in groups if index in group)
    unsafe = int(_unsafe(cases, _joints(cases))[members].sum())
    return f" ({unsafe} of {len(members)} cases)" if unsafe < len(members) else ""


def _none_safe(cases: Cases) -> list[str]:
    """Return a sentence if no combination of several is safe; [] if there is only one combination or a sample."""
    joints = _joints(cases)
    if not joints or len(cases.case_ids) < 2 or cases.record.get("sample"):
        return []
    paths, conditions = designs.divided(cases.axes)
    if len(designs.groups(paths, cases.column, len(cases.case_ids))) == 1:
        names = wording.sentence_list([wording.axis_name(path) for path in conditions])
        unsafe = int(_unsafe(cases, joints).sum())
        said = f"unsafe in {unsafe} of {wording.count(len(cases.case_ids), 'case')}" if unsafe else "safe in every case"
        return [f"Over {names}, the film is {said}. Safe means {_meaning(cases, joints[0])}."]
    return [f"No combination of the values is safe under every condition. Safe means {_meaning(cases, joints[0])}."]


def _meaning(cases: Cases, joint: str) -> str:
    """Return the criteria of a safe film: within its law, and thicker than the roughness if this is known."""
    if needed(cases, joint) is None:
        return (
            "within the range of the film law. No roughness is given: compare the films with "
            f"{ROUGHNESSES:g} times the combined roughness of the surfaces"
        )
    return f"within the range of the film law and above {ROUGHNESSES:g} times the combined roughness"


def _range_of_law(cases: Cases, index: int, thinnest: str, joint: str) -> list[str]:
    """Return sentences on the cases that leave the range of their law, and on the thinnest film within it."""
    outside, count = outside_law(cases)
    if not len(outside):
        return ["Every case is within the range of the film law."] if count > 1 else []
    share, said = float(cases.column(f"{joint}_{OUTSIDE}")[index]), []
    if share > 0.0:
        said.append(f"It is {beyond_law(share)}: do not rely on it.")
    of_cases = wording.count(count, "case")
    said.append(f"{count - len(outside)} of {of_cases} {'is' if count - len(outside) == 1 else 'are'} within the law.")
    others = [place for place in outside.tolist() if place != index]
    if others:
        listed = "; ".join(cases.setting_text(place).removeprefix(" at ").removeprefix(" in ") for place in others)
        said.append(f"Outside, too: {listed}." if len(others) <= LISTED_OUTSIDE else _many_outside(cases, outside))
    films = cases.column(thinnest).astype(float).copy()
    films[outside] = np.nan
    if np.isfinite(films).any():
        least = int(np.nanargmin(films))
        at = cases.at_difference(least, index)
        said.append(f"The thinnest that its law covers: {cases.text(thinnest, least)}{at}.")
    return said


def _many_outside(cases: Cases, outside: np.ndarray) -> str:
    """Return a sentence with the values that the cases outside the range of their law share, or with their number."""
    shared = [path for path in cases.axes if len({str(cases.column(path)[place]) for place in outside}) == 1]
    if not shared:
        return f"The {len(outside)} others leave it."
    return f"All {len(outside)} outside have {cases.setting(int(outside[0]), shared)}."


def _loss(cases: Cases, joint: str) -> list[str]:
    """Return sentences on the range of a film's loss and the effects on it."""
    loss = f"{joint}_{LOSS}"
    if not cases.has(loss):
        return []
    least, largest = cases.extremes(loss)
    low, high = cases.text(loss, least), cases.text(loss, largest)
    name = labels.capital(cases.label(loss))
    if low == high:
        return [f"{name}: {high}."]
    text = f"{name}: {low} to {high}. It is largest{cases.setting_text(largest)}."
    moved = effects.sentences(cases, cases.label(loss), cases.column(loss).astype(float), partial(cases.texts, loss))
    return [" ".join([text, *moved])]


def _percent(share: float) -> str:
    return f"{wording.short(100.0 * share, 3)}{wording.BLANK}%"
