"""Computes figures of one's own from the time histories of a case."""

import contextlib
import dataclasses
import math
import sys
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from ... import grid
from ...answers.validity import OWN_FIGURE, join_remarks
from ...contracts.case import Case, OwnFigure, Save
from ...contracts.layout import TIME
from ...contracts.results import Trajectory
from ...language.errors import InputError, did_you_mean, quoted
from ...mechanics.laws.contract import compile_law


def records_samples(case: Case) -> bool:
    """Return whether a run of a case records samples: some are saved, or figures of one's own need them."""
    return case.save.orbits != "none" or bool(case.figures)


def recorded_part(case: Case) -> Save:
    """Return settings that save at least what a run of a case records."""
    return case.save._replace(orbits="all") if case.figures else case.save


def first_sample(case: Case) -> int:
    """Return the number of the first sample that a run of a case records."""
    return min(_first_saved(case), _first_in_window(case)) if case.figures else _first_saved(case)


def _first_saved(case: Case) -> int:
    save, revolutions = case.save, case.simulate.revolutions
    return round((revolutions - save.revolutions) * save.samples) if save.orbits == "last" else 0


def _first_in_window(case: Case) -> int:
    return math.ceil(case.simulate.discard * case.save.samples - 1e-9)


def with_own_figures(case: Case, trajectory: Trajectory) -> Trajectory:
    """Return a trajectory with the figures of one's own of a case, and with the samples that the case saves only.

    A figure that fails, or gives no finite number, is missing, and a remark says why.
    """
    if not case.figures:
        return trajectory
    first = first_sample(case)
    histories = {name: values[_first_in_window(case) - first :] for name, values in trajectory.channels.items()}
    values, remarks = dict[str, float](), list[str]()
    for figure in case.figures if trajectory.status == "ok" else ():
        try:
            values[figure.name] = _value_of(figure, case, histories)
        except InputError as error:
            remarks.append(f"{OWN_FIGURE}figures.{figure.name}: {error}")
    saved = {name: samples[_first_saved(case) - first :] for name, samples in trajectory.channels.items()}
    return dataclasses.replace(
        trajectory,
        summary=trajectory.summary | values,
        message=join_remarks(trajectory.message, *remarks),
        channels={} if case.save.orbits == "none" else saved,
    )


class Channels(dict[str, np.ndarray]):
    """Time histories by the name of their channel."""

    unknown = ""  # a channel that was asked for in vain

    def __missing__(self, name: Any) -> np.ndarray:
        self.unknown = str(name)
        hint = did_you_mean(str(name), self) or f" (known: {', '.join(self)})"
        raise InputError(f"there is no channel {quoted(name)}{hint}")


def check_channels(case: Case, names: Iterable[str]) -> None:
    """Raise InputError if a figure of one's own reads a channel that a case does not have.

    The samples are made up, so that any other failure means nothing.
    """
    for figure in case.figures:
        channels, mistake = Channels({name: np.ones(2) for name in names}), ""
        try:
            with np.errstate(all="ignore"), grid.guarded(case.law_files):
                _evaluated(figure, case, channels)
        except InputError as error:
            mistake = str(error)
        if channels.unknown:
            raise InputError(f"figures.{figure.name}.law: {mistake}")


def _evaluated(figure: OwnFigure, case: Case, channels: Channels) -> Any:
    """Return what the function of a figure returns.  Raises InputError."""
    for samples in channels.values():
        samples.flags.writeable = False
    owner: Any = figure  # of the law, as a joint is of others
    evaluate: Callable = compile_law("figure", figure.law, owner)
    with grid.reported(case.law_files), contextlib.redirect_stdout(sys.stderr):
        return evaluate(channels[TIME], channels)


def _value_of(figure: OwnFigure, case: Case, histories: dict[str, np.ndarray]) -> float:
    """Return a figure from the samples of the window; raise InputError if it fails or gives no finite number."""
    value = _evaluated(figure, case, Channels({name: samples.view() for name, samples in histories.items()}))
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value.item()
    place = next(law.origin for file in case.law_files for law in file.laws if law.name == figure.law)
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise InputError(f"{place}: laws.figure '{figure.law}' gives {quoted(value)}; expected a number")
    if not math.isfinite(value):
        raise InputError(f"{place}: laws.figure '{figure.law}' gives {float(value)}; expected a finite number")
    return float(value)
