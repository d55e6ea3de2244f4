"""Substitute mechanics with a fault on some machines, requested by an environment variable of the machine."""

import errno
import os
import signal
import time

from fake_physics import Fake

from clearsweep.store import durable

SLOW = 3.0  # s, of a case on a slow machine


class FullDisk(Fake):
    """Substitute for the mechanics on machines with a full disk."""

    @staticmethod
    def load():
        """Prevent this worker from writing files."""
        if os.environ.get("CLEARSWEEP_TEST_FULL"):

            def refuse(*_, **__):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

            durable.replace = refuse


class OtherClock(Fake):
    """Substitute for the mechanics on machines with different clocks."""

    @staticmethod
    def load():
        """Shift the clock of this worker by some seconds."""
        offset = float(os.environ.get("CLEARSWEEP_TEST_CLOCK", "0"))
        now, now_ns = time.time, time.time_ns
        time.time = lambda: now() + offset
        time.time_ns = lambda: now_ns() + int(1e9 * offset)


class Slow(Fake):
    """Substitute for the mechanics on slow machines."""

    @staticmethod
    def solve(case):
        """Return the result of `Fake`; on a slow machine note the case in a file, and take some seconds."""
        if log := os.environ.get("CLEARSWEEP_TEST_SLOW"):
            with open(log, "a", encoding="utf-8") as file:
                file.write(f"{case.mechanism.values['slider.mass']}\n")
            time.sleep(SLOW)
        return Fake.solve(case)


class DiesFinishing(Fake):
    """Substitute for the mechanics in which the first worker is killed while it finishes a block."""

    @staticmethod
    def peak(case, joint, revolutions, window_from=None):
        """Die once, otherwise return the result of `Fake`."""
        marker = os.environ["CLEARSWEEP_TEST_MARKER"]
        if not os.path.exists(marker):
            with open(marker, "w", encoding="utf-8"):
                os.kill(os.getpid(), signal.SIGKILL)
        return Fake.peak(case, joint, revolutions)
