"""results/speed.md, of which `make bench` and `make scale` write a part each."""

from pathlib import Path

PAGE = Path(__file__).parent.parent / "results" / "speed.md"
MARK = "\n<!-- below: written by `make scale ARGS=--write` -->\n"


def write_bench(text: str, page: Path = PAGE) -> None:
    """Replace what stands before the mark."""
    _, mark, scale = page.read_text(encoding="utf-8").partition(MARK)
    page.write_text(f"{text}{mark}{scale}", encoding="utf-8")


def write_scale(text: str, page: Path = PAGE) -> None:
    """Replace what stands after the mark."""
    bench, _, _ = page.read_text(encoding="utf-8").partition(MARK)
    page.write_text(f"{bench}{MARK}{text}", encoding="utf-8")
