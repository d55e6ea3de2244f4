"""An adversary's list of command lines, which must end in time, with a sentence, and leave other files unchanged.

Each attempt is a shell script, in its own folder with a grid `g.yaml` and a finished run `ok` of it.
"""

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

from right_grids import text_of

SECONDS = 60.0  # time limit of an attempt, including loading and compiling
TROUBLE = re.compile(r"Traceback|internal error|[\x00-\x08\x0b-\x1f\x7f]")

THOUSAND = "{{linspace: [{low}, {high}, 1000]}}"
AXES = {
    "joints.rod-slider.clearance": ("0.1 mm", "0.5 mm"),
    "drive.speed": ("1000 rpm", "5000 rpm"),
    "mechanism.slider.mass": ("0.1 kg", "0.2 kg"),
    "mechanism.rod.mass": ("0.1 kg", "0.2 kg"),
    "mechanism.crank.mass": ("0.1 kg", "0.2 kg"),
    "mechanism.rod.inertia": ("1e-4", "2e-4"),
    "mechanism.crank.inertia": ("1e-4", "2e-4"),
}
GRID = text_of("a crank of attempts")
SWEEP = "sweep:\n  joints.rod-slider.clearance: {linspace: [0.1 mm, 0.5 mm, 6]}\n"


class TrialStep(NamedTuple):
    """One attempt, and its required result."""

    name: str
    script: str
    codes: tuple[int, ...] = (2,)
    said: str = ""


def edited(old: str, new: str, verb: str = "run g.yaml --out x") -> str:
    """Return a script that runs the grid with a text replaced; backslash sequences are for printf."""
    return f"""python - <<'END'
text = open("g.yaml").read()
assert {old!r} in text
open("g.yaml", "w").write(text.replace({old!r}, {new!r}, 1))
END
clearsweep {verb}"""


def axes(count: int) -> str:
    """Return a script that previews a grid with `count` axes of a thousand values."""
    lines = [f"  {path}: {THOUSAND.format(low=low, high=high)}" for path, (low, high) in list(AXES.items())[:count]]
    return edited(SWEEP, "sweep:\n" + "\n".join(lines) + "\n", "run g.yaml --dry-run")


def spares(harm: str, check: str, verb: str = "run g.yaml --out ok") -> str:
    """Return a script that damages the run, then runs its grid, then checks the parts that must not have changed."""
    return f"{harm}; clearsweep {verb}; c=$?; {check} || exit 99; exit $c"


ATTEMPTS = (
    TrialStep("a tag on a section", edited("mechanism:\n", "mechanism: !!python/object:os.system\n"), said="tag"),
    TrialStep("1 mm^(10**10)", edited("0.5 mm", "1 mm^(10**10)")),
    TrialStep("1 mm^2^2^2^2^2^9", edited("0.5 mm", "1 mm^2^2^2^2^2^9")),
    TrialStep("an escape sequence in a unit", edited("0.5 mm", '"1 \\e]0;x\\a\\e[31mx"'), said="clearance"),
    TrialStep("an escape sequence in a key", edited("drive:", '"\\e[2Jkey": 1\ndrive:'), said="unknown key"),
    TrialStep("1e9 revolutions with all orbits", edited("3, discard: 1}", "1e9}\nsave: {orbits: all}")),
    TrialStep("1e300 revolutions", edited("revolutions: 3", "revolutions: 1e300")),
    TrialStep("/dev/zero as a grid", "clearsweep run /dev/zero --dry-run", said="regular file"),
    TrialStep("a pipe as a grid", "mkfifo p; clearsweep run p --dry-run", said="regular file"),
    TrialStep("a grid of 70 MB", "head -c 70000000 /dev/zero | tr '\\0' '#' >big; clearsweep run big", said="bytes"),
    TrialStep("/dev/zero as a table", "ln -s /dev/zero t.csv; " + edited(SWEEP, "cases: t.csv\n"), said="regular file"),
    *(TrialStep(f"{count} axes of 1,000 values", axes(count), said="at most") for count in (3, 7)),
    TrialStep(
        "a lognormal cv of 1e300",
        edited(
            SWEEP,
            "sample: {method: random, n: 4, seed: 1, over: {drive.speed: {lognormal: {mean: 5 rpm, cv: 1e300}}}}\n",
        ),
    ),
    *(
        TrialStep(
            f"--{option} {value}", f"clearsweep run g.yaml --out x --{option} {value}", said=option.replace("-", " ")
        )
        for option, value in (
            *(("case-timeout", value) for value in ("nan", "inf", "-1")),
            *(("max-failures", value) for value in ("nan", "inf", "1e999", "5%%")),
        )
    ),
    TrialStep(
        "files of the user where a run would write",
        "mkdir -p d/shards d/tmp; echo precious >d/shards/mine.h5; echo precious >d/tmp/mine; "
        + spares("true", "grep -q precious d/shards/mine.h5 && grep -q precious d/tmp/mine", "run g.yaml --out d"),
        (0, 2),
    ),
    TrialStep(
        "a load without a name",
        edited("drive:", "loads: {a b: {on: slider, fx: 1 N}}\ndrive:"),
        said="is not a valid name",
    ),
    TrialStep("a mass of 1e308 kg", edited("0.14 kg", "1e308 kg"), said="out of range"),
    TrialStep(
        "a speed of zero",
        "printf 'time [s],speed [rpm]\\n0,0\\n1,0\\n' >s.csv; " + edited("5000 rpm}", "{table: s.csv}}"),
        said="is 0 in every row",
    ),
    TrialStep(
        "a list for the column of a limit",
        edited(SWEEP, SWEEP + "limits: {rod_slider_force_peak: {at_most: 1, times: [a]}}\n"),
        said="is not a column of this grid",
    ),
    TrialStep(
        "a list for a unit",
        edited(SWEEP, "sweep: {joints.rod-slider.clearance: {logspace: [1, 2, 3, [mm]]}}\n"),
        said="a list as the unit",
    ),
    *(
        TrialStep(
            f"parts/{name} of the user",
            spares(f"echo precious >ok/parts/{name}", f"grep -q precious ok/parts/{name}"),
            (0,),
        )
        for name in ("notes.txt", ".DS_Store", "mine.parquet")
    ),
    TrialStep(
        "the lock is a link to a file",
        spares("rm ok/lock; echo precious >v; ln -s ../v ok/lock", "grep -qx precious v"),
        said="lock",
    ),
    TrialStep("the lock is a pipe", "rm ok/lock; mkfifo ok/lock; clearsweep run g.yaml --out ok", said="lock"),
    TrialStep("tmp is a link", spares("mkdir v; rm -rf ok/tmp; ln -s ../v ok/tmp", '[ -z "$(ls -A v)" ]'), (0, 2)),
    *(
        TrialStep(
            f"a folder in {name}", spares(f"mkdir -p ok/{name}/sub.parquet", f"[ -d ok/{name}/sub.parquet ]"), (0, 2)
        )
        for name in ("parts", "shards")
    ),
    TrialStep(
        "a pipe in place of histories",
        "s=$(ls ok/shards/* | head -1); rm $s; mkfifo $s; clearsweep run g.yaml --out ok",
        said="pipe",
    ),
    TrialStep(
        "summary.parquet is a folder",
        "rm ok/summary.parquet; mkdir ok/summary.parquet; clearsweep run g.yaml --out ok",
        said="directory",
    ),
    *(
        TrialStep(
            f"run.json is {name}",
            f"{make} >ok/run.json; clearsweep report ok; [ $? = 2 ] || exit 99; clearsweep run g.yaml --out ok",
            (0,),
            "run.json",
        )
        for name, make in (
            ("{}", "echo {}"),
            ("[]", "echo []"),
            ("nested deeply", "python -c \"print('['*100000+']'*100000)\""),
        )
    ),
    TrialStep("report --out: a pipe", spares("mkfifo p", "[ -p p ]", "report ok --out p"), said="pipe"),
    TrialStep(
        "report --out: a folder", spares("mkdir f", '[ -z "$(ls -A f)" ]', "report ok --out f"), said="directory"
    ),
    TrialStep(
        "head -1 of a run",
        'clearsweep run g.yaml --out x 2>&1 | head -1; [ -e x/summary.parquet ] || exit 99; exit "${PIPESTATUS[0]}"',
        (0,),
    ),
)


class Result(NamedTuple):
    """Result of an attempt."""

    attempt: TrialStep
    code: int | None  # None: not within SECONDS
    seconds: float
    said: str

    @property
    def fault(self) -> str:
        """Return the fault of the result, or ''."""
        if self.code is None:
            return "did not end in time"
        if trouble := TROUBLE.search(self.said):
            return f"said {trouble.group()!r}"
        if self.code not in self.attempt.codes:
            return f"exit code {self.code}"
        return "" if self.attempt.said in self.said else f"did not say {self.attempt.said!r}"


def prepared(folder: Path) -> dict[str, str]:
    """Create a folder with the grids, a finished run and the command; return the environment of the attempts."""
    (folder / "bin").mkdir(parents=True)
    program = (
        f"#!{sys.executable}\nfrom clearsweep.__main__ import main\nmain()\n"  # no shell, which needs files of its own
    )
    (folder / "bin" / "clearsweep").write_text(program)
    (folder / "bin" / "clearsweep").chmod(0o755)
    root, python = Path(__file__).parent.parent, Path(sys.executable).parent
    environment = os.environ | {
        "PYTHONPATH": str(root),
        "PATH": os.pathsep.join([str(folder / "bin"), str(python), os.environ["PATH"]]),
    }
    fresh = folder / "fresh"
    fresh.mkdir()
    (fresh / "g.yaml").write_text(GRID + SWEEP)
    subprocess.run(
        ["clearsweep", "run", "g.yaml", "--out", "ok"], cwd=fresh, env=environment, check=True, capture_output=True
    )
    return environment


def tried(attempt: TrialStep, folder: Path, environment: dict[str, str]) -> Result:
    """Return the result of an attempt in a copy of the prepared folder."""
    place = folder / "place"
    shutil.rmtree(place, ignore_errors=True)
    shutil.copytree(folder / "fresh", place)
    begin = time.monotonic()
    with subprocess.Popen(
        ["bash", "-c", attempt.script],
        cwd=place,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    ) as process:
        try:
            text, code = process.communicate(timeout=SECONDS)[0], process.returncode
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, 9)
            text, code = process.communicate()[0], None
    return Result(attempt, code, time.monotonic() - begin, text.decode("utf-8", "replace"))


def try_all(folder: Path, describe=print) -> list[Result]:
    """Run all attempts and return their results; report faults."""
    environment = prepared(folder)
    results = [tried(attempt, folder, environment) for attempt in ATTEMPTS]
    for result in results:
        if result.fault:
            describe(f"{result.attempt.name}: {result.fault}: {result.said[-400:]}")
    return results
