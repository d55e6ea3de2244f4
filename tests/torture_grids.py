"""Mutated grids: each is rejected or runs, within seconds, without a traceback and without changes outside its
directory.

Keys and values of valid grids are replaced by others of the schema and by hostile ones, and their bytes are corrupted.
Each grid is given to the command line in a child of this process, which has loaded everything and compiled a few kinds
of scene; mechanics of other kinds, and long runs, are truncated.
"""

import contextlib
import copy
import io
import os
import random
import resource
import shutil
import signal
import sys
import time
from collections import Counter
from pathlib import Path
from typing import NamedTuple

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import seed as seeded
from hypothesis import strategies as st
from ruamel.yaml import YAML

from clearsweep import cli, grid, simulation
from clearsweep.grid.pages.schema import whole_schema
from clearsweep.language.errors import ClearsweepError
from clearsweep.sweeping import sweep
from clearsweep.sweeping.pool.case_runner import SIMULATION
from clearsweep.sweeping.pool.worker import failure

ROOT = Path(__file__).parent.parent
SECONDS = 5.0  # time limit of a grid
SPACE = 6_000_000_000  # limit of address space, bytes
MOST_CASES = 6  # largest number of cases run; of a larger grid only the first and the last are examined
COMPILED = ("frictionless.yaml", "impact_pair.yaml", "two_joints.yaml")  # their kinds of scene run, others do not
HOSTILE = (
    *(None, True, False, 0, -1, 1, 3, 10**30, 1e300, -1e300, 5e-324, float("nan"), float("inf"), 0.1, 1e-9),
    *("", " ", "~", "x" * 5000, "0", "1", "-1", "1e999", "nan", "inf", "1 mm", "1 rpm", "1 kg", "0.5", "1e9 N/m^1.5"),
    *(
        "1 mm^9^9^9",
        "1 mm^(10**10)",
        "1e400 m",
        "1 mm" + "*mm" * 500,
        "1 µm",
        "1 °",
        "\u0661 mm",
        "1\u202emm",
        "\x1b]0;x\x07",
    ),
    *("\ud800", "\x00", "../../up", "/etc/passwd", "/dev/zero", "a/b", "con", "-rf", "{{7*7}}", "${HOME}", "%s%n"),
    *([], {}, [[]], [1], [1] * 2000, ["1 mm", "2 mm"], {"": ""}, {"linspace": ["1 mm", "2 mm", 3]}, {"from": 1}),
    {"linspace": [0, 1, 10**9]},
    {"linspace": ["1 mm", "2 mm", 10**6]},
    {"geomspace": [0, 1, 3]},
    {"logspace": [-400, 400, 5]},
    {"normal": {"mean": "1 mm", "cv": 1e300}},
    {"uniform": {"low": "2 mm", "high": "1 mm"}},
)
UNITS = ("m", "mm", "rpm", "rad/s", "kg", "N/m^1.5", "N/m", "m^2/N", "Pa", "GPa", "m/s", "kg*m^2", "1", "%", "furlong")

MILD = ("number", "number", "number", "word", "copy")  # what becomes of a value
WAYS = (*MILD, "hostile", "hostile", "quantity", "remove", "rename", "insert", "insert")


class Ended(NamedTuple):
    """Result of a grid."""

    code: int | None  # None: not within SECONDS
    seconds: float
    said: str

    @property
    def fault(self) -> str:
        """Return the fault of the result, or ''."""
        if self.code is None:
            return "did not end in time"
        if "OUTSIDE " in self.said:
            return "wrote outside its directory"
        if "Traceback" in self.said or "internal error" in self.said:
            return "traceback"
        return "" if self.code in (0, 2, 3) else f"exit code {self.code}"


def schema_keys() -> dict[str, list]:
    """Return the dotted paths of all keys of a grid, each with the words that it takes, if it takes words."""
    keys: dict[str, list] = {}

    def look(node, path):
        for key, inner in node.get("properties", {}).items():
            keys.setdefault(f"{path}{key}", []).extend(inner.get("enum", []))
            look(inner, f"{path}{key}.")
        for branch in node.get("anyOf", []):
            look(branch, path)

    look(whole_schema(simulation.catalogue()), "")
    return keys


def grids_that_work() -> list[dict]:
    """Return the grids of configs/ and the one to start from, as plain values."""
    texts = [path.read_text(encoding="utf-8") for path in sorted((ROOT / "configs").glob("*.yaml"))]
    return [YAML(typ="safe", pure=True).load(text) for text in [*texts, grid.starter()]]


def places(node, path=()):
    """Yield the path of every value in a document, as a tuple of keys and indices."""
    inner = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in inner:
        yield (*path, key)
        yield from places(value, (*path, key))


def at(document, path):
    for key in path:
        document = document[key]
    return document


@st.composite
def mutated(draw, documents, keys):
    """Draw the bytes of a grid."""
    document = copy.deepcopy(draw(st.sampled_from(documents)))
    amount = st.floats(allow_nan=True, allow_infinity=True) | st.floats(0.0, 10.0) | st.integers(-(10**6), 10**6)
    quantity = st.builds("{} {}".format, amount, st.sampled_from(UNITS)) | amount
    mild = draw(st.booleans())  # such grids are mostly valid
    ways = MILD if mild else WAYS
    for _ in range(draw(st.integers(1, 1 if mild else 3))):
        known = list(places(document))
        if not known:
            break
        path = draw(st.sampled_from(known))
        parent, key = at(document, path[:-1]), path[-1]
        way = draw(st.sampled_from(ways))
        if way == "number":
            parent[key] = rescaled(parent[key], draw(st.floats(-1.0, 1.0) | st.sampled_from([-300.0, -9.0, 6.0, 30.0])))
        elif way == "hostile":
            parent[key] = copy.deepcopy(draw(st.sampled_from(HOSTILE)))
        elif way == "quantity":
            parent[key] = draw(quantity)
        elif way == "word":
            words = keys.get(".".join(map(str, path)))
            parent[key] = draw(st.sampled_from(words)) if words else draw(st.text(max_size=8))
        elif way == "remove":
            del parent[key]
        elif way == "rename" and isinstance(parent, dict):
            parent[draw(st.sampled_from([str(key)[:-1], f"{key}x", str(key).upper(), "", "9"]))] = parent.pop(key)
        elif way == "copy":
            parent[key] = copy.deepcopy(at(document, draw(st.sampled_from(known))))
        else:
            insert(document, draw(st.sampled_from(sorted(keys))), draw, quantity, keys)
    target = io.BytesIO()
    YAML().dump(document, target)
    return spoiled(target.getvalue(), draw) if not mild and draw(st.booleans()) else target.getvalue()


def rescaled(value, power):
    """Return a quantity times a power of ten, its unit kept; any other value as it is."""
    number, _, unit = str(value).partition(" ")
    try:
        return f"{float(number) * 10.0**power:.6g} {unit}".strip()
    except ValueError:
        return value


def insert(document, path, draw, quantity, keys):
    """Write a key of the schema into a document, with a word or a number that may fit."""
    *parents, last = path.split(".")
    for name in parents:
        if not isinstance(document.get(name), dict):
            document[name] = {}
        document = document[name]
    document[last] = draw(st.sampled_from(keys[path])) if keys[path] else draw(quantity)


def spoiled(content, draw):
    """Return bytes with a few of them changed, inserted, removed or doubled."""
    content = bytearray(content)
    for _ in range(draw(st.integers(1, 4))):
        place = draw(st.integers(0, len(content)))
        way = draw(st.sampled_from(["flip", "put", "cut", "double", "end"]))
        if way == "flip" and place < len(content):
            content[place] ^= 1 << draw(st.integers(0, 7))
        elif way == "put":
            content[place:place] = draw(st.binary(min_size=1, max_size=4))
        elif way == "cut":
            del content[place : place + draw(st.integers(1, 40))]
        elif way == "double":
            content[place:place] = content[place : place + draw(st.integers(1, 400))]
        elif way == "end":
            del content[place:]
    return bytes(content)


def drawn(count: int, seed: int) -> list[bytes]:
    """Return `count` different mutated grids, determined by the seed."""
    result: dict[bytes, None] = {}
    quietly = {"database": None, "deadline": None, "suppress_health_check": list(HealthCheck)}

    @seeded(seed)
    @settings(max_examples=2 * count + 10, phases=[Phase.generate], **quietly)
    @given(mutated(grids_that_work(), schema_keys()))
    def collect(content):
        result[content] = None

    collect()
    return list(result)[:count]


class Short:
    """Mechanics of compiled kinds, over two revolutions; scenes of other kinds are only built."""

    def __init__(self):
        """Compile the kinds of scene of COMPILED."""
        self.known = set()
        for name in COMPILED:
            case = sweep.load(ROOT / "configs" / name).case(0)
            self.known.add(simulation.signature(case))
            for method in ("explicit", "implicit"):  # stiff scenes change to the latter automatically
                of_kind = case._replace(simulate=case.simulate._replace(method=method))
                simulation.compile_for(of_kind)
                self.solve(of_kind)

    def __getattr__(self, name):
        return getattr(SIMULATION, name)

    def compile_for(self, case):
        """Compile nothing."""

    compile_loop = compile_for

    def solve(self, case):
        """Return the result of a truncated case."""
        limits = case.simulate
        short = limits._replace(
            revolutions=min(limits.revolutions, 2.0),
            discard=min(limits.discard, 1.0) if limits.revolutions > 1.0 else 0.0,
            impacts=min(limits.impacts, 3),
            step_budget=min(limits.step_budget, 50_000),
            event_budget=min(limits.event_budget, 1000),
            error_check=False,
            horizon=False,
            until=None,
        )
        save = case.save._replace(revolutions=min(case.save.revolutions, 1.0))
        case = case._replace(simulate=short, save=save)
        if simulation.signature(case) in self.known:
            return simulation.solve(case)
        simulation.build(case)
        return failure("crashed", "no code is compiled for this kind of scene here")


def swept(mechanics):
    """Return a substitute for `sweep` that runs a few cases in this process."""

    def run(source, out=None, **options):
        read = sweep.load(source, mechanics)
        if len(read) > MOST_CASES:
            for index in (0, len(read) - 1):
                read.case(index), read.case_id(index)
            sweep.facts(read, mechanics)
            raise ClearsweepError(f"{len(read)} cases are too many to run them here")
        options |= {"executor": "serial"}
        return sweep.run_sweep(read, out, sweep.Options(**options), mechanics)

    return run


def watch(inside: Path) -> None:
    """Report on stderr if this process opens for writing, creates, renames or removes anything outside `inside`."""
    changes = {"os.mkdir": 1, "os.rename": 2, "os.link": 2, "os.symlink": 2, "os.remove": 1, "os.rmdir": 1}
    root = os.path.realpath(inside)

    def look(event, args):
        if event == "open":
            paths = [args[0]] if args[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT) else []
        else:
            paths = args[: changes.get(event, 0)]
        for path in paths:
            if isinstance(path, (str, bytes, os.PathLike)):
                full = os.path.realpath(os.fsdecode(path))
                if not full.startswith(f"{root}{os.sep}") and full not in (root, os.devnull):
                    os.write(2, f"OUTSIDE {event} {full}\n".encode("utf-8", "replace"))

    sys.addaudithook(look)


def run(content: bytes, place: Path, mechanics, arguments=()) -> Ended:
    """Give a grid to the command line in a child process whose working directory is `place`."""
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    (place / "grid.yaml").write_bytes(content)
    begin = time.monotonic()
    child = os.fork()
    if not child:
        code = 99
        with contextlib.suppress(BaseException):
            code = _in_child(place, mechanics, arguments)
        os._exit(code)
    ended, status = 0, 0
    while not ended and time.monotonic() - begin < SECONDS:
        ended, status = os.waitpid(child, os.WNOHANG)
        time.sleep(0.002)
    seconds = time.monotonic() - begin
    if not ended:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    text = (place / "said").read_text(encoding="utf-8", errors="replace")
    strangers = {path.name for path in place.iterdir()} - {"grid.yaml", "said", "results", "out"}
    text += "".join(f"OUTSIDE {name}\n" for name in strangers)
    return Ended(os.waitstatus_to_exitcode(status) if ended else None, seconds, text)


def _in_child(place: Path, mechanics, arguments) -> int:
    os.setsid()
    os.chdir(place)
    text = os.open("said", os.O_WRONLY | os.O_CREAT)
    for number in (1, 2):
        os.dup2(text, number)
    sys.stdout, sys.stderr = sys.__stdout__, sys.__stderr__
    resource.setrlimit(resource.RLIMIT_AS, (SPACE, SPACE))
    sweep.sweep = swept(mechanics)
    watch(place / ("out" if "--out" in arguments else "results"))
    try:
        cli.main(["run", "grid.yaml", *arguments])
    except SystemExit as ended:
        sys.stdout.flush()
        sys.stderr.flush()
        return 0 if "are too many to run them here" in Path("said").read_text(errors="replace") else int(ended.code)


def fuzz(count: int, seed: int, folder: Path, describe=print) -> dict:
    """Run `count` mutated grids below `folder`; return counts by exit code and the faults; a grid at fault is kept."""
    mechanics, chance = Short(), random.Random(seed)
    codes, faults, longest = Counter(), [], 0.0
    for number, content in enumerate(drawn(count, seed)):
        arguments = ["--out", "out"] if chance.random() < 0.5 else []
        ended = run(content, folder / "grid", mechanics, arguments)
        codes[ended.code] += 1
        longest = max(longest, ended.seconds)
        if ended.fault:
            kept = folder / f"grid{number}.yaml"
            kept.write_bytes(content)
            faults.append((kept.name, ended.fault))
            describe(f"{kept}: {ended.fault}: {ended.said[-600:]}")
    return {"grids": codes.total(), "codes": dict(codes), "faults": faults, "longest": longest}


def main() -> int:
    """Fuzz as the arguments say: how many grids, seed, folder."""
    count, seed, folder = int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3])
    folder.mkdir(exist_ok=True, parents=True)
    begin = time.monotonic()
    result = fuzz(count, seed, folder)
    print(result, f"{time.monotonic() - begin:.0f} s")
    return bool(result["faults"])


if __name__ == "__main__":
    sys.exit(main())
