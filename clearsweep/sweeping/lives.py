"""The shortest and the longest life of a run, for its last lines."""

import operator
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..answers import lifetime
from ..contracts.layout import Layout
from ..language import wording

COMPARISONS = {"shortest": operator.lt, "longest": operator.gt}


class LifeExtremes:
    """Keeps the shortest and longest life of finished cases."""

    def __init__(self, layout: Layout, section: Mapping[str, Any]):
        """Prepare for the layout of a run and the section `life` of its grid; without a life nothing is kept."""
        column_names = {column.name for column in layout.columns}
        names = {name: f"{layout.life}_{name}" for name in lifetime.FIELD_BY_COLUMN} if layout.life else {}
        self.columns_by_name, self.joint = (
            {name: column for name, column in names.items() if column in column_names},
            layout.life,
        )
        self.columns = [*self.columns_by_name.values()]
        self.until = lifetime.criterion_text(section)
        self.unreached, self.widths = 0, list[float]()  # rad, smoothing of the worn shapes
        self.extremes: dict[str, dict[str, Any]] = {}  # key of COMPARISONS -> the case

    def add(self, block: Mapping[str, np.ndarray], describe: Callable[[int], dict[str, Any]]) -> None:
        """Add finished cases; describe : index in the block -> description of the case."""
        if not self.columns:
            return
        hours = block[self.columns[0]].astype(float)
        self.unreached += int(np.isnan(hours).sum())
        if np.isnan(hours).all():
            return
        if width_column := self.columns_by_name.get("wear_smoothing"):
            widths = block[width_column].astype(float)[np.isfinite(hours)]
            known = [*self.widths, *widths[np.isfinite(widths)].tolist()]
            self.widths = [min(known), max(known)] if known else []
        for index in dict.fromkeys((int(np.nanargmin(hours)), int(np.nanargmax(hours)))):
            life = lifetime.read_lifetime(
                {name: float(block[column].astype(float)[index]) for name, column in self.columns_by_name.items()}
            )
            for key, precedes in COMPARISONS.items():
                if key not in self.extremes or precedes(life.hours, self.extremes[key]["hours"]):
                    self.extremes[key] = describe(index) | {
                        "hours": life.hours,
                        "text": lifetime.hours_text(life),
                        "remarks": lifetime.remarks(life),
                    }

    def facts(self) -> dict[str, Any] | None:
        """Return both lives and the number of cases that did not reach their limit, for JSON, or None without lives."""
        return (
            {"joint": self.joint, "until": self.until, **self.extremes, "unreached": self.unreached}
            | {"omitted": lifetime.smoothing_sentences(self.widths)}
            if self.columns
            else None
        )


def life_lines(life: dict[str, Any] | None, setting: Callable[[dict[str, Any]], str]) -> list[str]:
    """Return the last lines on lives; setting : swept values of a case -> words."""
    if not life:
        return []
    until_text = f", {life['until']}" if life["until"] else ""
    lines, listed_ids = ["", "Answer"], []
    for key in COMPARISONS:
        if key in life and life[key]["case_id"] not in listed_ids:
            listed_ids.append(life[key]["case_id"])
            case_setting = setting(life[key]["swept"])
            setting_text = f" at {case_setting}" if case_setting else ""
            case_text = f"{setting_text} (case {wording.short_id(life[key]['case_id'])})"
            joint_text = "" if listed_ids[1:] else f" of joint {wording.joint_name(life['joint'])}{until_text}"
            lines.append(
                f"  {key.capitalize()} life{joint_text}: {life[key]['text']}{case_text}. "
                f"{' '.join(life[key]['remarks'])}"
            )
    lines += [f"  {sentence}" for sentence in life["omitted"]]
    if life["unreached"]:
        lines.append(f"  {wording.count_text(life['unreached'], 'case')} did not reach the limit.")
    return lines
