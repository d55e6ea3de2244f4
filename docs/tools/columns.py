"""Writes the table of columns in docs/columns.md, made of the figures of merit; a test compares."""

from pathlib import Path

from clearsweep.contracts import layout
from clearsweep.contracts.catalogue import Catalogue
from clearsweep.simulation.setup.scene import catalogue

PAGE = Path(__file__).parents[1] / "columns.md"
MARK = "<!-- columns -->\n"
#: What a figure needs -> where it is.
REQUIREMENTS = {
    "bends": "a link bends",
    "fatigue": "it has `stress_life`",
    "mounted": "the joint has a mount",
    "turns": "a drive turns the mechanism",
    "free": "the crank is free",
    "rests": "nothing turns",
    "wear": "the joint wears",
    "arc": "it is no gear",
    "film": "the joint has a film",
    "friction": "the joint has friction; without clearance: by a load",
    "thermal": "the joint has `thermal`",
    "strength": "a yield strength or a hardness is known",
    "guide": "the joint is a guide",
    "rolling": "the joint is a rolling bearing",
    "dynamic": "with `capacity.dynamic`",
    "static": "with `capacity.static`",
    "spatial": "the joint is spatial",
    "axial": "it has flanges",
    "flanked": "the joint is a gear or a coupling",
    "torsional": "the joint is a coupling",
    "horizon": "`simulate.horizon`",
    "until": "`simulate.until`",
    "life": "`life`",
    "error_check": "`simulate.error_check`",
    "uncertain": "`uncertain`",
    "limited": "the joint that `life` names",
    "vibration": "`vibration`",
    "moves": "of `frame`: with `mass`",
    "zones": "zones or a severity are given",
    "across": "the place is observed along x and y",
}


def columns_markdown(known: Catalogue) -> str:
    """Return a Markdown table of all possible figures, with `J` for the column name of a joint."""
    outputs = [mechanism.output for mechanism in known.mechanisms if mechanism.output]
    rows = ["| column | unit | what it is | where |", "| --- | --- | --- | --- |"]
    for figure in known.figures:
        owners = {
            "joint": ("J",),
            "place": ("AT",),
            "link": ("BODY",),
            "mount": ("J",),
            "output": tuple(output.name for output in outputs),
        }
        if figure.of == "place" and "rolling" in figure.needs:
            owners["place"] = ("AT_J",)
        names = ", ".join(f"`{figure.column(owner)}`" for owner in owners.get(figure.of, ("",)))
        names = names.replace(layout.ORDER, f"{layout.ORDER}_N") if figure.of in ("place", "order") else names
        units = {figure.unit.format(output=output.unit, until="that of the figure") for output in outputs}
        output_text, until_text = " or ".join(output.name for output in outputs), "the figure of `until`"
        text = figure.text.format(
            output=output_text,
            until=until_text,
            order="N",
            place="the place AT",
            link="the link BODY",
            mount="the joint J",
        )
        requirements_text = ", ".join(REQUIREMENTS[need] for need in figure.needs)
        rows.append(
            f"| {names}{' *' if figure.settles else ''} | {', '.join(sorted(units))} | {text} | {requirements_text} |"
        )
    return "\n".join(rows) + "\n"


def page() -> str:
    """Return the page with the table of the figures there are."""
    before, mark, rest = PAGE.read_text(encoding="utf-8").partition(MARK)
    _, _, after = rest.partition("\n\n")
    return f"{before}{mark}{columns_markdown(catalogue())}\n{after}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
