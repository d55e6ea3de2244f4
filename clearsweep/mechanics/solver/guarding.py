"""The guards of joints: functions that change something where they turn positive."""

from ..compiled.family import invoke, kernel
from ..observe.stages import END, NODES

ELSEWHERE = NODES.size  # place of the value of a guard at a state by itself, behind those at the nodes of a step


@kernel
def evaluate_guards(at, y, row):
    """Put values of all guards into `work.guards.value`.

    Where `row` is END those at the start of the step, the state `y`, and at its stages; else, ELSEWHERE, those at the
    state `y` whose observables are in row `row`.
    """
    work, guards = at[0], at[0].guards
    for g in range(guards.contact.size):
        if guards.column[g] >= 0:
            if row == END:
                for m in range(NODES.size):
                    guards.value[g, m] = guards.sign[g] * work.o[guards.column[g], NODES[m]]
            else:
                guards.value[g, ELSEWHERE] = guards.sign[g] * work.o[guards.column[g], row]
    if guards.evaluate.code != 0:
        given = y, work.nodes, work.latched, work.o, guards.value
        invoke(guards.evaluate.code, guards.evaluate.parameters, given, row)


@kernel
def looked_at(at, g):
    """Return whether guard `g` is looked at in the mode in which its contact is."""
    guards = at[0].guards
    return guards.modes[g] >> at[0].mode[guards.contact[g]] & 1 != 0
