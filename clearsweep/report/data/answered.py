"""The finished cases of a study, as the sentences that answer the question of a grid need them."""

from collections.abc import Sequence

import numpy as np

from ...judging import answer
from ...language import wording
from .study import Study
from .worst_case import question


def answers(study: Study) -> list[str]:
    """Return the sentences that answer the question of the grid; [] where a figure that ranks the cases is not kept."""
    if any(name not in study.cases for name in question(study).columns):
        return []
    return answer.sentences(answer_cases(study))


def answer_cases(study: Study) -> answer.Cases:
    """Return the finished cases of a study for `judging.answer`."""
    axes = {axis.path: axis for axis in study.swept()}
    ids = study.cases.index

    def column(name: str) -> np.ndarray:
        values: np.ndarray = study.cases[name].to_numpy()
        return values

    def setting(index: int, paths: Sequence[str]) -> str:
        known = [(axes[path], study.value(ids[index], path)) for path in paths if path in axes]
        return ", ".join(f"{axis.name} {axis.text(value)}" for axis, value in known if value is not None)

    def texts(name: str, values: Sequence[float]) -> list[str]:
        if name in (answer.FASTEST,):
            return [wording.scale("rad/s", value, speed=True).text(value) for value in values]
        return wording.in_common_unit(values, study.unit(name))

    return answer.Cases(
        study.run.grid, study.run.layout, question(study), tuple(axes), list(ids), column, texts, setting
    )
