"""The cases that did not finish, with their reasons."""

from markupsafe import Markup

from ...language.wording import TIMES
from ..blocks.case_table import CaseRows, axis_columns
from ..blocks.section import Section, Sentences
from ..blocks.table import Column, Table
from ..data.study import Study
from ..samples import counts


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if every case finished."""
    if study.failed.empty:
        return []
    return [Section("failures", "Failed cases", [Sentences([_reasons_sentence(study)]), _table(study)])]


def _reasons_sentence(study: Study) -> str:
    """Return a sentence with the number of failed cases by status, the most frequent first."""
    ordered = sorted(counts.failures_by_status(study).items(), key=lambda pair: (-pair[1], pair[0]))
    reasons = Markup(", ").join(Markup("{} {} <b>{}</b>").format(number, TIMES, status) for status, number in ordered)
    return Markup("{}. <code>clearsweep run --retry-failed</code> runs them again.").format(reasons)


def _table(study: Study) -> Table:
    columns = (Column("case_id"), *axis_columns(study, study.swept()), Column("status"), Column("reason"))
    shown_columns = [*(axis.path for axis in study.swept()), "status", "message"]
    return Table("failed", "Failed cases", "", columns, CaseRows(study.failed, shown_columns))
