"""Error against run time next to the rivals: `make bench`.

Problems, error and timing are those of `clearsweep verify`: every method has its turn in every round and the least
time counts.  Ours is the whole call of `clearsweep.simulate` with every figure of the summary; the rivals find the same
events and take nothing else along.
"""

import argparse
import json
import math
import os
import sys
from functools import partial
from importlib import import_module
from importlib.metadata import version

import numpy as np
import speed_page

from clearsweep.simulation.running.run import integration_of
from clearsweep.simulation.setup.scene import Scene
from clearsweep.simulation.setup.start import NO_TIMES
from clearsweep.verify import accuracy
from clearsweep.verify.accuracy import FLAGSHIP, HEADLINE_TOLERANCE, Method, all_problems, scene_of

from . import compiled, parts, stepwise

NAMES = (FLAGSHIP, "b_grav_fric", "ab_base")
ERRORS = tuple(10.0 ** (-6.0 - 0.5 * k) for k in range(9))  # at which times are compared
OURS, SCIPY, SODA = "clearsweep", "scipy DOP853", "numbalsoda DOP853"
ASKED = {SODA: 1.0 / 0.3, SCIPY: 150.0}  # how many times slower they are to be at equal error
ROUNDS = 5
DECADES = tuple(10.0**-k for k in range(5, 13))
HALVES = tuple(float(f"{10.0 ** (-0.5 * k):.0e}") for k in range(10, 26))  # 1e-5, 3e-6, ..., 1e-12, 3e-13
TIGHT = HALVES[8:]  # scipy's are relative to the coordinates, not to the clearance
RIVALS = {  # package -> what it needs; diffrax is in `ensemble` alone
    "numbalsoda": "it is built from source: `apt-get install -y g++ gfortran`, then `make bench` again",
    "heyoka": "it comes as a wheel or not at all",
}


def methods() -> tuple[list[Method], dict[str, str]]:
    """Return all methods that are installed, and the reasons why others are left out."""
    ours = next(method for method in accuracy.all_methods(quick=False) if method.name == "event-driven")
    result = [
        ours._replace(name=OURS, settings=HALVES),
        Method(SCIPY, "tolerance", TIGHT, stepwise.solve, stepwise.repeat),
        Method("numba DOP853", "tolerance", HALVES, compiled.solve, compiled.repeat),
    ]
    missing = {}
    for rival, remedy in RIVALS.items():
        try:
            import_module(rival)
        except ImportError as reason:
            missing[rival] = f"{reason}; {remedy}"
            continue
        if rival == "numbalsoda":
            from . import soda

            for name in soda.DRIVERS:
                solve, repeat = partial(soda.solve, method=name), partial(soda.repeat, method=name)
                settings = HALVES if name == "DOP853" else DECADES
                result.append(Method(f"numbalsoda {name}", "tolerance", settings, solve, repeat))
        else:
            from . import taylor

            result.append(Method(rival, "tolerance", DECADES, taylor.solve, taylor.repeat))
    return result, missing


def work_counts(scene: Scene) -> dict[str, int]:
    """Return the work counts of a scene's run, those of its events apart."""
    counts = integration_of(scene, NO_TIMES, scene.crank_clock.value_after(scene.case.simulate.revolutions)).work.counts
    return {
        "steps": int(counts.steps),
        "steps_rejected": int(counts.rejected),
        "rhs_evaluations": int(counts.evaluations),
        "rhs_evaluations_locating": int(counts.locating),
    }


def measure(repetitions: int, note) -> dict:
    """Return every figure; `note` is called with a sentence on what is being done."""
    chosen, missing = methods()
    result = accuracy.describe_measurement("make bench") | {"rounds": repetitions, "missing": missing, "problems": []}
    result["machine"] |= {name: version(name) for name in RIVALS if name not in missing} | {"load": os.getloadavg()[0]}
    for problem in all_problems():
        if problem.name in NAMES:
            note(f"{problem.name}: {problem.title}")
            able = [method for method in chosen if method.name != "heyoka" or problem.name == FLAGSHIP]
            result["problems"].append(accuracy.measure_problem(problem, able, repetitions, math.inf))
            if problem.name == FLAGSHIP:
                result["work"] = work_counts(scene_of(problem, HEADLINE_TOLERANCE))
    result["parts"] = parts.measure(repetitions, note)
    result["ratios"] = [ratio for entry in result["problems"] for ratio in ratios(entry)]
    return result


def least_time(entry: dict, method: str, error: float) -> float | None:
    """Return the least time (ms a revolution) in which a method errs by at most `error`, or None if it never does.

    The lower envelope over all its tolerances.  Motion with clearance amplifies every error: that of one tolerance is a
    sample, so a single one says little.
    """
    times = [
        row["ms_per_revolution"]
        for row in entry["rows"]
        if row["method"] == method and row["error_first_half"] and row["error_first_half"] <= error
    ]
    return min(times, default=None)


def ratios(entry: dict) -> list[dict]:
    """Return how many times slower each rival is than ours on one problem: geometric means over ERRORS."""
    result = []
    for method in dict.fromkeys(row["method"] for row in entry["rows"] if row["method"] != OURS):
        pairs = [(least_time(entry, method, error), least_time(entry, OURS, error)) for error in ERRORS]
        each = [float(theirs / ours) if theirs and ours else None for theirs, ours in pairs]
        known = [ratio for ratio in each if ratio]
        mean, asked = float(np.exp(np.mean(np.log(known)))) if known else None, ASKED.get(method)
        result.append(
            {
                "problem": entry["name"],
                "method": method,
                "over_ours": mean,
                "each": each,
                "asked": asked,
                "met": mean >= asked if mean and asked else None,
            }
        )
    return result


# ---------------------------------------------------------------------------------------------- what is printed

HEAD = (
    f"  {'method':<19}{'tolerance':>10}{'error, 1st half':>17}{'3 peaks':>10}{'events':>8}{'rhs':>9}{'ms/rev':>9}"
    f"{'integrating':>13}{'over ours':>11}"
)
EXPLANATION = (
    "error: as in `clearsweep verify`, over the first half of the revolution; 3 peaks: largest relative error of the",
    "    first three force peaks ('-': none requested); events: = means that number and order are exact.",
    "rhs: right-hand sides, those for events included; heyoka has none, its steps are series.",
    "ms/rev: processor time, which other programs disturb least; least of {rounds} interleaved rounds, compilation",
    "    excluded; ours: the whole call of clearsweep.simulate with every figure of the summary, no orbits;",
    "    integrating: the part of it within the integrator.",
    "over ours: over the least time in which clearsweep, at any of its tolerances, errs by no more than the row.",
)


def text(results: dict) -> str:
    """Return the tables and the figures that matter most."""
    machine = results["machine"]
    versions = ", ".join(
        f"{name} {machine[name]}" for name in ("python", "numpy", "numba", "scipy", *RIVALS) if name in machine
    )
    lines = [
        f"clearsweep {results['version']} and its rivals ({results['command']}, {results['date']})",
        f"{machine['processor']}, {machine['cores']} cores, {machine['system']}; load at the start "
        f"{machine['load']:.1f}; {versions}",
        *(f"left out: {name}: {reason}" for name, reason in results["missing"].items()),
    ]
    for entry in results["problems"]:
        lines += ["", f"{entry['name']}: {entry['title']} ({entry['events_expected']} events)", HEAD]
        lines += [_row(entry, row) for row in entry["rows"]]
    lines += ["", *(line.format(rounds=results["rounds"]) for line in EXPLANATION)]
    lines += ["", f"Least times for errors of at most {ERRORS[0]:g} to {ERRORS[-1]:g}, over those of clearsweep:"]
    lines += [f"  {'problem':<12} {'method':<18}{''.join(f'{error:>8.0e}' for error in ERRORS)}  geometric mean"]
    lines += [_ratio(ratio) for ratio in results["ratios"]]
    return "\n".join([*lines, "", *_work(results["work"]), "", *parts.lines(results["parts"])])


def _row(entry: dict, row: dict) -> str:
    def number(value, form):
        return "-" if value is None else format(value, form)

    ours = least_time(entry, OURS, row["error_first_half"]) if row["error_first_half"] else None
    events = f"{'=' if row['events_exact'] else ''}{row['events']}"
    over = number(row["ms_per_revolution"] / ours if ours else None, ".2f")
    return (
        f"  {row['method']:<19}{row['tolerance']:>10.0e}{number(row['error_first_half'], '.1e'):>17}"
        f"{number(row['peak_error_first_three'], '.1e'):>10}{events:>8}{number(row['rhs_evaluations'], 'd'):>9}"
        f"{row['ms_per_revolution']:>9.3g}{number(row['integration_ms_per_revolution'], '.3g'):>13}{over:>11}"
    )


def _ratio(ratio: dict) -> str:
    cells = "".join(f"{each:>8.3g}" if each else f"{'-':>8}" for each in ratio["each"])
    line = f"  {ratio['problem']:<12} {ratio['method']:<18}{cells}"
    if ratio["over_ours"] is None:
        return f"{line}  no error that both reach"
    line += f"  {ratio['over_ours']:.3g}: clearsweep takes {1.0 / ratio['over_ours']:.3f} of it"
    if ratio["asked"] is None:
        return line
    return f"{line}; asked {1.0 / ratio['asked']:.3g}: {'met' if ratio['met'] else 'missed'}"


def _work(work: dict) -> list[str]:
    tried = work["steps"] + work["steps_rejected"]
    return [
        f"What clearsweep does on {FLAGSHIP} at {HEADLINE_TOLERANCE:g}: {work['rhs_evaluations']} evaluations, "
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
        stamp = f"Written by `{results['command']} ARGS=--write` on {results['date']}."
        speed_page.write(
            "other programs", f"# Speed compared with other programs\n\n{stamp}\n\n```text\n{text(results)}\n```\n"
        )


if __name__ == "__main__":
    main()
