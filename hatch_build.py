"""What a build adds to the sources: the machine code of the integration loop, and the tag of the platforms it is for.

CLEARSWEEP_PLATFORM names another platform of PLATFORMS than this machine's, for which the code is then made here.
"""

import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

#: By the platform as sysconfig has it: levels of processors, and the tag. The code asks the C library for memcpy and
#: memset alone, which every glibc has; 2.17, that of manylinux2014, is older than what llvmlite asks for.
PLATFORMS = {
    "linux-x86_64": (("x86-64-v3", "x86-64-v4"), "manylinux_2_17_x86_64"),
    "linux-aarch64": (("aarch64",), "manylinux_2_17_aarch64"),
}
#: The dependencies that making the code needs; their versions are those of the package.
NEEDED = ("numba", "numpy", "ruamel-yaml")


class LoopHook(BuildHookInterface):
    """The hook that hatchling calls for a wheel."""

    def dependencies(self) -> list[str]:
        """Return what the build needs besides hatchling."""
        return needed(self.metadata.core.dependencies)

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the code and the tag; an editable install, which lies in a checkout, has neither."""
        if version == "editable":
            return
        levels, tag = wanted()
        self.place = tempfile.mkdtemp(prefix="clearsweep-wheel-")
        objects = built(Path(self.root), Path(self.place), levels)
        build_data["force_include"][str(objects)] = "clearsweep/mechanics/objects"
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{tag}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove what was made for the build alone."""
        if version != "editable":
            shutil.rmtree(self.place)


def needed(dependencies: list[str]) -> list[str]:
    """Return the requirements, of those of the package, for making the code; spellings of a name count as one."""
    named = {canonicalize_name(Requirement(text).name): text for text in dependencies}
    return [named[name] for name in NEEDED]


def wanted() -> tuple[tuple[str, ...], str]:
    """Return the levels of processors and the tag of the platform; no level: this processor's own."""
    name = os.environ.get("CLEARSWEEP_PLATFORM") or sysconfig.get_platform()
    if name in PLATFORMS:
        return PLATFORMS[name]
    if name != sysconfig.get_platform():
        raise ValueError(f"CLEARSWEEP_PLATFORM is {name}; code can be made here for: {', '.join(PLATFORMS)}")
    return (), name.replace("-", "_").replace(".", "_")


def built(root: Path, place: Path, levels: tuple[str, ...]) -> Path:
    """Return the directory of the code, made from a copy of the sources, so that nothing older is in it."""
    shutil.copytree(root / "clearsweep", place / "clearsweep", ignore=shutil.ignore_patterns("__pycache__", "objects"))
    environment = os.environ | {"CLEARSWEEP_CACHE_DIR": str(place / "cache")}
    command = [sys.executable, "-m", "clearsweep.simulation.analyses.prebuild", *levels]
    subprocess.run(command, cwd=place, env=environment, check=True, stdout=sys.stderr)
    return place / "clearsweep" / "mechanics" / "objects"
