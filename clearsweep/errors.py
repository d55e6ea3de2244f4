"""The errors clearsweep raises: one root, each also a builtin, each with the exit code of the command line."""


class ClearsweepError(Exception):
    """Root of every error that clearsweep raises on purpose; `exit_code` is what the command line returns."""

    exit_code = 1


class InputError(ClearsweepError, ValueError):
    """A grid, case or argument that cannot be used; `problems` holds one sentence per mistake found."""

    exit_code = 2

    def __init__(self, *problems: str):
        super().__init__("\n".join(problems))
        self.problems = problems


class DirectoryError(ClearsweepError, FileExistsError):
    """A run directory that does not fit: of another grid, locked by another run, or not writable at the start."""

    exit_code = 2


class StorageError(ClearsweepError, OSError):
    """Writing results failed while a run was under way; what was committed before is unharmed."""

    exit_code = 4
