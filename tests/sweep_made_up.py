"""A program without a `__main__` guard that sweeps a made-up grid: for tests that kill it."""

import importlib
import json
import os
import sys
from pathlib import Path

from fake_physics import sweep

from clearsweep.language.errors import ClearsweepError
from clearsweep.sweeping.pool.system import Stopped, end_with_run

directory, source, options = sys.argv[1:]
end_with_run()
try:
    result = sweep(json.loads(source), directory, **json.loads(options))
except (Stopped, ClearsweepError) as error:
    print(f"{type(error).__name__}: {error}", file=sys.stderr)
    sys.exit(error.exit_code)
slow = sorted({"pandas", "scipy", "matplotlib", "pyarrow.compute"} & sys.modules.keys())
importlib.import_module("pyarrow.compute")  # which runs of many cases load, so that peaks differ by their cases alone
facts = {
    "ran": result.ran,
    "reused": result.reused,
    "failed": result.failed,
    "slow": slow,
    "peak": max(
        int(line.split()[1])
        for line in Path(f"/proc/{os.getpid()}/status").read_text().splitlines()
        if line.startswith("VmHWM")
    )
    if sys.platform == "linux"
    else 0,
}
print(json.dumps(facts))
sys.exit(result.exit_code)
