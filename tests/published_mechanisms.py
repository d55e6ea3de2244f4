"""Published machines whose motion a crank, a film or friction determines: see published_machines.py."""

import math

import numpy as np
from film_oracle import solution
from published_machines import FAR, FIRM, PRINTED, STILL, G, grid_of, run
from scipy.integrate import quad, solve_ivp

# ---------------------------------------------------------------------------------------------- friction and films


def sliding_to_rolling():
    """Return speed and time at which a ball, a disk and a hoop (50 mm, 1 m/s, friction 0.2) begin to roll."""
    exact, computed = [], []
    for share in (0.4, 0.5, 1.0):  # inertia over m r^2
        exact.append((1.0 / (1.0 + share), share / (1.0 + share) / (0.2 * G)))
        bowl = {"clearance": 9999.95, "bearing_radius": 1e4, "contact": FIRM}  # as good as a plane
        bowl["friction"] = {"law": "tanh", "coefficient": 0.2, "velocity_scale": 1e-6}
        body = {"ball": (1.0, share * 0.05**2, {"y": -9999.949999999, "vx": 1.0})}
        grid = grid_of(0.5, body, {"floor": ("revolute", "ground", "ball", bowl)}, gravity=G, tolerance=1e-12)
        grid["mechanism"]["joints"]["floor"]["journal"] = "ball"
        path = run(grid)
        slip = path["ball/vx"] + 0.05 * path["ball/rate"]
        slides = (slip > 0.1) & (slip < 0.9)
        slope, begin = np.polyfit(path.t[slides], slip[slides], 1)
        computed.append((path["ball/vx"][-1], -begin / slope))
    exact, computed = np.transpose(exact), np.transpose(computed)
    return {"three final speeds, m/s": (exact[0], computed[0]), "three times of rolling, s": (exact[1], computed[1])}


def on_slides(journal):
    """Return the grid of a housing that slides freely along x and y, with a bearing on the shaft or on the ground."""
    pairs = {
        "main": {"type": "revolute", "between": ["ground.p", "shaft.p"]},
        "across": {"type": "prismatic", "between": ["ground.p", "carriage.p"], "axis": 0.0},
        "along": {"type": "prismatic", "between": ["carriage.p", "housing.p"], "axis": 0.5 * math.pi},
        "bearing": {"type": "revolute", "between": [f"{journal}.p", "housing.p"], "journal": journal},
    }
    masses = {"shaft": (1.0, 1e-4), "carriage": (0.0, 0.0), "housing": (1e-4 if journal == "ground" else 1.0, 0.0)}
    bodies = {"ground": {"points": {"p": STILL}}}
    for name, (mass, inertia) in masses.items():
        bodies[name] = {"mass": mass, "inertia": inertia, "center": STILL, "points": {"p": STILL}}
    machine = {"type": "planar", "gravity": 0.0, "bodies": bodies, "joints": pairs, "driven": "main"}
    return {"mechanism": machine | {"output": {"body": "shaft"}}, "save": {"orbits": "all"}}


def friction_circle():
    """Return torque and place of a dry journal bearing: the load is tangent to the circle of radius r sin(atan mu)."""
    torques, angles = ([], []), ([], [])
    for coefficient in (0.1, 0.3, 0.5):
        grid = on_slides("shaft") | {"drive": {"speed": 10.0}}
        contact = {"law": "kelvin-voigt", "stiffness": 1e8, "damping": 2e4}
        friction = {"law": "tanh", "coefficient": coefficient, "velocity_scale": 1e-5}
        bearing = {"clearance": 1e-4, "bearing_radius": 0.02, "contact": contact, "friction": friction}
        damper = {"between": ["ground", "housing"], "anchor": [-100.0, 0.0], "point": "p", "stiffness": 0.0}
        grid["loads"] = {"weight": {"on": "housing", "force": [0.0, -100.0]}, "damper": damper | {"damping": 2000.0}}
        grid |= {"joints": {"bearing": bearing}, "simulate": {"discard": 4, "revolutions": 5, "tolerance": 1e-8}}
        path = run(grid)
        torques[0].append(0.0199 * 100.0 * math.sin(math.atan(coefficient)))
        torques[1].append(abs(path["drive/torque"][-1]))
        angles[0].append(math.atan(coefficient))
        x, y = (path[f"joints/bearing/{axis}"][-1] for axis in "xy")
        angles[1].append(math.atan2(abs(x), abs(y)))
    return {"three torques, N m": torques, "three angles of climb, rad": angles}


BEARING = {"clearance": 4e-5, "bearing_radius": 0.02, "length": 0.01}  # m
VISCOSITY, LOAD = 0.05, 200.0  # Pa s, N


def squeezed(law, times):
    """Return how far the load has closed a bearing, from its middle, at `times` (s): eccentricity ratios."""
    grid = on_slides("ground") | {"drive": {"speed": 2.0 * math.pi / 0.4}}
    grid["joints"] = {"bearing": BEARING | {"film": {"law": law, "viscosity": VISCOSITY, "limit": 0.995}}}
    grid["loads"] = {"weight": {"on": "housing", "force": [0.0, -LOAD]}}
    grid["simulate"] = {"discard": 0, "revolutions": 1, "tolerance": 1e-9}
    path = run(grid, np.array([0.0, *times]))
    return np.hypot(path["joints/bearing/x"], path["joints/bearing/y"])[1:] / BEARING["clearance"]


def squeeze():
    """Return how far a short bearing (Ocvirk's film where it presses) closes in times that a quadrature gives."""
    radius, length, gap = BEARING["bearing_radius"], BEARING["length"], BEARING["clearance"]
    ratios = (0.2, 0.5, 0.8, 0.9, 0.95)

    def resistance(e):
        film = quad(lambda a: math.cos(a) ** 2 / (1.0 + e * math.cos(a)) ** 3, 0.5 * math.pi, 1.5 * math.pi)[0]
        return VISCOSITY * length**3 * radius / gap**2 / LOAD * film

    times = [quad(resistance, 0.0, ratio, epsabs=0.0, epsrel=1e-12)[0] for ratio in ratios]
    return {"eccentricity ratio at five times": (ratios, squeezed("short", times))}


def squeeze_of_finite_length():
    """Return the same with both laws of finite length, against a second solver of Reynolds' equation."""
    radius, length, gap = BEARING["bearing_radius"], BEARING["length"], BEARING["clearance"]
    unit = 12.0 * VISCOSITY * length * radius**3 / gap**2 / LOAD  # s: time of a force of 1
    ratios, nodes, weights = (0.2, 0.5, 0.8), *np.polynomial.legendre.leggauss(5)
    times, begin, time = [], 0.0, 0.0
    for end in ratios:
        forces = [
            np.hypot(*solution(0.5 * length / radius, 0.5 * (begin + end + node * (end - begin)), 1.0, 0.0)[:2])
            for node in nodes
        ]
        time += 0.5 * (end - begin) * unit * weights @ forces
        times.append(time)
        begin = end
    return {
        "eccentricity ratio at three times": (ratios, squeezed("reynolds", times)),
        "the same, law finite": (ratios, squeezed("finite", times)),
    }


# ---------------------------------------------------------------------------------------------- pendulum and springs


def adams_pendulum():
    """Return the motion of a rod of 1 kg, 2 m from its pivot, that falls from rest, as ADAMS printed it."""
    printed = PRINTED["adams_pendulum"]
    pin = {"clearance": 1e-6, "bearing_radius": 0.01}
    pin["contact"] = {"law": "kelvin-voigt", "stiffness": 1e7, "damping": 900.0}
    rod = {"rod": (1.0, 0.1, {"x": 2.0})}
    grid = grid_of(5.0, rod, {"pin": ("revolute", "ground", "rod", pin)}, gravity=9.80665, tolerance=1e-5)
    grid["mechanism"]["bodies"]["rod"]["center"] = [2.0, 0.0]
    path = run(grid, np.array([0.0, *printed["t"]]))
    force = np.hypot(path["joints/pin/force_normal"], path["joints/pin/force_tangential"])[1:]
    return {
        "x to 5 s, m": (printed["x"], path["rod/x"][1:]),
        "z to 5 s, m": (printed["z"], path["rod/y"][1:]),
        "rate to 5 s, rad/s": (printed["rate"], path["rod/rate"][1:]),
        "force of the pivot to 5 s, N": (printed["force"], force),
    }


def adams_springs():
    """Return the motion of 1 kg on a spring with damper, as ADAMS printed it: hanging, and swinging."""
    result = {}
    for name, stiffness, free, damping, start in (("1", 10.0, 0.0, 0.5, 0.0), ("2", 100.0, 2.0, 5.0, 2.0)):
        spring = {"between": ["ground", "mass"], "anchor": STILL, "point": "p", "stiffness": stiffness}
        loads = {"spring": spring | {"free_length": free, "damping": damping}}
        mass = {"mass": (1.0, 0.1, {"x": start, "y": 0.0 if start else -1e-9})}
        printed = PRINTED[f"adams_spring_{name}"]
        grid = grid_of(5.0, mass, {"far": ("revolute", "ground", "mass", FAR)}, loads, gravity=9.80665, tolerance=1e-12)
        path = run(grid, np.array(printed["t"]))
        result[f"z of case {name} to 5 s, m"] = (printed["z"], path["mass/y"])
        if start:
            result[f"y of case {name} to 5 s, m"] = (printed["y"], path["mass/x"])
    return result


def crank_under_torque(times):
    """Return the angle (rad) and rate (rad/s) of Exudyn's slider-crank under 0.1 N m, from rest, by its energy.

    J(a) a'^2/2 = 0.1 a; with a = s^2 the rate s' = sqrt(0.05/J) is regular at the start.
    """

    def inertia(angle):
        sin, cos = math.sin(angle), math.cos(angle)
        reach = math.sqrt(0.3**2 - (0.1 * sin) ** 2)
        turn = -0.1 * cos / reach  # rate of the rod over that of the crank
        slider = -0.1 * sin * (1.0 + 0.1 * cos / reach)
        middle = (0.5 * (slider - 0.1 * sin), 0.05 * cos)
        rod = 0.0015 * turn**2 + 0.2 * (middle[0] ** 2 + middle[1] ** 2)
        return 0.2 * 0.1**2 / 3.0 + rod + 0.4 * slider**2

    def rate(_, state):
        return [math.sqrt(0.05 / inertia(state[0] ** 2))]

    s = solve_ivp(rate, (0.0, times[-1]), [0.0], "DOP853", times, rtol=1e-12, atol=1e-13).y[0]
    return s**2, np.array([2.0 * root * rate(0.0, [root])[0] for root in s])


def torque_grid():
    """Return the grid of Exudyn's slider-crank next to a weight in a bowl, as a machine needs a clearance."""
    bowl = {"clearance": 1e-3, "bearing_radius": 2e-3, "contact": {"law": "hertz", "stiffness": 1e9}}
    grid = grid_of(1.0, {"weight": (1.0, 1.0, {})}, {"rest": ("revolute", "ground", "weight", bowl)}, tolerance=1e-11)
    machine = grid["mechanism"]
    for name, mass, inertia, center, points in (
        ("wheel", 0.2, 0.2 * 0.1**2 / 12.0, 0.05, {"p": STILL, "pin": [0.1, 0.0]}),
        ("rod", 0.2, 0.0015, 0.15, {"pin": STILL, "end": [0.3, 0.0]}),
        ("slider", 0.4, 4e-4, 0.0, {"end": STILL}),
    ):
        body = {"mass": mass, "inertia": inertia, "center": [center, 0.0], "points": points}
        machine["bodies"][name] = body
    machine["joints"] |= {
        "big": {"type": "revolute", "between": ["wheel.pin", "rod.pin"]},
        "small": {"type": "revolute", "between": ["rod.end", "slider.end"]},
        "bore": {"type": "prismatic", "between": ["ground.p", "slider.end"], "axis": 0.0},
    }
    machine["output"] = {"body": "slider", "point": "end"}
    grid["drive"] = {"torque": 0.1, "initial_speed": 0.0}
    grid["simulate"] |= {"revolutions": 9, "time_limit": 3.0}
    return grid


def slider_crank_under_torque():
    """Return the motion of Exudyn's sliderCrankFloatingTest with a fixed frame, against its energy and MATLAB."""
    printed = PRINTED["matlab_slider_crank"]
    times = np.array(sorted([0.0, 0.3, *printed["t"]]))
    angle, rate = crank_under_torque(times)
    path = run(torque_grid(), times)
    at, shared = np.searchsorted(times, 0.3), np.isin(times, printed["t"])
    reach = 0.1 * math.cos(angle[at]) + math.sqrt(0.3**2 - (0.1 * math.sin(angle[at])) ** 2)
    return {
        "slider at 0.3 s, m": (reach, path["slider/x"][at]),
        "the same by Exudyn, m": (PRINTED["exudyn"]["slider_crank"], path["slider/x"][at]),
        "crank to 1.9 s, rad": (angle, path["crank_angle"]),
        "its rate to 1.9 s, rad/s": (rate, path["wheel/rate"]),
        "crank to 1.9 s by MATLAB, rad": (printed["angle"], path["crank_angle"][shared]),
    }


# ---------------------------------------------------------------------------------------------- change points


def n_four_bar_grid(open_pins):
    """Return the grid of IFToMM's A02: two parallelograms of rods of 1 m, 1 kg, whose crank passes the top at 1 rad/s.

    `open_pins`: settings of pins with clearance, by name; without any, a body at rest has the one that a grid needs.
    """
    rod = {"mass": 1.0, "inertia": 1.0 / 12.0, "center": [0.5, 0.0], "points": {"a": STILL, "b": [1.0, 0.0]}}
    bodies = {"ground": {"points": {"g0": STILL, "g1": [-1.0, 0.0], "g2": [-2.0, 0.0]}}}
    bodies |= dict.fromkeys(("crank", "c1", "mid", "c2", "last"), rod)
    ends = {"main": "ground.g0 crank.a", "j1": "crank.b c1.a", "j2": "c1.b mid.b", "j3": "ground.g1 mid.a"}
    ends |= {"j4": "mid.b c2.a", "j5": "c2.b last.b", "j6": "ground.g2 last.a"}
    loads = {}
    if not open_pins:
        bodies["weight"] = {"mass": 1.0, "inertia": 1.0, "center": STILL, "points": {"p": STILL}, "initial": {}}
        ends["rest"], open_pins = "ground.g0 weight.p", {"rest": FAR | {"clearance": 1e-3}}
        loads["hold"] = {"on": "weight", "force": [0.0, G]}
    pins = {name: {"type": "revolute", "between": pair.split()} for name, pair in ends.items()}
    start = {"c1": math.pi, "c2": math.pi, "mid": 0.5 * math.pi, "last": 0.5 * math.pi}
    machine = {"type": "planar", "gravity": G, "bodies": bodies, "joints": pins, "driven": "main"}
    return {
        "mechanism": machine | {"output": {"body": "crank", "point": "b"}, "start": start},
        "drive": {"torque": 0.0, "initial_speed": 1.0, "start_angle": 0.5 * math.pi},
        "joints": open_pins,
        "loads": loads,
        "simulate": {"discard": 0, "revolutions": 6, "tolerance": 1e-9},
        "save": {"orbits": "all"},
    }


def n_four_bar():
    """Return the motion of A02 against that of its rods, which stay parallel: 3 w' = -3.5 g cos(angle)."""
    times = np.linspace(0.0, 10.0, 101)
    rods = solve_ivp(
        lambda _, y: (y[1], -3.5 / 3.0 * G * math.cos(y[0])),
        (0.0, 10.0),
        (0.5 * math.pi, 1.0),
        t_eval=times,
        method="DOP853",
        rtol=1e-12,
        atol=1e-12,
    )
    path = run(n_four_bar_grid({}), times)
    energy = 1.5 * path["crank/rate"] ** 2 + 3.5 * G * np.sin(path["crank_angle"])
    pin = {"clearance": 1e-5, "bearing_radius": 0.02}
    pin["contact"] = {"law": "flores", "stiffness": 1e9, "restitution": 0.5}
    played = run(n_four_bar_grid({"j2": pin, "j5": pin}) | {"simulate": {"discard": 0, "revolutions": 0.6}}, times[:11])
    return {
        "crank to 10 s, rad": (rods.y[0], path["crank_angle"]),
        "last rod to 10 s, rad": (rods.y[0], path["last/angle"]),
        "energy to 10 s, J": (np.full(len(times), 1.5 + 3.5 * G), energy),
        "last rod to 1 s with two pins open, rad": (rods.y[0][:11], played["last/angle"]),
    }


# ---------------------------------------------------------------------------------------------- a block in its guide


def moreau_guide(step, times):
    """Return crank revolutions and crank rate (rad/s) of the block of Flores, Leine & Glocker at `times` (s).

    Moreau's midpoint rule with Newton impacts (0.4) and Coulomb friction (0.01) at each of four corners. `q`: angles of
    crank, rod and block.
    """
    crank, rod, half, side, gap = 0.153, 0.306, 0.05, 0.025, 0.001
    first, second = 7.4e-5 + (0.0095 + 0.114) * crank**2, 5.9e-4 + (0.0095 + 0.076) * rod**2
    mixed, weights = 0.095 * crank * rod, (0.133 * G * crank, 0.095 * G * rod)
    q, v, result, k = [0.0, 0.0, 0.0], [150.0, -75.0, 0.0], [], 0
    for time in times:
        for _ in range(round(time / step) - k):
            x = [a + 0.5 * step * b for a, b in zip(q, v, strict=True)]
            sin, cos = [math.sin(a) for a in x], [math.cos(a) for a in x]
            c, s = math.cos(x[0] - x[1]), math.sin(x[0] - x[1])
            pull = (-mixed * s * v[1] ** 2 - weights[0] * cos[0], mixed * s * v[0] ** 2 - weights[1] * cos[1])
            det = first * second - (mixed * c) ** 2
            inverse = (second / det, -mixed * c / det, first / det, 1.0 / 2.7e-6)
            u = [a + step * b for a, b in zip(v, divided(inverse, (*pull, 0.0)), strict=True)]
            y, corners = crank * sin[0] + rod * sin[1], []
            for up in (1.0, -1.0):
                for end in (-half, half):
                    if up * y + up * end * sin[2] + side * cos[2] > side + gap:
                        across = (-up * crank * cos[0], -up * rod * cos[1], side * sin[2] - up * end * cos[2])
                        lengthwise = (-crank * sin[0], -rod * sin[1], -end * sin[2] - up * side * cos[2])
                        corners.append([(a, divided(inverse, a)) for a in (across, lengthwise)])
            if corners:
                u = collided(corners, u, v)
            q, v = [a + 0.5 * step * b for a, b in zip(x, u, strict=True)], u
        k = round(time / step)
        result.append((q[0] / (2.0 * math.pi), v[0]))
    return np.array(result)


def divided(inverse, force):
    """Return the accelerations due to generalised forces."""
    a, b, d, e = inverse
    return (a * force[0] + b * force[1], b * force[0] + d * force[1], e * force[2])


def dot(a, b):
    """Return the product of two vectors of three."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def collided(corners, u, v):
    """Return the velocities after impulses at the closed corners, by projected Gauss-Seidel."""
    impulses, change = [[0.0, 0.0] for _ in corners], 1.0
    while change > 1e-14:
        change = 0.0
        for ((across, moved), (lengthwise, slid)), impulse in zip(corners, impulses, strict=True):
            normal = max(0.0, impulse[0] - (dot(across, u) + 0.4 * dot(across, v)) / dot(across, moved))
            u = [a + (normal - impulse[0]) * b for a, b in zip(u, moved, strict=True)]
            rubbing = impulse[1] - dot(lengthwise, u) / dot(lengthwise, slid)
            rubbing = min(max(rubbing, -0.01 * normal), 0.01 * normal)
            u = [a + (rubbing - impulse[1]) * b for a, b in zip(u, slid, strict=True)]
            change = max(change, abs(normal - impulse[0]))
            impulse[:] = normal, rubbing
    return u


def block_in_guide():
    """Return the motion of Flores, Leine & Glocker's block after its first contact, against Moreau's rule."""
    times = np.array([4e-3, 0.01, 0.02, 0.03, 0.05, 0.08, 0.1])
    contact = {"law": "exact", "stiffness": 1e10, "restitution": 0.4}
    friction = {"law": "tanh", "coefficient": 0.01, "velocity_scale": 1e-3}
    guide = {"clearance": 1e-3, "length": 0.1, "height": 0.05, "contact": contact, "friction": friction}
    mechanism = {
        "type": "slider-crank",
        "gravity": G,
        "crank": {"length": 0.153, "mass": 0.038, "inertia": 7.4e-5},
        "rod": {"length": 0.306, "mass": 0.038, "inertia": 5.9e-4},
        "slider": {"mass": 0.076, "inertia": 2.7e-6},
    }
    grid = {
        "mechanism": mechanism,
        "drive": {"torque": 0.0, "initial_speed": 150.0},
        "joints": {"slider-ground": guide},
        "simulate": {"revolutions": 2, "discard": 0, "tolerance": 1e-9, "time_limit": 1.0},
        "save": {"orbits": "all"},
    }
    path, exact = run(grid, np.array([0.0, *times])), moreau_guide(4e-6, times)
    return {
        "revolutions of the crank to 0.1 s": (exact[:, 0], path["crank_angle"][1:] / (2.0 * math.pi)),
        "rate of the crank to 0.1 s, rad/s": (exact[:, 1], path["crank/rate"][1:]),
    }
