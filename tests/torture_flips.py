"""Flipped bits: one bit of every file of a run is changed; no reader may accept it as the original."""

import contextlib
import io
import random
import shutil
from collections import Counter
from pathlib import Path

import clearsweep
from clearsweep import cli, exit_codes
from clearsweep.contracts.results import TIMINGS
from clearsweep.language.errors import ClearsweepError

NAMED, UNREAD, UNNAMED, SILENT, FAULT = "named", "without meaning", "unnamed", "silent", "traceback"
PASSING = ("start", "end", "counts", "checksum", "merged")  # of run.json: they differ between any two runs


def content(directory: Path) -> str:
    """Return everything that a reader gets from a run, without timings."""
    run = clearsweep.open(directory)
    known = {key: value for key, value in run.grid.items() if key not in PASSING}
    summary = run.summary.drop(columns=list(TIMINGS))
    parts = [known, summary.to_dict("list"), run.summary.attrs]
    for case_id in summary["case_id"]:
        parts += [run.orbit(case_id).to_dict("list"), run.events(case_id).to_dict("list")]
        parts += [[depths.tobytes() for depths in pair] for pair in run.wear(case_id).values()]
    return repr(parts)


def flip(path: Path, chance: random.Random) -> None:
    """Change one bit of a file."""
    changed = bytearray(path.read_bytes())
    changed[chance.randrange(len(changed))] ^= 1 << chance.randrange(8)
    path.write_bytes(changed)


def command(*arguments: object) -> tuple[int, str]:
    """Return the exit code and the output of a command line."""
    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
        code = exit_codes.run(cli.verbs, [str(argument) for argument in arguments])
    return code, text.getvalue()


def outcome(run: Path, path: Path, written: str) -> str:
    """Return what readers make of a run with a changed file: they name it, refuse it unnamed, read it as it was, or
    SILENT: they read something else."""
    refused = ""
    try:
        if content(run) != written:
            return SILENT
    except ClearsweepError as error:
        refused = str(error)
    except Exception:
        return FAULT
    code, text = command("status", run, "--verify")
    if code not in (0, 2):
        return FAULT
    if path.name in refused or (code == 2 and path.name in text):
        return NAMED
    return UNNAMED if refused or code else UNREAD


def flips(finished: Path, count: int, seed: int, restore, describe=print) -> dict[str, Counter]:
    """Flip `count` bits, one at a time, in copies of a run; `restore(directory)` runs its grid again.

    Return for each kind of file how many had each outcome, and how many runs were `restored` to what was
    written, or refused with the name of the file.
    """
    chance, written, result = random.Random(seed), content(finished), {}
    run = finished.with_name("flipped")
    kinds: dict[str, list[Path]] = {}
    for path in sorted(path.relative_to(finished) for path in finished.rglob("*") if path.is_file()):
        kinds.setdefault(f"{path.parent}/*{path.suffix}" if path.parent.name else path.name, []).append(path)
    for _ in range(count):
        shutil.rmtree(run, ignore_errors=True)
        shutil.copytree(finished, run)
        kind = chance.choice(list(kinds))
        name = chance.choice(kinds[kind])
        flip(run / name, chance)
        what = outcome(run, run / name, written)
        try:
            with contextlib.redirect_stderr(io.StringIO()):
                restore(run)
            restored = content(run) == written
        except ClearsweepError as error:
            restored = name.name in str(error)
        except Exception:
            what, restored = FAULT, False
        result.setdefault(kind, Counter()).update([what, "restored"] if restored else [what])
        if what not in (NAMED, UNREAD) or not restored:
            describe(f"{name}: {what}, {'restored' if restored else 'NOT RESTORED'}")
    return result
