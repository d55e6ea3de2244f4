"""Where compiled code is kept: a directory stamped with everything that the code depends on."""

import hashlib
import os
import platform
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

#: All compiled code and what decides it lies below this directory.
ROOM = Path(__file__).parents[1]


def stamp() -> str:
    """Return a hash of all sources of `mechanics` and of the compiler's version.

    The compiler itself does not notice an edit in another file than that of the function it has kept.
    """
    digest = hashlib.sha256(f"{platform.python_version()} {version('numba')} {version('llvmlite')}".encode())
    for source in sorted(ROOM.rglob("*.py")):
        digest.update(f"{source.relative_to(ROOM).as_posix()} {source.stat().st_size}\n".encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def prepare() -> Path:
    """Make the compiler keep its code in a stamped directory, and return that.

    It lies in NUMBA_CACHE_DIR where that is set, else in the user's cache; in a temporary directory where neither can
    be written.
    """
    mark = stamp()
    given = os.environ.get("NUMBA_CACHE_DIR")
    if given and Path(given).name == mark:
        return Path(given)  # inherited from the process that prepared it
    home = Path(given or Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "clearsweep")
    place = home / mark
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError:
        place = Path(tempfile.gettempdir()) / f"clearsweep-{os.getuid()}" / mark
        place.mkdir(parents=True, exist_ok=True)
    os.environ["NUMBA_CACHE_DIR"] = str(place)
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = str(place)
    return place
