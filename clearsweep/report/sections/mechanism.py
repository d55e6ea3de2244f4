"""The mechanism of a run as it starts, so that a reader sees what was studied."""

from ...errors import InputError
from .. import mechanism
from ..section import Gallery, Section, filled
from ..study import Study, resolved


def sections(study: Study) -> list[Section]:
    """Return the section; [] where the mechanism has no picture, or is not known here."""
    cases = [*study.cases.index, *study.failed.index]
    try:
        drawn = mechanism.picture(resolved(study, cases[:1])[0]) if cases else None
    except InputError:  # of another version
        return []
    return [Section("mechanism", "", filled([Gallery("", [drawn] if drawn else [])]))]
