"""Machines in space compared with a second program: absolute coordinates, quaternions and multipliers, scipy alone.

The clearance is so wide that nothing touches within the horizon: what is compared is how the bodies of a tree move.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from spatial_oracle import rotation, skew
from test_machines_in_space import CRANK, GRAVITY, ROCKER, ROD, RPM, four_bar

import clearsweep

pytestmark = [pytest.mark.heavy, pytest.mark.compiled, pytest.mark.slow]

SPEED, FOOT = 1000 * RPM, np.array([0.13, 0.0, -0.001])
BODIES = {"coupler": ROD, "rocker": ROCKER}
Z = np.array([0.0, 0.0, 1.0])


class FourBar:
    """Coupler and rocker on a crank at constant speed; `joints` : of those that are closed, name -> kind."""

    def __init__(self, joints):
        """Take the joints."""
        self.joints = joints

    def point(self, y, t, body, name):
        """Return place, velocity, acceleration without that of the coordinates, and rows of a point of a body."""
        if body == "ground":
            return FOOT, np.zeros(3), np.zeros(3), np.zeros((3, 12))
        if body == "crank":
            c, s = math.cos(SPEED * t), math.sin(SPEED * t)
            arm = CRANK["points"]["pin"][0] * np.array([c, s, 0.0])
            return arm, SPEED * np.cross(Z, arm), -(SPEED**2) * arm, np.zeros((3, 12))
        k, first = list(BODIES).index(body), BODIES[body]
        at, turn, v, w = self.state(y, k)
        arm = turn @ (np.array(first["points"][name]) - np.array(first["center"]))
        rows = np.zeros((3, 12))
        rows[:, 6 * k : 6 * k + 3], rows[:, 6 * k + 3 : 6 * k + 6] = np.eye(3), -skew(arm)
        return at + arm, v + np.cross(w, arm), np.cross(w, np.cross(w, arm)), rows

    @staticmethod
    def state(y, k):
        """Return centre, rotation, velocity and angular velocity of body `k`."""
        part = y[13 * k : 13 * k + 13]
        return part[:3], rotation(part[3:7] / np.linalg.norm(part[3:7])), part[7:10], part[10:13]

    def axis(self, y, body):
        """Return the rotation, angular velocity and place of the angular rows of a body, the ground's at rest."""
        if body in BODIES:
            k = list(BODIES).index(body)
            return self.state(y, k)[1], self.state(y, k)[3], slice(6 * k + 3, 6 * k + 6)
        return np.eye(3), SPEED * Z if body == "crank" else np.zeros(3), None

    def constraints(self, t, y):
        """Return rows over the accelerations (linear, angular of each body) and their right side."""
        rows, right = [], []
        for kind, near, far in self.joints:
            _, _, free, across = self.point(y, t, *near)
            _, _, there, beyond = self.point(y, t, *far)
            rows += [*(beyond - across)]
            right += [*(free - there)]
            if kind == "spherical":
                continue
            (frame, spin, here), (other, its, where) = self.axis(y, near[0]), self.axis(y, far[0])
            u = other[:, 2]
            for i in range(2):  # the far body's axis stays across two axes of the near one
                p, row = frame[:, i], np.zeros(12)
                row[where] = np.cross(u, p)
                if here is not None:
                    row[here] = np.cross(p, u)
                rest = np.cross(its, np.cross(its, u)) @ p + u @ np.cross(spin, np.cross(spin, p))
                rows.append(row)
                right.append(-rest - 2.0 * np.cross(its, u) @ np.cross(spin, p))
        return np.array(rows), np.array(right)

    def rates(self, t, y):
        """Return the rates of the state."""
        mass, applied, flow = np.zeros((12, 12)), np.zeros(12), np.zeros(26)
        for k, first in enumerate(BODIES.values()):
            _, turn, v, w = self.state(y, k)
            inertia = turn @ np.diag(first["inertia"]) @ turn.T
            mass[6 * k : 6 * k + 3, 6 * k : 6 * k + 3] = first["mass"] * np.eye(3)
            mass[6 * k + 3 : 6 * k + 6, 6 * k + 3 : 6 * k + 6] = inertia
            applied[6 * k : 6 * k + 3] = first["mass"] * np.array(GRAVITY)
            applied[6 * k + 3 : 6 * k + 6] = -np.cross(w, inertia @ w)
            q = y[13 * k + 3 : 13 * k + 7]
            flow[13 * k : 13 * k + 3] = v
            flow[13 * k + 3 : 13 * k + 7] = 0.5 * np.concatenate([[-w @ q[1:]], q[0] * w + np.cross(w, q[1:])])
        rows, right = self.constraints(t, y)
        many = len(rows)
        whole = np.block([[mass, rows.T], [rows, np.zeros((many, many))]])
        result = np.linalg.solve(whole, np.concatenate([applied, right]))[:12]
        for k in range(2):
            flow[13 * k + 7 : 13 * k + 13] = result[6 * k : 6 * k + 6]
        return flow


def start_of(result):
    """Return the state at the first sample of a run."""
    parts = []
    for body in BODIES:
        names = ["x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz"]
        parts += [result[f"{body}/{name}"][0] for name in names]
    return np.array(parts)


WIDE = {"clearance": 4e-3, "axial_clearance": 4e-3, "tilt": None, "offset": None}
PINS = {
    "crank-coupler": (("crank", "pin"), ("coupler", "big")),
    "coupler-rocker": (("coupler", "small"), ("rocker", "pin")),
    "rocker-ground": (("ground", "foot"), ("rocker", "foot")),
}


@pytest.mark.parametrize(
    ("opened", "ideal"),
    [
        ("crank-coupler", {"coupler_rocker": "spherical"}),
        ("rocker-ground", {"crank_coupler": "spherical"}),
    ],
    ids=("a ball on a hinge", "a hinge on a ball"),
)
def test_the_bodies_of_a_tree_move_as_absolute_coordinates_have_it(opened, ideal):
    """Places agree to 7e-15 m, angular velocities to 5e-12 rad/s, while the bodies turn out of the plane."""
    case = four_bar(opened, **ideal)
    joint = {key: value for key, value in (case["joints"][opened] | WIDE).items() if value is not None}
    case["joints"][opened] = joint
    times = np.linspace(0.0, 0.003, 13)
    case["simulate"] |= {"revolutions": 0.05}
    result = clearsweep.simulate(clearsweep.load_case(case), times=times)
    assert result.status == "ok"
    assert len(result.events) == 0
    kinds = {name: ideal.get(name.replace("-", "_"), "revolute") for name in PINS if name != opened}
    machine = FourBar([(kind, *PINS[name]) for name, kind in kinds.items()])
    own = solve_ivp(machine.rates, (0.0, times[-1]), start_of(result), "DOP853", times, rtol=1e-12, atol=1e-14).y
    for k, body in enumerate(BODIES):
        places = np.array([result[f"{body}/{axis}"] for axis in "xyz"])
        spins = np.array([result[f"{body}/w{axis}"] for axis in "xyz"])
        assert places == pytest.approx(own[13 * k : 13 * k + 3], rel=0.0, abs=1e-13)
        assert spins == pytest.approx(own[13 * k + 10 : 13 * k + 13], rel=0.0, abs=1e-10)
        if body == "coupler":
            assert np.abs(spins[:2]).max() > 1e-2  # rad/s
