"""All that a sweep or a report asks of mechanics, in one place, so that a test can put something else there."""

import importlib

from clearsweep.outcome import Trajectory


class Physics:
    """What is done with a case; the modules that do it are loaded when they are first needed."""

    @staticmethod
    def catalogue():
        """Return all laws there are, for reading a grid."""
        return importlib.import_module("clearsweep.scene").catalogue()

    @staticmethod
    def laws_text(name: str | None) -> str:
        """Return what there is to say of one law, or of all."""
        return importlib.import_module("clearsweep.laws").text(name)

    @staticmethod
    def load() -> None:
        """Load the modules that cases need, which takes as long as many a case."""
        importlib.import_module("clearsweep.scene")
        importlib.import_module("clearsweep.simulation")

    @staticmethod
    def signature(case: dict):
        """Return a hashable that is equal for cases that share their compiled code."""
        return importlib.import_module("clearsweep.scene").signature(case)

    @staticmethod
    def compile(case: dict) -> None:
        """Compile the code of a case, or load it from the cache."""
        importlib.import_module("clearsweep.simulation").compile_for(case)

    @staticmethod
    def solve(case: dict) -> Trajectory:
        """Return the result of a case."""
        scene = importlib.import_module("clearsweep.scene").build(case)
        return importlib.import_module("clearsweep.simulation").simulate(scene)

    @staticmethod
    def restitution(joint: dict) -> float | None:
        """Return what a free impact in a joint section of a case gives back, None where mass and speed decide that."""
        return importlib.import_module("clearsweep.laws").restitution(joint)

    @staticmethod
    def elastic_choices(joint: dict) -> dict[str, dict]:
        """Return, by name, a joint section with each elastic law that its radii, length and material allow."""
        return importlib.import_module("clearsweep.laws").elastic_choices(joint)

    @staticmethod
    def elastic_forces(joint: dict, depths) -> list[float]:
        """Return the elastic force (N) in a joint section of a case at each of some penetrations (m)."""
        return importlib.import_module("clearsweep.laws").elastic_forces(joint, depths)

    @staticmethod
    def penetration_limit(joint: dict) -> float:
        """Return the largest penetration (m) that the elastic law of a joint section of a case holds for."""
        return importlib.import_module("clearsweep.laws").penetration_limit(joint)

    @staticmethod
    def derived(case: dict) -> dict:
        """Return name -> (value, unit) of what was derived from other values."""
        return importlib.import_module("clearsweep.scene").derived(case)

    @staticmethod
    def warnings(case: dict) -> list[str]:
        """Return sentences about values that may not be what was meant."""
        return importlib.import_module("clearsweep.scene").warnings(case)
