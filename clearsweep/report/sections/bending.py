"""Links that bend on the page: deflection and stress of the worst case, and where their first rates are."""

from ... import simulation
from ...language import wording
from ...language.errors import InputError
from ..blocks.section import Section, Sentences, without_empty
from ..blocks.table import Column, Table
from ..study import Study, resolve_cases


def bending_links_sections(study: Study) -> list[Section]:
    """Return the section, or [] if no case finished or no link bends."""
    columns = [column.name for column in study.run.layout.columns if column.figure == "stress_max"]
    columns = [name for name in columns if study.has(name)]
    if study.cases.empty or not columns:
        return []
    worst_column = max(columns, key=study.cases.largest)
    worst = str(study.cases[worst_column].idxmax())
    try:
        links = simulation.bending_links(resolve_cases(study, [worst])[0])
    except InputError:  # of another version
        return []
    hardest = max(links, key=lambda link: link.ratio)
    name = worst_column.removesuffix("_stress_max")
    stress, deflection = (study.text(worst, column) for column in (worst_column, f"{name}_deflection_max"))
    setting = study.setting(worst)
    sentences = [
        f"The largest stress is {stress}, in {name.replace('_', '-')}{f' at {setting}' if setting else ''}. It "
        f"deflects by {deflection} there.",
        f"The drive turns at {wording.number_text(hardest.ratio, 2)} of the first bending rate of {hardest.name}. "
        "Above 0.5 the deflections leave the model.",
    ]
    blocks = without_empty([Sentences(sentences), _table(study, worst, links)])
    return [Section("bending-links", "Links that bend", blocks)]


def _table(study: Study, worst: str, links: tuple[simulation.BendingLink, ...]) -> Table:
    """Return the table of the links in the case with the largest stress."""
    columns = (
        Column("link"),
        Column("modes"),
        Column("first bending rate", "rad/s"),
        Column("drive over it"),
        Column("deflection", "m"),
        Column("stress", "Pa"),
    )
    rows = []
    for link in links:
        name = link.name.replace("-", "_")
        figures = (float(study.cases.at[worst, f"{name}_{figure}"]) for figure in ("deflection_max", "stress_max"))
        rows.append((link.name, str(link.modes), link.rate, link.ratio, *figures))
    note = "The case has the largest stress, by bending and normal force at the worst of 11 stations."
    return Table("bending_links", "Links that bend", note, columns, rows)
