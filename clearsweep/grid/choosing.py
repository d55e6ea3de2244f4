"""Describes the sections of a grid file that choose cases, for the page of keys and for `list`."""

from ..contracts.catalogue import Catalogue
from .axes import FORMS
from .fits import FORM
from .json_schema import schema
from .law_check import CHECK
from .limit_keys import SECTIONS
from .sampling import DISTRIBUTIONS, METHODS
from .uncertain import UNCERTAIN

_FIRST = ("name", "define", "sweep", "zip", "cases", "sample")
_SEARCHES = ("seek", "refine", "optimise", "identify")
_ADDED = {"added": "do not write it: run.json lists the added cases here"}
_CASES = "a table next to the grid, .csv or .parquet: a column per path, a row per case"
AXES = {**FORMS, "fits": "[H7/g6, H7/f7], of a radial clearance: the means of fits of ISO 286"}
LABELS = """\
An axis of `sweep`, `zip` or `cases` may give its values labels: `{bronze: 3e-15 m^2/N, PTFE: 1e-15 m^2/N}`. Tables,
figures and sentences show them. The column of summary.parquet keeps the numbers, and its metadata the labels. A label
contains a letter. The words above and the names of distributions are reserved."""
SAMPLES = {**DISTRIBUTIONS, "fit": f"{FORM}, of a radial clearance: between the limits of a fit"}

#: Key -> meaning, of each section with keys of its own.
KEYS = {
    "sample": {
        "method": "one of the designs below",
        "n": "number of points, at least 2",
        "seed": "a whole number, default 0; the same seed gives the same cases",
        "over": "dotted path -> distribution",
    },
    "seek": {
        "largest": "the path whose largest value is wanted, or several paths with a common value",
        "smallest": "the same for the smallest value",
        "between": "[low, high]: the range of the search",
        "within": "accuracy of the answer, at most a quarter of the range",
        "among": "{fits: [H7/g6, H7/f7]} instead of both: each fit counts with its largest clearance",
        "meeting": "`limits`, the default",
        "for": "`each` case of the other axes (default), or `all`: the worst case decides",
        **_ADDED,
    },
    "refine": {
        "along": "`limits`, the default: the border to follow",
        "cases": "most cases to add, a whole number",
        **_ADDED,
    },
    "optimise": {
        "over": "path -> [low, high], {among: [a, ...]} (laws, materials, fits, numbers) or {whole: [low, high]}",
        "minimise": "column or columns to minimise",
        "maximise": "column or columns to maximise",
        "cases": "most cases to add, a whole number",
        "seed": "a whole number, default 0",
        **_ADDED,
    },
    "identify": {
        "over": "dotted path -> [low, high], the range of its prior",
        "from": "CSV file next to the grid -> {channel: column} of the measured signals",
        "cases": "most cases to add, a whole number of at least 16",
        "features": "a list of rms, peaks, spectrum, impacts; default all",
        "seed": "a whole number, default 0",
        **_ADDED,
    },
}

#: Section -> its syntax.
EXAMPLES = {
    "name": "name: press-joint",
    "define": "define: {play: 50 um}   # used as `clearance: = play`",
    "sweep": "sweep: {drive.speed: [1000 rpm, 3000 rpm], joints.rod-slider.clearance: {linspace: [20 um, 80 um, 4]}}",
    "zip": "zip: {mechanism.rod.length: [120 mm, 140 mm], mechanism.rod.mass: [0.21 kg, 0.24 kg]}",
    "cases": "cases: cases.csv",
    "sample": "sample: {method: sobol, n: 64, over: {joints.rod-slider.clearance: {uniform: [20 um, 80 um]}}}",
    "figures": "figures: {amplification: rod_slider_load_peak / rod_slider_force_peak_ideal}",
    "limits": "limits: {rod_slider_force_peak: 5 kN, rod_slider_force_peak_ratio: {at_most: 3}}",
    "uncertain": "uncertain: {joints.rod-slider.wear.coefficient: {factor: 3}}",
    "seek": "seek: {largest: joints.rod-slider.clearance, between: [5 um, 200 um], within: 2 um, for: all}",
    "refine": "refine: {along: limits, cases: 100}",
    CHECK: "check_laws: true",
    "optimise": "optimise: {over: {drive.speed: [500 rpm, 3000 rpm]}, minimise: rod_slider_load_peak, cases: 60}",
    "identify": "identify: {over: {joints.rod-slider.clearance: [20 um, 300 um]}, from: {rig.csv: {slider/a: "
    "acceleration}}, cases: 400}",
}


def sections(catalogue: Catalogue) -> dict[str, str]:
    """Return section -> description, in the order of the page."""
    top = schema(catalogue)
    while "else" in top:  # those of any mechanism
        top = top["else"]
    keys = (*_FIRST, *SECTIONS, UNCERTAIN, *_SEARCHES, CHECK)
    texts = {key: top["properties"][key].get("description", "") for key in keys}
    return texts | {"cases": _CASES, "name": texts["name"].replace("<name>", "NAME")}


def markdown(catalogue: Catalogue) -> str:
    """Return the last part of the page of keys: these sections."""
    return "\n".join(
        [
            "## Choosing cases\n",
            *_table("key", "meaning", sections(catalogue)),
            "\nAn axis is a list of values, or one of\n",
            *_table("form", "contains", AXES),
            f"\n{LABELS}",
            *(line for name in _SEARCHES for line in (f"\n### `{name}`\n", *_table("key", "meaning", KEYS[name]))),
            "\n### `sample`\n",
            *_table("key", "meaning", KEYS["sample"]),
            "",
            *_table("design", "what it draws", METHODS),
            "",
            *_table("distribution", "contains", SAMPLES),
            "",
        ]
    )


def _table(heading: str, second: str, rows: dict[str, str]) -> list[str]:
    return [f"| {heading} | {second} |", "| --- | --- |", *(f"| `{key}` | {text} |" for key, text in rows.items())]
