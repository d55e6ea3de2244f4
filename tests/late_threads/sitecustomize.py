"""Releases the threads that the preloaded library delays, as the last act before the interpreter ends."""

import atexit
import ctypes
import os
import sys

if "late_threads" in os.environ.get("LD_PRELOAD", ""):
    sys.setswitchinterval(10.0)  # so that this thread keeps the interpreter's lock from here to the end
    library, process = ctypes.PyDLL(os.environ["LD_PRELOAD"]), os.getpid()  # PyDLL does not give the lock back
    atexit.register(lambda: library.release() if os.getpid() == process else None)
