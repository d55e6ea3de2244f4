"""The interactive parts of a page: its scripts, and the encoding of their data.

All scripts are inline, so that a page opens without a network; its security policy blocks all others.  uPlot (MIT
licence, next to it in `vendor`) draws the curves.
"""

import base64
import functools
import hashlib
import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup
from numpy.typing import ArrayLike

FOLDER = Path(__file__).parent
#: Files of the page's one script, in order; those of `vendor` are unmodified.
SCRIPTS = (
    "vendor/uPlot.iife.min.js",
    *(f"script/{name}.js" for name in ("common", "explorer", "player", "worn", "cells", "start")),
)
STYLES = ("vendor/uPlot.min.css",)


class Script(NamedTuple):
    """The script of a page, and its hash in the security policy."""

    text: Markup
    hash: str


@functools.cache
def page_script() -> Script:
    """Return the script of pages with interactive parts."""
    text = "\n".join((FOLDER / name).read_text(encoding="utf-8").strip() for name in SCRIPTS)
    return Script(Markup(text), base64.b64encode(hashlib.sha256(text.encode()).digest()).decode())


def style_sheets() -> Markup:
    """Return the style sheets of the scripts."""
    return Markup("\n".join((FOLDER / name).read_text(encoding="utf-8").strip() for name in STYLES))


def encode_floats(values: ArrayLike) -> str:
    """Return numbers as little-endian 32-bit floats in base 64: seven digits in 5.3 characters."""
    return base64.b64encode(np.asarray(values, dtype="<f4").tobytes()).decode()


def safe_json(content: dict[str, Any]) -> Markup:
    """Return content as JSON that is safe in a script element for any text."""
    text = json.dumps(content, ensure_ascii=False, separators=(",", ":"), sort_keys=True, allow_nan=False)
    return Markup(text.replace("<", "\\u003c").replace("&", "\\u0026"))
