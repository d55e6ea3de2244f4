"""Motions and figures against a second program: absolute coordinates with multipliers, scipy, none of the package.

See `absolute_crank`.  Motion with clearance is chaotic, so horizons are short.
"""

import copy
import itertools
import math

import numpy as np
import pytest
from absolute_crank import NAMES, Crank, Damped, Karnopp, Yielding, seat, start_of
from mechanism_cases import SLIDER_CRANK, slider_crank
from scipy.integrate import solve_ivp
from spatial_oracle import rotation, skew
from test_machines_in_space import CRANK, GRAVITY, ROCKER, ROD, RPM, four_bar

import clearsweep
from clearsweep.simulation.running import observed_run

pytestmark = [pytest.mark.heavy, pytest.mark.compiled]

CLEARANCE, BEARING, STIFFNESS = 0.5e-3, 0.01, 6.61e10
TIGHT = {"simulate.tolerance": 1e-11, "simulate.method": "explicit"}


def simulated(joints, changes, times=None):
    """Return the run of a slider-crank."""
    result = clearsweep.simulate(clearsweep.load_case(slider_crank(*joints, changes=TIGHT | changes)), times=times)
    assert result.status == "ok", result.message
    return result


def again(result, law, rpm, *, friction=None, gravity=0.0, sizes=(CLEARANCE, BEARING), seated=False, rtol=1e-11):
    """Return the second program after the same motion, its states and its contacts at the same times.

    found : a run with its open joints' histories; law : makes a contact's law.
    """
    opened = [name for name in NAMES if f"joints/{name.replace('-', '_')}/x" in result.channels]
    mechanism = SLIDER_CRANK["mechanism"] | {"gravity": gravity}
    crank = Crank(mechanism, rpm * 2.0 * math.pi / 60.0, {name: (law(), friction, sizes) for name in opened})
    start = start_of(crank, result)
    if seated:
        seat(crank, start)
    return crank, *crank.run(start, np.array(result.t), rtol, longest=1e-3 / crank.speed)  # no contact is stepped over


def check_motion(result, crank, states, message, share):
    """Check the motion to a share of the clearance, and forces to that share of the largest."""
    assert result["slider/x"] == pytest.approx(states[:, 6], rel=0.0, abs=share * CLEARANCE)
    assert result["rod/angle"] == pytest.approx(states[:, 5], rel=0.0, abs=share * CLEARANCE / 0.12)
    for k, name in enumerate(crank.names):
        for row, force in enumerate(("normal", "tangential")):
            here = result[f"joints/{name.replace('-', '_')}/force_{force}"]
            assert here == pytest.approx(message[:, k, row], rel=0.0, abs=share * message[:, k, 0].max())


def onsets(result):
    """Return times (s) and joints of all onsets and separations of a run."""
    return result.events["t"], [name.replace("_", "-") for name in result.events["joint"]]


def check_events(result, crank, off):
    """Check that contacts begin and end at the same times, to `off` (s)."""
    times, joints = onsets(result)
    own = [(t, name) for t, name, what in crank.events if what in ("onset", "separation")]
    assert joints == [name for _, name in own]
    assert times == pytest.approx([t for t, _ in own], rel=0.0, abs=off)


# ---------------------------------------------------------------------------------------------- friction that sticks

STICKS = {"law": "karnopp", "coefficient": 0.15, "static_coefficient": 0.25, "stribeck_velocity": 0.1, "band": 0.08}


@pytest.mark.slow
def test_three_joints_that_stick_at_once_solve_the_complementarity_problem():
    """60 rpm, seated: one slides, sticks and lets go again; forces of all three meet their limits.

    The second program tries all ways in which three forces can be free or at a limit; N and T agree to 1e-9.
    """
    contact = {"law": "lankarani-nikravesh", "stiffness": 6.61e8, "restitution": 0.5, "onset": "first"}
    changes = {
        f"joints.{name}.{key}": value for name in NAMES for key, value in (("friction", STICKS), ("contact", contact))
    }
    changes |= {"drive.speed": "60 rpm", "mechanism.gravity": 9.81, "simulate.start": "seated"}
    result = simulated(NAMES, changes | {"simulate.revolutions": 0.03}, np.linspace(0.0, 0.03, 61))
    crank, states, message = again(
        result, lambda: Damped(6.61e8, 0.5), 60.0, friction=Karnopp(0.15, 0.25, 0.1, 0.08), gravity=9.81, seated=True
    )
    check_motion(result, crank, states, message, 1e-8)
    assert [what for *_, what in crank.events] == ["stick", "slip"]
    shares = np.abs(message[:, :, 1]) / message[:, :, 0]
    assert np.all(shares[10] < 0.24)  # all three hold
    assert np.count_nonzero(shares > 0.25 - 1e-9, axis=0).min() >= 3  # and each comes to its limit


# ---------------------------------------------------------------------------------------------- contact that yields

YIELDS = {"law": "lankarani-nikravesh-plastic", "stiffness": STIFFNESS, "restitution": 0.7}


@pytest.mark.slow
def test_a_yielding_contact_moves_the_slider_as_the_second_program_says():
    """5000 rpm, 0.3 revolutions: contacts turn back and deepen again.

    N agrees to 2e-7 of its peak, an error of the second program: 1e-6, 2e-7, 7e-7 at its rtol 1e-11, 1e-12, 3e-13.
    """
    end = 0.3 * 60.0 / 5000.0
    times = np.linspace(0.0, end, 2001)
    changes = {"joints.rod-slider.contact": YIELDS, "simulate.revolutions": 0.3}
    result = simulated(["rod-slider"], changes, times)
    crank, states, message = again(result, lambda: Yielding(STIFFNESS, 0.7), 5000.0, rtol=1e-12)
    check_motion(result, crank, states, message, 3e-7)
    force = "joints/rod_slider/force_normal"
    tighter = simulated(["rod-slider"], changes | {"simulate.tolerance": 1e-13}, times)[force]
    assert result[force] == pytest.approx(tighter, rel=0.0, abs=1e-9 * tighter.max())
    check_events(result, crank, 1e-9)
    kinds = [what for *_, what in crank.events]
    assert kinds.count("turn") > 3
    assert kinds.count("reach") > 0
    theta = crank.speed * times
    ideal = 0.05 * np.cos(theta) + np.sqrt(0.12**2 - (0.05 * np.sin(theta)) ** 2)
    off = np.abs(states[:, 6] - ideal)
    k = int(np.argmax(off))
    assert 0 < k < len(times) - 1
    peak = off[k] + (off[k + 1] - off[k - 1]) ** 2 / (8.0 * (2.0 * off[k] - off[k + 1] - off[k - 1]))
    assert result.summary["slider_error_max"] == pytest.approx(peak, rel=1e-6)


@pytest.mark.slow
def test_two_joints_that_yield_move_as_the_second_program_says():
    joints = ["crank-rod", "rod-slider"]
    changes = {f"joints.{name}.contact": YIELDS for name in joints} | {"simulate.revolutions": 0.2}
    result = simulated(joints, changes, np.linspace(0.0, 0.2 * 60.0 / 5000.0, 201))
    crank, states, message = again(result, lambda: Yielding(STIFFNESS, 0.7), 5000.0)
    check_motion(result, crank, states, message, 5e-5)
    check_events(result, crank, 1e-8)
    assert {name for _, name, what in crank.events if what == "turn"} == set(joints)


# ---------------------------------------------------------------------------------------------- figures of motion


def twin_growths(crank, start, moments, size=1e-6):
    """Return the logarithm of the growth of a disturbance from the start to each of the moments (s): Benettin et al.

    The distance is that of the rod's angle and of the slider in clearances and of their rates in clearances times crank
    rate, the angle's times the rod's length; while one motion is in contact and the other not, it waits.
    """
    places, n = [5, 6, 14, 15], 4
    units = CLEARANCE * np.array([1.0 / 0.12, 1.0, crank.speed / 0.12, crank.speed])
    base, other = crank, copy.deepcopy(crank)
    y, growths = start.copy(), [0.0]

    def moved(state, off):
        """Return a state off by so much in the four numbers, with the rod's centre where the ideal crank pin has it."""
        there = state.copy()
        there[places] += off * units
        t = base.solver_time
        pin = 0.05 * np.array([math.cos(crank.speed * t), math.sin(crank.speed * t)])
        moving = crank.speed * np.array([-pin[1], pin[0]])
        distance = 0.06 * np.array([math.cos(there[5]), math.sin(there[5])])
        there[3:5], there[12:14] = pin + distance, moving + there[14] * np.array([-distance[1], distance[0]])
        return there

    base.solver_time = 0.0
    off = np.full(n, size / math.sqrt(n))
    z = moved(y, off)
    for ends in itertools.pairwise(moments):
        span = np.array(ends)
        y = base.run(y, span, longest=4e-3 / crank.speed)[0][-1]
        z = other.run(z, span, longest=4e-3 / crank.speed)[0][-1]
        base.solver_time = span[-1]
        off = (z - y)[places] / units
        distance = np.linalg.norm(off)
        assert base.contacts[0].touching == other.contacts[0].touching
        growths.append(growths[-1] + math.log(distance / size))
        z = moved(y, size * off / distance)
        other.contacts = copy.deepcopy(other.contacts)
        gone = (other.contacts[0].onset - base.contacts[0].onset) * size / distance
        other.contacts[0].onset = base.contacts[0].onset + gone
    return np.array(growths)


@pytest.mark.slow
def test_a_disturbance_grows_as_the_second_program_has_it(monkeypatch):
    """5000 rpm, one revolution: growths of up to e^11 agree within a tenth of their logarithm, at all moments."""
    seen = []

    class Seen(observed_run.Perturbed):
        def __init__(self, *args):
            super().__init__(*args)
            seen.append(self)

    monkeypatch.setattr("clearsweep.simulation.running.run.Perturbed", Seen)
    contact = {"law": "lankarani-nikravesh", "stiffness": STIFFNESS, "restitution": 0.9, "onset": "first"}
    changes = {"joints.rod-slider.contact": contact, "simulate.horizon": True, "simulate.tolerance": 1e-12}
    result = simulated(["rod-slider"], changes, np.linspace(0.0, 60.0 / 5000.0, 3))
    opened = {"rod-slider": (Damped(STIFFNESS, 0.9), None, (CLEARANCE, BEARING))}
    crank = Crank(SLIDER_CRANK["mechanism"], 5000.0 * math.pi / 30.0, opened)
    moments = np.array(seen[0].times)
    own = twin_growths(crank, start_of(crank, result), moments)
    assert seen[0].growths == pytest.approx(list(own), rel=0.0, abs=0.1)
    assert moments[-1] > 0.8 * 60.0 / 5000.0
    assert result.summary["lyapunov_exponent"] == pytest.approx(own[-1] / moments[-1], rel=1e-2)


def own_period(states, units):
    """Return the least number of revolutions that a motion repeats three times at its end; states: one a turn."""
    for period in range(1, 17):
        last = states[-4 * period :]
        if len(last) < 4 * period:
            return None
        off = (last[period:] - last[:-period]) / units
        if np.abs(off).max() <= 1e-3:
            return period
    return None


@pytest.mark.parametrize(
    ("rpm", "clearance", "restitution", "period"),
    [(5000.0, 5e-5, 0.3, 1), (3000.0, 2e-4, 0.3, 2), (2000.0, 1e-4, 0.3, 2), (1000.0, 5e-5, 0.1, None)],
)
def test_the_period_of_a_motion_is_that_of_its_bodies_in_absolute_coordinates(rpm, clearance, restitution, period):
    friction = {"law": "ambrosio", "coefficient": 0.05, "v0": 1e-3, "v1": 1e-2}
    joint = {"clearance": clearance, "contact.restitution": restitution, "friction": friction}
    changes = {f"joints.rod-slider.{key}": value for key, value in joint.items()}
    changes |= {
        "drive.speed": f"{rpm} rpm",
        "simulate.revolutions": 45,
        "simulate.discard": 20,
        "simulate.tolerance": 1e-8,
    }
    turns = np.arange(20, 46) * 60.0 / rpm
    result = simulated(["rod-slider"], changes | {"simulate.method": "auto"}, turns)
    law = Damped(STIFFNESS, restitution)
    crank = Crank(SLIDER_CRANK["mechanism"], rpm * math.pi / 30.0, {"rod-slider": (law, None, (clearance, BEARING))})
    states = np.array([start_of(crank, result, k) for k in range(len(turns))])
    states[:, 2] -= crank.speed * turns
    units = clearance * np.tile([1.0, 1.0, 1.0 / 0.12], 6)
    units[9:] *= crank.speed
    assert result.summary["period"] == own_period(states, units) == period


# ---------------------------------------------------------------------------------------------- in space


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


def sampled_start(result):
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


@pytest.mark.slow
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
    own = solve_ivp(machine.rates, (0.0, times[-1]), sampled_start(result), "DOP853", times, rtol=1e-12, atol=1e-14).y
    for k, body in enumerate(BODIES):
        places = np.array([result[f"{body}/{axis}"] for axis in "xyz"])
        spins = np.array([result[f"{body}/w{axis}"] for axis in "xyz"])
        assert places == pytest.approx(own[13 * k : 13 * k + 3], rel=0.0, abs=1e-13)
        assert spins == pytest.approx(own[13 * k + 10 : 13 * k + 13], rel=0.0, abs=1e-10)
        if body == "coupler":
            assert np.abs(spins[:2]).max() > 1e-2  # rad/s
