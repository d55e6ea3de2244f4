"""Writes the table of columns in docs/columns.md, made of the figures of merit; a test compares."""

from pathlib import Path

from clearsweep.contracts import layout
from clearsweep.simulation.setup.scene import catalogue

PAGE = Path(__file__).parents[1] / "columns.md"
MARK = "<!-- columns -->\n"


def page() -> str:
    """Return the page with the table of the figures there are."""
    before, mark, rest = PAGE.read_text(encoding="utf-8").partition(MARK)
    _, _, after = rest.partition("\n\n")
    return f"{before}{mark}{layout.columns_markdown(catalogue())}\n{after}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
