"""Trust in law files: their paths and hashes that the user allowed to run, in a private file, or for one command.

Trust covers the text of a file and the content of each library and table that the text names.  It is given by
`clearsweep trust FILE`, or for one run by `--trust-laws`; a library that the user has installed needs none.
"""

import contextlib
import contextvars
import fcntl
import json
import os
import secrets
import shlex
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from ...contracts.case import LawFile
from ...language.errors import InputError
from ...tracing.cache import privacy_problem
from .law_files import contents_text, installed_file, open_regular, read_law_file, recorded_file

STORE = "trusted-laws.json"
MAX_STORE_BYTES = 2**24
OWN_FOLDER = "own-folder"  # --trust-laws without a value: files in the grid's own folder
_PERMISSION: contextvars.ContextVar[str | None] = contextvars.ContextVar("_PERMISSION", default=None)
_ALLOWED: set[str] = set()  # keys of files, in this process

Entry = dict[str, Any]  # path, sha256, named


@contextlib.contextmanager
def allowing(permission: str | None) -> Iterator[None]:
    """In this context, --trust-laws has this value; None leaves it as it is."""
    token = _PERMISSION.set(permission or _PERMISSION.get())
    try:
        yield
    finally:
        _PERMISSION.reset(token)


def store_file() -> Path:
    """Return the file of trusted paths and hashes; raise InputError if the user has no directory for it."""
    try:
        return Path(os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config") / "clearsweep" / STORE
    except RuntimeError as error:  # pathlib's, without HOME and without an entry in passwd
        raise InputError(f"{error}; set HOME or XDG_CONFIG_HOME, or run with --trust-laws") from None


def entries() -> list[Entry]:
    """Return what the user trusts; raise InputError if the file is damaged, or another user could have written it."""
    path = store_file()
    if not path.parent.exists() or not os.path.lexists(path):
        return []
    try:
        with open_regular(path) as file:
            status, content = os.fstat(file.fileno()), file.read(MAX_STORE_BYTES)
        reason = privacy_problem(path.parent)
        if status.st_uid != os.geteuid() or status.st_mode & 0o077:
            reason = reason or f"{path} is not a private file of yours (chmod 600)"
        stored = json.loads(content)
    except OSError as error:
        reason, stored = f"{path} cannot be read: {error.strerror}", []
    except ValueError:
        reason, stored = f"{path} is damaged; delete it and trust your files again", []
    if reason:
        raise InputError(f"the list of trusted files is not used: {reason}")
    return [entry for entry in stored if isinstance(entry, dict)]


def _entry_of(file: LawFile) -> Entry:
    return {"path": file.path, "sha256": file.sha256, "named": dict(file.named)}


def remember(file: LawFile) -> Path:
    """Trust a file with its present content; return the file that remembers it."""
    _change(lambda stored: [*(entry for entry in stored if entry != _entry_of(file)), _entry_of(file)])
    return store_file()


def revoke(path: Path) -> int:
    """Stop trusting all contents of a file; return how many were trusted."""
    real = str(Path(os.path.realpath(path.parent), path.name))
    trusted = [entry for entry in entries() if entry.get("path") == real]
    _change(lambda stored: [entry for entry in stored if entry not in trusted])
    return len(trusted)


def _change(change: Any) -> None:
    """Replace the list of trusted files, one process at a time."""
    path = store_file()
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        if reason := privacy_problem(path.parent):
            raise InputError(f"nothing was changed: {reason}")
        with open(path.with_suffix(".lock"), "a") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            content = json.dumps(change(entries()), indent=1).encode()
            partial = path.with_suffix(f".{secrets.token_hex(8)}")
            with open(os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600), "wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            partial.replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); nothing was changed") from None


def trust(path: Path, recorded: Iterable[Mapping[str, Any]] | None = None) -> str:
    """Trust a law file, or those in the run.json of a directory; return what they contain.  None of it runs."""
    files = [read_law_file(path, str(path))] if recorded is None else [*map(recorded_file, recorded)]
    texts = [f"{contents_text(file)}\ntrusted: remembered in {remember(file)}" for file in files]
    return "\n".join(texts) or "the run has no law files"


def list_text() -> str:
    """Return a line for each file that the user trusts."""
    return "\n".join(f"{entry['sha256']}  {entry['path']}" for entry in entries()) or "no file is trusted"


def is_allowed(file: LawFile, folder: Path | None = None) -> bool:
    """Return whether this process may run a law file; folder : that of the grid that names it, if one does."""
    if file.is_allowed or file.key in _ALLOWED:
        return True
    with contextlib.suppress(InputError):  # `refusal_text` has its message
        if installed_file(file.name).key == file.key if file.package else _entry_of(file) in entries():
            _ALLOWED.add(file.key)
    if file.key not in _ALLOWED and _is_permitted(file, folder):
        _ALLOWED.add(file.key)
    return file.key in _ALLOWED


def _is_permitted(file: LawFile, folder: Path | None) -> bool:
    """Return whether --trust-laws covers a file and what it names."""
    permission = _PERMISSION.get()
    contents = {file.path: file.sha256, **dict(file.named)}
    if permission == OWN_FOLDER:
        own = folder and os.path.realpath(folder)
        return all(os.path.dirname(path) == own for path in contents)
    pairs = [pair.rpartition("=") for pair in (permission or "").split(",") if pair]
    for name, equals, digest in pairs:
        if not equals or len(digest) != 64:
            expected = "expected nothing, or FILE=SHA256 with 64 digits, several separated by commas"
            raise InputError(f"--trust-laws: found {permission!r}; {expected}")
        contents = {
            path: known for path, known in contents.items() if (os.path.realpath(name), digest.lower()) != (path, known)
        }
    return bool(pairs) and not contents


def refusal_text(file: LawFile) -> str:
    """Return why a file does not run, what would run, and how to allow it."""
    try:
        earlier = [entry for entry in entries() if entry.get("path") == file.path]
        reason = "has changed since it was trusted" if earlier else "is not trusted"
    except InputError as error:
        reason = f"is not trusted ({error})"
    pairs = ",".join(f"{os.path.relpath(path)}={digest}" for path, digest in ((file.path, file.sha256), *file.named))
    if file.laws:  # of a run
        remedy = "Read it, `laws` in run.json; then allow it with `clearsweep trust DIR`, the directory of the run"
        return f"{file.name} {reason}, and nothing of it has run\n{contents_text(file)}\n{remedy}"
    return (
        f"{file.name} {reason}, and nothing of it has run\n{contents_text(file)}\nRead it; then allow it with "
        f"`clearsweep trust {shlex.quote(os.path.relpath(file.path))}`, or for one run with "
        f"`--trust-laws {shlex.quote(pairs)}`"
    )
