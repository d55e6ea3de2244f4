"""Docstrings of the package as Markdown: lists of `name : text`, headings of their sections, tables of plain text."""

import re

from griffe import Extension

NAMED = re.compile(r"^(`?[\w*][\w*, ]*`?) : (.*)$")
HEADING = re.compile(r"^(\w[\w ]*)\n-{3,}$", re.MULTILINE)
TABLE = re.compile(r"^(=+( +=+)*\n(?:.*\n)+?.*?=+( +=+)*)$(?=\n\n|\Z)", re.MULTILINE)


def markdown(text: str) -> str:
    """Return a docstring as Markdown."""
    lines = []
    for line in TABLE.sub(r"```text\n\1\n```", HEADING.sub(r"**\1**\n", text)).split("\n"):
        named = NAMED.match(line)
        if named and (not lines or lines[-1]) and not (lines and lines[-1].startswith(("* ", "  "))):
            lines.append("")
        lines.append(f"* `{named[1].strip('`')}`: {named[2]}" if named else line)
    return "\n".join(lines)


class Docstrings(Extension):
    """What mkdocstrings loads: rewrites each docstring."""

    def on_instance(self, *, obj, **_) -> None:
        """Rewrite the docstring of one object."""
        if not obj.is_alias and obj.docstring:
            obj.docstring.value = markdown(obj.docstring.value)
