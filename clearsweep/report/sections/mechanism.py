"""The mechanism of a run at its start."""

from ...language.errors import InputError
from ..blocks.section import Gallery, Section, without_empty
from ..data.study import Study, resolve_cases
from ..one_case import mechanism


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if the mechanism has no picture, or is not known here."""
    first_case = [*study.cases.index[:1], *study.failed.index[:1]][:1]
    try:
        picture = mechanism.mechanism_picture(resolve_cases(study, first_case)[0]) if first_case else None
    except InputError:  # of another version
        return []
    return [Section("mechanism", "", without_empty([Gallery("", [picture] if picture else [])]))]
