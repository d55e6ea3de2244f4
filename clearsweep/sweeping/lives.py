"""The shortest and the longest life of a run, for its closing lines."""

import operator
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..contracts.layout import Layout
from ..judging import lifetime
from ..language import wording

BETTER = {"shortest": operator.lt, "longest": operator.gt}


class Lives:
    """Keeps the shortest and longest life of finished cases."""

    def __init__(self, layout: Layout):
        """Prepare for the layout of a run; without a life nothing is kept."""
        there = {column.name for column in layout.columns}
        names = {name: f"{layout.life}_{name}" for name in lifetime.COLUMNS} if layout.life else {}
        self.named, self.joint = {name: column for name, column in names.items() if column in there}, layout.life
        self.columns = [*self.named.values()]
        self.unreached = 0
        self.ends: dict[str, dict[str, Any]] = {}  # key of BETTER -> the case

    def add(self, block: Mapping[str, np.ndarray], known: Callable[[int], dict[str, Any]]) -> None:
        """Add finished cases; known : index in the block -> description of the case."""
        if not self.columns:
            return
        hours = block[self.columns[0]].astype(float)
        self.unreached += int(np.isnan(hours).sum())
        if np.isnan(hours).all():
            return
        for place in dict.fromkeys((int(np.nanargmin(hours)), int(np.nanargmax(hours)))):
            life = lifetime.lifetime_of(
                {name: float(block[column].astype(float)[place]) for name, column in self.named.items()}
            )
            for word, better in BETTER.items():
                if word not in self.ends or better(life.hours, self.ends[word]["hours"]):
                    self.ends[word] = known(place) | {"hours": life.hours, "words": lifetime.interval_text(life)}

    def facts(self) -> dict[str, Any] | None:
        """Return both lives and the number of cases that did not reach their limit, for JSON; None without a life."""
        return {"joint": self.joint, **self.ends, "unreached": self.unreached} if self.columns else None


def life_lines(life: dict[str, Any] | None, setting: Callable[[dict[str, Any]], str]) -> list[str]:
    """Return the closing lines on lives; setting : swept values of a case -> words."""
    if not life:
        return []
    lines, listed = ["", f"Life of {wording.joint_name(life['joint'])}"], []
    for word in BETTER:
        if word in life and life[word]["case_id"] not in listed:
            listed.append(life[word]["case_id"])
            at = setting(life[word]["swept"])
            case = f"case {wording.short_id(life[word]['case_id'])}" + (f", {at}" if at else "")
            lines.append(f"  {word} {life[word]['words']}: {case}")
    if life["unreached"]:
        lines.append(f"  {wording.count(life['unreached'], 'case')} did not reach the limit")
    return lines
