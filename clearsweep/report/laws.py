"""What the choice of a law does: forces law by law, the spread between laws, restitution asked for and given back."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pandas as pd

from .. import simulation, wording
from ..errors import InputError
from . import draw, findings, stiffness
from .figures import Canvas, Picture
from .study import Axis, Joint, Study, dig, joint_of, resolved
from .table import Column, Quantity, Table

CHOICES = (".contact.law", ".contact.elastic", ".friction.law")  # paths within a joint that name a law
FIGURES = (("force_peak", "force peak"), ("force_p99", "force p99"), ("force_rms", "force rms"))
ASKED = 5  # values of the restitution that are told at most, evenly from the least to the largest


class Part(NamedTuple):
    """What a report says about the choice of one law."""

    key: str
    title: str
    sentences: list[str]
    tables: list[Table]
    drawings: list[Callable[[Canvas], Picture]]


class Matched(NamedTuple):
    """Cases that differ in one law alone, side by side."""

    axis: Axis
    pairs: pd.DataFrame  # columns group, law, case_id

    def table(self, study: Study, column: str) -> pd.DataFrame:
        """Return a figure (SI) by group and law, of the groups in which at least two laws have it above zero."""
        values = study.cases[column].reindex(self.pairs["case_id"]).to_numpy()
        known = self.pairs.assign(value=values)[values > 0.0]
        table = known.pivot_table(index="group", columns="law", values="value", aggfunc="median")
        return table[table.count(axis=1) > 1]

    def case(self, group: int, law: str) -> str:
        """Return the id of the case of a law in a group."""
        return self.pairs.loc[(self.pairs["group"] == group) & (self.pairs["law"] == law), "case_id"].iloc[0]


def parts(study: Study) -> list[Part]:
    """Return one part for each law that is swept, and one for each joint whose material allows other elastic laws."""
    if study.cases.empty:
        return []
    axes = [axis for axis in study.swept() if axis.path.endswith(CHOICES)]
    swept = {axis.path for axis in axes}
    found = [_part(study, axis) for axis in axes]
    for joint in study.joints:
        if f"joints.{joint.title}.contact.elastic" not in swept:
            told = stiffness.of_material(study, joint)
            title = f"What another elastic law would give in joint {joint.title}"
            found += [Part(f"other_elastic_{joint.name}", title, *told)] if told else []
    return found


def tables(study: Study) -> list[Table]:
    """Return the tables about the choice of laws."""
    return [table for part in parts(study) for table in part.tables]


def matched(study: Study, axis: Axis) -> Matched:
    """Return the cases that share all swept values but those of one axis.

    A value that a law does not use keeps no case apart: such a case stands beside each that shares what it uses.
    """
    others = [other.path for other in study.swept() if other is not axis]
    codes = pd.DataFrame({path: pd.factorize(study.cases[path])[0] for path in others}, index=study.cases.index)
    groups = codes.drop_duplicates().rename_axis(None).reset_index(drop=True).rename_axis("group").reset_index()
    used = [tuple(path for path in others if code[path] >= 0) for code in codes.to_dict("records")]
    found = []
    for on in dict.fromkeys(used):
        rows = codes[[one == on for one in used]].reset_index()[["case_id", *on]]
        found.append(groups[["group", *on]].merge(rows, **({"on": list(on)} if on else {"how": "cross"})))
    pairs = pd.concat(found, ignore_index=True)[["group", "case_id"]]
    return Matched(axis, pairs.assign(law=study.cases[axis.path].reindex(pairs["case_id"]).to_numpy()))


def _part(study: Study, axis: Axis) -> Part:
    """Return what the report says about one swept law."""
    beside = matched(study, axis)
    joint = next(joint for joint in study.joints if axis.path.startswith(f"joints.{joint.title}."))
    spread = _spread(study, beside)
    found = [spread, *(_forces(study, beside, one) for one in study.joints)]
    sentences = [_spread_told(study, axis, spread)]
    drawings = [_strip(study, axis, one, *figure) for one in study.joints for figure in _figures(study, one)]
    more = ([], [], [])
    if axis.path.endswith(".contact.law"):
        more = _restitution(study, axis, joint)
    elif axis.path.endswith(".contact.elastic"):
        more = stiffness.of_axis(study, axis, joint)
    found = [table for table in (*found, *more[1]) if table.rows]
    return Part(_key(axis), f"What the choice of {axis.name} does", sentences + more[0], found, drawings + more[2])


def _figures(study: Study, joint: Joint) -> list[tuple[str, str]]:
    """Return the forces of a joint that are compared: column, name; a percentile of few impacts says nothing."""
    pair = study.mechanism == "impact-pair"
    found = [(joint.column(figure), name) for figure, name in FIGURES if not (pair and figure == "force_p99")]
    return [one for one in found if study.has(one[0])]


def _forces(study: Study, beside: Matched, joint: Joint) -> Table:
    """Return the forces of one joint law by law."""
    axis, figures = beside.axis, _figures(study, joint)
    heads, ratios = [], {}
    for column, name in figures:
        heads += [
            Column(name, "N"),
            Column(f"{name}, smallest", "N", file_only=True),
            Column(f"{name}, largest", "N", file_only=True),
            Column(f"{name.removeprefix('force ')} beside other laws"),
        ]
        table = beside.table(study, column)
        ratios[column] = table.div(table.median(axis=1), axis=0).median()
    rows = []
    for law in axis.values:
        here, cells = study.cases[study.cases[axis.path] == law], []
        for column, _ in figures if len(here) else ():
            low, middle, high = here[column].min(), here[column].median(), here[column].max()
            scale = wording.scale("N", middle)
            span = f" ({scale.number(low)} to {scale.number(high)})" if len(here) > 1 else ""
            cells += [Quantity(middle, scale.text(middle) + span), low, high, float(ratios[column].get(law, np.nan))]
        rows += [(law, Quantity(len(here), str(len(here))), *cells)] if cells else []
    note = (
        "Median (smallest to largest) of all finished cases with the law. Beside other laws: the figure over the "
        "median of all laws at otherwise equal values; the median of these ratios."
    )
    return Table(
        f"{_key(axis)}_{joint.name}",
        f"Forces in joint {joint.title}, by {axis.name}",
        note,
        (Column(axis.name), Column("cases"), *heads),
        rows,
    )


def _spread(study: Study, beside: Matched) -> Table:
    """Return by which factor each figure differs between laws at otherwise equal values."""
    rows = []
    for joint in study.joints:
        for column, name in _figures(study, joint):
            table = beside.table(study, column)
            if table.empty:
                continue
            factor = table.max(axis=1) / table.min(axis=1)
            worst = table.loc[factor.idxmax()].dropna()
            ends = (worst.idxmin(), worst.idxmax())
            rows.append(
                (
                    name,
                    joint.title,
                    Quantity(len(table), str(len(table))),
                    float(factor.median()),
                    float(factor.max()),
                    *(
                        cell
                        for law in ends
                        for cell in (Quantity(worst[law], f"{wording.text(worst[law], 'N')}, {law}"), law)
                    ),
                    study.setting(beside.case(factor.idxmax(), ends[0]), without=beside.axis),
                )
            )
    columns = (
        Column("figure"),
        Column("joint"),
        Column("comparisons"),
        Column("factor, median"),
        Column("factor, largest"),
        Column("there: from", "N"),
        Column("law of the smallest", file_only=True),
        Column("to", "N"),
        Column("law of the largest", file_only=True),
        Column("at"),
    )
    return Table(
        f"{_key(beside.axis)}_spread",
        f"Spread between the {_plural(beside.axis)}",
        "Largest over smallest value among the laws, at otherwise equal values.",
        columns,
        rows,
    )


def _spread_told(study: Study, axis: Axis, spread: Table) -> str:
    """Return the spread in the joint that bears the largest force in a sentence."""
    hardest = study.hardest_joint()
    rows = {name: rest for name, title, *rest in spread.rows if title == hardest.title}
    if "force peak" not in rows:
        return f"No two finished cases differ in the {axis.name} alone: what follows does not compare like with like."
    said = [
        f"the {name} by a factor of {wording.plain(median)} (at most {wording.plain(largest)})"
        for name, (_, median, largest, *_) in rows.items()
    ]
    where = f" in joint {hardest.title}" if len(study.joints) > 1 else ""
    count = rows["force peak"][0].value
    told = (
        f"At otherwise equal values the choice among {len(axis.values)} {_plural(axis)} changes "
        f"{wording.sentence_list(said)}{where}" + (f", the median of {count} comparisons." if count > 1 else ".")
    )
    effect = next((one for one in findings.effects(study, hardest.column("force_peak")) if one.axis is axis), None)
    if effect is not None and not effect.clear() and rows["force peak"][1] >= findings.CLEAR_FACTOR:
        told += (
            " For the peak that is within the scatter: it is a single event, and part of its spread is chance; "
            "p99 and rms compare laws better."
        )
    return told


def _strip(study: Study, axis: Axis, joint: Joint, column: str, name: str) -> Callable[[Canvas], Picture]:
    """Return the drawing of one point per case, law by law."""
    groups = [(law, study.cases.loc[study.cases[axis.path] == law, column].dropna().to_numpy()) for law in axis.values]
    groups = sorted((one for one in groups if len(one[1])), key=lambda one: np.median(one[1]))
    scale = study.scale(column)
    title = f"{name[0].upper()}{name[1:]} by {axis.name}" + (f", joint {joint.title}" if len(study.joints) > 1 else "")
    alt = f"{title}, medians. " + "; ".join(f"{law}: {scale.text(np.median(values))}" for law, values in groups)
    return lambda canvas: canvas.picture(
        lambda ax: draw.strip(ax, groups, name, scale),
        title,
        "One point per case; bar: median.",
        alt,
        size=(4.2, 1.0 + 0.22 * len(groups)),
    )


def _restitution(study: Study, axis: Axis, joint: Joint) -> tuple[list[str], list[Table], list]:
    """Return sentence, table and drawing of restitution asked for and given back, law by law."""
    path = f"joints.{joint.title}.contact.restitution"
    asked = study.cases[path] if path in study.cases else dig(study.base, path)
    points = pd.DataFrame({"law": study.cases[axis.path], "asked": asked}, index=study.cases.index).astype(
        {"asked": float}
    )
    known = np.sort(points["asked"].dropna().unique())
    told = known[np.unique(np.linspace(0, len(known) - 1, ASKED).round().astype(int))] if len(known) else known
    firsts = points.drop_duplicates()
    firsts = firsts[firsts["asked"].isna() | firsts["asked"].isin(told)]
    try:
        contacts = [joint_of(case, joint) for case in resolved(study, firsts.index)]
    except InputError:
        return [stiffness.UNKNOWN], [], []
    measured = study.has("pair_restitution")
    rows = []
    for (law, value), section in zip(firsts.itertuples(index=False), contacts, strict=True):
        wanted, got = section.contact.values.get("restitution", np.nan), simulation.restitution(section)
        got = np.nan if got is None else got
        same = (points["law"] == law) & (points["asked"].isna() if np.isnan(value) else points["asked"] == value)
        rows.append(
            (
                law,
                wanted,
                got,
                Quantity(got - wanted, _signed(got - wanted)),
                *([float(study.cases.loc[same, "pair_restitution"].median())] if measured else []),
            )
        )
    rows.sort(key=lambda row: (np.isnan(row[1]), row[1], axis.values.index(row[0])))
    note = (
        f"Of a free impact, in closed form, whatever the elastic law. {wording.DASH}: the law takes none, "
        "or mass and speed decide what it gives back (kelvin-voigt and others)."
    )
    columns = (
        Column(axis.name),
        Column("asked for"),
        Column("given back"),
        Column("difference"),
        *([Column("measured here")] if measured else []),
    )
    table = Table(f"{_key(axis)}_restitution", "Restitution asked for and given back", note, columns, rows)
    drawn = [row[:3] for row in rows if not np.isnan(row[2])]
    return _restitution_told(rows), [table], [_returned(axis, drawn)] if drawn else []


def _restitution_told(rows: list[tuple]) -> list[str]:
    """Return how far apart laws are that are asked for the same restitution, at the value where they are farthest."""
    spans = []
    for asked in {row[1] for row in rows if not np.isnan(row[1])}:
        given = sorted((row[2], row[0]) for row in rows if row[1] == asked and not np.isnan(row[2]))
        spans += [(given[-1][0] - given[0][0], asked, given[0], given[-1])] if given else []
    if not spans:
        return []
    widest, asked, least, most = max(spans)
    if widest < 5e-4:
        return ["In a free impact each of these laws gives back the restitution that it is asked for, or all the same."]
    return [
        f"Asked for a restitution of {wording.short(asked, 3)}, a free impact gives back {wording.plain(least[0])} "
        f"({least[1]}) to {wording.plain(most[0])} ({most[1]})."
    ]


def _returned(axis: Axis, rows: list[tuple[str, float, float]]) -> Callable[[Canvas], Picture]:
    names = {row[0] for row in rows}
    alt = "; ".join(f"{law}, asked for {asked:.3g}: {got:.3g}" for law, asked, got in rows)
    return lambda canvas: canvas.picture(
        lambda ax: draw.returned(ax, rows),
        "Restitution given back",
        "Of a free impact, beside what was asked for.",
        f"Restitution by {axis.name}. {alt}",
        size=(4.2, 1.15 + 0.22 * len(names)),
    )


def _key(axis: Axis) -> str:
    """Return 'laws_rod_slider_contact_law' for 'joints.rod-slider.contact.law'."""
    return axis.path.replace("joints.", "laws_", 1).replace(".", "_").replace("-", "_")


def _plural(axis: Axis) -> str:
    return axis.name.replace("law", "laws", 1)


def _signed(difference: float) -> str:
    return wording.DASH if np.isnan(difference) else f"{difference:+.4f}".replace("-", wording.MINUS)
