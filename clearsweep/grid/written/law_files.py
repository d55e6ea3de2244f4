"""Files with laws of a user's own: which of them may run, and what they declare."""

import ast
import contextlib
import contextvars
import fcntl
import hashlib
import importlib.util
import json
import os
import secrets
import shlex
import site
import stat
import sys
import sysconfig
import unicodedata
import warnings
from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from io import BufferedReader
from pathlib import Path
from typing import Any

from ...contracts.case import LawFile
from ...contracts.catalogue import Catalogue, Field, Law
from ...language import quantity
from ...language.errors import InputError, did_you_mean, quoted
from ...language.wording import sentence_list
from ...laws import KINDS, NAME_PATTERN
from ...tracing.cache import privacy_problem
from . import NOT_UTF_8, Problems, WrittenValue

# ----------------------------------------------------------------------------------------------------------------------
# Trust in law files: their paths and hashes that the user allowed to run, in a private file, or for one command.
#
# Trust covers the text of a file and the content of each library and table that the text names.  It is given by
# `clearsweep trust FILE`, or for one run by `--trust-laws`; a library that the user has installed needs none.


STORE = "trusted-laws.json"
MAX_STORE_BYTES = 2**24
OWN_FOLDER = "own-folder"  # --trust-laws without a value: files in the grid's own folder
_PERMISSION: contextvars.ContextVar[str | None] = contextvars.ContextVar("_PERMISSION", default=None)
ALLOWED_KEYS: set[str] = set()  # keys of files, in this process

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
    if file.is_allowed or file.key in ALLOWED_KEYS:
        return True
    with contextlib.suppress(InputError):  # `refusal_text` has its message
        if installed_file(file.name).key == file.key if file.package else _entry_of(file) in entries():
            ALLOWED_KEYS.add(file.key)
    if file.key not in ALLOWED_KEYS and _is_permitted(file, folder):
        ALLOWED_KEYS.add(file.key)
    return file.key in ALLOWED_KEYS


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


# ----------------------------------------------------------------------------------------------------------------------
# Law files: the key `laws`, and the content of a file by its text and its syntax tree.  Nothing here runs it.


LAWS = "laws"  # the key of a grid
LAWS_TEXT = "file of laws of one's own, such as my_laws.py, the name of an installed library, or a list of these"
GROUP = "clearsweep.laws"  # entry points of libraries
MAX_BYTES = 2**18  # of a law file
MAX_LINE = 1000  # characters
MAX_NAMED_BYTES = 2**28  # of a library or a table
_SCRIPTS = ("LATIN", "GREEK", "DIGIT", "LOW", "SUBSCRIPT", "SUPERSCRIPT")  # first words of characters of names


def read_law_files(root: WrittenValue, problems: Problems) -> tuple[WrittenValue, dict[LawFile, WrittenValue]]:
    """Return the document without its key `laws`, and the files that this names, with their places; none has run."""
    written = root.value.get(LAWS)
    if written is None:
        return root, {}
    files: dict[LawFile, WrittenValue] = {}
    for entry in written.items:
        try:
            file = _read_entry(entry)
        except InputError as error:
            problems.add(entry, LAWS, str(error))
            continue
        if any(file.path == earlier.path for earlier in files):
            problems.add(entry, LAWS, f"{file.name} is named twice; remove one")
        files[file] = entry
    if written.value == []:
        problems.add(written, LAWS, f"names no file; expected a {LAWS_TEXT}")
    return root.without(LAWS), files


def _read_entry(written: WrittenValue) -> LawFile:
    """Return the file that an entry of `laws` names, or contains as run.json does."""
    name = written.value
    if isinstance(name, LawFile):
        return name
    if isinstance(name, dict):
        return recorded_file(plain_value(written))
    if not isinstance(name, str) or not name:
        raise InputError(f"found {quoted(name)}; expected a {LAWS_TEXT}")
    if not name.endswith(".py"):
        return installed_file(name)
    path = Path(name)
    if written.line and (path.is_absolute() or ".." in path.parts):
        raise InputError(f"found {quoted(name)}; expected a file in the folder of the grid or below it")
    return read_law_file(Path(written.origin).parent / path if written.line else path, name)


def plain_value(written: WrittenValue) -> Any:
    """Return a value without its positions."""
    if isinstance(written.value, dict):
        return {key: plain_value(value) for key, value in written.value.items()}
    return list(map(plain_value, written.value)) if isinstance(written.value, list) else written.value


def installed_file(name: str) -> LawFile:
    """Return the file of an installed library of laws; raise InputError if there is none."""
    from importlib import metadata

    points = [x for x in metadata.entry_points(group=GROUP) if x.dist and not is_neighbour(str(x.dist.locate_file("")))]
    point = next((point for point in points if point.name == name), None)
    if point is None:
        names = sorted({point.name for point in points})
        hint = did_you_mean(name, names) or f" (installed: {', '.join(names) or 'none'}; a file ends in .py)"
        raise InputError(f"no installed package has laws of the name {quoted(name)}{hint}")
    located = importlib.util.find_spec(point.module)  # runs the packages around the module, which the user installed
    if located is None or not located.origin or not located.origin.endswith(".py"):
        raise InputError(f"the laws of {quoted(name)} are in {point.module}, which is no file of Python")
    package = point.module if located.submodule_search_locations else point.module.rpartition(".")[0]
    return read_law_file(Path(located.origin), name, package or point.module)


def is_neighbour(place: str | Path, folder: str | Path = ".") -> bool:
    """Return whether a file or folder is in a folder or in the current one, but not where packages are installed."""
    near = (Path(folder).resolve(), Path.cwd())
    return any(Path(place).resolve().is_relative_to(x) and not _is_installed(place) for x in near)


def _is_installed(place: str | Path) -> bool:
    """Return whether a file or folder is of Python, of clearsweep, or where packages are installed."""
    kinds = map(sysconfig.get_path, ("stdlib", "platstdlib", "purelib", "platlib"))
    folders = (*map(str, kinds), *site.getsitepackages(), site.getusersitepackages(), str(Path(__file__).parents[2]))
    return any(Path(place).resolve().is_relative_to(os.path.realpath(folder)) for folder in folders)


# ----------------------------------------------------------------------------------------------------------------------


def read_law_file(path: Path, name: str, package: str = "") -> LawFile:
    """Return a law file, read once; raise InputError if it is none."""
    try:
        with open_regular(path) as stream:
            content = stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError(f"{name}: cannot be read: {error.strerror}; expected a file of Python") from None
    if len(content) > MAX_BYTES:
        size = f"has more than the {MAX_BYTES:,} bytes that are read"
        raise InputError(f"{name}: {size}; put its numbers into a table, or its code into an installed package")
    try:
        text = content.decode()
    except UnicodeDecodeError as error:
        raise InputError(f"{name}: {NOT_UTF_8.format(error.start)}") from None
    path = Path(os.path.realpath(path.parent), path.name)
    file = LawFile(name, str(path), text, package=package)
    return LawFile(name, str(path), text, tuple(_named_files(file)), package)


def open_regular(path: Path) -> BufferedReader:
    """Return a regular file opened for reading; raise OSError for a link, a folder, a pipe or a device."""
    if not stat.S_ISREG(os.lstat(path).st_mode):  # before opening, since opening a device may have effects
        raise OSError(0, "it is a link" if path.is_symlink() else "it is not a regular file")
    handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    file = os.fdopen(handle, "rb")
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        file.close()
        raise OSError(0, "it is not a regular file")
    return file


def hash_of(path: str) -> str:
    """Return the SHA-256 of a library or a table, or '' if it is too large or cannot be read."""
    with contextlib.suppress(OSError), open_regular(Path(path)) as file:
        if os.fstat(file.fileno()).st_size <= MAX_NAMED_BYTES:
            return hashlib.file_digest(file, "sha256").hexdigest()
    return ""


def _named_files(file: LawFile) -> Iterator[tuple[str, str]]:
    """Yield the paths and hashes of the files whose names are texts in a law file: libraries and tables."""
    folder, located = Path(file.path).parent, set()
    for node in ast.walk(syntax_tree(file)):
        text = node.value if isinstance(node, ast.Constant) else None
        text = text.decode(errors="replace") if isinstance(text, bytes) else text
        if isinstance(text, str) and 0 < len(text) <= 255 and os.path.isfile(folder / text):
            located.add(os.path.realpath(folder / text))
    for path in sorted(located - {file.path}):
        digest = hash_of(path)
        if not digest:
            raise InputError(f"{file.name}: names {path}, which cannot be read or has over {MAX_NAMED_BYTES:,} bytes")
        yield path, digest


@lru_cache(maxsize=16)
def syntax_tree(file: LawFile) -> ast.Module:
    """Return the syntax tree of a law file without documentation; raise InputError if its text hides anything."""
    for number, line in enumerate(file.source.split("\n"), start=1):
        hidden = next((x for x in line if unicodedata.category(x) in ("Cc", "Cf", "Zl", "Zp") and x != "\t"), "")
        if hidden:
            raise InputError(f"{file.name}:{number}: has the invisible character U+{ord(hidden):04X}; remove it")
        if len(line) > MAX_LINE:
            raise InputError(f"{file.name}:{number}: has {len(line):,} characters, more than {MAX_LINE:,}; divide it")
    try:
        with warnings.catch_warnings(action="ignore"):
            tree = ast.parse(file.source, file.name)
        ast.unparse(tree)  # raises RecursionError where `digest_of_law` would
    except SyntaxError as error:
        place = f"{file.name}:{error.lineno or 1}:{error.offset or 1}"
        raise InputError(f"{place}: not valid Python: {error.msg}") from None
    except (ValueError, RecursionError, MemoryError):
        raise InputError(f"{file.name}: is nested too deeply; divide its longest expressions") from None
    for node in ast.walk(tree):
        for name in (getattr(node, part, None) for part in ("id", "attr", "arg", "name", "asname")):
            letters = (x for x in name if not x.isascii()) if isinstance(name, str) else ()
            if any(unicodedata.name(x, "?").split()[0] not in _SCRIPTS for x in letters):
                message = f"{name!a} has letters that look like others; use those of Latin and Greek"
                raise InputError(f"{file.name}:{getattr(node, 'lineno', 1)}: {message}")
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and ast.get_docstring(node, clean=False) is not None:
            node.body = node.body[1:] or [ast.Pass()]
        if isinstance(node, ast.Call) and _kind_of(node, *KINDS, "key", "Key"):
            node.keywords = [part for part in node.keywords if part.arg != "doc"]
    return tree


def imports(file: LawFile) -> dict[str, int]:
    """Return the modules of the highest level that a law file imports, and their first lines."""
    modules: dict[str, int] = {}
    for node in ast.walk(syntax_tree(file)):
        if isinstance(node, ast.ImportFrom) and node.level and not file.package:
            raise InputError(f"{file.name}:{node.lineno}: imports a neighbouring file; {NO_NEIGHBOURS}")
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        names += [node.module] if isinstance(node, ast.ImportFrom) and node.module and not node.level else []
        for name in names:
            modules.setdefault(name.partition(".")[0], getattr(node, "lineno", 1))
    return modules


NO_NEIGHBOURS = "trust covers one text: write its code into the law file, or install it as a package"


def declared(file: LawFile) -> list[str]:
    """Return the laws that a file declares with literal names, such as 'contact my-law (damper)'."""
    texts = []
    for node in ast.walk(syntax_tree(file)):
        for call in getattr(node, "decorator_list", ()):
            kind = _kind_of(call, *KINDS)
            if kind and call.args and isinstance(call.args[0], ast.Constant):
                keys = [
                    part.arg for part in call.keywords if part.arg not in (None, "doc", "kinks", "states", "may_gain")
                ]
                texts.append(f"{kind} {call.args[0].value!s}" + (f" ({', '.join(keys)})" if keys else ""))
    return texts


def _kind_of(call: Any, *known: str) -> str:
    """Return which of these names of `laws` a call has, as `laws.contact(...)` or `contact(...)`, or ''."""
    function = call.func if isinstance(call, ast.Call) else None
    name = getattr(function, "attr", None) or getattr(function, "id", "")
    return name if name in known else ""


def contents_text(file: LawFile) -> str:
    """Return lines on a law file: size, hash, laws, imports, and the files that it names."""
    lines = [f"{file.path}: {len(file.text.encode()):,} bytes, sha256 {file.sha256}"]
    lines += [f"  declares {sentence_list(texts)}" for texts in [declared(file)] if texts]
    lines += [f"  imports {sentence_list(list(modules))}" for modules in [imports(file)] if modules]
    lines += [f"  names {path}, sha256 {digest}" for path, digest in file.named]
    return "\n".join(lines)


# ----------------------------------------------------------------------------------------------------------------------
# What decides the identity of a case: the syntax tree of the laws that it uses, with what they call.


def digests_in_use(files: Iterable[LawFile], words: Iterable[Any]) -> dict[str, str]:
    """Return law -> hash, of the laws of one's own among these words."""
    words = {word for word in words if isinstance(word, str)}
    return {
        f"{law.family} {law.name}": digest_of_law(file, law.name)
        for file in files
        for law in file.laws
        if law.name in words
    }


@lru_cache(maxsize=256)
def digest_of_law(file: LawFile, name: str) -> str:
    """Return the hash of the laws of a name in a file, 16 hexadecimal digits; name : '' for all laws.

    It covers the syntax tree of their functions, of the functions and classes that these reach by name, and of all
    other statements of the file, without comments and documentation; further the files that the text names and the
    versions of the packages that it imports.
    """
    body = syntax_tree(file).body
    statements = [x for x in body if not (isinstance(x, ast.Expr) and isinstance(x.value, ast.Constant))]
    definitions = [x for x in statements if isinstance(x, (ast.FunctionDef, ast.ClassDef))]
    own = [x for x in definitions if any(_declares(decorator, name) for decorator in x.decorator_list)]
    reached = [x for x in statements if x not in definitions] + (own or definitions)
    for statement in reached:  # grows
        used = {node.id for node in ast.walk(statement) if isinstance(node, ast.Name)}
        reached += [x for x in definitions if x.name in used and x not in reached]
    parts = [ast.unparse(x) for x in sorted(reached, key=lambda x: x.lineno)]
    text = "\n".join([*parts, *(digest for _, digest in file.named), *_versions(file)])
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _declares(decorator: Any, name: str) -> bool:
    """Return whether a decorator is that of the law called `name`."""
    first = decorator.args[0] if _kind_of(decorator, *KINDS) and decorator.args else None
    return isinstance(first, ast.Constant) and first.value == name


def _versions(file: LawFile) -> list[str]:
    """Return the versions of the packages that a file imports, but not of Python, numpy and clearsweep."""
    from importlib import metadata

    known = {"numpy", "clearsweep", *sys.stdlib_module_names}
    versions = []
    for module in sorted(imports(file).keys() - known):
        try:
            versions.append(f"{module} {metadata.version(module)}")
        except metadata.PackageNotFoundError:
            versions.append(module)  # its package has another name
    return versions


# ----------------------------------------------------------------------------------------------------------------------
# Law files in run.json.

_PLAIN = (str, bool)  # types of the parts of a description that laws of one's own have, besides their keys


def recorded(file: LawFile) -> dict[str, Any]:
    """Return a law file as run.json contains it."""
    laws = [
        {name: part for name, part in law._asdict().items() if isinstance(part, _PLAIN)}
        | {
            "fields": [
                {name: repr(part) if isinstance(part, float) else part for name, part in field._asdict().items()}
                for field in law.fields  # JSON has no infinities
            ]
        }
        for law in file.laws
    ]
    lines = [line.encode("unicode_escape").decode() for line in file.text.split("\n")]  # texts there have one line
    parts = {"name": file.name, "path": file.path, "sha256": file.sha256, "named": dict(file.named)}
    return parts | {"package": file.package, "laws": laws, "text": lines}


def with_recorded_laws(catalogue: Catalogue, resolved: Mapping[str, Any]) -> Catalogue:
    """Return the catalogue with the laws that a resolved grid, or run.json, contains."""
    laws = [law for content in resolved.get(LAWS, ()) for law in recorded_file(content).laws]
    return catalogue._replace(laws=(*catalogue.laws, *laws))


def recorded_file(content: Mapping[str, Any]) -> LawFile:
    """Return the law file of an entry of run.json; raise InputError if it has another form."""
    try:
        name, path, package = (content[key] for key in ("name", "path", "package"))
        text = "\n".join(line.encode("ascii").decode("unicode_escape") for line in content["text"])
        laws = tuple(map(_recorded_law, content["laws"]))
        named = tuple((str(path), str(digest)) for path, digest in content["named"].items())
        if not laws or not all(isinstance(part, str) for part in (name, path, package)):
            raise TypeError
    except (AttributeError, KeyError, TypeError, ValueError):
        raise InputError("is a section that `clearsweep run` did not write; name a file") from None
    file = LawFile(name, path, text, named, package, laws)
    syntax_tree(file)
    return file


def _recorded_law(content: Mapping[str, Any]) -> Law:
    """Return the description of a law; raise InputError or another error if a part is not valid."""
    fields = tuple(map(_recorded_field, content["fields"]))
    law = Law(**{name: part for name, part in content.items() if name != "fields"}, fields=fields)
    names = [law.name, *(field.name for field in fields)]
    is_plain = all(isinstance(part, _PLAIN) for name, part in content.items() if name != "fields")
    if not is_plain or not all(NAME_PATTERN.fullmatch(name) for name in names):
        raise ValueError
    return law


def _recorded_field(content: Mapping[str, Any]) -> Field:
    """Return a key of a law; its numbers are texts."""
    if not all(isinstance(part, (*_PLAIN, type(None))) for part in content.values()):
        raise TypeError
    numbers = {name: float(content[name]) for name in ("low", "high", "default") if content[name] is not None}
    field = Field(**{**content, **numbers})
    quantity.read(f"1 {quantity.replace_exponent(field.unit, 1.5)}", quantity.replace_exponent(field.unit, 1.5))
    return field
