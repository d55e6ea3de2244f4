"""Reads and checks the keys of a run: what is saved of a case (`save`), its time budget, and its life (`life`)."""

from ...contracts.layout import ALWAYS_STORED, Layout
from ...language.errors import nearest, shown
from ..keys.kinds import NameList, Number, Use
from ..keys.run_keys import CHANNELS, LIFE, TIME_BUDGET, TIME_BUDGET_PATH
from ..sections.reader import Reader
from ..written.document import WrittenValue

SHALLOW = 0.1  # of the bearing radius; deeper wear is no longer a small change of shape
WHOLE = 1e-9  # revolutions; tolerance on a whole number of them


def read_channels(reader: Reader, path: str) -> None:
    """Read the names of the time histories that are stored; `check_channels` knows which there are."""
    written, node = reader.written.get(path), reader.shape[path]
    if written is None:
        return
    assert isinstance(node, NameList), path
    items = written.value if isinstance(written.value, list) else []
    invalid = [item for item in items if not isinstance(item.value, str)]
    for item in invalid or ([] if items else [written]):
        sentence = f"found {shown(item.value)}; expected {node.noun}, such as {node.example}"
        reader.problems.add(item, path, sentence)
    if invalid or not items:
        return
    if reader.values.get("save.orbits") == "none":
        sentence = "is not used, as save.orbits is none; leave one of them out"
        reader.problems.add(written, path, sentence)
    else:
        reader.values[path] = list(dict.fromkeys(item.value for item in items))


def check_channels(reader: Reader, layout: Layout) -> None:
    """Note names in `save.channels` that no time history of these cases has."""
    written = reader.written.get(CHANNELS)
    if written is None or CHANNELS not in reader.values:
        return
    allowed = [channel.name for channel in layout.channels if channel.name not in ALWAYS_STORED]
    for item in written.value:
        if isinstance(item, WrittenValue) and item.value not in (*allowed, *ALWAYS_STORED):
            suggestion = nearest(item.value, allowed) or f" (known: {', '.join(allowed)})"
            reader.problems.add(item, CHANNELS, f"there is no channel '{item.value}'{suggestion}")


def put_time_budget(reader: Reader) -> None:
    """Set the default of `patience` from the time budget of a case with a life."""
    if LIFE in reader.shape and TIME_BUDGET_PATH in reader.shape:
        field = TIME_BUDGET._replace(default=None, optional=True)
        reader.shape[TIME_BUDGET_PATH] = Number((Use(field),), sweep=False)


def check_life(reader: Reader) -> None:
    """Report keys that conflict with `life`."""
    if LIFE not in reader.shape:
        return
    joint = reader.values.get(f"{LIFE}.joint")
    if joint is not None:
        _check_limited_joint(reader, str(joint))
    for path, reason in (
        ("simulate.until", "a life makes its blocks as long as the wear rate needs"),
        ("simulate.error_check", "a life gives its own error, in the interval of its revolutions"),
        ("save.worst", "a life has many blocks; its history contains the peak of each"),
    ):
        if path in reader.sections or path in reader.values:
            reader.problems.add(reader.place(path), path, f"has no effect with `life`: {reason}; leave it out")
    _check_blocks(reader)
    _check_periodicity(reader)


def _check_limited_joint(reader: Reader, joint: str) -> None:
    """Check that the limited joint wears, and that its limit is a small change of shape."""
    path, own = f"{LIFE}.joint", f"joints.{joint}"
    if own not in reader.shape:
        wearing = [name.split(".")[1] for name in reader.shape if name.startswith("joints.") and name.endswith(".wear")]
        remedy = f"name one that wears ({', '.join(wearing)})" if wearing else "give it clearance and wear"
        reader.problems.add(reader.place(path), path, f"{joint} has no clearance here; {remedy}")
        return
    if f"{own}.wear" not in reader.shape:
        sentence = "is missing; life needs the wear of its joint; for example: {law: archard, coefficient: 2e-14 m^2/N}"
        reader.problems.add(reader.place(path), f"{own}.wear", sentence)
    limits, radii = reader.values_of(f"{LIFE}.limit"), reader.values_of(f"{own}.bearing_radius")
    if limits and radii and max(limits) > SHALLOW * min(radii):
        path = f"{LIFE}.limit"
        sentence = (
            f"found {reader.text(path, max(limits))}; allowed: at most {SHALLOW:g} of {own}.bearing_radius, "
            f"{reader.text(f'{own}.bearing_radius', min(radii))}: wear must remain a small change of the shape"
        )
        reader.problems.add(reader.place(path), path, sentence)


def _check_blocks(reader: Reader) -> None:
    """Check that blocks are whole revolutions, and that the longest is not below the shortest."""
    path = f"{LIFE}.max_revolutions"
    least, most = reader.values_of("simulate.revolutions"), reader.values_of(path)
    if least and most and min(most) < max(least):
        sentence = (
            f"found {reader.text(path, min(most))}; allowed: at least "
            f"{reader.text('simulate.revolutions', max(least))}, the value of simulate.revolutions, the shortest block"
        )
        reader.problems.add(reader.place(path), path, sentence)
    discards = reader.values_of("simulate.discard") or (2.0,)
    for turns in least:
        for discard in discards:
            window = turns - (discard if turns > 2.0 or reader.is_given("simulate.discard") else 0.0)
            if abs(window - round(window)) > WHOLE or round(window) < 1:
                where = "simulate.revolutions"
                sentence = (
                    f"found {window:.6g} revolutions after simulate.discard; with life the number must be whole, "
                    "as their wear is extrapolated to all revolutions"
                )
                reader.problems.add(reader.place(where), where, sentence)
                return


def _check_periodicity(reader: Reader) -> None:
    """Check that drive and loads repeat every revolution."""
    tables = {path: values for path, values in reader.values.items() if isinstance(values, dict)}
    for path, table in tables.items():
        if path.startswith(("drive.", "loads.")) and "time" in table:
            sentence = (
                "depends on time, but `life` assumes a periodic drive: write a table over "
                "crank_angle, or a constant speed"
            )
            reader.problems.add(reader.place(path), path, sentence)
