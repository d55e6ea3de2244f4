"""Spoils lines that decide numbers, one at a time in a copy, and sees that the tests named for each notice.

`python tests/mutate.py [WORD ...]` runs the mutations whose file or text contains one of the words, by default all; it
ends with 1 where one survives or no longer applies.  The tests run with the compiler off: a changed kernel would else
be compiled anew each time.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parent.parent
SLOWEST = 300.0  # s for the tests of one mutation; more is taken for a loop without an end, which a test run would show


class Mutation(NamedTuple):
    """A text that is once in a file of the package, what replaces it, and tests of which one must then fail."""

    file: str
    old: str
    new: str
    tests: str  # arguments of pytest


FIGURES, SUMS, OUTCOME = "simulation/figures.py", "simulation/sums.py", "simulation/outcome.py"
SPREAD, WORN = "simulation/spread.py", "simulation/wear_figures.py"
WINDOW = "tests/test_plain.py -k window"
WEAR = "tests/test_plain.py -k archard"
IMPACT = "tests/test_plain.py -k give"
FLIGHT = "tests/test_plain.py -k flight"
LIMIT = "tests/test_law_limit.py"
BLOCKS, MEANS = "simulation/batch_means.py", "tests/test_batch_means.py"
EVENTS, ACCEPTANCE, SPAN = (f"mechanics/solver/{name}.py" for name in ("event", "acceptance", "span"))
SEEN, SEARCH = "tests/test_plain.py -k unseen", "tests/test_event_search.py"
ENDS = "tests/test_plain.py -k at_its_bearing"
STICKS = "tests/test_plain.py -k stick"
SCENES = "tests/test_plain.py"
TOTALS, RAMPS = "mechanics/solver/accumulate/totals.py", "tests/test_tally.py"
FAST_PATH, BESIDE = "mechanics/solver/fast_path.py", "tests/test_side_by_side.py -k 'fast_path or fast'"
HISTOGRAM, ALONG = "mechanics/observe/histogram.py", "mechanics/solver/accumulate/step_sums.py"
STORE, SHARDS = "tests/test_store.py", "tests/test_shards.py"
STRANGERS = "tests/test_strangers.py -k 'not report'"
PRESSURE, PERSSON, ARCHARD = (f"mechanics/joint/wear/{name}.py" for name in ("pressure", "persson", "archard"))
BINS = "tests/test_every_wear_law.py"
PASSING, PASSES = "mechanics/joint/film/transition.py", "tests/test_every_transition.py"
FILMS, OIL = "mechanics/joint/film", "mechanics/joint/lubricated.py"
BALANCE, REYNOLDS, TIPS = (f"tests/test_{name}.py" for name in ("film_balance", "reynolds_film", "asperities"))
SHARES, IDEALS, HEAT = (f"tests/test_{name}.py" for name in ("shares_of_contact", "ideal_peaks", "heat"))
PATTERN, IDENTITY = "grid/pattern.py", "tests/test_grid.py -k 'id or demo or frame'"

MUTATIONS = (
    # figures of merit
    Mutation(OUTCOME, "return end - scene.crank_clock.at(scene.case.simulate.discard)", "return end", WINDOW),
    Mutation(OUTCOME, "settings.revolutions - settings.discard if scene", "settings.revolutions if scene", WINDOW),
    Mutation("simulation/window.py", "RARELY = 0.01", "RARELY = 0.02", WINDOW),
    Mutation(FIGURES, "sums=RootMean(total_columns.FORCE_SQUARE)", "sums=Mean(total_columns.FORCE_SQUARE)", WINDOW),
    Mutation(FIGURES, "clearance + depth(window, place)", "clearance", WINDOW),
    Mutation(FIGURES, "max(depth(window, place), 0.0)", "depth(window, place)", FLIGHT),
    Mutation(FIGURES, "total_columns.DEPTH_MAX], -window", "total_columns.DEPTH_MAX], 0.0 * window", FLIGHT),
    Mutation(FIGURES, "joint[total_columns.RESTITUTION] / joint", "1.0 / joint", IMPACT),
    Mutation(WORN, "joint.journal_radius * journal.sum()", "joint.bearing_radius * journal.sum()", WEAR),
    Mutation(WORN, "2.0 * math.pi / len(bearing) * law.length", "2.0 * math.pi / len(bearing)", WEAR),
    Mutation(WORN, "max(map(np.max, worn", "min(map(np.max, worn", WEAR),
    Mutation(OUTCOME, '== events.ONSET, "on", "off"', '!= events.ONSET, "on", "off"', SEEN),
    # what figures follow from, and their intervals
    Mutation(
        SUMS,
        'the mean over the window."""\n        return self.take(window.totals, place) / window.duration',
        'the mean."""\n        return self.take(window.totals, place)',
        WINDOW,
    ),
    Mutation(
        SUMS,
        "math.sqrt(self.take(window.totals, place) / window.duration)",
        "math.sqrt(self.take(window.totals, place))",
        WINDOW,
    ),
    Mutation(SUMS, "self.take(window.totals, place) / window.turns", "self.take(window.totals, place)", WINDOW),
    Mutation(
        SUMS, "self.take(window.totals, place).max() / window.duration", "self.take(window.totals, place).max()", WEAR
    ),
    Mutation(OUTCOME, "RARELY * duration", "0.5 * RARELY * duration", WINDOW),
    Mutation(SPREAD, "CONFIDENCE = 0.95", "CONFIDENCE = 0.9", MEANS),
    Mutation(SPREAD, "STRONGEST = 0.9 ", "STRONGEST = 0.95 ", MEANS),
    Mutation(SUMS, "0.5 + 0.5 * CONFIDENCE", "CONFIDENCE", MEANS),
    Mutation(SPREAD, "(1.0 + together) / (1.0 - together)", "1.0 / (1.0 - together)", MEANS),
    Mutation(SUMS, "count * (count - 1)", "count * count", MEANS),
    Mutation(SUMS, "stdtrit(count - 1", "stdtrit(count", MEANS),
    Mutation(SUMS, "0.5 * width / value if value", "width / value if value", MEANS),
    Mutation(SUMS, "(revolutions * (len(sums) - 1))", "(revolutions * len(sums))", MEANS),
    Mutation(SUMS, "np.argmax(depths[-1] - depths[0])", "np.argmin(depths[-1] - depths[0])", MEANS),
    Mutation(SUMS, "reshape(len(totals.joint), -1)[place]", "reshape(len(totals.joint), -1)[0]", MEANS),
    Mutation(SUMS, "0.5 * (force(RARELY - width)", "1.0 * (force(RARELY - width)", MEANS),
    Mutation(HISTOGRAM, "spent[place] * (high - force)", "spent[place] * (force - low)", MEANS),
    Mutation(SUMS, "least = LEAST_DRY * (", "least = 0.1 * (", SHARES),
    Mutation(SUMS, "half_width(part - ratio * whole)", "half_width(part)", SHARES),
    Mutation("simulation/largest.py", "slope[of, at] > STEEP * usual", "slope[of, at] < 0.0", IDEALS),
    Mutation("simulation/ideal.py", "np.union1d(even, knots)", "even", IDEALS),
    Mutation("simulation/heat.py", "converged = run > 0 and ", "converged = ", HEAT),
    Mutation("simulation/heat.py", "np.minimum(width, UNSURE * (rises - ambient))", "width", HEAT),
    Mutation(BLOCKS, "LEAST, MOST = 8, 32", "LEAST, MOST = 7, 32", MEANS),
    Mutation(BLOCKS, "LEAST, MOST = 8, 32", "LEAST, MOST = 8, 64", MEANS),
    Mutation(BLOCKS, "relative * abs(self.value)", "relative * self.value", MEANS),
    Mutation(BLOCKS, "del self.ends[1::2]", "del self.ends[0::2]", MEANS),
    Mutation(BLOCKS, "self.stride *= 2", "self.stride += 2", MEANS),
    # where events are
    Mutation(EVENTS, "SPANS = 8", "SPANS = 1", SEEN),
    Mutation(EVENTS, "MARGIN = 1.2", "MARGIN = 0.1", SEEN),
    Mutation(EVENTS, "return onset_in(at, j, h, Span(xa, da, sa, xb, db, sb))", "return xb", SEARCH),
    Mutation(EVENTS, "if da < 0.0 <= db:", "if da < 0.0 <= -db:", SEARCH),
    Mutation(EVENTS, "peaks = da < 0.0 and db < 0.0 and sa > 0.0 > sb", "peaks = False", SEARCH),
    Mutation(EVENTS, "/ (sb - sa) >= 0.0:", "/ (sb - sa) >= 1e9:", SEARCH),
    Mutation(SPAN, "0.5 * (depth_begin + depth_end + reach)", "0.5 * (depth_begin + depth_end)", SEARCH),
    Mutation(ACCEPTANCE, "middle = 0.5 * (second + third) +", "middle = 0.5 * (second + third) -", SEARCH),
    Mutation(EVENTS, "return crossing(at, (SEPARATION, j, 0.0), xa, xb)", "return xb", ENDS),
    Mutation(ACCEPTANCE, "lowest - dip, 1.0) > 0.0", "lowest - dip, 1.0) > -1.0", SCENES),
    Mutation(
        EVENTS,
        "if x < best:\n            best, kind, contact = x, what",
        "if x > best:\n            best, kind, contact = x, what",
        SCENES,
    ),
    # steps that are not looked at
    Mutation(FAST_PATH, "stepper[SPENT] = work.counts[EVALUATIONS]", "stepper[SPENT] += END * fast", BESIDE),
    Mutation(FAST_PATH, "choice[LEFT] -= stepper[FAST_STEPS]", "choice[LEFT] -= 0.0", BESIDE),
    Mutation(FAST_PATH, "due = min(due, turns.marks[mark])", "due = due", BESIDE),
    Mutation(FAST_PATH, "due = min(due, record.times[sample])", "due = due", BESIDE),
    Mutation(ACCEPTANCE, "(stepper[FAST_STEPS] < stepper[UNASKED])", "(stepper[FAST_STEPS] >= 0.0)", BESIDE),
    Mutation(ACCEPTANCE, "fast = settled & (", "fast = (step[ACCEPTED] < 0.0) & (", BESIDE),
    # the histogram and the sums
    Mutation(HISTOGRAM, "BIN_BITS = 8", "BIN_BITS = 4", RAMPS),
    Mutation(HISTOGRAM, "density * (bin_edge(first + 1) - low)", "density * (high - bin_edge(first + 1))", RAMPS),
    Mutation(HISTOGRAM, "where(crosses, bin_edge(last + 1), bin_edge(last))", "bin_edge(last)", RAMPS),
    Mutation(HISTOGRAM, "histogram[j, place, 1] +=", "histogram[j, place + 1, 1] +=", RAMPS),
    Mutation(HISTOGRAM, "first == last, last > first + 1,", "first == last, last > first + 2,", RAMPS),
    Mutation(HISTOGRAM, "Ramp(where(rises, lower, upper),", "Ramp(where(rises, upper, lower),", RAMPS),
    Mutation(TOTALS, "part.density - density", "part.density", RAMPS),
    Mutation(
        HISTOGRAM,
        "rest = float(totals[1 + bins[0]]) - duration",
        "rest = float(totals[1 + bins[0]]) + duration",
        RAMPS,
    ),
    Mutation(HISTOGRAM, "(totals[1:] >= duration) &", "(totals[1:] >= 2.0 * duration) &", RAMPS),
    Mutation(ALONG, "square + share * (force * force)", "square + share * force", WINDOW),
    Mutation(
        TOTALS,
        "begin, end = step[force + i], step[force + i + 1]",
        "begin, end = step[force + i], step[force + i]",
        RAMPS,
    ),
    Mutation(
        HISTOGRAM,
        "if step_values[DEPTH_COURSE, i] > limit:",
        "if step_values[DEPTH_COURSE, i] < limit:",
        LIMIT,
    ),
    Mutation(HISTOGRAM, "return beyond / total", "return beyond", LIMIT),
    Mutation(ALONG, "& (sign * fall < 0.0)", "& (sign * fall > 0.0)", WINDOW),
    Mutation(ALONG, "lost + share * o", "lost + 1.001 * share * o", IMPACT),
    # pressures and wear laws: each of them three times too large
    Mutation(PRESSURE, "return 1.0  # half-spaces", "return 3.0  # half-spaces", BINS),
    Mutation(PRESSURE, "return half / math.sin(half) if", "return 3.0 * half / math.sin(half) if", BINS),
    Mutation(PRESSURE, "return 4.0 * half * half", "return 12.0 * half * half", BINS),
    Mutation(PERSSON, "+ SUM[i]\n    return total", "+ SUM[i]\n    return 3.0 * total", BINS),
    Mutation(PRESSURE, "return 4.0 / math.pi", "return 12.0 / math.pi", BINS),
    Mutation(PRESSURE, "half):\n    return 1.0\n\n\nregister(", "half):\n    return 3.0\n\n\nregister(", BINS),
    Mutation(PRESSURE, "return 2.0 * sine * sine / (half", "return 6.0 * sine * sine / (half", BINS),
    Mutation(PERSSON, "+ PEAK[i]\n    return total", "+ PEAK[i]\n    return 3.0 * total", BINS),
    Mutation(PRESSURE, "min(pressure.spread *", "min(3.0 * pressure.spread *", BINS),
    Mutation(PRESSURE, "return 2.0 * total * math.sqrt(square)", "return 6.0 * total * math.sqrt(square)", BINS),
    Mutation(PERSSON, "return total * math.sqrt(z)", "return 3.0 * total * math.sqrt(z)", BINS),
    Mutation(PRESSURE, "0.5 + 0.5 * x, 0.0", "0.5 + 1.5 * x, 0.0", BINS),
    Mutation(PRESSURE, "0.5 + 0.5 * _overlap_before", "0.5 + 1.5 * _overlap_before", BINS),
    Mutation(PRESSURE, "0.5 - share * rest", "0.5 - 3.0 * share * rest", BINS),
    Mutation(PERSSON, "0.5 - share * rest", "0.5 - 3.0 * share * rest", BINS),
    Mutation(ARCHARD, "sliding = rubbing.pressed", "sliding = 3.0 * rubbing.pressed", BINS),
    Mutation(ARCHARD, "bearing_coefficient * rubbing.work", "bearing_coefficient * 3.0 * rubbing.work", BINS),
    Mutation(ARCHARD, "math.exp(-rubbing.slid /", "math.exp(-3.0 * rubbing.slid /", BINS),
    # from film to dry contact
    Mutation(
        PASSING,
        "(depth - transition.begin) / transition.width",
        "3.0 * (depth - transition.begin) / transition.width",
        PASSES,
    ),
    Mutation(PASSING, "as_type_of(1.0, depth)\n", "as_type_of(3.0, depth)\n", PASSES),
    Mutation(PASSING, "return 2.0 * transition.load", "return -2.0 * transition.load", PASSES),
    Mutation(OIL, "fx=rest * afloat.fx + share * pressed.fx", "fx=rest * afloat.fx + 3.0 * share * pressed.fx", PASSES),
    Mutation(
        OIL,
        "rest = afloat.contacts[0], pressed.contacts[0], 1.0 - share",
        "rest = afloat.contacts[0], pressed.contacts[0], 1.0",
        PASSES,
    ),
    Mutation(OIL, "elastic=rest * a.elastic + share", "elastic=rest * a.elastic + 3.0 * share", PASSES),
    # what is stored
    Mutation("store/directory.py", "np.argsort([-batch.written", "np.argsort([batch.written", STORE),
    Mutation("store/directory.py", 'rows["failed"], rows["id"]))]', 'rows["id"]))]', STORE),
    Mutation("store/directory.py", "[:HASH_LENGTH] != named_hash(path)", "[:HASH_LENGTH] == path.name", STORE),
    Mutation("store/directory.py", "(batch.orbits) == batch.sha256", "(batch.orbits) > ''", STORE),
    Mutation("store/directory.py", "if path not in needed)", "if False)", STORE),
    Mutation("store/directory.py", 'return f"{name}: missing"', "return None", STORE),
    Mutation("store/directory.py", "[:HASH_LENGTH] == named_hash(path)", "> ''", STORE),
    Mutation("store/directory.py", "not in (None, batch.frame)", "in ()", STRANGERS),
    Mutation("store/durable.py", "if kind != stat.S_IFREG:", "if False:", STRANGERS),
    Mutation("store/durable.py", "if _PASSING.fullmatch(name):", "if True:", STRANGERS),
    Mutation("store/read.py", "if actual != wanted:", "if False:", STRANGERS),
    Mutation("store/record.py", 'if record.get("checksum") != checksum:', "if False:", STRANGERS),
    Mutation("store/assemble.py", "return second << 16 | first", "return first << 16 | second", STRANGERS),
    Mutation("store/directory.py", "if present.get(path) != wanted.get(path)]", "if path not in present]", STORE),
    Mutation("store/directory.py", "if batch.name not in known]", "]", STORE),
    Mutation("store/durable.py", "os.fsync(file.fileno())", "pass", STORE),
    Mutation(
        "store/durable.py",
        "os.fsync(file.fileno())\n    sync(path.parent)",
        "os.fsync(file.fileno())\n    sync(path)",
        STORE,
    ),
    Mutation("store/durable.py", "except (OSError, RuntimeError) as error:", "except RuntimeError as error:", STORE),
    Mutation("store/batch.py", "valid = np.isfinite(numbers)", "valid = np.ones(len(numbers), bool)", STORE),
    Mutation("store/batch.py", 'if trajectory.status != "ok":', "if False:", STORE),
    Mutation("store/batch.py", '[joint][body == "journal"]', '[joint][body == "bearing"]', STORE),
    Mutation("store/batch.py", "numbers[words == word] = code", "numbers[words != word] = code", STORE),
    Mutation(
        "store/batch.py", "np.full((len(rows), *dataset.shape), np.nan)", "np.zeros((len(rows), *dataset.shape))", STORE
    ),
    Mutation("store/assemble.py", "reshape(-1, size).T.tobytes()", "reshape(-1, size).tobytes()", STORE),
    Mutation("store/assemble.py", "place += rows\n", "place += rows - 1\n", STORE),
    Mutation("store/assemble.py", "first[here], count[here] = starts[row],", "first[here], count[here] = 0,", STORE),
    Mutation("store/assemble.py", 'for column in ("id", "row"):', 'for column in ("id",):', STRANGERS),
    Mutation(
        "store/assemble.py", "order = np.argsort(np.concatenate(places))", "order = np.concatenate(places)", STORE
    ),
    Mutation(
        "store/assemble.py",
        "if merged == known:",
        "if True:",
        "tests/test_sweep.py -k merged_file",
    ),
    Mutation("store/compare.py", "if values[0] != values[1]:", "if len(values[0]) != len(values[1]):", SHARDS),
    Mutation("store/compare.py", "if name in TIMINGS or", "if", SHARDS),
    Mutation("store/read.py", "return max(records", "return min(records", "tests/test_store.py -k newest_run"),
    Mutation("store/read.py", "if not matching:", "if False:", STRANGERS),
    Mutation("store/read.py", "[place : place + 2] if stored", "[0:2] if stored", STORE),
    # identity of a case
    Mutation(
        PATTERN,
        '("mechanism", "drive", "loads", "life", "uncertain", "joints")',
        '("mechanism", "loads", "life", "uncertain", "joints")',
        IDENTITY,
    ),
    Mutation(
        PATTERN,
        '("mechanism", "drive", "loads", "life", "uncertain", "joints")',
        '("mechanism", "drive", "loads", "life", "uncertain", "joints", "save")',
        IDENTITY,
    ),
    Mutation(
        PATTERN, 'content | {"model_version": MODEL_VERSION}, sort_keys=True', "content, sort_keys=True", IDENTITY
    ),
    Mutation(PATTERN, "sort_keys=True, ", "", IDENTITY),
    Mutation(PATTERN, "hexdigest()[:16]", "hexdigest()[1:17]", IDENTITY),
    # versions of workers
    Mutation(
        "sweeping/worker.py",
        "if job.grid.case_id(first.grid_index) != first.case_id:",
        "if False:",
        "tests/test_driver.py -k version",
    ),
    # films
    Mutation(f"{FILMS}/contract.py", "return -couple - 0.5 * moment, couple", "return -couple, couple", BALANCE),
    Mutation(f"{FILMS}/contract.py", "couple - 0.5 * moment\n", "couple\n", BALANCE),
    Mutation(f"{FILMS}/shear.py", "as_type_of(shear.drag * rotation,", "as_type_of(-shear.drag * rotation,", BALANCE),
    Mutation(f"{FILMS}/shear.py", "math.sqrt(1.0 - motion.ratio * motion.ratio)", "1.0", BALANCE),
    Mutation(OIL, "spin=journal + bearing - 2.0 * across", "spin=journal - bearing - 2.0 * across", BALANCE),
    Mutation(OIL, "pumped=0.5 * eccentricity", "pumped=eccentricity", BALANCE),
    Mutation(OIL, "eccentricity * tangential)", "joint.clearance * tangential)", BALANCE),
    Mutation(f"{FILMS}/short.py", "radial = 0.5 * law.force", "radial = 0.4 * law.force", BALANCE),
    Mutation(f"{FILMS}/long.py", "radial -= 6.0 * law.force", "radial -= 5.0 * law.force", BALANCE),
    Mutation(f"{FILMS}/reynolds.py", "radial - turned * cosine", "radial + turned * cosine", REYNOLDS),
    Mutation(f"{FILMS}/reynolds.py", "turned * sine * stretch", "turned * sine", REYNOLDS),
    Mutation(f"{FILMS}/reynolds.py", "2.0 * pair * a * before", "2.0 * pair * a * after", REYNOLDS),
    Mutation(f"{FILMS}/reynolds.py", "share = math.exp(log_share)", "share = 1.0 + log_share", REYNOLDS),
    Mutation(f"{FILMS}/reynolds.py", "np.log(slenderness) - nodes", "np.log(1.05 * slenderness) - nodes", REYNOLDS),
    Mutation(f"{FILMS}/transition.py", "or plane_strain_modulus", "or 2.0 * plane_strain_modulus", TIPS),
    Mutation(f"{FILMS}/transition.py", "0.05308344", "0.05408344", TIPS),
    Mutation("grid/film_checks.py", "(min(lengths), max(radii))", "(max(lengths), max(radii))", REYNOLDS),
    Mutation("judging/validity.py", "if joint.fed > FED", "if joint.fed < FED", "tests/test_film.py -k remarks"),
)


def run(place: Path, tests: str) -> int:
    """Return how pytest ended, started in `place` without the compiler."""
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(place), "PYTHONDONTWRITEBYTECODE": "1"}
    words = [word.strip("'") for word in tests.split(" ", 2)]
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", "not slow and not compiled"]
    try:
        done = subprocess.run(
            [*command, *words], cwd=place, env=environment, capture_output=True, check=False, timeout=SLOWEST
        )
    except subprocess.TimeoutExpired:
        return 1
    return done.returncode


def spoiled(place: Path, mutation: Mutation) -> str:
    """Return what became of one mutation: 'killed', or what is wrong."""
    file = place / "clearsweep" / mutation.file
    whole = file.read_text(encoding="utf-8") if file.exists() else ""
    if whole.count(mutation.old) != 1:
        return f"NO LONGER APPLIES: the text is there {whole.count(mutation.old)} times"
    file.write_text(whole.replace(mutation.old, mutation.new), encoding="utf-8")
    try:
        code = run(place, mutation.tests)
    finally:
        file.write_text(whole, encoding="utf-8")
    return {0: "SURVIVES", 1: "killed"}.get(code, f"CANNOT BE TESTED: pytest ended with {code}")


def main() -> int:
    """Run the mutations that are asked for, and report what became of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("words", nargs="*")
    words = parser.parse_args().words
    chosen = [first for first in MUTATIONS if not words or any(word in f"{first.file} {first.old}" for word in words)]
    bad = []
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch)
        for name in ("clearsweep", "tests", "configs"):
            shutil.copytree(ROOT / name, place / name, ignore=shutil.ignore_patterns("__pycache__"))
        for name in ("pyproject.toml", "README.md"):
            shutil.copy(ROOT / name, place)
        for tests in dict.fromkeys(mutation.tests for mutation in chosen):
            if code := run(place, tests):
                sys.exit(f"{tests}: fails without a mutation (pytest ended with {code})")
        for number, mutation in enumerate(chosen, 1):
            begin = time.perf_counter()
            outcome = spoiled(place, mutation)
            bad += [mutation] if outcome != "killed" else []
            took = time.perf_counter() - begin
            change = f"{mutation.file}: {mutation.old!r} -> {mutation.new!r}"
            print(f"{number:3}/{len(chosen)} {took:5.1f} s  {change}: {outcome}", flush=True)
    print(f"{len(chosen) - len(bad)} of {len(chosen)} mutations killed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
