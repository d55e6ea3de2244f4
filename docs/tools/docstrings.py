"""The package as Markdown, read from its sources: signatures, and docstrings with their lists, headings and tables."""

import ast
import re
from pathlib import Path

Definition = ast.FunctionDef | ast.ClassDef

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


def module(path: Path) -> str:
    """Return a module: its own docstring, then every public function and class that has one."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    parts = [markdown(ast.get_docstring(tree) or "")]
    parts += [definition(node) for node in tree.body if _shown(node)]
    return "\n\n".join(parts)


def definition(node: Definition, within: str = "") -> str:
    """Return a function, or a class with its fields and methods, below a heading."""
    name = f"{within}.{node.name}" if within else node.name
    parts = [f"### `{name}`", f"```python\n{_signature(node)}\n```", markdown(ast.get_docstring(node) or "")]
    if isinstance(node, ast.ClassDef):
        parts += [definition(inner, name) for inner in node.body if _shown(inner)]
    return "\n\n".join(parts)


def _shown(node: ast.AST) -> bool:
    """Return whether a statement defines something public that has a docstring."""
    return isinstance(node, Definition) and not node.name.startswith("_") and bool(ast.get_docstring(node))


def _signature(node: Definition) -> str:
    """Return the head of a definition as it could be written, a class with its fields."""
    if isinstance(node, ast.ClassDef):
        bases = f"({', '.join(map(ast.unparse, node.bases))})" if node.bases else ""
        fields = [f"\n    {ast.unparse(inner)}" for inner in node.body if isinstance(inner, ast.AnnAssign)]
        return f"class {node.name}{bases}:{''.join(fields) or ' ...'}"
    returns = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    return f"def {node.name}({ast.unparse(node.args)}){returns}"
