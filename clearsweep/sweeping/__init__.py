"""Runs many cases: batches, worker processes, shards, resuming, and the summary of a run.

The options of `run` are declared here, for the command line, for `clearsweep.sweep`, and for the workers.
"""

from typing import Annotated, Any, NamedTuple, get_type_hints


class Flag(NamedTuple):
    """How an option is written on the command line, and what it means."""

    help: str  # for the command line; '': it is an option of `clearsweep.sweep` alone
    text: str  # for Python
    names: tuple[str, ...] = ()  # on the command line, besides that of the option
    metavar: str | None = None
    least: int | None = None  # smallest value of a whole number
    show_default: bool = False
    bare: str | None = None  # value of an option that is written without one


class Options(NamedTuple):
    """Options of a sweep.  The workers get them, too: `RunContext.options`."""

    jobs: Annotated[
        int | None,
        Flag(
            "Number of worker processes; default: one per core.",
            "number of worker processes; default the number of cores this process may use.",
            names=("-j",),
            metavar="N",
            least=1,
        ),
    ] = None
    executor: Annotated[
        str,
        Flag(
            "Where cases run. local: worker processes; serial: this process; dask: the workers of a dask cluster; "
            "nodes: a pool of processes on each node of a cluster.",
            "'local' (processes), 'serial' (this process), 'dask' (a cluster) or 'nodes' (a driver on each node).",
            metavar="local|serial|dask|nodes",
            show_default=True,
        ),
    ] = "local"
    scheduler: Annotated[
        str | None,
        Flag(
            "Address of a running dask scheduler; `dask` can start its own.",
            "address of the cluster's scheduler; default a new cluster on this machine.",
            metavar="ADDRESS",
        ),
    ] = None
    retry_failed: Annotated[
        bool,
        Flag("Rerun the cases that failed in an earlier run.", "run cases again that failed before."),
    ] = False
    case_timeout: Annotated[
        float | None,
        Flag(
            "Stop any case that runs longer than this.",
            "s, longest time of a case; a longer case gets the status 'timeout'.",
            metavar="SECONDS",
        ),
    ] = None
    max_failures: Annotated[
        int | str | None,
        Flag(
            "Stop when more than N cases, or P % of the cases, have failed.",
            "int, or text such as '5%' of the cases to run: stop when more than that have failed.",
            metavar="N|P%",
        ),
    ] = None
    shard: Annotated[
        str | None,
        Flag(
            "Run only part I of N equal parts; `merge` joins the parts.",
            "text such as '2/8': run only the second of eight parts of the cases; `merge` joins them.",
            metavar="I/N",
        ),
    ] = None
    fresh: Annotated[
        bool,
        Flag(
            "Move an earlier run in the directory aside, to NAME-2, and start anew.",
            "move an earlier run in the directory aside, also one of an equal grid.",
        ),
    ] = False
    no_effects: Annotated[
        bool,
        Flag(
            "Where `seek` finds no value, do not run the cases that show which other keys help.",
            "where `seek` finds no value, do not run the cases that show which other keys help.",
        ),
    ] = False
    trust_laws: Annotated[
        str | None,
        Flag(
            "Run law files for this command: without a value those in the folder of the grid, else FILE=SHA256,... "
            "`clearsweep trust` allows them for good.",
            "'own-folder': run the law files in the folder of the grid; or 'FILE=SHA256,...': run these texts.",
            metavar="[FILE=SHA256]",
            bare="own-folder",
        ),
    ] = None
    show_progress: Annotated[bool, Flag("", "show progress on stderr.")] = True


NO_OPTIONS = Options()


def flags() -> dict[str, Flag]:
    """Return the flag of each option, by name."""
    hints = get_type_hints(Options, include_extras=True)
    declared = {name: hint.__metadata__[0] for name, hint in hints.items()}
    return {
        name: flag._replace(names=(*flag.names, f"--{name.replace('_', '-')}")) if flag.help else flag
        for name, flag in declared.items()
    }


def flag_type(name: str) -> Any:
    """Return the type of an option's value on the command line: bool, int, float or str."""
    annotated = get_type_hints(Options)[name]
    kinds = [kind for kind in getattr(annotated, "__args__", (annotated,)) if kind is not type(None)]
    return kinds[-1]
