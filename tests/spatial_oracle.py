"""An independent slider-crank with a spatial joint: absolute coordinates, multipliers, the fixed frame, scipy.

It uses no code of the package.  Rod and slider have all their coordinates; ideal joints and the guide are constraints
on
accelerations.  The point of a circle that is farthest from an axis is searched on a fan of angles and refined by
Newton's method on the angle.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

ENDS = (1.0, -1.0)
FAN = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
DIRECTIONS = np.array([np.cos(FAN), np.sin(FAN)])[:, :, None]


def rotation(q):
    """Return the rotation matrix of a unit quaternion w, x, y, z."""
    w, v = q[0], q[1:]
    return (w * w - v @ v) * np.eye(3) + 2.0 * np.outer(v, v) + 2.0 * w * skew(v)


def skew(v):
    """Return the matrix of v x."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def turned_about(vector):
    """Return the rotation matrix of a rotation vector (Rodrigues)."""
    angle = np.linalg.norm(vector)
    if angle == 0.0:
        return np.eye(3)
    k = skew(vector / angle)
    return np.eye(3) + math.sin(angle) * k + (1.0 - math.cos(angle)) * k @ k


def extreme(center, radius, axes, distance, sign):
    """Return the point of a circle with the largest distance from an axis through 0, times `sign`.

    axes : (2, 3) vectors in the circle's plane; distance : (3,) the axis.
    """
    off = np.eye(3) - np.outer(distance, distance)
    c, a, b = off @ center, radius * off @ axes[0], radius * off @ axes[1]

    def slopes(x):
        p, d = c + math.cos(x) * a + math.sin(x) * b, -math.sin(x) * a + math.cos(x) * b
        return sign * 2.0 * p @ d, sign * 2.0 * (d @ d - p @ (p - c))

    x = FAN[int(np.argmax(sign * np.sum((c + DIRECTIONS[0] * a + DIRECTIONS[1] * b) ** 2, axis=1)))]
    for _ in range(30):
        first, second = slopes(x)
        if second >= 0.0:
            break
        step = -first / second
        x += min(max(step, -0.2), 0.2)
        if abs(step) < 1e-15:
            break
    return center + radius * (math.cos(x) * axes[0] + math.sin(x) * axes[1])


class Oracle:
    """One scene: `grid` is a grid in SI without defaults; one joint is open, the other spherical or cylindrical."""

    def __init__(self, grid):
        """Read the numbers."""
        mechanism = grid["mechanism"]
        crank, rod = mechanism["crank"], mechanism["rod"]
        (self.name, joint), *_ = grid["joints"].items()
        self.on_crank = self.name == "crank-rod"
        self.ball = next(iter(mechanism["ideal"].values())) == "spherical"
        self.radius, self.length, self.mass = crank["length"], rod["length"], rod["mass"]
        self.inertia, self.center = np.diag(rod["inertia"]), np.array(rod["center"], float)
        self.slider, self.gravity = mechanism["slider"]["mass"], np.array(mechanism["gravity"], float)
        self.speed, self.joint = grid["drive"]["speed"], joint
        self.bearing = joint["bearing_radius"]
        self.journal = self.bearing - joint["clearance"]
        self.half, self.journal_half_length = 0.5 * joint["length"], 0.5 * joint.get("journal_length", joint["length"])
        self.tilt = turned_about(np.array([*joint.get("tilt", (0.0, 0.0)), 0.0]))
        self.offset = np.array(joint.get("offset", (0.0, 0.0, 0.0)), float)
        contact = joint["contact"]
        self.stiffness, self.chi = contact["stiffness"], 0.75 * (1.0 - contact["restitution"] ** 2)
        self.count = 4 if joint["flange"] else 2
        self.touching, self.onset = [False] * self.count, [0.0] * self.count

    def start(self):
        """Return the state: rod's centre, slider (3), quaternion, velocities of both, angular velocity."""
        rate = -self.radius * self.speed / self.length
        pin, spin = np.array([self.radius, 0.0, 0.0]), np.array([0.0, 0.0, rate])
        moving = np.array([0.0, self.radius * self.speed, 0.0]) + np.cross(spin, self.center)
        slider = np.array([self.radius + self.length, 0.0, 0.0])
        return np.concatenate([pin + self.center, slider, [1.0, 0.0, 0.0, 0.0], moving, np.zeros(3), spin])

    def crank(self, t):
        """Return the rotation matrix of the crank and its angular velocity (rad/s)."""
        c, s = math.cos(self.speed * t), math.sin(self.speed * t)
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), np.array([0.0, 0.0, self.speed])

    def look(self, t, y):
        """Return rotation and pins of the rod; centre, axis, velocity and angular velocity of bearing and journal."""
        r, s, q, v, vs, w = y[:3], y[3:6], y[6:10] / np.linalg.norm(y[6:10]), y[10:13], y[13:16], y[16:19]
        turn = rotation(q)
        near, far = -turn @ self.center, turn @ (np.array([self.length, 0.0, 0.0]) - self.center)
        if self.on_crank:
            frame, spin = self.crank(t)
            middle = frame @ (np.array([self.radius, 0.0, 0.0]) + self.offset)
            return turn, near, far, (middle, frame @ self.tilt[:, 2], np.cross(spin, middle), spin), r + near, (v, w)
        return turn, near, far, (s + self.offset, self.tilt[:, 2], vs, np.zeros(3)), r + far, (v, w)

    def points(self, seen):
        """Return position (m), outward normal and depth (m) of every contact point."""
        turn, _, _, (middle, u, _, _), journal, _ = seen
        w, result = turn[:, 2], []
        facing = math.copysign(1.0, u @ w)
        for end in ENDS:
            if self.count == 2 and self.journal_half_length > self.half:
                a = np.cross(u, np.array([1.0, 0.3, 0.2]))
                a /= np.linalg.norm(a)
                edge = middle + end * facing * self.half * u - journal
                p = extreme(edge, self.bearing, (a, np.cross(u, a)), w, -1.0)
                out = p - (p @ w) * w
                depth = self.journal - np.linalg.norm(out)
                n = out / np.linalg.norm(out)
                result.append((journal + p + depth * n, n, depth))
            else:
                p = extreme(
                    journal + end * self.journal_half_length * w - middle,
                    self.journal,
                    (turn[:, 0], turn[:, 1]),
                    u,
                    1.0,
                )
                out = p - (p @ u) * u
                distance = np.linalg.norm(out)
                result.append((middle + p, out / distance, distance - self.bearing))
        for end in ENDS if self.count == 4 else ():
            n = end * facing * u
            rim = n - (n @ w) * w
            size = np.linalg.norm(rim)
            p = journal + end * self.journal_half_length * w + (self.journal * rim / size if size > 0.0 else 0.0)
            result.append((p, n, (p - middle) @ n - self.half - self.joint["axial_clearance"]))
        return result

    def rubbing(self, normal, speed):
        """Return the friction force (N) for a normal force (N) and a sliding speed (m/s)."""
        law = self.joint.get("friction")
        if law is None:
            return 0.0
        ramp = (speed - law["v0"]) / (law["v1"] - law["v0"])
        return law["coefficient"] * normal * min(max(ramp, 0.0), 1.0)

    def forces(self, t, y):
        """Return force (N) on the rod, moment (N m) about its centre, force (N) on the slider, rates (m/s)."""
        seen = self.look(t, y)
        _, _, _, (middle, _, moving, spin), _, (v, w) = seen
        force, moment, on_slider, rates, normals = np.zeros(3), np.zeros(3), np.zeros(3), [], []
        for k, (p, n, depth) in enumerate(self.points(seen)):
            base = p - depth * n
            relative = v + np.cross(w, p - y[:3]) - moving - np.cross(spin, base - middle)
            rate = relative @ n
            rates.append(rate)
            push = 0.0
            if self.touching[k]:
                share = 0.5 if k < 2 else 1.0
                push = share * self.stiffness * max(depth, 0.0) ** 1.5 * (1.0 + self.chi * rate / self.onset[k])
                push = max(push, 0.0)
            normals.append(push)
            sliding = relative - rate * n
            size = np.linalg.norm(sliding)
            whole = -push * n - (self.rubbing(push, size) / size * sliding if size > 0.0 else 0.0)
            force += whole
            moment += np.cross(p - y[:3], whole)
            on_slider -= 0.0 if self.on_crank else whole
        return seen, force, moment, on_slider, rates, normals

    def constraints(self, seen, t):
        """Return rows over (rod's acceleration, angular acceleration, slider's acceleration); right side."""
        _, near, far, _, _, (_, w) = seen
        arm = far if self.on_crank else near
        pull = np.cross(w, np.cross(w, arm))
        rows, right = np.zeros((3, 9)), -pull
        rows[:, :3], rows[:, 3:6] = np.eye(3), -skew(arm)
        if self.on_crank:
            rows[:, 6:] = -np.eye(3)
        else:
            frame, _ = self.crank(t)
            right = right - self.speed**2 * frame @ np.array([self.radius, 0.0, 0.0])
        guide = np.zeros((2, 9))
        guide[0, 7] = guide[1, 8] = 1.0
        if self.ball:
            return np.vstack([rows, guide]), np.concatenate([right, np.zeros(2)])
        upright = np.zeros((2, 9))  # the journal's axis remains along z
        upright[0, 3] = upright[1, 4] = 1.0
        return np.vstack([rows[:2], upright, guide]), np.concatenate([right[:2], np.zeros(4)])

    def rates(self, t, y):
        """Return the rates of the state."""
        seen, force, moment, on_slider, _, _ = self.forces(t, y)
        turn, w = seen[0], y[16:19]
        inertia = turn @ self.inertia @ turn.T
        mass = np.zeros((9, 9))
        mass[:3, :3], mass[3:6, 3:6], mass[6:, 6:] = self.mass * np.eye(3), inertia, self.slider * np.eye(3)
        applied = np.concatenate(
            [
                force + self.mass * self.gravity,
                moment - np.cross(w, inertia @ w),
                on_slider + self.slider * self.gravity,
            ]
        )
        rows, right = self.constraints(seen, t)
        many = len(rows)
        whole = np.block([[mass, rows.T], [rows, np.zeros((many, many))]])
        a = np.linalg.solve(whole, np.concatenate([applied, right]))[:9]
        q = y[6:10]
        angle_rate = 0.5 * np.concatenate([[-w @ q[1:]], q[0] * w + np.cross(w, q[1:])])
        return np.concatenate([y[10:13], y[13:16], angle_rate, a[:3], a[6:], a[3:6]])

    def run(self, times):
        """Return the states at `times` (s), the normal forces there, and the events (t, contact, rate)."""

        def gap(k):
            def depth(t, y):
                return self.points(self.look(t, y))[k][2]

            depth.terminal = True
            return depth

        watched, t, y, events = [gap(k) for k in range(self.count)], 0.0, self.start(), []
        states, normals = np.zeros((len(times), 19)), np.zeros((len(times), self.count))
        while t < times[-1]:
            for k, function in enumerate(watched):
                function.direction = -1.0 if self.touching[k] else 1.0
            result = solve_ivp(
                self.rates,
                (t, times[-1]),
                y,
                "DOP853",
                events=watched,
                rtol=1e-12,
                atol=1e-14,
                dense_output=True,
                max_step=2e-4,
            )
            for i in np.flatnonzero((times >= t) & (times <= result.t[-1])):
                states[i] = result.sol(times[i])
                normals[i] = self.forces(times[i], states[i])[5]
            t, y = result.t[-1], result.y[:, -1]
            for k in range(self.count) if result.status == 1 else ():
                if len(result.t_events[k]):
                    rate = self.forces(t, y)[4][k]
                    self.touching[k] = not self.touching[k]
                    self.onset[k] = max(rate, 1e-3)
                    events.append((t, k, rate))
        return states, normals, events


class SlicedOracle(Oracle):
    """The same scene with 60 slices of the length, each pressed by itself at the farthest point of its circle.

    The contact is lossless, without friction and without flanges in reach.
    """

    def __init__(self, grid, count=60):
        """Read the numbers; `count` slices at the nodes of Gauss's rule."""
        grid["joints"][next(iter(grid["joints"]))]["contact"].setdefault("restitution", 1.0)
        super().__init__(grid)
        nodes, weights = np.polynomial.legendre.leggauss(count)
        self.z, self.shares = self.journal_half_length * nodes, 0.5 * weights

    def forces(self, t, y):
        """Return what Oracle.forces returns, with the force of each slice in place of those of contact points."""
        seen = self.look(t, y)
        turn, _, _, (middle, u, _, _), journal, _ = seen
        center = journal - middle + self.z[:, None] * turn[:, 2]
        across = center - (center @ u)[:, None] * u
        a, b = (self.journal * (turn[:, k] - (turn[:, k] @ u) * u) for k in range(2))
        angle = np.arctan2(across @ b, across @ a)
        for _ in range(8):
            d = np.cos(angle)[:, None] * a + np.sin(angle)[:, None] * b
            e = -np.sin(angle)[:, None] * a + np.cos(angle)[:, None] * b
            out = across + d
            curvature = np.sum(e * e, axis=1) - np.sum(out * d, axis=1)
            angle = angle - np.sum(out * e, axis=1) / np.where(curvature < 0.0, curvature, -np.inf)
        distance = np.linalg.norm(out, axis=1)
        size = self.stiffness * self.shares * np.maximum(distance - self.bearing, 0.0) ** 1.5
        normals = -size[:, None] * out / distance[:, None]
        rim = np.cos(angle)[:, None] * turn[:, 0] + np.sin(angle)[:, None] * turn[:, 1]
        points = middle + center + self.journal * rim
        force, moment = normals.sum(axis=0), np.cross(points - y[:3], normals).sum(axis=0)
        return seen, force, moment, np.zeros(3) if self.on_crank else -force, [], size

    def move(self, time):
        """Return the state at `time` (s)."""
        result = solve_ivp(self.rates, (0.0, time), self.start(), "DOP853", rtol=1e-9, atol=1e-12, max_step=1e-5)
        return result.y[:, -1]
