"""The one place that words an answer: a sentence is a rule (its condition), a template, and values of the answer."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from ..language import wording
from . import blocks, labels, lifetime
from .judge import NOT_RUN, missing_groups
from .words import Words, factor_text, margin_text

MAX_LINES, MAX_LENGTH = 6, 160  # of an answer, and characters of a line
SMALL_MARGIN = 0.1  # margins below this are not certain
CONVERGED = 0.01  # relative difference of coarser numerics up to which a figure is converged
MAX_EFFECTS = 2  # effects on one figure
MAX_BETWEEN = 3  # medians between both ends that an effect lists
MAX_FIGURES = 2  # limited figures whose effects are named
PERCENT = f"{wording.BLANK}%"

Answer = Mapping[str, Any]


class Sentence(NamedTuple):
    """A template and the values that fill it."""

    template: str
    values: Mapping[str, Any] = {}

    @property
    def text(self) -> str:
        """Return the sentence, which begins with a capital letter."""
        return labels.capitalise(self.template.format(**self.values))


Rule = Callable[[Answer, Words], Iterable[Sentence]]


def sentences(answer: Answer, words: Words) -> list[str]:
    """Return the sentences of an answer, the most important first: at most MAX_LINES lines of MAX_LENGTH characters."""
    lines: list[str] = []
    for rule in RULES[answer["question"]]:
        lines += [sentence.text for sentence in rule(answer, words)]
    return [shortened(line) for line in dict.fromkeys(lines)][:MAX_LINES]


def shortened(line: str) -> str:
    """Return a line of at most MAX_LENGTH characters; what is left out is marked."""
    return line if len(line) <= MAX_LENGTH else f"{line[: MAX_LENGTH - 4].rsplit(' ', 1)[0]} ..."


def listed(items: Sequence[str], room: int, separator: str = "; ") -> str:
    """Return as many items as fit into `room` characters, and how many more there are."""
    for count in range(len(items), 0, -1):
        more = f"{separator}{len(items) - count} more" if count < len(items) else ""
        text = separator.join(items[:count]) + more
        if len(text) <= room or count == 1:
            return text
    return ""


def state(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Say that a run is not complete."""
    if not answer["complete"]:
        yield Sentence("The run is not complete: the answer holds for the cases that are finished so far.")


def verdict(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Say how many designs meet the limits under every condition; without designs, how many cases do."""
    designs, total, counts = answer["designs"], answer["designs_total"], answer["cases"]
    judged = sum(counts[name] for name in ("met", "exceeded", "undecided")) if counts else 0
    if not judged:
        return
    verdicts = answer["verdicts"] if designs else {"meets": counts["met"], "undecided": counts["undecided"]}
    met, open_count = verdicts["meets"], verdicts["undecided"]
    values = {"every": every_text(answer, words), "limits": words.limits_text(), "met": met, "total": total or judged}
    values["open"] = f"; {open_count} undecided" if open_count else ""
    values["verb"] = "meets" if met == 1 else "meet"
    if not designs:
        yield Sentence("{met} of {total} cases {verb} the limits: {limits}{open}.", values)
    elif total == 1:
        (design,) = designs
        values["subject"] = "the machine" if design["conditions"] > 1 else "the case"
        exceeding = f" ({design['exceeded']} of {design['conditions']} exceed)" if design["conditions"] > 1 else ""
        template = {
            "meets": "{subject} meets the limits{every}: {limits}.",
            "exceeds": "{subject} does not meet the limits{every}: {limits}{exceeding}.",
            "undecided": "Whether {subject} meets the limits{every} is undecided: {limits}.",
        }
        yield Sentence(template[design["verdict"]], values | {"exceeding": exceeding})
    elif met == total:
        yield Sentence("All {total} designs meet the limits{every}: {limits}.", values)
    elif open_count == total:
        yield Sentence("No design is known to meet the limits{every}: {limits}; all {total} are undecided.", values)
    elif not met:
        yield Sentence("None of {total} designs meets the limits{every}: {limits}{open}.", values)
    else:
        yield Sentence("{met} of {total} designs {verb} the limits{every}: {limits}{open}.", values)


def every_text(answer: Answer, words: Words) -> str:
    """Return ' at every crank speed and under every contact law', or ''."""
    paths = {
        role: [path for path, of_path in answer["roles"].items() if of_path == role]
        for role in ("condition", "uncertainty", "model")
    }
    conditions = [words.axis_name(path) for path in (*paths["condition"], *paths["uncertainty"])]
    models = [words.axis_name(path) for path in paths["model"]]
    parts = [f" at every {wording.sentence_list(conditions)}"] if conditions else []
    parts += [f" under every {wording.sentence_list(models)}"] if models else []
    return " and".join(parts)


def share(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Say which share of the draws of a sample exceeds a limit; the interval is that of the share that meets them."""
    for design in answer["designs"][:2]:
        if part := design.get("share"):
            exceeded, undecided = (f"{100.0 * part[name]:.2g}{PERCENT}" for name in ("exceeded", "undecided"))
            values = {"where": f"{words.setting(design['values'])}: " if design["values"] else "", "interval": ""}
            values |= {"exceeded": exceeded, "count": design["conditions"], "limits": words.limits_text()}
            values["undecided"] = f"; {undecided} are undecided" if part["undecided"] else ""
            if part["low"] is not None:
                ends = (part["low"], part["high"]) if part["undecided"] else (1.0 - part["high"], 1.0 - part["low"])
                low, high = (f"{100.0 * end:.2g}" for end in ends)
                of_what = "meeting them" if part["undecided"] else "exceeding one"
                values["interval"] = f" ({low} to {high}{PERCENT} {of_what}, 95{PERCENT} interval)"
            template = "{where}{exceeded} of {count} draws exceed a limit{interval}{undecided}: {limits}."
            yield Sentence(template, values)


def boundary(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Say up to where the limits are met, which designs meet them best, or which comes nearest."""
    designs = answer["designs"]
    if not designs or any("share" in design for design in designs):
        return
    met = [design for design in designs if design["verdict"] == "meets"]
    if answer["designs_total"] == 1 or not designs[0]["values"]:
        if text := words.margin(designs[0]):
            lead = "Smallest" if designs[0]["verdict"] == "meets" else "Worst:"
            values = {"lead": lead, "margin": text, "where": at_worst(answer, words, designs[0])}
            yield Sentence("{lead} {margin}{where}.", values)
    elif edge := _edge(answer):
        good, bad, upwards = edge
        values = {
            "word": "up to" if upwards else "from",
            "good": words.setting(good["values"]),
            "margin": in_brackets(words.margin(good)),
            "bad": words.setting(bad["values"]),
            "worse": words.margin(bad),
            "where": at_worst(answer, words, bad),
        }
        yield Sentence("Met {word} {good}{margin}; {bad} has {worse}{where}.", values)
    elif met:
        items = [f"{words.setting(design['values'])}{in_brackets(words.margin(design))}" for design in met]
        lead = "Met by" if len(met) < answer["designs_total"] else "Best first:"
        yield Sentence("{lead} {designs}.", {"lead": lead, "designs": listed(items, MAX_LENGTH - 15)})
    elif exceeding := [design for design in designs if design["verdict"] == "exceeds"]:
        nearest = exceeding[0]
        values = {"design": words.setting(nearest["values"]), "margin": words.margin(nearest)}
        yield Sentence("Nearest: {design}, {margin}{where}.", values | {"where": at_worst(answer, words, nearest)})
    smallest = min((design["margin"] for design in met if design["margin"] is not None), default=1.0)
    if met and smallest < SMALL_MARGIN:
        text = f"{wording.short_number_text(100.0 * smallest, 3)}{PERCENT}"
        yield Sentence(
            "A margin of {margin} is not certain: other laws or longer runs may use it up.", {"margin": text}
        )


def in_brackets(text: str) -> str:
    """Return ' (text)', or '' for no text."""
    return f" ({text})" if text else ""


def at_worst(answer: Answer, words: Words, design: Mapping[str, Any]) -> str:
    """Return ' at crank speed 2000 rpm', the conditions of a design's worst case, or ''."""
    setting = words.setting(answer.get("settings", {}).get(design["worst"]) or {}, design["worst"])
    return f" at {setting}" if setting else ""


def _edge(answer: Answer) -> tuple[Mapping[str, Any], Mapping[str, Any], bool] | None:
    """Return the last design that meets the limits, the next one, and whether smaller values meet them.

    None unless a single number is chosen and the verdict changes once; undecided designs count as not met.
    """
    designs = answer["designs"]
    paths = {path for design in designs for path in design["values"]}
    if len(paths) != 1 or answer["designs_total"] != len(designs):
        return None
    (path,) = paths
    order = answer.get("order", {}).get(path)
    values = [design["values"].get(path) for design in designs]
    if order is None and any(not isinstance(value, float) for value in values):
        return None
    place = (lambda design: order.index(design["values"][path])) if order else (lambda design: design["values"][path])
    ascending = sorted(designs, key=place)
    is_met = [design["verdict"] == "meets" for design in ascending]
    changes = [index for index in range(len(is_met) - 1) if is_met[index] != is_met[index + 1]]
    if len(changes) != 1:
        return None
    low, high = ascending[changes[0]], ascending[changes[0] + 1]
    good, bad = (low, high) if is_met[changes[0]] else (high, low)
    return (good, bad, good is low) if bad["verdict"] == "exceeds" else None


def missing(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Say what is missing of undecided designs: conditions that were not run, failed, or lack a figure."""
    designs = [design for design in answer["designs"] if design["missing"]]
    if not designs:
        return
    if is_paired(answer):
        yield Sentence(
            "Every row of `cases` has its own condition, so no design was run under all of them; name what you choose "
            "in `roles`."
        )
        return
    groups = [
        (values, why, [design for design in designs if {"values": values, "why": why} in design["missing"]])
        for values, why, _ in missing_groups(designs)
    ]
    items = [_missing_text(answer, words, *group) for group in groups]
    yield Sentence("Undecided: {items}.", {"items": listed(items, MAX_LENGTH - 12)})


def _missing_text(
    answer: Answer, words: Words, values: Mapping[str, Any], why: str, designs: Sequence[Mapping[str, Any]]
) -> str:
    names = [words.setting(design["values"]) for design in designs if design["values"]]
    total = answer["designs_total"]
    everyone = "both designs" if total == 2 else f"all {total} designs"
    several = everyone if len(designs) == total else f"{len(names)} designs"
    subject = (names[0] if len(names) == 1 else several) if names else "it" if values else "the case"
    at = f" at {words.setting(values)}" if values else ""
    if why == NOT_RUN:
        return f"{subject} {'was' if len(names) < 2 else 'were'} not run{at}"
    if why.endswith(" is null"):
        column = why.removesuffix(" is null")
        return f"{words.figure(column)} of {subject} is null{at}"
    return f"{subject} failed{at} ({why})"


def is_paired(answer: Answer) -> bool:
    """Return whether every case has a condition of its own, so that no design has more than one."""
    designs = answer["designs"]
    run = [design["met"] + design["exceeded"] + design["undecided"] for design in designs]
    return (
        len(designs) > 1
        and len(designs) == answer["designs_total"]
        and all(count == 1 for count in run)
        and all(design["conditions"] == len(designs) for design in designs)
    )


def convergence(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Say whether figures at coarser numerics agree with the finest ones, which decide."""
    largest: dict[tuple[str, str], Mapping[str, Any]] = {}
    for entry in answer["convergence"]:
        key = entry["path"], entry["figure"]
        if key not in largest or size_of(entry) > size_of(largest[key]):
            largest[key] = entry
    for (path, figure), entry in list(largest.items())[:2]:
        finest, coarse = words.figures(figure, [entry["finest"], entry["next"]])
        values = {
            "axis": words.axis_name(path),
            "figure": words.figure(figure),
            "value": words.value(path, entry["value"]),
            "finest": finest,
            "coarse": coarse,
            "difference": f"{wording.number_text(100.0 * size_of(entry), 2)}{PERCENT}",
        }
        if size_of(entry) <= CONVERGED:
            yield Sentence(
                "The finest {axis} decides; coarser ones differ in {figure} by at most {difference}.", values
            )
        else:
            yield Sentence(
                "The finest {axis} decides ({figure} {finest}); {value}: {coarse}, {difference} off, not converged.",
                values,
            )


def size_of(entry: Mapping[str, Any]) -> float:
    """Return the relative difference of a convergence entry; 1 where the finest figure is 0."""
    return 1.0 if entry["difference"] is None else float(entry["difference"])


def effect_lines(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Say how figures change with what varies, the strongest effect first."""
    for figure in deciding_figures(answer):
        effects = [effect for effect in answer["effects"] if effect["figure"] == figure]
        clear = [effect for effect in effects if effect["verdict"] in (blocks.RISES, blocks.FALLS, blocks.DIFFERS)]
        texts = [effect_text(answer, words, effect, subject=not index) for index, effect in enumerate(clear)]
        texts = [text for text in texts if text]
        if texts:
            yield Sentence("{effects}.", {"effects": listed(texts[:MAX_EFFECTS], MAX_LENGTH - 1)})
        others = {
            verdict_: [words.axis_name(effect["path"]) for effect in effects if effect["verdict"] == verdict_]
            for verdict_ in (blocks.MIXED, blocks.NONE)
        }
        clauses = (
            [f"no steady trend with {wording.sentence_list(others[blocks.MIXED])}"] if others[blocks.MIXED] else []
        )
        clauses += [f"no effect of {wording.sentence_list(others[blocks.NONE])}"] if others[blocks.NONE] else []
        if clauses and (not texts or figure == deciding_figures(answer)[0]):
            values = {"figure": words.figure(figure), "clauses": " and ".join(clauses)}
            yield Sentence("{figure} has {clauses}.", values)


def deciding_figures(answer: Answer) -> list[str]:
    """Return the figures that lead: those of exceeding designs first, then those with the smallest margins."""
    figures = list(dict.fromkeys(effect["figure"] for effect in answer["effects"]))
    order = {verdict_: rank for rank, verdict_ in enumerate(("exceeds", "undecided", "meets"))}
    ranked = sorted(answer["designs"], key=lambda design: order[design["verdict"]])
    leading = dict.fromkeys(design["limit"] for design in ranked if design["limit"] in figures)
    return [*dict.fromkeys([*leading, *figures])][:MAX_FIGURES]


def effect_text(answer: Answer, words: Words, effect: Mapping[str, Any], *, subject: bool) -> str:
    """Return an effect: 'force peak rises from 64.5 to 442 N as crank speed grows from 500 to 2000 rpm'."""
    figure, path = effect["figure"], effect["path"]
    start, end = words.figures(figure, [effect["from"], effect["to"]])
    name = words.figure(figure) if subject else "it"
    if effect["verdict"] == blocks.DIFFERS:
        low, high = words.value(path, effect["lowest"]), words.value(path, effect["highest"])
        return f"{name} is smallest, {start}, with {words.axis_name(path)} {low} and largest, {end}, with {high}"
    ends = answer.get("ends", {}).get(path)
    if effect["method"] == "ranks":
        return f"{name} {effect['verdict']} with {words.axis_name(path)}, {from_to(start, end)} over its quarters"
    if effect.get("with"):
        names = wording.sentence_list([words.axis_name(tied) for tied in (path, *effect["with"])])
        return f"{name} {effect['verdict']} {from_to(start, end)} along {names}, which vary together"
    grows = f" as {words.axis_name(path)} grows"
    between = effect.get("medians", [])[1:-1]
    if start == end:
        return ""
    if 0 < len(between) <= MAX_BETWEEN and None not in between and subject:
        texts = [
            text.partition(wording.BLANK)[0] for text in words.figures(figure, [effect["from"], *between, effect["to"]])
        ]
        start = f"{start} over {', '.join(texts[1:-1])}" if start == texts[0] else start
    grows += f" {from_to(*(words.value(path, value) for value in ends))}" if ends else ""
    return f"{name} {effect['verdict']} {from_to(start, end)}{grows}"


def from_to(first: str, last: str) -> str:
    """Return 'from 1 to 2 mm' for '1 mm' and '2 mm'."""
    for blank in (wording.BLANK, " "):
        _, _, unit = last.partition(blank)
        if unit and first.endswith(f"{blank}{unit}") and "(" not in last:
            return f"from {first.removesuffix(f'{blank}{unit}')} to {last}"
    return f"from {first} to {last}"


def own_figures(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the range of the user-defined figures."""
    for name in words.record.get("figures") or {}:
        if entry := extreme(answer, name):
            low, high = words.figures(name, [entry["smallest"]["value"], entry["largest"]["value"]])
            text = low if low == high else f"{low} to {high}"
            yield Sentence("{figure}: {range}.", {"figure": words.figure(name), "range": text})


def extreme(answer: Answer, column: str) -> Mapping[str, Any] | None:
    """Return the entry with the extremes of a column, or None."""
    return next((entry for entry in answer.get("extremes", ()) if entry["figure"] == column), None)


def extremes_of(answer: Answer, figure: str, words: Words) -> list[Mapping[str, Any]]:
    """Return the entries of a figure of all joints."""
    names = {column.name for column in words.layout.columns if column.figure == figure}
    return [entry for entry in answer.get("extremes", ()) if entry["figure"] in names]


def place_text(answer: Answer, words: Words, end: Mapping[str, Any]) -> str:
    """Return ' at crank speed 2000 rpm (case 1a2b3c4d)' for an end of an extreme."""
    setting = words.setting(end["values"], end["case"])
    if not setting:
        return ""
    return f" in {setting}" if setting.startswith("case ") else f" at {setting} (case {wording.short_id(end['case'])})"


def force(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the largest normal force and its ratio to the ideal reaction."""
    entries = extremes_of(answer, "force_peak", words)
    if not entries:
        return
    entry = max(entries, key=lambda candidate: candidate["largest"]["value"])
    if not entry["largest"]["value"]:
        yield Sentence("The surfaces never touch: every force peak is 0.")
        return
    (text,) = words.figures(entry["figure"], [entry["largest"]["value"]])
    ratio = entry["largest"].get("ratio")
    values = {
        "figure": words.figure(entry["figure"]),
        "value": text,
        "ratio": f", {factor_text(ratio)} times the ideal" if ratio else "",
        "where": place_text(answer, words, entry["largest"]),
    }
    yield Sentence("Largest {figure}: {value}{ratio}{where}.", values)
    never = [other for other in entries if not other["largest"]["value"]]
    if never:
        names = wording.sentence_list([words.figure(other["figure"]) for other in never])
        yield Sentence("The surfaces never touch: {names} 0.", {"names": names})
    elif not entry["smallest"]["value"]:
        where = place_text(answer, words, entry["smallest"])
        yield Sentence("The surfaces do not touch in every case, such as{where}.", {"where": where})


def error(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the largest error of the output."""
    for entry in [entry for entry in extremes_of(answer, "error_max", words) if entry["largest"]["value"]][:1]:
        (text,) = words.figures(entry["figure"], [entry["largest"]["value"]])
        where = place_text(answer, words, entry["largest"])
        values = {"figure": words.figure(entry["figure"]), "value": text, "where": where}
        yield Sentence("Largest {figure}: {value}{where}.", values)


def touch(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Say that the surfaces of a joint never touch, where limits lead."""
    for entry in extremes_of(answer, "force_peak", words):
        if not entry["largest"]["value"]:
            joint = next(column.joint for column in words.layout.columns if column.name == entry["figure"])
            name = wording.joint_name(joint)
            yield Sentence("The surfaces of {joint} never touch in any case.", {"joint": name})


def life(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the shortest and the longest life with their intervals."""
    criterion = lifetime.criterion_text(words.record.get("life") or {})
    until = f" {criterion}" if criterion else ""
    for entry in extremes_of(answer, "life_hours", words)[:1]:
        joint = wording.joint_name(words.layout.life)
        shortest, longest = entry["smallest"], entry["largest"]
        values = {"joint": joint, "until": until, **_life_values(answer, words, shortest)}
        yield Sentence("Shortest life of {joint}{body}: {hours}{where}.", values)
        yield Sentence("It lasts{until}{interval}.", values)
        if shortest.get("spread"):
            yield Sentence("{spread}.", {"spread": shortest["spread"]})
        if longest["case"] != shortest["case"]:
            yield Sentence("Longest: {hours}{interval}{where}.", _life_values(answer, words, longest))
    if unreached := answer.get("unreached"):
        count = wording.count_text(unreached, "case")
        yield Sentence("{count} did not reach the limit, so the life there is longer than the run.", {"count": count})


def _life_values(answer: Answer, words: Words, end: Mapping[str, Any]) -> dict[str, str]:
    return {
        "body": f" ({end['body']})" if end.get("body") else "",
        "hours": f"{wording.number_text(end['value'])}{wording.BLANK}h",
        "interval": in_brackets(end.get("interval", "")),
        "where": place_text(answer, words, end),
    }


def start_up(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Say how fast the motor reaches its speed, and which cases do not."""
    entry = extreme(answer, "start_up_time")
    unreached, total = answer.get("unreached", 0), answer.get("finished", 0)
    if entry is None:
        yield Sentence("No case reaches 95 % of the motor's no-load speed within its run; run more revolutions.")
        return
    first, last = words.figures("start_up_time", [entry["smallest"]["value"], entry["largest"]["value"]])
    text = last if first == last else f"{first} to {last}"
    where = place_text(answer, words, entry["largest"]) if first != last else ""
    cases = f"{total - unreached} of {total} cases reach" if total > 1 else "The motor reaches"
    values = {"cases": cases, "time": text, "where": f", the slowest{where}" if where else ""}
    yield Sentence("{cases} 95 % of the no-load speed after {time}{where}.", values)
    if unreached:
        yield Sentence(
            "{count} ended before: run more revolutions there.", {"count": wording.count_text(unreached, "start")}
        )


def film(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the thinnest film, and the combinations whose films stay safe under every condition."""
    entries = extremes_of(answer, "film_thickness_min", words)
    if not entries:
        return
    safe = answer.get("film")
    if safe and safe["total"] > 1:
        items = [f"{words.setting(design['values'])}{in_brackets(design['text'])}" for design in safe["designs"]]
        values = {"count": safe["count"], "total": safe["total"], "every": every_text(answer, words)}
        values |= {"criterion": safe["criterion"], "designs": listed(items, 60)}
        values["open"] = f"; {safe['undecided']} undecided" if safe["undecided"] else ""
        template = "{count} of {total} combinations keep their film {criterion}{every}"
        yield Sentence(template + (": {designs}{open}." if items else "{open}."), values)
        yield from missing({**answer, "designs": safe["missing"], "designs_total": safe["total"]}, words)
    entry = min(entries, key=lambda candidate: candidate["smallest"]["value"])
    (text,) = words.figures(entry["figure"], [entry["smallest"]["value"]])
    where = place_text(answer, words, entry["smallest"])
    yield Sentence("Thinnest film: {value}{where}.", {"value": text, "where": where})


def losses(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the range of the loss of each film."""
    for entry in extremes_of(answer, "film_loss", words)[:1]:
        low, high = words.figures(entry["figure"], [entry["smallest"]["value"], entry["largest"]["value"]])
        values = {"figure": words.figure(entry["figure"]), "range": low if low == high else f"{low} to {high}"}
        yield Sentence("{figure}: {range}.", values)


def wear(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the deepest wear in 1000 hours, and when it would reach the clearance."""
    for entry in extremes_of(answer, "wear_rate_max", words)[:1]:
        rate = entry["largest"]["value"]
        if not rate:
            continue
        (text,) = wording.texts_in_common_unit([3.6e6 * rate], "m")
        hours = entry["largest"].get("clearance_hours")
        until = f"valid up to {wording.number_text(hours, 2)} h, when it has doubled the clearance" if hours else ""
        values = {"value": text, "where": place_text(answer, words, entry["largest"]), "until": in_brackets(until)}
        yield Sentence("Deepest wear: {value} per 1000 h{where}{until}.", values)


def added(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Say how many cases a search added, and how many exceed a limit with them."""
    counts = answer["cases"]
    if counts and not counts["added"] and answer["question"] == "refine":
        yield Sentence("No cases were added: no two neighbours differ in meeting the limits.")
    if counts and counts["added"] and (totals := answer.get("all_cases")):
        values = {"added": counts["added"], "count": sum(totals.values()), **totals}
        values["open"] = f", {totals['undecided']} are undecided" if totals["undecided"] else ""
        yield Sentence(
            "The search added {added} cases; of all {count}, {exceeded} exceed a limit{open} and {met} meet them.",
            values,
        )


def seek(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the answers of `seek`, or what comes nearest where there is none."""
    section = words.record.get("seek") or {}
    direction = "largest" if "largest" in section else "smallest"
    sought = section.get(direction)
    paths = [sought] if isinstance(sought, str) else list(sought or ())
    if not paths or not answer["search"]:
        yield Sentence("The search was interrupted; run the same command again to continue.")
        return
    names = wording.sentence_list([words.axis_name(path) for path in paths])
    items = []
    for row in answer["search"]:
        point = {path: value for path, value in row.items() if path in words.path_units}
        setting = words.setting({path: value for path, value in point.items() if value is not None})
        items.append(f"{setting}: {_sought(words, row, paths[0])}" if setting else _sought(words, row, paths[0]))
    every = every_text(answer, words) if section.get("for") == "all" else ""
    lead = f"The {direction} {names} within the limits{every}"
    if len(items) == 1:
        yield Sentence("{lead}: {item}.", {"lead": lead, "item": items[0]})
    else:
        yield Sentence("{lead}:", {"lead": lead})
        room = 3
        for item in items[:room]:
            yield Sentence("{item}.", {"item": item})
        if len(items) > room:
            yield Sentence("{more} more are in seek.parquet.", {"more": len(items) - room})
    for nearest in answer.get("nearest", ())[:1]:
        values = {"tried": nearest["tried"], "failed": nearest["failed"], "margin": words.margin(nearest)}
        values["where"] = words.setting(nearest["values"], nearest["case"])
        yield Sentence("Of {tried} values tried, {failed} failed; nearest: {margin} at {where}.", values)


def _sought(words: Words, row: Mapping[str, Any], path: str) -> str:
    """Return an answer of `seek` in words."""
    value, limiting = row.get(f"seek.{path}"), row.get("limiting")
    if value is None:
        figures = {column.name for column in words.layout.columns} | {*(words.record.get("figures") or {})}
        if limiting and figures.isdisjoint(limiting.split(",")):
            return f"not known, as cases failed ({limiting})"
        return "none in the range" if "seek_fit" not in row else "none of the fits"
    text = f"{row['seek_fit']} ({words.value(path, value)})" if row.get("seek_fit") else words.value(path, value)
    other = row["seek_high"] if "largest" in (words.record.get("seek") or {}) else row["seek_low"]
    by = wording.sentence_list([words.figure(name) for name in (limiting or "").split(",") if name])
    border = f" (not known to be safe at {words.value(path, other)})" if row["seek_low"] != row["seek_high"] else ""
    return f"{text}{border}{f', limited by {by}' if by else ', the end of the range'}"


def optimise(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the best cases of `optimise`."""
    rows = answer["search"]
    if not rows:
        return
    section = words.record.get("optimise") or {}
    objectives = [
        name
        for sense in ("minimise", "maximise")
        for name in ([section[sense]] if isinstance(section.get(sense), str) else section.get(sense) or ())
    ]
    margins = [row.get("margin") for row in rows]
    is_met = answer.get("best_met", True)
    count = len(rows)
    tried = wording.count_text(answer["tried"], "case")
    lead = f"The best of {tried}" if count == 1 else f"The front has {count} of {tried}, such as"
    lead = lead if is_met else "No case meets the limits; nearest"
    for index, row in enumerate(rows[: MAX_LINES - 2]):
        values = {
            "lead": f"{lead}: " if not index else "",
            "setting": words.setting({path: row[path] for path in words.path_units if row.get(path) is not None}),
            "figures": wording.sentence_list(
                [
                    f"{words.figure(name)} {words.figures(name, [row[name]])[0]}"
                    for name in objectives
                    if row.get(name) is not None
                ]
            ),
            "margin": "" if margins[index] is None else f", {margin_text(margins[index], _limits_of(words, row))}",
        }
        yield Sentence("{lead}{setting}: {figures}{margin}.", values)
    if count > MAX_LINES - 2:
        yield Sentence("{more} more are in optimise.parquet.", {"more": count - MAX_LINES + 2})


def _limits_of(words: Words, row: Mapping[str, Any]) -> list:
    return [limit for limit in words.limits if limit.column in (row.get("limiting") or "").split(",")]


def identify(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the identified values with their intervals."""
    for parameter in answer.get("identified", ())[: MAX_LINES - 1]:
        path = parameter["path"]
        value, low, high = (words.value(path, parameter[key]) for key in ("value", "low", "high"))
        values = {"name": words.axis_name(path), "value": value, "range": from_to(low, high).removeprefix("from ")}
        yield Sentence("{name} {value} (95 %: {range}){note}.", values | {"note": parameter["note"]})
    if not answer.get("explained", True):
        yield Sentence("Misfit: no values of these keys explain the measurement, so the intervals are widened.")


def laws(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Say whether other laws change the verdict on the deciding case."""
    if check := answer.get("laws"):
        yield Sentence("{text}", {"text": check})


def fits(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Say what the verdicts on fits hold for: their mean clearances, and the ends that are covered."""
    if coverage := answer.get("fits"):
        yield Sentence("{text}", {"text": coverage})


def irregular(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Warn that longer runs exceed limits on peaks more often where the motion is not periodic."""
    if count := answer.get("irregular"):
        values = {"count": count, "total": answer["finished"]}
        yield Sentence(
            "{count} of {total} motions are not periodic: longer runs exceed limits on peaks more often.", values
        )


def suggestion(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Suggest a limit for a grid without limits."""
    if limit := answer.get("suggestion"):
        yield Sentence("No limits are set. To judge the cases, add for example: limits: {{{limit}}}", {"limit": limit})


JUDGED = (state, verdict, missing, boundary, fits)
RULES: dict[str, tuple[Rule, ...]] = {
    "limits": (*JUDGED, convergence, touch, laws, effect_lines, own_figures, losses, wear),
    "sample": (state, share, irregular, missing, effect_lines, own_figures, wear),
    "refine": (*JUDGED, added, convergence, effect_lines),
    "seek": (state, seek),
    "optimise": (state, optimise),
    "identify": (state, identify),
    "life": (state, life, verdict, boundary, laws, effect_lines, own_figures),
    "start-up": (state, start_up, force, error, laws, effect_lines, own_figures, wear, suggestion),
    "film": (state, film, effect_lines, losses, force, laws, own_figures, suggestion),
    "force": (state, force, error, convergence, laws, effect_lines, wear, own_figures, suggestion),
}
