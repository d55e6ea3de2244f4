"""The figures of every finished case in tables: forces of each joint, slider and drive, how certain they are."""

from ...layout import DIFFERENCE
from ..case_table import case_table
from ..section import Block, Note, Section, filled
from ..study import P99, RATIO, Joint, Study
from ..table import Table

JOINT = (
    ("force_peak", "force peak"),
    ("force_p99", "force p99"),
    ("force_rms", "force rms"),
    ("force_peak_ideal", "ideal peak"),
    (RATIO, "p99 / ideal"),
    ("impacts_per_rev", "impacts per rev."),
    ("contact_fraction", "time in contact"),
    ("onset_rate_max", "fastest onset"),
    ("penetration_max", "penetration"),
)
PAST_LAWS = (("law_limit_fraction", "time past its law's range"), ("force_clips", "clips"))  # shown where there are any
WHOLE = (
    ("slider_error_max", "slider error"),
    ("slider_acceleration_peak", "slider acc. peak"),
    ("slider_acceleration_rms", "slider acc. rms"),
    ("crank_torque_peak", "crank torque peak"),
    ("pair_restitution", "restitution"),
)
CERTAINTY = (
    ("revolutions_run", "revolutions"),
    ("period", "period"),
    ("settled", "settled"),
    ("figure_ci", "95 % interval, half"),
    ("lyapunov_exponent", "Lyapunov exponent"),
    ("horizon_revolutions", "horizon (rev.)"),
)
CHECKED = JOINT[:3]  # figures whose error is shown where the grid asked for it


def sections(study: Study) -> list[Section]:
    """Return the section; [] where no case finished."""
    if study.cases.empty:
        return []
    blocks: list[Block] = []
    if study.lead is P99:
        blocks.append(
            Note(
                "Rank designs by p99 and rms: they are taken over the whole window. The peak is a single event of a "
                "chaotic motion. Ideal peak: largest reaction of the same joint without clearance."
            )
        )
    tables = [*(_joint(study, joint) for joint in study.joints), _whole(study), _certainty(study)]
    return [Section("peaks", "Peaks", filled([*blocks, *tables]))]


def _joint(study: Study, joint: Joint) -> Table:
    """Return forces and impacts of one joint, the largest leading figure first."""
    columns = [(joint.column(figure), heading) for figure, heading in JOINT]
    if not study.driven:
        count = joint.column("impacts_per_rev")
        columns = [(column, study.onsets if column == count else heading) for column, heading in columns]
    for figure, heading in PAST_LAWS:
        column = joint.column(figure)
        if study.has(column) and (study.cases[column] > 0.0).any():
            columns.append((column, heading))
    columns.append(WHOLE[0])
    lead = joint.column(study.lead.figure)
    return case_table(study, f"peaks_{joint.name}", f"Forces in joint {joint.title}", columns, lead)


def _whole(study: Study) -> Table:
    """Return what the slider and the drive feel, or the measured restitution."""
    first = next((column for column, _ in WHOLE if column in study.cases), "")
    title = "Measured restitution" if first == "pair_restitution" else "Slider and drive"
    return case_table(study, "slider", title, WHOLE, first)


def _certainty(study: Study) -> Table:
    """Return how far figures can be trusted; empty unless the grid asked for any of it."""
    until = study.run.layout.until
    columns = [*CERTAINTY[:3], (until, until), *CERTAINTY[3:]]
    for joint in study.joints:
        for figure, name in CHECKED:
            columns.append((joint.column(figure) + DIFFERENCE, f"error of {name}{study.where(joint, ' ({})')}"))
    first = next((column for column, _ in columns if study.has(column)), "")
    table = case_table(study, "certainty", "How certain the figures are", columns, first)
    return table._replace(
        note=f"{table.note} Error: difference from a run at a tenth of the tolerance, which in "
        "chaotic motion is that of two samples; horizon: after it two such runs are."
    )
