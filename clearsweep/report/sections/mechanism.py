"""The mechanism of a run at its start."""

from ...language.errors import InputError
from ..blocks.section import Gallery, Section, without_empty
from ..data.study import Study, resolved
from ..one_case import mechanism


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if the mechanism has no picture, or is not known here."""
    first = [*study.cases.index[:1], *study.failed.index[:1]][:1]
    try:
        drawn = mechanism.picture(resolved(study, first)[0]) if first else None
    except InputError:  # of another version
        return []
    return [Section("mechanism", "", without_empty([Gallery("", [drawn] if drawn else [])]))]
