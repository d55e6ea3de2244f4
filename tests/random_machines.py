"""Random planar machines in the form of a grid: dyads on a driven crank, with laws and settings by chance."""

import law_cases
import numpy as np

LAWS, ELASTIC, FRICTION = (law_cases.names(kind) for kind in ("law", "elastic", "friction"))
OF_GUIDES = ("lankarani-nikravesh", "flores", "kelvin-voigt", "hertz")


class Builder:
    """The bodies and joints of a machine; every dyad adds two bodies and three joints."""

    def __init__(self, rng):
        self.rng, self.count = rng, 0
        self.bodies = {"ground": {"points": {"o": [0.0, 0.0]}}, "crank": self.body({"o": [0.0, 0.0], "a": [0.05, 0.0]})}
        self.joints = {"main": {"type": "revolute", "between": ["ground.o", "crank.o"]}}
        self.start = {}

    def body(self, points):
        """Return a body with some mass and moment of inertia, at times none."""
        mass = 0.0 if self.rng.random() < 0.05 else float(10.0 ** self.rng.uniform(-2.0, 1.0))
        return {
            "mass": mass,
            "inertia": 1e-3 * mass,
            "points": points,
            "center": self.rng.uniform(-0.02, 0.1, 2).tolist(),
        }

    def fixed_point(self, distance):
        """Return a new point of the ground at a distance (m) from the crank's axis."""
        name, angle = f"g{self.count}", self.rng.uniform(-np.pi, np.pi)
        self.bodies["ground"]["points"][name] = [float(distance * np.cos(angle)), float(distance * np.sin(angle))]
        return f"ground.{name}"

    def moving_point(self):
        """Return a point of a moving body."""
        body = str(self.rng.choice([name for name in self.bodies if name != "ground"]))
        return f"{body}.{self.rng.choice(list(self.bodies[body]['points']))}"

    def dyad(self):
        """Add two bodies that end on the ground, on a guide or on another moving body."""
        self.count += 1
        first, second, length = f"rod{self.count}", f"end{self.count}", float(self.rng.uniform(0.35, 0.45))
        begin, slides = self.moving_point(), self.rng.random() < 0.5
        distance = self.rng.uniform(0.0, 0.1) if slides else self.rng.uniform(0.3, 0.5)
        end = self.fixed_point(distance) if self.rng.random() < 0.8 else self.moving_point()
        self.bodies[first] = self.body({"o": [0.0, 0.0], "a": [length, 0.0]})
        reach = [0.0, 0.0] if slides else [float(self.rng.uniform(0.35, 0.45)), 0.0]
        self.bodies[second] = self.body({"o": [0.0, 0.0], "a": reach})
        last = {"type": "prismatic" if slides else "revolute", "between": [end, f"{second}.o"]}
        if slides:
            last["axis"] = float(self.rng.uniform(-3.0, 3.0))
        pins = {"a": [begin, f"{first}.o"], "b": [f"{first}.a", f"{second}.a"]}
        for letter, ends in pins.items():
            self.joints[f"j{self.count}{letter}"] = {"type": "revolute", "between": ends}
        self.joints[f"j{self.count}c"] = last
        self.start |= {first: float(self.rng.uniform(-3.0, 3.0)), second: float(self.rng.uniform(-3.0, 3.0))}


def settings_of(joint, rng, *, wears):
    """Return laws and sizes of a joint with clearance."""
    is_guide = joint["type"] == "prismatic"
    law, elastic = (
        (str(rng.choice(OF_GUIDES)), "power") if is_guide else (str(rng.choice(LAWS)), str(rng.choice(ELASTIC)))
    )
    section = law_cases.written(law, elastic, str(rng.choice([*FRICTION, ""])) or None)
    if is_guide:
        section["contact"].pop("material", None)
    section["clearance"] = float(10.0 ** rng.uniform(-6.0, -2.5))
    if is_guide:
        section.pop("bearing_radius")
        section |= {"length": 0.05, "height": 0.03}
    elif wears:
        section["wear"] = {"law": "archard", "coefficient": 1e-14, "bins": int(rng.choice([8, 90, 720]))}
    return section


def simulate_of(rng):
    """Return settings of a short run: at times it ends before the revolutions to discard."""
    revolutions = float(rng.choice([0.02, 0.3, 1.0]))
    discard = float(rng.choice([0.0, 0.5, 0.9])) * revolutions
    budgets = {"step_budget": int(rng.choice([20, 200])), "event_budget": int(rng.choice([1, 100]))}
    chosen = {"revolutions": revolutions, "discard": discard, "tolerance": float(10.0 ** rng.uniform(-10.0, -3.0))}
    return chosen | budgets | {"time_budget": 20.0}


def random_machine(seed):
    """Return the grid of a random machine."""
    rng = np.random.default_rng(seed)
    builder = Builder(rng)
    for _ in range(int(rng.integers(1, 4))):
        builder.dyad()
    names = [name for name in builder.joints if name != "main"]
    opened = rng.choice(names, size=min(len(names), int(rng.integers(1, 4))), replace=False)
    drive = {"speed": float(10.0 ** rng.uniform(-1.0, 3.0))}
    if rng.random() < 0.4:
        drive = {"torque": float(rng.uniform(0.0, 5.0)), "initial_speed": float(rng.choice([0.0, 1.0, 30.0]))}
        drive["inertia"] = float(rng.choice([0.0, 0.1]))
    loads = {}
    if rng.random() < 0.5:
        body = str(rng.choice([name for name in builder.bodies if name != "ground"]))
        loads["push"] = {"on": body, "force": rng.uniform(-100.0, 100.0, 2).tolist()}
    has_guide = any(builder.joints[name]["type"] == "prismatic" for name in opened)
    wears = not has_guide and rng.random() < 0.5
    start = "centred" if has_guide else str(rng.choice(["centred", "seated"]))
    machine = {"type": "planar", "gravity": 9.81, "bodies": builder.bodies, "joints": builder.joints, "driven": "main"}
    return {
        "mechanism": machine | {"output": {"body": "crank", "point": "a"}, "start": builder.start},
        "drive": drive,
        "joints": {str(name): settings_of(builder.joints[name], rng, wears=wears) for name in opened},
        "loads": loads,
        "simulate": simulate_of(rng) | {"start": start},
        "save": {"orbits": str(rng.choice(["none", "last", "all"]))},
    }
