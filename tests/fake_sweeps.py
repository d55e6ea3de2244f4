"""What a sweep does to mechanics made up by formula."""

import functools

from fake_physics import Fake

from clearsweep.sweeping.merge import run_merge
from clearsweep.sweeping.sweep import Options, RunResult, run_sweep

merge = functools.partial(run_merge, simulator=Fake)


def sweep(source, out=None, *, simulator=Fake, **options) -> RunResult:
    """Do what `clearsweep.sweep` does."""
    return run_sweep(source, out, Options(**options), simulator)
