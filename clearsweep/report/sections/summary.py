"""The cards at the top of the page: the largest figures of the run, each beside what it is to be compared with."""

from ..section import Cards, Section
from ..study import ELASTIC_TEXT, RATIO, Study


def sections(study: Study) -> list[Section]:
    """Return the cards of a run."""
    return [Section("summary", "", [Cards(_cards(study))])]


def _worst_ratio(study: Study) -> str:
    """Return the column with the largest ratio of all joints."""
    columns = [joint.column("force_peak_ratio") for joint in study.joints]
    return max(columns, key=lambda column: float(study.cases[column].max()) if study.has(column) else 0.0)


def _cards(study: Study) -> list[tuple[str, str, str]]:
    """Return name, value with unit, what it is beside."""
    finished, failed = len(study.cases), len(study.failed)
    cards = [("Cases finished", f"{finished} of {finished + failed}", f"{failed} failed" if failed else "none failed")]
    if study.cases.empty:
        return cards
    joint = study.hardest_joint()
    where = f"joint {joint.title}"
    figures = (
        (joint.column(study.lead.figure), f"Largest {study.lead.name}", where),
        (_worst_ratio(study), "Peak over ideal peak", "1: as without clearance"),
        (joint.column(RATIO), "p99 over ideal peak", "blind to impacts under 1 % of a turn"),
        (joint.column("force_rms"), "Largest force rms", where),
        (joint.column("onset_rate_max"), "Fastest onset", f"steel elastic to {ELASTIC_TEXT}"),
        (study.column("error_max"), f"Largest {study.run.layout.output} error", "off the ideal place"),
        (joint.column("restitution"), "Measured restitution", "largest of all cases"),
        (joint.column("wear_depth_max"), "Deepest wear", "in the recorded window"),
    )
    for column, name, beside in figures:
        if study.has(column):
            cards.append((name, study.text(study.cases[column].idxmax(), column), beside))
    return cards
