"""`identify`: its section, which has the keys with unknown values and the measured signals, and the answer."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from ..answers import features
from ..answers.questions import difference_text, identification_sentences
from ..answers.words import grid_text, number_of_joints
from ..contracts.case import column_name
from ..contracts.layout import Layout
from ..grid.keys import Number
from ..grid.keys.run_keys import CHANNELS
from ..grid.sections import PAIR_SCHEMA, EntriesKey, KeySection, Reader, WordListKey, cases_key, entries_schema
from ..grid.written import WrittenValue
from ..grid.written.tables import read_signals
from ..language.errors import InputError, did_you_mean, mistake_of, quoted
from .identifying import MIN_REVOLUTIONS, Identification, Signal, angular_signals
from .seeking import MISSING_OVER_TEXT, ROUND_SIZE, SEED_KEY, SearchOver

IDENTIFY = "identify"
_PRIOR = "prior"  # the kind of a `Choice`
FEATURES = ("rms", "peaks", "spectrum", "impacts")
SIGNATURE = "signature"  # crest and kurtosis, only on request: without the size, where a gain is not known
MAX_CASES = 20_000  # the time of an emulator grows with their third power
MAX_SAVED_SAMPLES = 12_000  # samples of a signal that every case keeps where the grid does not say how many
MAX_SAMPLES_PER_REVOLUTION = 2880  # samples of a revolution that are kept then
_COLUMN_SCHEMA = {"oneOf": [{"type": "string"}, PAIR_SCHEMA]}
_SIGNAL_EXAMPLE = "{rig.csv: {slider/a: acceleration}}"
IDENTIFY_SECTION = KeySection(
    IDENTIFY,
    "search for the values of keys that reproduce measured signals",
    "{over: {joints.rod-slider.clearance: [20 um, 300 um]}, from: {rig.csv: {slider/a: acceleration}}, cases: 400}",
    (
        EntriesKey(
            "over",
            "dotted path -> [low, high], the range of its prior",
            required=True,
            missing=f"{MISSING_OVER_TEXT}, such as {{joints.rod-slider.clearance: [20 um, 300 um]}}",
            entry=PAIR_SCHEMA,
        ),
        EntriesKey(
            "from",
            "CSV file in the directory of the grid -> {channel: column} of the measured signals; for joints/J/x of a "
            "gear or coupling [input, output], the columns of two encoders",
            required=True,
            missing=f"; give a file, a channel and the column of the file: {_SIGNAL_EXAMPLE}",
            entry=entries_schema(_COLUMN_SCHEMA),
        ),
        cases_key(ROUND_SIZE, MAX_CASES),
        WordListKey(
            "features",
            f"a list of {', '.join(FEATURES)}, and {SIGNATURE} (crest and kurtosis); default: all but that",
            words=(*FEATURES, SIGNATURE),
            default=FEATURES,
            noun="feature of a signal",
        ),
        SEED_KEY,
    ),
)


@dataclass(frozen=True)
class Identify(SearchOver):
    """The section `identify`, in SI."""

    name: ClassVar[str] = IDENTIFY
    keys: ClassVar[KeySection] = IDENTIFY_SECTION
    example: ClassVar[str] = (
        "identify: {over: {joints.rod-slider.clearance: [20 um, 300 um]}, from: {rig.csv: {slider/a: "
        "acceleration}}, cases: 400}"
    )
    answer_key: ClassVar[str] = "identified"
    rows_answer: ClassVar[bool] = False
    conflicts: ClassVar[tuple[str, ...]] = ("sweep", "zip", "cases", "sample", "seek", "refine", "optimise", "life")
    seconds_per_choice: ClassVar[float] = 0.045
    library: ClassVar[tuple[str, str]] = "sklearn", "scikit-learn"
    at_work: ClassVar[Callable[..., Any]] = Identification
    signals: tuple[Signal, ...]
    features: tuple[str, ...]  # some of FEATURES
    cycle_rate: float | None = None  # rad/s, of a phase over the cycles of a run, if it has any

    def resolved_fields(self) -> dict[str, Any]:
        """Return the files of signals and the features."""
        files: dict[str, dict[str, str | list[str]]] = {}
        for signal in self.signals:
            columns = [signal.column, signal.output] if signal.output else signal.column
            files.setdefault(signal.file, {})[signal.channel] = columns
        return {"from": files, "features": list(self.features)}

    def result_channels(self) -> list[str]:
        """Return the channels of the signals, over time and crank angle."""
        return ["t", "crank_angle", *(signal.channel for signal in self.signals)]

    @classmethod
    def missing_answer(cls, answer: Mapping[str, Any]) -> str:
        """Return that nothing is identified."""
        return "" if answer.get("identified") else "`identify` has no answer"

    @classmethod
    def table_columns(cls, record: Mapping[str, Any]) -> set[str]:
        """Return the columns of identify.parquet."""
        return {*record["units"], "weight"}

    @classmethod
    def lines(cls, facts: Mapping[str, Any]) -> list[str]:
        """Return the lines that compare the best cases with the measured signals, feature by feature."""
        lines = ["", "The best cases compared with the measured signals"]
        for fit in facts["fits"]:
            measured, computed = (grid_text(fit[name], fit["unit"]) for name in ("measured", "computed"))
            discrepancy = difference_text(fit)
            lines.append(f"  {fit['channel']}, {fit['feature']}: {measured} measured, {computed} computed{discrepancy}")
        joints = number_of_joints(parameter["path"] for parameter in facts["parameters"])
        lines += ["", f"Identified by {facts['finished']:,} finished cases of {facts['looked_at']:,}"]
        return [*lines, *(f"  {sentence}" for sentence in identification_sentences(facts, joints))]

    @classmethod
    def read_choice(cls, reader: Reader, key: str, written: WrittenValue) -> tuple[str, WrittenValue] | None:
        """Return path and ends of an entry of `over`."""
        used_key = reader.keys_in_use.get(key)
        is_whole = isinstance(used_key, Number) and any(key_use.field.integer for key_use in used_key.uses)
        if not isinstance(written.value, list) or len(written.value) != 2 or is_whole:
            fraction_text = "a path of a quantity that may have a fraction"
            range_text = "[low, high], the range of its prior"
            message = f"found {quoted(written.value)}; expected {fraction_text if is_whole else range_text}"
            reader.problems.add(written, f"{IDENTIFY}.over.{key}", message)
            return None
        reader.choices[key] = _PRIOR
        return key, written

    @classmethod
    def read(cls, reader: Reader, root: WrittenValue) -> "Identify | None":
        """Return the section `identify`, or None if it is missing or wrong; the axes must have been read.

        The signals have no units yet; `check` adds them once the channels are known.  Keys of `save` that the grid
        omits are set to what the signals need.
        """
        section = super().read(reader, root)
        if section:
            _set_saved_signals(reader, section.signals)
        return section

    @classmethod
    def read_own(cls, reader: Reader, section: WrittenValue) -> dict[str, Any]:
        """Return the signals and features; `save` must keep time histories."""
        signals = _read_signals_section(reader, section)
        features = IDENTIFY_SECTION.value(reader.problems, section, "features")
        if reader.values.get("save.orbits") != "last":
            position = reader.position_of("save.orbits")
            message = f"found {reader.values.get('save.orbits')}; `identify` needs last: it compares time histories"
            reader.problems.add(position, "save.orbits", message)
        return {"signals": signals, "features": features} if signals else {}

    def check(self, reader: Reader, root: WrittenValue, layout: Layout) -> "Identify":
        """Return the section with the units of its signals; report mistakes in the files and in the saved channels."""
        written = root.value[IDENTIFY].value["from"]
        units = {channel.name: channel.unit for channel in layout.channels if channel.unit and channel.name != "t"}
        signals = [signal._replace(unit=units.get(signal.channel, "")) for signal in self.signals]
        signals = [
            signal._replace(arms=_arms(reader, signal.channel)) if signal.output else signal for signal in signals
        ]
        for signal in signals:
            if not signal.unit:
                suggestion = did_you_mean(signal.channel, units) or f" (known: {', '.join(units)})"
                reader.problems.add(written, f"{IDENTIFY}.from", f"there is no channel '{signal.channel}'{suggestion}")
            elif signal.output and not signal.arms:
                message = (
                    f"{signal.channel} has the columns of two encoders, which only joints/J/x of a gear or a coupling "
                    "with one ratio, radius and pressure_angle compares; write one column"
                )
                reader.problems.add(written, f"{IDENTIFY}.from", message)
        unsaved = sorted({signal.channel for signal in signals if signal.unit} - {*reader.values.get(CHANNELS, units)})
        if unsaved:
            reader.report(CHANNELS, f"lacks {', '.join(unsaved)}, which `identify` compares; add it")
        saved_revolutions = reader.values.get("save.revolutions") or 2.0
        if saved_revolutions < MIN_REVOLUTIONS:
            message = (
                f"found {saved_revolutions:g}; `identify` needs at least {MIN_REVOLUTIONS} revolutions that a case "
                "saves"
            )
            reader.report("save.revolutions", message)
        signals = [signal for signal in signals if signal.unit and bool(signal.output) == bool(signal.arms)]
        for file in dict.fromkeys(signal.file for signal in signals):
            file_signals = [signal for signal in signals if signal.file == file]
            if mistake := mistake_of(angular_signals, file, file_signals, crank_rate(reader)):
                reader.problems.add(written, f"{IDENTIFY}.from", mistake)
        return replace(self, signals=tuple(signals), cycle_rate=_cycle_rate(reader))


def _arms(reader: Reader, channel: str) -> tuple[float, ...]:
    """Return the arms (m, or 1) of both angles of a gear or coupling whose position a channel has; () of another."""
    joint = next((joint for joint in reader.outline.joints if channel == f"joints/{column_name(joint.name)}/x"), None)
    if joint is None or joint.type not in ("gear", "coupling"):
        return ()
    if joint.type == "coupling":
        return 1.0, -1.0
    paths = (f"mechanism.joints.{joint.name}.{key}" for key in ("radius", "pressure_angle", "ratio"))
    sizes = [reader.values_of(path) for path in paths]
    if any(len(values) != 1 for values in sizes):
        return ()
    radius, angle, ratio = (float(values[0]) for values in sizes)
    return radius * math.cos(angle), radius * math.cos(angle) * ratio


def _read_signals_section(reader: Reader, section: WrittenValue) -> tuple[Signal, ...]:
    """Return the signals as they are written."""
    files = IDENTIFY_SECTION.value(reader.problems, section, "from")
    signals = []
    for name, columns in files.value.items() if files else ():
        if not isinstance(columns.value, dict) or not columns.value:
            message = f"found {quoted(columns.value)}; expected channel: column, such as {_SIGNAL_EXAMPLE}"
            reader.problems.add(columns, f"{IDENTIFY}.from.{name}", message)
            continue
        folder = Path(columns.origin).parent if columns.line else Path()
        file = str((folder / name).absolute())
        for channel, column in columns.value.items():
            is_pair = isinstance(column.value, list)
            names = [item.value for item in column.value] if is_pair else [column.value]
            if len(names) == 1 + is_pair and all(isinstance(each, str) for each in names):
                signals.append(Signal(file, channel, names[0], "", *names[1:]))
            else:
                message = f"found {quoted(column.value)}; expected the name of a column, or [input, output] of encoders"
                reader.problems.add(column, f"{IDENTIFY}.from.{name}.{channel}", message)
    return tuple(signals)


def _set_saved_signals(reader: Reader, identified: Sequence[Signal]) -> None:
    """Set the keys of `save` that `identify` needs and the grid omits: revolutions, samples, channels."""
    rate = crank_rate(reader)
    max_density = 0.0
    for file in {signal.file for signal in identified}:
        columns = {column: None for signal in identified if signal.file == file for column in signal.columns}
        try:
            signals = read_signals(file, columns, allow_others=True)
        except InputError:
            continue  # `check` says what is wrong
        angle = signals.abscissa if signals.over == "crank_angle" else signals.abscissa * (rate or 1.0)
        max_density = max(max_density, features.samples_per_revolution(angle))
    if "save.samples" not in reader.written:
        reader.values["save.samples"] = int(
            min(max(features.MIN_SAMPLES, 2.0 * max_density), MAX_SAMPLES_PER_REVOLUTION)
        )
    if "save.revolutions" not in reader.written:
        samples = reader.values["save.samples"]
        revolutions = min(reader.values_of("simulate.revolutions") or reader.values_of("simulate.cycles") or (10.0,))
        counted_revolutions = revolutions - max(reader.values_of("simulate.discard") or (2.0,))
        reader.values["save.revolutions"] = float(
            max(min(counted_revolutions, max(MAX_SAVED_SAMPLES // samples, MIN_REVOLUTIONS)), 1)
        )
    if CHANNELS not in reader.written:
        reader.values[CHANNELS] = list(dict.fromkeys(signal.channel for signal in identified))


def crank_rate(reader: Reader) -> float | None:
    """Return the speed of the crank (rad/s), or that of the phase of cycles; None if it is not a single number."""
    speeds = reader.values_of("drive.speed")
    return _cycle_rate(reader) or (float(speeds[0]) if len(speeds) == 1 and speeds[0] else None)


def _cycle_rate(reader: Reader) -> float | None:
    """Return 2 pi over the period (rad/s) of the cycles of a run, None if it has none."""
    periods = reader.values_of("simulate.period")
    return 2.0 * math.pi / float(periods[0]) if len(periods) == 1 else None
