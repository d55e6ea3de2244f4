"""Writes results/inverse.md from the measurements of rigs.py, optima.py and kills.py: `python tests/inverse_page.py`.

Each of these scripts appends lines to a file below results/inverse, so that an interrupted run can be continued.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import optima
import rigs

FOLDER = Path(__file__).parents[1] / "results" / "inverse"
PAGE = FOLDER.with_suffix(".md")
HEAD = """\
# Inverse questions, measured

Written by `python tests/inverse_page.py` from the files in `results/inverse`, by model version {version}.

## `identify`

{rigs} made-up rigs, `python tests/rigs.py`, with {cases} cases each. A rig has 30 revolutions of acceleration with 2 %
noise, an unknown gain and an unknown angle. Clearance, restitution, stiffness and friction are unknown. Signals are
computed with a tolerance of 1e-9, cases with 1e-7. Each rig was measured twice: with the law of the model, and with
`flores`, which the model does not have.
"""
RIG_COLUMNS = "| true clearance, um | 95 % interval, um | half-width | with `flores`, um | half-width |"
OPTIMISE = """\
## `optimise`

Three problems, `python tests/optima.py`, each with a brute force over a regular grid and {seeds} starts of 300 cases.
A negative difference is better than the brute force, whose grid is coarse next to a limit.
"""
KILLS = """\
## Kills

`python tests/kills.py` kills runs with SIGKILL at random moments and starts them again. Each answer is compared with
that of an undisturbed run.
"""


def rows(name: str) -> list[dict[str, Any]]:
    """Return the measurements of a script, or [] if it has not run."""
    file = FOLDER / f"{name}.jsonl"
    return [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()] if file.exists() else []


def table(head: str, lines: list[str]) -> str:
    """Return a table of Markdown."""
    return "\n".join([head, "| --- " * (head.count("|") - 1) + "|", *lines])


def identify(measured: list[dict[str, Any]]) -> str:
    """Return the intervals of all rigs, and their summary."""
    laws = {law: {row["seed"]: row for row in measured if row["law"] == law} for law in ("", "flores")}
    lines = []
    for seed, row in laws[""].items():
        both = [row, laws["flores"].get(seed)]
        cells = [cell for each in both for cell in (_interval(each), each and f"{100.0 * each['half_width']:.1f} %")]
        lines.append(f"| {row['true'][rigs.CLEARANCE] * 1e6:.1f} | {' | '.join(cell or '-' for cell in cells)} |")
    return table(RIG_COLUMNS, lines) + "\n\n" + _in_all(laws)


def _interval(row: dict[str, Any] | None) -> str:
    if row is None:
        return "-"
    low, _, high, _ = row["found"][rigs.CLEARANCE]
    text = ("" if row["inside"] else ", outside") + ("" if row["explained"] else ", misfit reported")
    return f"{low * 1e6:.1f} to {high * 1e6:.1f}{text}"


def _in_all(laws: dict[str, dict[int, dict[str, Any]]]) -> str:
    lines = []
    for law, mine in laws.items():
        each = list(mine.values())
        inside, misfits = sum(row["inside"] for row in each), sum(not row["explained"] for row in each)
        good = sum(row["inside"] or not row["explained"] for row in each)
        counts = f"{len(each)} | {inside} | {misfits} | {good}"
        width = 100.0 * np.median([row["half_width"] for row in each])
        lines.append(f"| {f'`{law}`' if law else 'of the model'} | {counts} | {width:.1f} % |")
    return table("| law | rigs | true clearance inside | misfit reported | either | half-width, median |", lines)


def again(measured: list[dict[str, Any]]) -> str:
    """Return the results of the first rigs with a later model version, '' if they were not repeated."""
    if not measured:
        return ""
    inside, width = sum(row["inside"] for row in measured), np.median([row["half_width"] for row in measured])
    versions = " and ".join(sorted({str(row["model_version"]) for row in measured}))
    return (
        f"The first {len(measured)} rigs were measured again with model version {versions} "
        f"(`--out results/inverse/rigs_again.jsonl`): the true clearance is inside in {inside}, the half-width "
        f"{100.0 * width:.1f} % in the median."
    )


def times(measured: list[dict[str, Any]]) -> str:
    """Return the processor time (s) of runs without their cases."""
    own = [row["processor_seconds_beside_the_cases"] for row in measured]
    text = f"{np.median(own):.1f} s in the median, {max(own):.1f} s at most"
    return (
        f"Processor time apart from the cases, of {len(own)} runs (`--out results/inverse/rigs_times.jsonl`):\n{text}. "
        "Other programs on the same cores lengthen it."
    )


def optimise(measured: list[dict[str, Any]]) -> str:
    """Return the best cases of every problem relative to those of its brute-force search."""
    lines = []
    for name in optima.PROBLEMS:
        known, starts = optima.compared(measured, name)
        share, worst, own = optima.shares(known, starts, len(optima.PROBLEMS[name]["minimise"]))
        what = "difference" if len(optima.PROBLEMS[name]["minimise"]) == 1 else "hypervolume"
        cases = f"{known['cases']:,} | {len(starts)}"
        lines.append(f"| {name} | {cases} | {what} | {share:.2f} % | {worst:.2f} % | {own:.2f} s |")
    head = "| problem | brute force | starts | figure | median | worst | processor time apart from the cases |"
    return table(head, lines)


def kills(measured: list[dict[str, Any]]) -> str:
    """Return the number of killed runs, and their differences."""
    lines = [
        f"| `{row['of']}` | {', '.join(f'{count} {kind}' for kind, count in row['kills'].items())} | {row['runs']} | "
        f"{'; '.join(row['wrong']) or 'nothing'} |"
        for row in measured
    ]
    return table("| run | killed | runs | other than undisturbed |", lines)


def page() -> str:
    """Return the page."""
    of_rigs, of_optima, of_kills = (rows(name) for name in ("rigs", "optima", "kills"))
    rigs_measured = len({row["seed"] for row in of_rigs})
    head = HEAD.format(version=of_rigs[0]["model_version"], rigs=rigs_measured, cases=of_rigs[0]["cases"])
    seeds = len({row["seed"] for row in of_optima}) - 1
    own = [identify(of_rigs), again(rows("rigs_again")), times(rows("rigs_times"))]
    parts = [head, *own, OPTIMISE.format(seeds=seeds), optimise(of_optima), KILLS, kills(of_kills)]
    return "\n\n".join(part.strip() for part in parts if part) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
