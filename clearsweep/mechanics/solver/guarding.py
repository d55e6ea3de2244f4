"""The guards of joints: functions that change something where they turn positive."""

from ..compiled.family import invoke, kernel
from ..observe.stages import END, NODES, STAGES


@kernel
def evaluate_guards(at, y, row):
    """Put the values of all guards at the start of a step, the state `y`, into `work.guards.value`; where `row` is END,
    those at the stages, too.
    """
    work, guards = at[0], at[0].guards
    for g in range(guards.contact.size):
        if guards.column[g] >= 0:
            for m in range(1 + STAGES if row == END else 1):
                guards.value[g, m] = guards.sign[g] * work.o[guards.column[g], NODES[m]]
    if guards.evaluate.code != 0:
        given = y, work.nodes, work.latched, work.o, guards.value
        invoke(guards.evaluate.code, guards.evaluate.parameters, given, row)


@kernel
def looked_at(at, g):
    """Return whether guard `g` is looked at in the mode in which its contact is."""
    guards = at[0].guards
    return guards.modes[g] >> at[0].mode[guards.contact[g]] & 1 != 0
