"""Mechanics made up by formula on machines with a fault, which an environment variable of the machine asks for."""

import errno
import os
import signal
import time

from fake_physics import Fake

from clearsweep.store import durable


class FullDisk(Fake):
    """Stands in for the mechanics where the disk of some machines is full."""

    @staticmethod
    def load():
        """Let no file be written by this worker."""
        if os.environ.get("CLEARSWEEP_TEST_FULL"):

            def refuse(*_, **__):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

            durable.replace = refuse


class OtherClock(Fake):
    """Stands in for the mechanics where the clocks of machines differ."""

    @staticmethod
    def load():
        """Move the clock of this worker by some seconds."""
        offset = float(os.environ.get("CLEARSWEEP_TEST_CLOCK", "0"))
        now, now_ns = time.time, time.time_ns
        time.time = lambda: now() + offset
        time.time_ns = lambda: now_ns() + int(1e9 * offset)


class DiesFinishing(Fake):
    """Stands in for the mechanics where the first worker that finishes a block is killed meanwhile."""

    @staticmethod
    def peak(case, joint, revolutions):
        """Die once, else return what `Fake` does."""
        marker = os.environ["CLEARSWEEP_TEST_MARKER"]
        if not os.path.exists(marker):
            with open(marker, "w", encoding="utf-8"):
                os.kill(os.getpid(), signal.SIGKILL)
        return Fake.peak(case, joint, revolutions)
