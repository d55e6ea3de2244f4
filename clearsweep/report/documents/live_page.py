"""The page of a run under way: a process of its own rewrites it at intervals, and a browser reloads it."""

import contextlib
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from ... import store
from ...language import wording
from ...language.errors import ClearsweepError
from ...store import durable
from ..study import open_partial, prepare
from .page import Page, page_of, write_page

INTERVAL = 5.0  # s between two pages at least, and between two loads by a browser
COST_SHARE = 0.2  # largest share of a core for drawing pages
NICENESS = 10  # cases have priority
REFRESH = f'<meta http-equiv="refresh" content="{INTERVAL:g}">\n'


@contextlib.contextmanager
def live_page(directory: Path, out: Path, system: str) -> Iterator[None]:
    """Rewrite the page of the finished cases of a run in `directory` for as long as this context lasts.

    The page is `out`; each is written atomically and makes the browser load the next one.  The last one no longer
    does.  system : unit system of its quantities
    """
    durable.check_output(out)
    context = multiprocessing.get_context("spawn")
    drawer = context.Process(target=_draw_pages, args=(directory, out, system, os.getpid()), daemon=True)
    drawer.start()
    try:
        yield
    finally:
        drawer.terminate()
        drawer.join()
        durable.remove_temporaries(out.parent)
        with contextlib.suppress(OSError, ClearsweepError):  # a stopped run leaves its last page, which stays as it is
            if REFRESH in (text := durable.read(out).decode()):
                write_page(text.replace(REFRESH, ""), out)


def _draw_pages(directory: Path, out: Path, system: str, parent: int) -> None:
    """Write pages until the parent process ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # of the terminal; the parent ends this process
    os.nice(NICENESS)
    sys.stderr = open(os.devnull, "w")  # noqa: SIM115 - until the process ends
    drawn: list[int] | None = None
    while os.getppid() == parent:
        begin = time.process_time()
        with contextlib.suppress(Exception), wording.unit_system(system):  # the run continues without its page
            drawn = draw_page(directory, out, drawn)
        time.sleep(max(INTERVAL, (time.process_time() - begin) * (1.0 / COST_SHARE - 1.0)))


def draw_page(directory: Path, out: Path, drawn: list[int] | None) -> list[int] | None:
    """Write the page of the finished cases, if there are others than those `drawn`; return their numbers."""
    state = store.status(directory)
    finished = [state["ok"], state["failed"]]
    if not state["holder"] or finished == drawn:
        return drawn
    kind = f"under way: {state['doing'] or 'starting'}; this page reloads itself"
    if not any(finished):
        page = Page(state["name"], kind, "", [], [])
    else:
        is_cut = store.is_cut(directory)
        run = store.BlockedRun(directory, partial=True) if is_cut else open_partial(directory, store.StoredRun)
        page = page_of(prepare(run))
        page = page._replace(subtitle=f"{page.subtitle} · {kind}")
    write_page(page.text().replace("<title>", f"{REFRESH}<title>", 1), out)
    return finished
