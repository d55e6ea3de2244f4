"""Whether a step passes the guards of joints: functions that change something where they turn positive."""

from ..compiled.family import inlined, invoke, kernel
from ..observe.stages import END


@inlined
def is_looked_at(guards, g, mode):
    """Return whether guard `g` is looked at while its contact is in this mode."""
    return guards.modes[g] >> mode & 1 != 0


@inlined
def highest_seen(o, column, sign, staged):
    """Return the value, at the end of a step, of a guard that is an observable; the largest, if `staged`, of stages."""
    highest = sign * o[column, END]
    for row in range(0 if staged else END, END):
        highest = max(highest, sign * o[column, row])
    return highest


@kernel
def evaluate_guards(at, y, row):
    """Put the values of all guards at the state `y`, whose observables are in row `row`, into `work.guards.value`."""
    work, guards = at[0], at[0].guards
    for g in range(guards.contact.size):
        if guards.column[g] >= 0:
            guards.value[0, g] = guards.value[1, g] = guards.sign[g] * work.o[guards.column[g], row]
            if row == END and guards.at_stages[g]:
                guards.value[1, g] = highest_seen(work.o, guards.column[g], guards.sign[g], staged=True)
    ask_laws(at, y, row)


@kernel
def ask_laws(at, y, row):
    """Put the values of those guards into `work.guards.value` of which laws give them."""
    work, guards = at[0], at[0].guards
    if guards.evaluate.code != 0:
        invoke(guards.evaluate.code, guards.evaluate.parameters, (y, work.latched, work.o, guards.value), row)


@kernel
def looked_at(at, g):
    """Return whether guard `g` is looked at in the mode in which its contact is."""
    guards = at[0].guards
    return is_looked_at(guards, g, at[0].mode[guards.contact[g]])


@kernel
def is_passed(guards, g):
    """Return whether the step in hand may pass guard `g`, which is looked at and was evaluated at its end."""
    return guards.value[1 if guards.at_stages[g] else 0, g] > 0.0


@kernel
def may_pass_by_law(at):
    """Return whether the step in hand may pass a guard of which a law gives the value."""
    guards, waiting = at[0].guards, True
    if guards.evaluate.code == 0:
        return False
    for g in range(guards.contact.size):
        if guards.column[g] < 0 and looked_at(at, g):
            if waiting:
                ask_laws(at, at[0].end, END)
                waiting = False
            if is_passed(guards, g):
                return True
    return False


@kernel
def pass_guards(at):
    """Put into `work.guards.passed` which guards the step in hand can hold."""
    guards, waiting = at[0].guards, True
    for g in range(guards.contact.size):
        guards.passed[g] = False
        if looked_at(at, g):
            if waiting:
                evaluate_guards(at, at[0].end, END)
                waiting = False
            guards.passed[g] = is_passed(guards, g)
