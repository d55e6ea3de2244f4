"""What `mkdocs` needs besides: pages from outside docs/, the reference, formulas that browsers draw, the search."""

import ast
import html
import json
import re
import sys
from pathlib import Path

from latex2mathml.converter import convert
from mkdocs.structure.files import File

sys.path.insert(0, str(Path(__file__).parent))
import docstrings

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "clearsweep"
#: Pages and pictures that lie elsewhere in the repository; they keep their places, so that links hold.
OUTSIDE = (
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "CITATION.cff",
    "SECURITY.md",
    "results/*.md",
    "results/accuracy/*.svg",
    "results/measured/*.svg",
    "results/readme/*.png",
)
FORMULA = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)


def rooms() -> dict[str, list[Path]]:
    """Return the modules of each room, and those that stand alone, in the order of their names."""
    modules = sorted(path for path in PACKAGE.rglob("*.py") if path.name not in ("__init__.py", "__main__.py"))
    found = {"clearsweep": [path for path in modules if path.parent == PACKAGE]}
    for path in modules:
        if path.parent != PACKAGE:
            found.setdefault(path.relative_to(PACKAGE).parts[0], []).append(path)
    return found


def public() -> str:
    """Return the page of what a program uses, from the table of public names."""
    source = ast.parse((PACKAGE / "__init__.py").read_text(encoding="utf-8"))
    homes = next(node.value for node in source.body if isinstance(node, ast.Assign) and node.targets[0].id == "_HOMES")
    parts = ["# From Python", "What `import clearsweep` gives. All else may change from one version to the next."]
    for name, home in ast.literal_eval(homes).items():
        parts.append(docstrings.definition(defined(PACKAGE / home.replace(".", "/"), name)))
    return "\n\n".join(parts)


def defined(home: Path, name: str) -> docstrings.Definition:
    """Return the definition of a public name, in a module or in one of the package that hands it on."""
    files = sorted(home.rglob("*.py")) if home.is_dir() else [home.with_suffix(".py")]
    for path in files:
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, docstrings.Definition) and node.name == name:
                return node
    raise LookupError(f"{home}: nothing in it defines {name}")


def reference(room: str, modules: list[Path]) -> str:
    """Return the page of a room: its own docstring, then that of every module and function."""
    top = "clearsweep" if room == "clearsweep" else f"clearsweep.{room}"
    package = PACKAGE if room == "clearsweep" else PACKAGE / room
    parts = [f"# {top}", docstrings.markdown(ast.get_docstring(ast.parse((package / "__init__.py").read_text())) or "")]
    for path in modules:
        name = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        parts += [f"## {name}", docstrings.module(path)]
    return "\n\n".join(parts)


def on_config(config):
    """Add the reference to the table of contents."""
    pages = [{"From Python": "reference/public.md"}, *({room: f"reference/{room}.md"} for room in rooms())]
    return config.update(nav=[*config["nav"], {"Reference": pages}]) or config


def on_files(files, config):
    """Add the pages and pictures from outside docs/, and the reference."""
    for pattern in OUTSIDE:
        for path in sorted(ROOT.glob(pattern)):
            files.append(File.generated(config, path.relative_to(ROOT).as_posix(), abs_src_path=str(path)))
    files.append(File.generated(config, "reference/public.md", content=public()))
    for room, modules in rooms().items():
        files.append(File.generated(config, f"reference/{room}.md", content=reference(room, modules)))
    return files


def on_page_markdown(markdown, page, config, files):
    """Return a page with links between docs/ and its surroundings as they are on the site."""
    if (ROOT / "docs" / page.file.src_uri).exists():
        up = "../" * page.file.src_uri.count("/")  # pages of howto/ are one level deeper
        return markdown.replace(f"]({up}../", f"]({up}")
    return markdown.replace("](docs/", "](").replace("](../docs/", "](../")


def on_page_content(content, page, config, files):
    """Return a page with its formulas as MathML."""
    return FORMULA.sub(_formula, content)


def _formula(match):
    """Return one formula, which stands alone or in a line."""
    tag, kind, latex = match.groups()
    display = "block" if kind == "[" else "inline"
    return f'<{tag} class="arithmatex">{convert(html.unescape(latex).strip(), display=display)}</{tag}>'


def on_post_build(config):
    """Make of the index of the search a script, as a page from the disk may not fetch it; remove what would."""
    place = Path(config.site_dir) / "search"
    entries = json.loads((place / "search_index.json").read_text(encoding="utf-8"))["docs"]
    titles = {entry["location"]: entry["title"] for entry in entries if "#" not in entry["location"]}
    # The text of a page is that of its sections, so it would be shown twice.
    entries = [
        entry | {"page": titles[entry["location"].partition("#")[0]]} for entry in entries if "#" in entry["location"]
    ]
    for path in place.iterdir():
        path.unlink()
    (place / "index.js").write_text(f"window.searchIndex = {json.dumps(entries)};\n", encoding="utf-8")
