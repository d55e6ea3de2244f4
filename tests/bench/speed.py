"""Error against run time beside the rivals: `make bench`.

Problems, error and timing are those of `clearsweep verify`: every method has its turn in every round and the least
time counts.  Ours is the whole call of `clearsweep.simulate` with every figure of the summary; the rivals find the same
events and take nothing else along.
"""

import argparse
import json
import math
import os
import sys
import time
from functools import partial
from importlib import import_module
from importlib.metadata import version

import numpy as np
import speed_page
from scipy.optimize import isotonic_regression

from clearsweep.simulation.trajectory import work_counts
from clearsweep.verify import accuracy
from clearsweep.verify.accuracy import FLAGSHIP, ROUNDS, TOLERANCE, Method, row_of, time_at_error
from clearsweep.verify.problems import problems, scene_of

from . import parts

NAMES = (FLAGSHIP, "b_grav_fric", "ab_base")
ERROR = 2.5e-8  # at which times are compared
ERRORS = tuple(10.0 ** (-6.0 - 0.5 * k) for k in range(9))  # at which their ratio is averaged
OURS, SCIPY, SODA = "clearsweep", "scipy DOP853", "numbalsoda DOP853"
ASKED = {SODA: 1.0 / 0.3, SCIPY: 200.0}  # how many times slower they are to be at equal error
#: ms per revolution of numbalsoda's DOP853 on the flagship at ERROR over that of scipy's at 1e-9, when both were first
#: measured: a driver that is much slower is not the one that a ratio is quoted against.
FAIR, SLACK = 2.3 / 127.0, 2.5
TOLERANCES = tuple(10.0**-k for k in range(5, 13))
FEW = TOLERANCES[1:6]  # for a slow method: those that span ERROR
RIVALS = {  # package -> what it needs
    "numbalsoda": "it is built from source: `apt-get install -y g++ gfortran`, then `make bench` again",
    "heyoka": "it comes as a wheel or not at all",
}


def methods() -> tuple[list[Method], dict[str, str]]:
    """Return all methods that are installed, and the reasons why others are left out."""
    ours, scipy = (next(m for m in accuracy.methods(quick=False) if m.name == name) for name in ("event-driven", SCIPY))
    found, missing = [ours._replace(name=OURS, settings=TOLERANCES), scipy._replace(settings=FEW)], {}
    for rival, remedy in RIVALS.items():
        try:
            import_module(rival)
        except ImportError as reason:
            missing[rival] = f"{reason}; {remedy}"
            continue
        if rival == "numbalsoda":
            from . import soda

            found += [
                Method(
                    f"numbalsoda {name}",
                    "tolerance",
                    TOLERANCES,
                    partial(soda.solve, method=name),
                    partial(soda.repeat, method=name),
                )
                for name in soda.DRIVERS
            ]
        else:
            from . import taylor

            found.append(Method(rival, "tolerance", TOLERANCES, taylor.solve, taylor.repeat))
    return found, missing


def measure(rounds: int, note) -> dict:
    """Return every figure; `note` is called with a sentence on what is being done."""
    chosen, missing = methods()
    found = accuracy.stamp("make bench") | {"rounds": rounds, "missing": missing, "problems": []}
    found["machine"] |= {name: version(name) for name in RIVALS if name not in missing} | {"load": os.getloadavg()[0]}
    for problem in problems():
        if problem.name in NAMES:
            note(f"{problem.name}: {problem.title}")
            able = [method for method in chosen if method.name != "heyoka" or problem.name == FLAGSHIP]
            found["problems"].append(accuracy.measure_one(problem, able, rounds, math.inf, time.process_time))
            if problem.name == FLAGSHIP:
                found["work"] = work_counts(scene_of(problem, TOLERANCE))
    found["parts"] = parts.measure(rounds, note)
    found["ratios"] = [ratio for entry in found["problems"] for ratio in ratios(entry)]
    found["fair"] = fairness(found["problems"])
    return found


def in_order(entry: dict, method: str) -> dict:
    """Return an entry with a method's rows, their errors made to fall with the time by pooling those out of order.

    Motion with clearance amplifies every error: that of one tolerance is a sample, the mean of neighbours less so.
    """
    rows = sorted(
        (row for row in entry["rows"] if row["method"] == method and row["error_first_half"]),
        key=lambda row: row["ms_per_revolution"],
    )
    if not rows:
        return {"rows": []}
    pooled = isotonic_regression(np.log([row["error_first_half"] for row in rows]), increasing=False).x
    return {"rows": [row | {"error_first_half": float(np.exp(value))} for row, value in zip(rows, pooled, strict=True)]}


def time_of(entry: dict, method: str, error: float = ERROR) -> float | None:
    """Return the time (ms a revolution) at which a method reaches an error; None where its settings do not span it."""
    return time_at_error(in_order(entry, method), method, error)


def ratios(entry: dict) -> list[dict]:
    """Return how the methods compare at equal error on one problem."""
    ours = time_of(entry, OURS)
    found = []
    for method in dict.fromkeys(row["method"] for row in entry["rows"]):
        theirs = time_of(entry, method)
        slower = theirs / ours if ours and theirs else None
        asked = ASKED.get(method)
        found.append(
            {
                "problem": entry["name"],
                "method": method,
                "ms_per_revolution": theirs,
                "over_ours": slower,
                "asked": asked,
                "met": bool(slower >= asked) if slower and asked else None,
            }
        )
    return found


def fairness(entries: list[dict]) -> float | None:
    """Return numbalsoda's time over scipy's on the flagship, over what it was when first measured."""
    entry = next(entry for entry in entries if entry["name"] == FLAGSHIP)
    soda = time_of(entry, SODA)
    return soda / row_of(entry, SCIPY, TOLERANCE)["ms_per_revolution"] / FAIR if soda else None


# ---------------------------------------------------------------------------------------------- what is printed

HEAD = (
    f"  {'method':<19}{'tolerance':>10}{'error, 1st half':>17}{'3 peaks':>10}{'events':>8}{'rhs':>9}{'ms/rev':>9}"
    f"{'integrating':>13}{'over ours':>11}"
)
EXPLANATION = (
    "error: as in `clearsweep verify`, over the first half of the revolution; 3 peaks: largest relative error of the",
    "    first three force peaks ('-': none sought); events: = means that number and order are exact.",
    "rhs: right-hand sides, those for events included; heyoka has none, its steps are series.",
    "ms/rev: processor time, which other programs disturb least; least of {rounds} interleaved rounds, compilation",
    "    excluded; ours: the whole call of clearsweep.simulate with every figure of the summary, no orbits;",
    "    integrating: the part of it within the integrator, by the clock.",
    "over ours: over the time in which clearsweep reaches the row's error, on a log-log line between its tolerances.",
)


def text(results: dict) -> str:
    """Return the tables and the figures that matter most."""
    machine = results["machine"]
    versions = ", ".join(
        f"{name} {machine[name]}" for name in ("python", "numpy", "numba", "scipy", *RIVALS) if name in machine
    )
    lines = [
        f"clearsweep {results['version']} beside its rivals ({results['command']}, {results['date']})",
        f"{machine['processor']}, {machine['cores']} cores, {machine['system']}; load at the start "
        f"{machine['load']:.1f}; {versions}",
        *(f"left out: {name}: {reason}" for name, reason in results["missing"].items()),
    ]
    for entry in results["problems"]:
        lines += ["", f"{entry['name']}: {entry['title']} ({entry['events_expected']} events)", HEAD]
        lines += [_row(entry, row) for row in entry["rows"]]
    lines += ["", *(line.format(rounds=results["rounds"]) for line in EXPLANATION)]
    lines += ["", f"At equal error ({ERROR:g}; errors out of order pooled), ms a revolution:"]
    lines += [_ratio(ratio) for ratio in results["ratios"]]
    if results["fair"]:
        verdict = "fair" if results["fair"] <= SLACK else "too slow for a ratio to count"
        lines += [
            "",
            f"numbalsoda's driver takes {results['fair']:.2f} of the time, in units of scipy's, that it took "
            f"when first measured: {verdict} (at most {SLACK})",
        ]
    lines += ["", *(_mean(entry) for entry in results["problems"])]
    return "\n".join([*lines, "", *_work(results["work"]), "", *parts.lines(results["parts"])])


def _mean(entry: dict) -> str:
    """Return the mean of a rival's times over ours at several errors: a single one may hang on one lucky tolerance."""
    pairs = [(time_of(entry, OURS, error), time_of(entry, SODA, error)) for error in ERRORS]
    shares = [ours / theirs for ours, theirs in pairs if ours and theirs]
    if not shares:
        return f"  {entry['name']:<12} {SODA}: no time at any of these errors"
    mean = float(np.exp(np.mean(np.log(shares))))
    return (
        f"  {entry['name']:<12} over {SODA}, geometric mean over {len(shares)} errors from {ERRORS[0]:g} to "
        f"{ERRORS[-1]:g}: {mean:.3f}"
    )


def _row(entry: dict, row: dict) -> str:
    def number(value, form):
        return "-" if value is None else format(value, form)

    ours = time_of(entry, OURS, row["error_first_half"]) if row["error_first_half"] else None
    events = f"{'=' if row['events_exact'] else ''}{row['events']}"
    over = number(row["ms_per_revolution"] / ours if ours else None, ".2f")
    return (
        f"  {row['method']:<19}{row['tolerance']:>10.0e}{number(row['error_first_half'], '.1e'):>17}"
        f"{number(row['peak_error_first_three'], '.1e'):>10}{events:>8}{number(row['rhs_evaluations'], 'd'):>9}"
        f"{row['ms_per_revolution']:>9.3g}{number(row['integration_ms_per_revolution'], '.3g'):>13}{over:>11}"
    )


def _ratio(ratio: dict) -> str:
    start = f"  {ratio['problem']:<12} {ratio['method']:<18}"
    if ratio["over_ours"] is None:
        return f"{start} no time: the tolerances do not span the error"
    line = f"{start}{ratio['ms_per_revolution']:>9.3g}"
    if ratio["method"] == OURS:
        return line
    line += f"  clearsweep takes {1.0 / ratio['over_ours']:.3f} of it, is {ratio['over_ours']:.1f} times as fast"
    if ratio["asked"] is None:
        return line
    return f"{line}; asked {ratio['asked']:.1f} times: {'met' if ratio['met'] else 'missed'}"


def _work(work: dict) -> list[str]:
    tried = work["steps"] + work["steps_rejected"]
    return [
        f"What clearsweep does on {FLAGSHIP} at {TOLERANCE:g}: {work['rhs_evaluations']} evaluations, "
        f"{100.0 * work['rhs_evaluations_locating'] / work['rhs_evaluations']:.1f} % of them to locate events; "
        f"{tried} steps tried, {100.0 * work['steps_rejected'] / tried:.1f} % of them rejected",
    ]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="make bench", description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--write", action="store_true", help="write results/speed.md too")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help="interleaved rounds, of which the least time counts")
    asked = parser.parse_args()
    results = measure(asked.rounds, lambda what: print(f"bench: {what}", file=sys.stderr, flush=True))
    print(json.dumps(results, indent=2, allow_nan=False) if asked.json else text(results))
    if asked.write:
        speed_page.write_bench(
            f"# Speed beside others\n\nWritten by `{results['command']} ARGS=--write` on "
            f"{results['date']}.\n\n```text\n{text(results)}\n```\n"
        )


if __name__ == "__main__":
    main()
