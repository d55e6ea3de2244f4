"""Mutates code that determines numbers, one place at a time in a copy, and checks that each mutation fails its tests.

`python tests/mutate.py [WORD ...]` runs the mutations whose file, function or pattern contains one of the words, by
default all; the exit code is 1 if one survives or no longer applies.  The tests run with the compiler off, because a
changed kernel would be compiled anew each time.
"""

import argparse
import ast
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parent.parent
SLOWEST = 300.0  # s for the tests of one mutation; more is taken for a loop without an end, which a test run would show


class Mutation(NamedTuple):
    """A pattern that is once in a function or constant, its replacement, and tests of which one must then fail."""

    file: str
    where: str  # name of the function, of the method (`Class.method`), or of the constant
    old: str  # Python; line breaks, spaces and a comma before a closing bracket need not be those of the file
    new: str
    tests: str  # arguments of pytest

    def applied(self, source: str) -> str:
        """Return the mutated text of the file; LookupError says why the mutation no longer applies."""
        sections = [section for name, section in named(ast.parse(source)) if name == self.where]
        if len(sections) != 1:
            raise LookupError(f"{self.where} is there {len(sections)} times")
        lines = source.splitlines(keepends=True)
        first, last = sections[0]
        head, body, tail = ("".join(part) for part in (lines[: first - 1], lines[first - 1 : last], lines[last:]))
        changed, count = pattern(self.old).subn(lambda _: self.new, body)
        if count != 1:
            raise LookupError(f"{self.where} has the pattern {count} times")
        return head + changed + tail


def named(tree: ast.Module | ast.ClassDef, prefix: str = "") -> Iterator[tuple[str, tuple[int, int]]]:
    """Yield (name, (first line, last line)) of every function, method and constant of a module."""
    for node in tree.body:
        lines = node.lineno, node.end_lineno or node.lineno
        if isinstance(node, ast.FunctionDef):
            yield prefix + node.name, lines
        elif isinstance(node, ast.ClassDef):
            yield from named(node, f"{prefix}{node.name}.")
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            for name in (part.id for target in targets for part in ast.walk(target) if isinstance(part, ast.Name)):
                yield prefix + name, lines


def pattern(text: str) -> re.Pattern[str]:
    """Return what matches `text` however the formatter breaks its lines, and only whole words and numbers of it."""
    tokens = re.findall(r"\w+|\S", text)
    parts = [rf",?\s*{re.escape(token)}" if token in ")]}" else re.escape(token) for token in tokens]
    begin = r"\b" if re.match(r"\w", tokens[0]) else ""
    end = r"\b" if re.match(r"\w", tokens[-1]) else ""
    return re.compile(begin + r"\s*".join(parts) + end)


FIGURES, SUMS, OUTCOME = (
    "simulation/figures/catalogue.py",
    "simulation/figures/sums.py",
    "simulation/analyses/outcome.py",
)
SPREAD, WORN = "simulation/figures/window.py", "simulation/figures/wear.py"
WINDOW = "tests/test_plain.py -k window"
WEAR = "tests/test_plain.py -k archard"
IMPACT = "tests/test_plain.py -k give"
FLIGHT = "tests/test_plain.py -k flight"
LIMIT = "tests/test_law_limit.py"
JUDGE, VERDICT, JUDGED_CASES = "answers/judge.py", "answers/verdict.py", "answers/judged.py"
JUDGED = "tests/test_judge.py"
BLOCKS, MEANS = "simulation/figures/catalogue.py", "tests/test_batch_means.py"
EVENTS, BERNSTEIN = (f"mechanics/solver/{name}.py" for name in ("event_search", "collocation"))
SEEN, SEARCH = "tests/test_plain.py -k unseen", "tests/test_event_search.py"
ENDS = "tests/test_plain.py -k at_its_bearing"
STICKS = "tests/test_plain.py -k stick"
SCENES = "tests/test_plain.py"
TOTALS, RAMPS = "mechanics/solver/totals.py", "tests/test_tally.py"
HISTOGRAM, ALONG = "mechanics/observe.py", "mechanics/solver/totals.py"
STORE, SHARDS = "tests/test_store.py", "tests/test_shards.py"
STRANGERS = "tests/test_strangers.py -k 'not report'"
CONDITIONS = "tests/test_blocks.py -k conditions"
PRESSURE = "mechanics/wear/laws.py"
BINS = "tests/test_every_wear_law.py"
FILM, FILMS, OIL = "mechanics/laws/film.py", "mechanics/laws/reynolds.py", "mechanics/joints/lubricated.py"
PASSES = "tests/test_every_transition.py"
BALANCE, REYNOLDS, TIPS = (f"tests/test_{name}.py" for name in ("film_balance", "reynolds_film", "asperities"))
SHARES, IDEALS, HEAT = (f"tests/test_{name}.py" for name in ("shares_of_contact", "ideal_peaks", "heat"))
ROWS, PLANAR = "mechanics/machines/planar/constraints.py", "tests/test_planar.py"
CASES, IDENTITY = "grid/cases.py", "tests/test_grid.py -k 'id or demo or frame'"

MUTATIONS = (
    # figures of merit
    Mutation(OUTCOME, "_duration", "end - scene.crank_clock.value_after(scene.case.simulate.discard)", "end", WINDOW),
    Mutation(
        OUTCOME,
        "window_of",
        "settings.revolutions - settings.discard if scene",
        "settings.revolutions if scene",
        WINDOW,
    ),
    Mutation("simulation/figures/window.py", "RARE_SHARE", "0.01", "0.02", WINDOW),
    Mutation(FIGURES, "JOINT", 'sums=RootMean("force_square")', 'sums=Mean("force_square")', WINDOW),
    Mutation(FIGURES, "JOINT", "clearance + depth(window, index)", "clearance", WINDOW),
    Mutation(FIGURES, "JOINT", "max(depth(window, index), 0.0)", "depth(window, index)", FLIGHT),
    Mutation(FIGURES, "depth", ".depth_max, -window", ".depth_max, 0.0 * window", FLIGHT),
    Mutation(FIGURES, "restitution", "joint.restitution / joint", "1.0 / joint", IMPACT),
    Mutation(WORN, "volume", "joint.journal_radius * journal.sum()", "joint.bearing_radius * journal.sum()", WEAR),
    Mutation(WORN, "volume", "2.0 * math.pi / len(bearing) * law.length", "2.0 * math.pi / len(bearing)", WEAR),
    Mutation(WORN, "WEAR", "max(map(np.max, depths_of", "min(map(np.max, depths_of", WEAR),
    Mutation(OUTCOME, "_events_of", '== integration.ONSET, "on", "off"', '!= integration.ONSET, "on", "off"', SEEN),
    # what figures follow from, and their intervals
    Mutation(
        SUMS,
        "Mean.value",
        "/ window.duration",
        "",
        WINDOW,
    ),
    Mutation(
        SUMS,
        "RootMean.value",
        "/ window.duration",
        "",
        WINDOW,
    ),
    Mutation(SUMS, "PerRevolution.value", "/ window.turns", "", WINDOW),
    Mutation(SUMS, "DepthRate.value", "/ window.duration", "", WEAR),
    Mutation(OUTCOME, "window_of", "RARE_SHARE * duration", "0.5 * RARE_SHARE * duration", WINDOW),
    Mutation(SPREAD, "CONFIDENCE", "0.95", "0.9", MEANS),
    Mutation(SPREAD, "MAX_CORRELATION", "0.9", "0.95", MEANS),
    Mutation(SUMS, "half_width", "0.5 + 0.5 * CONFIDENCE", "CONFIDENCE", MEANS),
    Mutation(SPREAD, "inflation_of", "(1.0 + counted) / (1.0 - counted)", "1.0 / (1.0 - counted)", MEANS),
    Mutation(SUMS, "half_width", "correlation + (1.0 + 3.0 * correlation) / count", "correlation", MEANS),
    Mutation(SUMS, "_longer_side", "(quantile + skewness / 6.0)", "quantile", MEANS),
    Mutation(BLOCKS, "Blocks.interval", "half_width <= EQUAL_TOLERANCE * abs(value)", "half_width < 0.0", MEANS),
    Mutation(BLOCKS, "UNOBSERVED", "3.0", "2.0", MEANS),
    Mutation(SUMS, "half_width", "count * (count - 1)", "count * count", MEANS),
    Mutation(SUMS, "half_width", "stdtrit(count - 1", "stdtrit(count", MEANS),
    Mutation(SUMS, "RootMean.over_blocks", "0.5 * width / value if value", "width / value if value", MEANS),
    Mutation(SUMS, "PerRevolution.over_blocks", "(revolutions * (len(sums) - 1))", "(revolutions * len(sums))", MEANS),
    Mutation(
        SUMS, "DepthRate.over_blocks", "np.argmax(depths[-1] - depths[0])", "np.argmin(depths[-1] - depths[0])", MEANS
    ),
    Mutation(
        SUMS, "DepthRate.take", "reshape(len(totals.joint), -1)[index]", "reshape(len(totals.joint), -1)[0]", MEANS
    ),
    Mutation(
        SUMS, "ForceExceeded.over_blocks", "max(force(RARE_SHARE - width)", "min(force(RARE_SHARE - width)", MEANS
    ),
    Mutation(HISTOGRAM, "time_above", "bin_time[index] * (high - force)", "bin_time[index] * (force - low)", MEANS),
    Mutation(SUMS, "DryTime.over_blocks", "threshold = DRY_FORCE_THRESHOLD * (", "threshold = 0.1 * (", SHARES),
    Mutation(SUMS, "Ratio.over_blocks", "half_width(numerator - ratio * denominator)", "half_width(numerator)", SHARES),
    Mutation(
        "simulation/machine/ideal.py",
        "_jumps",
        "slope[rows, columns] > STEEPNESS * median_slope",
        "slope[rows, columns] < 0.0",
        IDEALS,
    ),
    Mutation("simulation/machine/ideal.py", "peaks", "np.union1d(equidistant, knots)", "equidistant", IDEALS),
    Mutation(
        ROWS,
        "write_curvature",
        "proximal_rate * near[0] - distal_rate",
        "proximal_rate * near[0] + distal_rate",
        PLANAR,
    ),
    Mutation(ROWS, "write_curvature", "2.0 * proximal_rate * (c * dy", "1.0 * proximal_rate * (c * dy", PLANAR),
    Mutation(ROWS, "write_constraints", ".turns * (c * y - s * x)", ".turns * 0.0", PLANAR),
    Mutation(ROWS, "write_constraints", "value - work.constraints[row].offset", "value", "tests/test_elastic_link.py"),
    Mutation(ROWS, "invert", "pivot if pivot_row == k else -pivot", "pivot", PLANAR),
    Mutation(
        "mechanics/machines/planar/closure.py",
        "Closure._rows_of",
        "(-math.sin(joint.axis), math.cos(joint.axis))",
        "(math.sin(joint.axis), -math.cos(joint.axis))",
        PLANAR,
    ),
    Mutation(
        "mechanics/machines/planar/free_crank.py",
        "_passages",
        "highest_angles[middle] < angle",
        "highest_angles[middle] > angle",
        IDEALS,
    ),
    Mutation(
        "simulation/analyses/repeated.py", "at_equilibrium", "converged = run_index > 0 and ", "converged = ", HEAT
    ),
    Mutation(
        "simulation/analyses/repeated.py",
        "at_equilibrium",
        "np.minimum(width, DOUBTFUL_WIDTH * (implied_temperatures - ambient))",
        "width",
        HEAT,
    ),
    Mutation(BLOCKS, "MIN_REVOLUTIONS", "30", "7", "tests/test_watched_runs.py -k irregular"),
    Mutation(BLOCKS, "MAX_BLOCKS", "32", "64", MEANS),
    Mutation(BLOCKS, "Interval.within", "relative * abs(self.value)", "relative * self.value", MEANS),
    Mutation(BLOCKS, "Blocks.record", "del self.sums_at_ends[1::2]", "del self.sums_at_ends[0::2]", MEANS),
    Mutation(BLOCKS, "Blocks.record", "self.stride *= 2", "self.stride += 2", MEANS),
    # where events are
    Mutation(EVENTS, "fit_gap", "depth * (depth + 2.0 * size)", "depth", SEARCH),
    Mutation(EVENTS, "find_onset", "if start_depth >= 0.0 and work", "if start_depth >= 1e9 and work", SEARCH),
    Mutation(EVENTS, "refine_onset", "x - correction", "x + correction", SEARCH),
    Mutation(EVENTS, "ROUGH_ERROR", "1e-3", "1e3", SEARCH),
    Mutation(EVENTS, "find_separation", "negate(work.polynomials)", "None", ENDS),
    Mutation(BERNSTEIN, "find_first_crossing", "changes > 1 and", "changes > 3 and", SEARCH),
    Mutation(BERNSTEIN, "find_certain_crossing", "subtract(p, error)", "subtract(p, 0.0)", SEARCH),
    Mutation(BERNSTEIN, "_tail_weights", "a + b * Fraction(n, 2)", "a - b * Fraction(n, 2)", SEARCH),
    Mutation(EVENTS, "find_passage", "p[VALUES, 0] >= 0.0 and", "p[VALUES, 0] >= 1e9 and", SEARCH),
    Mutation(EVENTS, "refine_passage", "if fb <= 0.0: return NO_CROSSING", "if fb <= -1e9: return NO_CROSSING", SEARCH),
    Mutation(
        EVENTS,
        "locate_first_event",
        "if x < earliest: earliest, kind, contact = x, event_kind",
        "if x > first: first, kind, contact = x, event_kind",
        SCENES,
    ),
    # the histogram and the sums
    Mutation(HISTOGRAM, "BIN_BITS", "8", "4", RAMPS),
    Mutation(
        HISTOGRAM,
        "ramp_of",
        "density * (bin_edge(lowest_bin + 1) - low)",
        "density * (high - bin_edge(lowest_bin + 1))",
        RAMPS,
    ),
    Mutation(
        HISTOGRAM,
        "ramp_of",
        "where(crosses_bins, bin_edge(highest_bin + 1), bin_edge(highest_bin))",
        "bin_edge(highest_bin)",
        RAMPS,
    ),
    Mutation(HISTOGRAM, "add_ramp", "histogram[j, bins[0], 1] +=", "histogram[j, bins[0] + 1, 1] +=", RAMPS),
    Mutation(
        HISTOGRAM,
        "ramp_of",
        "lowest_bin == highest_bin, highest_bin > lowest_bin + 1,",
        "lowest_bin == highest_bin, highest_bin > lowest_bin + 2,",
        RAMPS,
    ),
    Mutation(
        HISTOGRAM, "ramp_of", "Ramp(where(is_rising, lower, upper),", "Ramp(where(is_rising, upper, lower),", RAMPS
    ),
    Mutation(HISTOGRAM, "add_fine_part", "(0.5 / FINE_PARTS)", "(1.0 / FINE_PARTS)", RAMPS),
    Mutation(
        HISTOGRAM,
        "force_quantile_of",
        "offset = (higher_time - time_exceeded) / bin_time",
        "offset = (higher_time + time_exceeded) / bin_time",
        RAMPS,
    ),
    Mutation(
        HISTOGRAM, "force_quantile_of", "higher_time >= time_exceeded and", "higher_time >= 2.0 * duration and", RAMPS
    ),
    Mutation(ALONG, "sum_stages", "square + weight * (force * force)", "square + weight * force", WINDOW),
    Mutation(
        TOTALS,
        "add_force_profile",
        "start_value, end_value = force[i], force[i + 1]",
        "start_value, end_value = force[i], force[i]",
        RAMPS,
    ),
    Mutation(
        HISTOGRAM,
        "fraction_above",
        "if step_values[DEPTH_ROW, i] > limit:",
        "if step_values[DEPTH_ROW, i] < limit:",
        LIMIT,
    ),
    Mutation(HISTOGRAM, "fraction_above", "return time_at_limit / total", "return time_at_limit", LIMIT),
    Mutation(ALONG, "interior_peak", "0.0 > sign * end_slope", "0.0 < sign * end_slope", WINDOW),
    Mutation(ALONG, "sum_stages", "dissipated + weight * o", "dissipated + 1.001 * weight * o", IMPACT),
    # pressures and wear laws: each of them three times too large
    Mutation(PRESSURE, "_pressure_integral_over_load_hertz_line", "return 1.0", "return 3.0", BINS),
    Mutation(
        PRESSURE,
        "_pressure_integral_over_load_uniform",
        "return half_angle / math.sin(half_angle) if",
        "return 3.0 * half_angle / math.sin(half_angle) if",
        BINS,
    ),
    Mutation(
        PRESSURE,
        "_pressure_integral_over_load_winkler",
        "return (4.0 * half_angle * half_angle",
        "return (12.0 * half_angle * half_angle",
        BINS,
    ),
    Mutation(PRESSURE, "_pressure_integral_over_load_persson", "return total", "return 3.0 * total", BINS),
    Mutation(PRESSURE, "_peak_over_mean_hertz_line", "return 4.0 / math.pi", "return 12.0 / math.pi", BINS),
    Mutation(PRESSURE, "_peak_over_mean_uniform", "return 1.0", "return 3.0", BINS),
    Mutation(
        PRESSURE,
        "_peak_over_mean_winkler",
        "(2.0 * sine * sine / (half_angle",
        "(6.0 * sine * sine / (half_angle",
        BINS,
    ),
    Mutation(PRESSURE, "_peak_over_mean_persson", "return total", "return 3.0 * total", BINS),
    Mutation(
        PRESSURE, "_half_arc_hertz_line", "min(pressure.width_factor *", "min(3.0 * pressure.width_factor *", BINS
    ),
    Mutation(
        PRESSURE,
        "_half_arc_of_rigid_circles",
        "return 2.0 * total * math.sqrt(square)",
        "return 6.0 * total * math.sqrt(square)",
        BINS,
    ),
    Mutation(PRESSURE, "_half_arc_persson", "return total * math.sqrt(z)", "return 3.0 * total * math.sqrt(z)", BINS),
    Mutation(PRESSURE, "_cumulative_pressure_uniform", "0.5 + 0.5 * x, 0.0", "0.5 + 1.5 * x, 0.0", BINS),
    Mutation(
        PRESSURE, "_cumulative_pressure_winkler", "0.5 + 0.5 * _overlap_integral", "0.5 + 1.5 * _overlap_integral", BINS
    ),
    Mutation(
        PRESSURE,
        "_cumulative_pressure_hertz_line",
        "0.5 - tail * edge_distance",
        "0.5 - 3.0 * tail * edge_distance",
        BINS,
    ),
    Mutation(
        PRESSURE,
        "_cumulative_pressure_persson",
        "0.5 - tail * edge_distance",
        "0.5 - 3.0 * tail * edge_distance",
        BINS,
    ),
    Mutation(
        PRESSURE,
        "_wear_rate_archard",
        "pressure_times_speed = sliding.pressure_integral",
        "pressure_times_speed = 3.0 * sliding.pressure_integral",
        BINS,
    ),
    Mutation(
        PRESSURE,
        "_wear_rate_energy",
        "bearing_coefficient * sliding.friction_power",
        "bearing_coefficient * 3.0 * sliding.friction_power",
        BINS,
    ),
    Mutation(
        PRESSURE,
        "_wear_rate_running_in",
        "math.exp(-sliding.sliding_distance /",
        "math.exp(-3.0 * sliding.sliding_distance /",
        BINS,
    ),
    # from film to dry contact
    Mutation(
        FILM,
        "_ramp_fraction",
        "(depth - transition.begin) / transition.width",
        "3.0 * (depth - transition.begin) / transition.width",
        PASSES,
    ),
    Mutation(FILM, "_ramp_fraction", "as_type_of(1.0, depth)", "as_type_of(3.0, depth)", PASSES),
    Mutation(
        FILM,
        "_asperity_load_greenwood_tripp",
        "return 2.0 * transition.load",
        "return -2.0 * transition.load",
        PASSES,
    ),
    Mutation(
        OIL,
        "blend_loads",
        "fx=film_fraction * film_only.fx + fraction * dry_load.fx",
        "fx=film_fraction * film_only.fx + 3.0 * fraction * dry_load.fx",
        PASSES,
    ),
    Mutation(
        OIL,
        "blend_loads",
        "film_fraction = film_only.contacts[0], dry_load.contacts[0], 1.0 - fraction",
        "film_fraction = film_only.contacts[0], dry_load.contacts[0], 1.0",
        PASSES,
    ),
    Mutation(
        OIL,
        "blend_loads",
        "elastic=film_fraction * film_contact.elastic + fraction",
        "elastic=film_fraction * film_contact.elastic + 3.0 * fraction",
        PASSES,
    ),
    # what is stored
    Mutation(
        "store/directory.py", "RunDirectory.rows", "np.argsort([-batch.written", "np.argsort([batch.written", STORE
    ),
    Mutation("store/directory.py", "RunDirectory.rows", "[batch], failed, ids))", "[batch], ids))", STORE),
    Mutation(
        "store/directory.py",
        "RunDirectory.load_batches",
        "[:HASH_LENGTH] != hash_in_name(path)",
        "[:HASH_LENGTH] == path.name",
        STORE,
    ),
    Mutation(
        "store/directory.py",
        "RunDirectory._describe_damage",
        "(batch.orbits) != batch.sha256",
        "(batch.orbits) < ''",
        STORE,
    ),
    Mutation("store/directory.py", "RunDirectory.load_intact_batches", "if path not in needed)", "if False)", STORE),
    Mutation("store/directory.py", "RunDirectory._describe_damage", 'return f"{name}: missing"', "return None", STORE),
    Mutation(
        "store/directory.py", "RunDirectory.load_intact_batches", "[:HASH_LENGTH] == hash_in_name(path)", "> ''", STORE
    ),
    Mutation("store/directory.py", "RunDirectory.load_batches", "not in (None, batch.frame)", "in ()", STRANGERS),
    Mutation("store/durable.py", "check_regular", "if kind != stat.S_IFREG:", "if False:", STRANGERS),
    Mutation("store/durable.py", "remove_temporaries", "if _TEMPORARY.fullmatch(name):", "if True:", STRANGERS),
    Mutation("store/read.py", "verify", "if actual != expected:", "if False:", STRANGERS),
    Mutation("store/record.py", "read_record", 'if record.get("checksum") != checksum:', "if False:", STRANGERS),
    Mutation("store/merged.py", "fletcher32", "return second << 16 | first", "return first << 16 | second", STRANGERS),
    Mutation(
        "store/directory.py",
        "RunDirectory._compare",
        "if stored_settings.get(path) != grid_settings.get(path)]",
        "if path not in stored]",
        STORE,
    ),
    Mutation("store/directory.py", "RunDirectory.link_batches", "if batch.name not in known]", "]", STORE),
    Mutation("store/durable.py", "replace", "os.fsync(file.fileno())", "pass", STORE),
    Mutation(
        "store/durable.py",
        "replace",
        "sync(path.parent)",
        "sync(path)",
        STORE,
    ),
    Mutation(
        "store/durable.py",
        "storing",
        "except (OSError, RuntimeError) as error:",
        "except RuntimeError as error:",
        STORE,
    ),
    Mutation(
        "store/datasets.py",
        "column_of",
        "valid = np.abs(numbers) <= LARGEST",
        "valid = np.ones(len(numbers), bool)",
        STORE,
    ),
    Mutation("store/batch.py", "_count_items", 'if trajectory.status != "ok":', "if False:", STORE),
    Mutation(
        "store/batch.py", "_concatenate_values", '[joint][body == "journal"]', '[joint][body == "bearing"]', STORE
    ),
    Mutation(
        "store/batch.py", "_encode_words", "numbers[words == word] = code", "numbers[words != word] = code", STORE
    ),
    Mutation(
        "store/batch.py",
        "_concatenate_values",
        "np.full((len(rows), *dataset.shape), np.nan)",
        "np.zeros((len(rows), *dataset.shape))",
        STORE,
    ),
    Mutation("store/merged.py", "_filter_chunk", "reshape(-1, size).T.tobytes()", "reshape(-1, size).tobytes()", STORE),
    Mutation("store/merged.py", "_write_compressed", "row += rows", "row += rows - 1", STORE),
    Mutation(
        "store/merged.py",
        "OrbitFiles.extents",
        "first[selection], count[selection] = starts[row],",
        "first[selection], count[selection] = 0,",
        STORE,
    ),
    Mutation("store/merged.py", "content_hash_of", 'for column in ("id", "row"):', 'for column in ("id",):', STRANGERS),
    Mutation(
        "store/merged.py",
        "_rows_of_batches",
        'starts[rows["batch"]] + rows["row"]',
        'rows["row"]',
        STORE,
    ),
    Mutation(
        "store/merged.py",
        "merge",
        "if current_checksums == recorded_checksums:",
        "if True:",
        "tests/test_sweep.py -k merged_file",
    ),
    Mutation(
        "store/results.py",
        "_orbits_difference",
        "if values[0] != values[1]:",
        "if len(values[0]) != len(values[1]):",
        SHARDS,
    ),
    Mutation("store/results.py", "_summary_difference", "if name in TIMINGS or", "if", SHARDS),
    Mutation(
        "store/read.py", "newest_run", "return max(records", "return min(records", "tests/test_store.py -k newest_run"
    ),
    Mutation("store/datasets.py", "open_orbits", " and stored_mark == mark)", ")", STRANGERS),
    Mutation("store/dataset.py", "_guarantee", "bound | field.is_null()", "bound", CONDITIONS),
    Mutation(
        "store/dataset.py",
        "Condition.__or__",
        "None if self.ids is None or other.ids is None else self.ids | other.ids",
        "self.ids or other.ids",
        CONDITIONS,
    ),
    Mutation("store/dataset.py", "Condition.__invert__", ", self.columns)", ", self.columns, self.ids)", CONDITIONS),
    Mutation("sweeping/pool/driver.py", "_describe_strange", "0 <= failed <=", "failed <=", "tests/test_driver.py"),
    Mutation("store/read.py", "StoredRun._frame", "[row : row + 2]) if stored", "[0:2]) if stored", STORE),
    # identity of a case
    Mutation(
        CASES,
        "_IDENTITY_SECTIONS",
        '"drive",',
        "",
        IDENTITY,
    ),
    Mutation(
        CASES,
        "_IDENTITY_SECTIONS",
        '"joints"',
        '"joints", "save"',
        IDENTITY,
    ),
    Mutation(
        CASES,
        "identity_text",
        'content | {"model_version": MODEL_VERSION}, sort_keys=True',
        "content, sort_keys=True",
        IDENTITY,
    ),
    Mutation(CASES, "identity_text", "sort_keys=True, ", "", IDENTITY),
    Mutation(CASES, "identity_of_text", "hexdigest()[:16]", "hexdigest()[1:17]", IDENTITY),
    # versions of workers
    Mutation(
        "sweeping/pool/worker.py",
        "run_batch",
        "if context.grid.case_id(first_task.grid_index) != first_task.case_id:",
        "if False:",
        "tests/test_driver.py -k version",
    ),
    # films
    Mutation(
        FILM,
        "film_couples",
        "return -couple - 0.5 * moment, couple",
        "return -couple, couple",
        BALANCE,
    ),
    Mutation(FILM, "film_couples", ", couple - 0.5 * moment", ", couple", BALANCE),
    Mutation(
        FILM,
        "_shear_couple_petroff",
        "as_type_of(shear.drag * rotation,",
        "as_type_of(-shear.drag * rotation,",
        BALANCE,
    ),
    Mutation(FILM, "_shear_couple_couette", "math.sqrt(1.0 - motion.ratio * motion.ratio)", "1.0", BALANCE),
    Mutation(
        OIL,
        "film_load",
        "spin=journal_spin + bearing_spin - 2.0 * tangential_rate",
        "spin=journal - bearing - 2.0 * tangential_rate",
        BALANCE,
    ),
    Mutation(OIL, "film_load", "pressure_power=0.5 * eccentricity", "pressure_power=eccentricity", BALANCE),
    Mutation(OIL, "film_load", "eccentricity * tangential)", "joint.clearance * tangential)", BALANCE),
    Mutation(FILMS, "_film_force_short", "radial = 0.5 * law.force", "radial = 0.4 * law.force", BALANCE),
    Mutation(FILMS, "_film_force_long", "radial -= (6.0 * law.force", "radial -= (5.0 * law.force", BALANCE),
    Mutation(
        FILMS,
        "_film_force_reynolds",
        "radial - direction_term * cosine",
        "radial + direction_term * cosine",
        REYNOLDS,
    ),
    Mutation(
        FILMS,
        "_film_force_reynolds",
        "direction_term * sine * wedge_scale",
        "direction_term * sine",
        REYNOLDS,
    ),
    Mutation(
        FILMS,
        "evaluate_expansion",
        "2.0 * pair * a * previous_slope",
        "2.0 * pair * a * current_slope",
        REYNOLDS,
    ),
    Mutation(
        FILMS,
        "_film_force_reynolds",
        "factor = math.exp(log_factor)",
        "factor = 1.0 + log_factor",
        REYNOLDS,
    ),
    Mutation(
        FILMS,
        "tables_at",
        "math.log(slenderness) - nodes",
        "math.log(1.05 * slenderness) - nodes",
        REYNOLDS,
    ),
    Mutation(
        FILM,
        "_make_greenwood_tripp",
        "or plane_strain_modulus",
        "or 2.0 * plane_strain_modulus",
        TIPS,
    ),
    Mutation(FILM, "EXPONENT_FIT", "0.05308344", "0.05408344", TIPS),
    Mutation(
        "grid/reading/machine_checks.py",
        "_most_and_least_slender",
        "(min(lengths), max(radii))",
        "(max(lengths), max(radii))",
        REYNOLDS,
    ),
    Mutation(VERDICT, "Limit.is_exceeded", "values > bounds", "values >= bounds", JUDGED),
    Mutation(VERDICT, "Limit.is_exceeded", "values < bounds", "values <= bounds", JUDGED),
    Mutation(VERDICT, "Limit.is_exceeded", "is_beyond |= ~np.isfinite(values)", "pass", JUDGED),
    Mutation(VERDICT, "Limit.is_undecided", "~is_missing & ~has_bound if self.null else", "", JUDGED),
    Mutation(VERDICT, "LimitsAndFigures.assess", "undecided |= ~is_finished", "pass", JUDGED),
    Mutation(VERDICT, "LimitsAndFigures.assess", "(is_beyond & ~(margin < 0.0))", "(is_beyond & False)", JUDGED),
    Mutation(
        JUDGED_CASES,
        "Cases.verdicts",
        "np.where(exceeded, EXCEEDED,",
        "np.where(exceeded & ~undecided, EXCEEDED,",
        JUDGED,
    ),
    Mutation(JUDGE, "combined", "EXCEEDED if EXCEEDED in verdicts else", "", JUDGED),
    Mutation(JUDGE, "_design", "for condition in tuples", "for condition in rows_by_tuple", JUDGED),
    Mutation(JUDGE, "_design", "UNDECIDED if missing else MET", "MET", JUDGED),
    Mutation(JUDGE, "_designs", 'sample.get("method") == ONE_AT_A_TIME or', "", JUDGED),
    Mutation(JUDGE, "_designs", "catalogue.CONDITION, catalogue.MODEL", "catalogue.CONDITION", JUDGED),
    Mutation(JUDGE, "_worst", 'fact["margin"] or 0.0', '-(fact["margin"] or 0.0)', JUDGED),
    Mutation(JUDGE, "_rank", "-(margin or 0.0)", "(margin or 0.0)", JUDGED),
    Mutation(JUDGED_CASES, "fineness_of", "-1 if", "1 if", JUDGED),
    Mutation(JUDGED_CASES, "_finest", "order[is_last].tolist()", "order[::-1][is_last].tolist()", JUDGED),
    Mutation(JUDGE, "_difference", "int(np.argmax(relative))", "int(np.argmin(relative))", JUDGED),
    Mutation(JUDGE, "_merged", "b if a < 0 else a", "a", JUDGED),
    Mutation(JUDGED_CASES, "named_value", "if labelled == value", "if labelled != value", JUDGED),
    Mutation(JUDGE, "_is_none", "max(abs(start), abs(end))", "min(abs(start), abs(end))", JUDGED),
    Mutation(JUDGE, "_direction", "sign_test(rising, falling) > SIGNIFICANCE", "False", JUDGED),
    Mutation(JUDGE, "_direction", "RISES if rising > falling", "RISES if rising < falling", JUDGED),
    Mutation(JUDGE, "_turns_back", "reversal > MAX_REVERSAL * (high - low)", "False", JUDGED),
    Mutation(JUDGE, "sign_test", "range(larger, total + 1)", "range(larger + 1, total + 1)", JUDGED),
    Mutation(JUDGE, "_spans", "int(codes.max()) == last", "True", JUDGED),
    Mutation(JUDGE, "_fix_one_another", "== len(np.unique(other))", "", JUDGED),
    Mutation(JUDGE, "_rank_effects", "FALLS if partial.high < 0.0", "FALLS if partial.high > 0.0", JUDGED),
    Mutation(
        "answers/validity.py",
        "film_remarks",
        "if joint.energy_gain > MIN_ENERGY_GAIN",
        "if joint.energy_gain < MIN_ENERGY_GAIN",
        "tests/test_film.py -k remarks",
    ),
)


def run(place: Path, tests: str) -> int:
    """Return how pytest ended, started in `place` without the compiler."""
    environment = {
        **os.environ,
        "CLEARSWEEP_DISABLE_JIT": "1",
        "PYTHONPATH": str(place),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
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
    try:
        whole = file.read_text(encoding="utf-8")
        changed = mutation.applied(whole)
    except (LookupError, OSError) as error:
        return f"NO LONGER APPLIES: {error}"
    file.write_text(changed, encoding="utf-8")
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
    chosen = [
        first
        for first in MUTATIONS
        if not words or any(word in f"{first.file} {first.where} {first.old}" for word in words)
    ]
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
            change = f"{mutation.file}: {mutation.where}: {mutation.old!r} -> {mutation.new!r}"
            print(f"{number:3}/{len(chosen)} {took:5.1f} s  {change}: {outcome}", flush=True)
    print(f"{len(chosen) - len(bad)} of {len(chosen)} mutations killed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
