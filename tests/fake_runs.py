"""A demo grid, and runs with the reading interface of the store, made up by formula.

Nothing is simulated or compiled; the figures are only plausible.
"""

import copy
import hashlib
import itertools
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
from right_grids import text_of

from clearsweep import grid, simulation
from clearsweep.contracts import case
from clearsweep.contracts.layout import Layout
from clearsweep.grid.written import law_execution, law_files

CONFIGS = Path(__file__).parent.parent / "configs"
CATALOGUE = simulation.catalogue()
TEXT = text_of("the demo grid")
JOINT = "joints.rod-slider"
CONTACT = f"{JOINT}.contact"


def forget_laws(monkeypatch):
    """Let this process be one that has allowed no law file and run none."""
    monkeypatch.setattr(law_files, "ALLOWED_KEYS", set())
    monkeypatch.setattr(law_execution, "RECORDS", {})


def load(source, overrides=None):
    return grid.load(source, CATALOGUE, overrides)


def sweep(base, axes):
    return copy.deepcopy(base) | {"sweep": axes}


def ids(cases):
    return [cases.case_id(k) for k in range(len(cases))]


def _columns_of(frame):
    return {name: frame[name].to_numpy() for name in frame}


class OfFrame:
    """The reading interface of a store whose summary is the frame `summary`, its units in `attrs`."""

    directory = Path("results") / "fake"

    seek = optimise = identify = None  # no search, optimisation or identification
    worst = ()  # no saved revolution of a peak

    def marks(self):
        """Return the marks of its blocks: one block."""
        return []

    @property
    def parts(self):
        """Return the only part, with the identities of its cases."""
        return [SimpleNamespace(ids=np.array([int(text, 16) for text in self.summary["case_id"]], "u8"))]

    @property
    def columns(self):
        """Return the names of the columns."""
        return list(self.summary.columns)

    @property
    def units(self):
        """Return column -> unit, for columns with a unit."""
        return self.summary.attrs["units"]

    def blocks(self, columns):
        """Yield all rows at once."""
        yield {name: self.summary[name].to_numpy() for name in columns}

    def column(self, name):
        """Return one column."""
        values = self.summary[name]
        return (
            values.to_numpy()
            if values.dtype.kind in "if"
            else values.astype(object).where(values.notna(), None).to_numpy()
        )

    def event_blocks(self):
        """Yield nothing: there are no events."""
        yield from ()

    def poincare(self, case_id):
        """Return None: there are no states at crank angle 0."""
        return pd.DataFrame()

    def orbit_columns(self, case_id):
        """Return the columns of `orbit`."""
        return _columns_of(self.orbit(case_id))

    def event_columns(self, case_id):
        """Return the columns of `events`."""
        return _columns_of(self.events(case_id))

    def section_columns(self, case_id):
        """Return the columns of `poincare`."""
        return _columns_of(self.poincare(case_id))


RPM = 2.0 * np.pi / 60.0
SWEEP = {
    "joints.rod-slider.clearance": [5e-5, 1e-4, 2e-4, 5e-4],
    "joints.rod-slider.contact.stiffness": [1e9, 1e10, 1e11],
    "joints.rod-slider.contact.restitution": [0.5, 0.7, 0.9],
    "drive.speed": [1000 * RPM, 3000 * RPM, 5000 * RPM],
}
UNITS = {"clearance": "m", "stiffness": "N/m^1.5", "speed": "rad/s"}
CRANK, ROD, SLIDER_MASS = 0.05, 0.12, 0.14


class Run(OfFrame):
    """The reading interface of a store: `.summary`, `.orbit`, `.events`, `.wear`, `.grid`, `.layout`."""

    def __init__(
        self,
        sweep=None,
        joints=("rod_slider",),
        mechanism="slider-crank",
        wear=True,
        histories=True,
        failures=0,
        name="slider-crank-clearance",
        bodies=None,
        further=None,
        strength=None,
        checked=False,
    ):
        self.histories = histories
        self.further = further or {}  # channel -> its value at all times
        sweep = SWEEP if sweep is None else sweep
        bins = 360 if wear else 0
        self.layout = _layout(mechanism, joints, bins, strength, checked)
        self.grid = _record(name, mechanism, joints, sweep, bodies)
        points = [dict(zip(sweep, values, strict=True)) for values in itertools.product(*sweep.values())]
        rows = [self._row(point, index < failures) for index, point in enumerate(points)]
        self.summary = pd.DataFrame(rows).sort_values("case_id", ignore_index=True)
        units = {column.name: column.unit for column in self.layout.columns}
        path_units = {path: UNITS.get(path.rsplit(".", 1)[-1], "1") for path in sweep}
        units |= path_units
        roles = {path: "condition" if path == "drive.speed" else "choice" for path in sweep}
        self.grid |= {"units": path_units, "layout": self.layout.written(), "roles": roles}
        self.summary.attrs["units"] = units

    def _row(self, point, failed):
        case_id = hashlib.sha256(repr(point).encode()).hexdigest()[:16]
        head = {
            "case_id": case_id,
            **point,
            "status": "step-budget" if failed else "ok",
            "message": "the step budget of 1000000 steps a revolution was used up at t = 1.2 ms" if failed else "",
        }
        columns = self.layout.columns
        if failed:
            return head | {column.name: None for column in columns}
        return head | {
            column.name: value for column, value in zip(columns, self._figures(point, columns, case_id), strict=True)
        }

    def _figures(self, point, columns, case_id):
        chance = np.random.default_rng(int(case_id, 16))
        speed = point.get("drive.speed", 5000 * RPM)
        clearance = point.get("joints.rod-slider.clearance", 5e-4)
        stiffness = point.get("joints.rod-slider.contact.stiffness", 6.61e10)
        ideal = SLIDER_MASS * speed**2 * CRANK * (1 + CRANK / ROD)
        raised = 1.0 + 40.0 / 6.0 * (clearance / 5e-4) ** 0.7 * (stiffness / 1e11) ** 0.15
        p99 = ideal * raised * chance.lognormal(0, 0.1)
        figures = {
            "force_peak": p99 * chance.uniform(1.2, 3.0),
            "force_rms": 0.3 * p99,
            "force_p99": p99,
            "force_peak_ideal": ideal,
            "impacts_per_rev": chance.uniform(5, 60),
            "contact_fraction": chance.uniform(0.5, 1),
            "onset_rate_max": 4.4 * speed / 523.6 * (clearance / 5e-4) ** 0.5,
            "penetration_max": 7.8e-5,
            "eccentricity_max": clearance + 7.8e-5,
            "law_limit_fraction": 0.0,
            "force_clips": 0.0,
            "wear_depth_max": 3e-9 * p99 / 1e4,
            "wear_rate_max": 2e-7 * p99 / 1e4,
            "wear_volume": 4e-13,
            "wear_narrow_arcs": 0.1,
            "acceleration_peak": 3.3e5 * p99 / 4e4,
            "acceleration_rms": 3e4 * p99 / 4e4,
            "error_max": clearance * 1.05,
            "crank_torque_peak": 0.03 * p99,
            "energy_residual": 3e-10,
            "steps": 12345,
            "steps_rejected": 3210,
            "rhs_evaluations": 160000,
            "run_time": 0.008,
            "restitution": 0.9,
        }
        return [figures.get(column.figure, 1.0) for column in columns]

    def _point(self, case_id):
        return self.summary.set_index("case_id").loc[case_id]

    def orbit(self, case_id):
        """Return the last two revolutions of a case by channel name; empty if not saved."""
        names = [column.name for column in self.layout.channels]
        if not self.histories:
            return pd.DataFrame({name: np.empty(0) for name in names})
        point = self._point(case_id)
        speed, clearance = point.get("drive.speed", 5000 * RPM), point.get("joints.rod-slider.clearance", 5e-4)
        angle = np.linspace(16 * np.pi, 20 * np.pi, 1441)
        t = angle / speed
        s = np.sqrt(ROD**2 - (CRANK * np.sin(angle)) ** 2)
        acceleration = -(speed**2) * CRANK * (np.cos(angle) + CRANK * np.cos(2 * angle) / s)
        load = SLIDER_MASS * acceleration
        depth = clearance * (0.06 * np.sin(17.3 * angle) + 0.03 * np.sin(41 * angle + 1))
        x = np.sign(load) * (clearance + depth) * np.cos(0.6 * np.sin(2 * angle))
        y = (clearance + depth) * np.sin(0.6 * np.sin(2 * angle))
        values = {
            "t": t,
            "crank_angle": angle,
            "crank/torque": 0.02 * load * np.sin(angle),
            **dict.fromkeys(("slider/place", "slider/x"), CRANK * np.cos(angle) + s + 0.5 * x),
            "slider/a": acceleration * (1 + 3e4 * np.maximum(depth, 0)),
            "pair/x": 5e-4 * np.sin(t * 300),
            "pair/v": 0.15 * np.cos(t * 300),
            **self.further,
        }
        for joint in self.layout.joints:
            prefix = f"joints/{joint.name}/"
            values |= {prefix + "x": x, prefix + "y": y, prefix + "force_normal": 5e9 * np.maximum(depth, 0) ** 1.2}
        frame = pd.DataFrame({name: values.get(name, np.zeros(len(t))) for name in names})
        frame.attrs["units"] = {column.name: column.unit for column in self.layout.channels}
        return frame

    def events(self, case_id):
        """Return 200 onsets and separations, alternating."""
        t = np.linspace(1e-4, 0.1, 200)
        return pd.DataFrame(
            {
                "t": t,
                "joint": self.layout.joints[0].name,
                "kind": ["on", "off"] * 100,
                "rate": 0.1 + np.sin(200 * t) ** 2,
                "force_peak": 100.0,
            }
        )

    def event_blocks(self):
        """Yield the events of all cases except failed ones."""
        if self.histories:
            first, good = self.events(""), (self.summary["status"] == "ok").to_numpy()
            values = {"t": first["t"].to_numpy(), "joint": np.zeros(len(first), int)}
            values["kind"] = (first["kind"] == "off").to_numpy(int)
            yield np.where(good, len(first), 0), {name: np.tile(value, good.sum()) for name, value in values.items()}

    def poincare(self, case_id):
        """Return ten revolutions of a journal whose wandering increases with the crank speed."""
        names = [path.removeprefix("poincare/") for _, path in self.layout.sections]
        if not self.histories or not names:
            return pd.DataFrame({"revolution": [], **{name: [] for name in names}})
        point, turn = self._point(case_id), np.arange(11)
        speed, clearance = point.get("drive.speed", 5000 * RPM), point.get("joints.rod-slider.clearance", 5e-4)
        aside = 0.3 * speed / (5000 * RPM) * np.sin(1.7 * turn)
        values = {
            "x": clearance * np.cos(aside),
            "y": clearance * np.sin(aside),
            "vx": 0.1 * aside,
            "vy": 0.2 * aside**2,
        }
        return pd.DataFrame({"revolution": turn, **{name: values[name.rsplit("/", 1)[-1]] for name in names}})

    def wear(self, case_id):
        """Return lobed wear depths, m."""
        middle = (np.arange(360) + 0.5) * np.pi / 180
        shape = np.maximum(np.cos(middle), 0) ** 2 + 0.6 * np.maximum(-np.cos(middle), 0) ** 2
        return {
            joint.name: (3e-9 * shape, 2e-9 * (1.1 + np.cos(2 * middle)) / 2.1)
            for joint in self.layout.joints
            if joint.wear_bins
        }


def _layout(mechanism, joints, bins, strength, checked):
    """Return the layout of a case with clearance in these joints, with a yield strength (Pa) or None.

    checked : its errors and its horizon are requested.
    """
    material = strength and case.Materials(*[case.Material(207e9, 0.3, strength)] * 2)
    contact = case.Contact("lankarani-nikravesh", "power", {}, material)
    wear = case.Wear("archard", "hertz-line", bins, {}) if bins else None
    parts = tuple(case.Joint(name.replace("_", "-"), 5e-4, contact, wear=wear) for name in joints)
    made = case.Case(
        case.Mechanism(mechanism, {}),
        parts,
        case.Simulate(1e-8, "auto", 1, 1, horizon=checked, error_check=checked),
        case.Save("last", 720),
    )
    return Layout.of(made, simulation.catalogue())


def _record(name, mechanism, joints, sweep, bodies=None):
    """Return the content of run.json; bodies : values below `mechanism` of another mechanism than those here."""
    contact = {
        "law": "lankarani-nikravesh",
        "elastic": "power",
        "stiffness": 6.61e10,
        "exponent": 1.5,
        "restitution": 0.9,
    }
    kind = simulation.catalogue().mechanism(mechanism)
    sections = {}
    for name_of_joint in joints:
        site = kind.site(name_of_joint.replace("_", "-"))
        sections[site.name] = {"clearance": 5e-4, "contact": contact}
        if site.kind == "revolute":
            journal = "rod" if "rod" in site.journals else site.journals[0]
            sections[site.name] |= {"bearing_radius": 0.01, "length": 0.02, "journal": journal}
    known = {
        "type": mechanism,
        "crank": {"length": CRANK, "mass": 0.3, "inertia": 1e-4, "center": 0.025},
        "rod": {"length": ROD, "mass": 0.21, "inertia": 2.5e-4, "center": 0.06},
        "slider": {"mass": SLIDER_MASS},
        "gravity": 0.0,
    }
    if mechanism == "impact-pair":
        known = {"type": mechanism, "masses": [0.2, 0.2], "speed": 1.0}
    return {
        "name": name,
        "mechanism": known if bodies is None else {"type": mechanism, **bodies},
        **({"drive": {"speed": 5000 * RPM}} if kind.turns else {}),
        "joints": sections,
        "simulate": {"tolerance": 1e-8}
        | ({"revolutions": 10, "discard": 2, "start": "centred"} if kind.turns else {"impacts": 10}),
        "save": {"orbits": "last", "samples": 720} | ({"revolutions": 2} if kind.turns else {}),
        **({"sweep": sweep} if sweep else {}),
        "keys": ["mechanism", "joints", "simulate", "save"],
        "source": "grid.yaml",
        "model_version": "1",
        "versions": {"clearsweep": "0.1.0", "llvmlite": "0.50.0"},
        "machine": {"node": "lab", "cores": 2},
        "start": "2025-01-01T00:00:00+00:00",
        "end": "2025-01-01T00:01:00+00:00",
        "counts": {"ok": 100, "failed": 8},
    }
