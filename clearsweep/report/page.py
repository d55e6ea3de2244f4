"""The report: one HTML file that carries everything it shows and asks nothing of the network."""

import os
from collections.abc import Mapping
from pathlib import Path

import jinja2
from markupsafe import Markup

from .. import wording
from . import cases, figures, findings, laws, probability, table
from .study import BASE, RATIO, Study, dig, prepare
from .table import SHOWN


def write(run, out: Path) -> Path:
    """Write the report of a run as one self-contained HTML file; the same run gives the same bytes."""
    return save(render(prepare(run)), Path(out))


def render(study: Study) -> str:
    """Return the page of a run as HTML."""
    canvas = figures.Canvas()
    record = study.run.grid
    return fill(
        "template.html.j2",
        name=record.get("name") or "clearsweep run",
        mechanism=study.mechanism,
        swept=study.swept(),
        study=study,
        cards=cards(study),
        sentences=findings.headline(study),
        decision=table.best_by_speed(study),
        sample=probability.part(study, canvas),
        method=(record.get("sample") or {}).get("method"),
        drivers=figures.drivers(study, canvas),
        effects=table.main_effects(study),
        laws=[(part, [draw(canvas) for draw in part.drawings]) for part in laws.parts(study)],
        maps=[(joint, figures.maps(study, joint, canvas)) for joint in study.joints],
        tradeoffs=figures.tradeoffs(study, canvas),
        detailed=cases.detailed(study, canvas),
        peaks=[table.peaks(study, joint) for joint in study.joints],
        slider=table.slider(study),
        certainty=table.certainty(study),
        wear=[(table.wear(study, joint), figures.wear(study, joint, canvas)) for joint in study.joints if joint.wears],
        failed=table.failed(study),
        reasons=reasons(study),
        fixed=fixed(study),
        derived=derived(study),
        warnings=record.get("warnings") or [],
        provenance=provenance(study),
        shown=SHOWN,
    )


def fill(template: str, **content) -> str:
    """Return a template of this package filled with content; text is escaped, drawings are not."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["drawing"] = Markup
    return environment.get_template(template).render(content)


def save(text: str, out: Path) -> Path:
    """Write a page so that it is either all there or not at all; return its path."""
    out.parent.mkdir(parents=True, exist_ok=True)
    temporary = out.with_name(f".{out.name}.part")
    temporary.write_text(text, encoding="utf-8")
    os.replace(temporary, out)
    return out


def cards(study: Study) -> list[tuple[str, str, str]]:
    """Return the figures at the top of the page: name, value with unit, what it is beside."""
    asked = len(study.cases) + len(study.failed)
    found = [
        (
            "Cases finished",
            f"{len(study.cases)} of {asked}",
            f"{len(study.failed)} failed" if len(study.failed) else "none failed",
        )
    ]
    if study.cases.empty:
        return found
    joint = study.hardest_joint()
    where = f"joint {joint.title}"
    for name, column, beside in (
        (f"Largest {study.lead.name}", joint.column(study.lead.figure), where),
        ("p99 over ideal peak", joint.column(RATIO), "1: as without clearance"),
        ("Largest force rms", joint.column("force_rms"), where),
        ("Fastest onset", joint.column("onset_rate_max"), f"steel elastic to {findings.ELASTIC_TEXT}"),
        ("Largest slider error", "slider_error_max", "off the ideal place"),
        ("Measured restitution", "pair_restitution", "largest of all cases"),
        ("Deepest wear", joint.column("wear_depth_max"), "in the recorded window"),
    ):
        if study.has(column):
            found.append((name, study.text(study.cases[column].idxmax(), column), beside))
    return found


def reasons(study: Study) -> list[tuple[str, int]]:
    """Return how many cases failed with which status, the most frequent first."""
    counted = study.failed["status"].value_counts(sort=False).items()
    return sorted(((str(status), int(count)) for status, count in counted), key=lambda one: (-one[1], one[0]))


def fixed(study: Study) -> list[tuple[str, str]]:
    """Return the values that every case shares: dotted path, value with unit."""
    swept = {axis.path for axis in study.axes}
    return [(path, _value(study, path, value)) for path, value in _leaves(study.base) if path not in swept]


def derived(study: Study) -> list[tuple[str, str]]:
    """Return what follows from the given values (such as a stiffness from a material): dotted path, range with unit."""
    found = []
    for path, one in (study.run.grid.get("derived") or {}).items():
        scale = wording.scale(one["unit"], (one["min"], one["max"]))
        ends = dict.fromkeys(scale.given(one[end], 4) for end in ("min", "max"))
        found.append((path, " to ".join(ends)))
    return found


def provenance(study: Study) -> list[tuple[str, str]]:
    """Return where the figures come from: versions, machine, times, counts, energy residual."""
    told = {key: value for key, value in study.run.grid.items() if key not in (*BASE, *_TOLD_ELSEWHERE) and value}
    if "sample" in told:
        told["sample"] = {key: value for key, value in told["sample"].items() if key != "drawn"}
    found = [(path.replace("_", " "), str(value)) for path, value in _leaves(told)]
    if study.has("energy_residual"):
        residual = study.cases["energy_residual"]
        found.append(("energy residual, largest", wording.plain(residual.max(), 2)))
        found.append(("energy residual, median", wording.plain(residual.median(), 2)))
    for column, name in (("steps", "accepted steps, all cases"), ("rhs_evaluations", "evaluations, all cases")):
        if study.has(column):
            found.append((name, wording.plain(study.cases[column].sum(), 4)))
    if study.has("run_time"):
        found.append(("integration time, all cases", wording.text(study.cases["run_time"].sum(), "s")))
    return found


_TOLD_ELSEWHERE = ("name", "sweep", "zip", "cases", "limits", "layout", "units", "keys", "frame", "derived", "warnings")


def _leaves(tree: Mapping, path: str = "") -> list[tuple[str, object]]:
    """Return the leaves of a nested mapping: dotted path, value."""
    found = []
    for key, value in tree.items():
        here = f"{path}.{key}" if path else str(key)
        found += _leaves(value, here) if isinstance(value, Mapping) else [(here, value)]
    return found


_UNITS = {
    "length": "m",
    "mass": "kg",
    "masses": "kg",
    "inertia": "kg*m^2",
    "center": "m",
    "gravity": "m/s^2",
    "clearance": "m",
    "bearing_radius": "m",
    "young": "Pa",
    "hardness": "Pa",
    "damping": "N*s/m",
    "v0": "m/s",
    "v1": "m/s",
    "velocity_scale": "m/s",
    "bearing_coefficient": "m^2/N",
    "journal_coefficient": "m^2/N",
}


def _value(study: Study, path: str, value) -> str:
    """Return a fixed value with its unit."""
    if isinstance(value, list):
        return ", ".join(_value(study, path, one) for one in value)
    if isinstance(value, str | bool) or not isinstance(value, int | float):
        return str(value)
    parent, _, leaf = path.rpartition(".")
    unit = study.units.get(path) or _UNITS.get(leaf, "1")
    if leaf == "speed":
        unit = "rad/s" if parent == "drive" else "m/s"
    elif leaf == "stiffness":
        exponent = dig(study.base, f"{parent}.exponent")
        unit = f"N/m^{exponent:g}" if exponent else "N/m"
    elif leaf == "coefficient" and parent.endswith("wear"):
        unit = "m^2/N"
    return wording.scale(unit, value, speed=path == "drive.speed").given(value)
