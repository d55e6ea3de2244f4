"""A slot whose worn shape acts: where the pin touches, what that does to the motion, and how long the slot lasts."""

import math

import numpy as np
import pytest
from test_slot import BINS, HALF, SPEED, way_along, worn_grid

import clearsweep
from clearsweep.mechanics.wear import Worn
from clearsweep.simulation.setup.scene import build

pytestmark = pytest.mark.heavy

RADIUS, PIN, PERIMETER = 6e-3, 5.95e-3, 0.24 + 2.0 * math.pi * 6e-3  # m
BIN_CENTRES = (np.arange(BINS) + 0.5) * PERIMETER / BINS  # m, along the perimeter


def wall(way):
    """Return what is worn off the wall (m) by the way (m) along it: some waves."""
    return 8e-6 * (1.0 + np.sin(6.0 * math.pi * way / PERIMETER)) + 3e-6 * np.cos(4.0 * math.pi * way / PERIMETER)


def pin(angle):
    """Return what is worn off the pin (m) by its angle (rad)."""
    return 5e-6 * (1.0 + np.cos(angle - 2.0))


def scene(worn=None, **changes):
    """Return the scene over 0.3 revolutions, with what its bodies have lost before."""
    made = worn_grid(evolve=True)
    made["simulate"] = made["simulate"] | {"revolutions": 0.3, "discard": 0.0, "tolerance": 1e-8}
    made["save"] = {"orbits": "all", "samples": 3000}
    for path, value in changes.items():
        made["joints"]["slot"][path] = value
    loaded = clearsweep.load_case(made)
    return build(loaded.case, {"slot": worn}) if worn else loaded


@pytest.fixture(scope="module")
def worn_path():
    both = Worn(wall(BIN_CENTRES), pin((np.arange(BINS) + 0.5) * 2.0 * math.pi / BINS), 0.0)
    path = clearsweep.simulate(scene(both, contact={"law": "hertz", "stiffness": 1e9}))
    assert path.status == "ok", path.message
    return path


def reach(x, side, turned):
    """Return how far (m) from the line of the slot the pin's centre is where it touches a flat wall at `x`."""
    offsets = np.linspace(-2e-3, 2e-3, 4001)
    ways = way_along(x + offsets, np.full(offsets.size, side), RADIUS)
    angles = side * 0.5 * math.pi - side * offsets / PIN + turned
    circle = np.sqrt((PIN - pin(angles)) ** 2 - offsets**2)
    return np.min(RADIUS + wall(ways % PERIMETER) - circle)


def test_the_pin_touches_worn_walls_where_a_circle_does_that_is_laid_between_them(worn_path):
    path = worn_path
    x, y, force = (path[f"joints/slot/{name}"] for name in ("x", "y", "force_normal"))
    pressed = np.flatnonzero((force > 0.05) & (np.abs(x) < HALF - 2e-3))[::2]
    assert pressed.size > 20
    turned = path["lever/angle"] + math.radians(80.0) - path["crank/angle"]
    for i in pressed:
        depth = (force[i] / 1e9) ** (2.0 / 3.0)
        expected = reach(x[i], math.copysign(1.0, y[i]), turned[i] - turned[0] + OFFSET) + depth
        assert abs(y[i]) == pytest.approx(expected, abs=1.5e-7)


#: At t = 0 the crank is at 0 and the lever points from its foot to the crank's pin.
OFFSET = math.atan2(0.15, 0.05)


def test_worn_walls_close_the_energy_balance_and_change_the_motion(worn_path):
    assert worn_path.summary["energy_residual"] < 1e-8
    new = clearsweep.simulate(scene(contact={"law": "hertz", "stiffness": 1e9}))
    assert worn_path.summary["slot_force_peak"] != pytest.approx(new.summary["slot_force_peak"], rel=1e-3)


@pytest.mark.slow
def test_worn_ends_close_the_energy_balance(too_short):
    both = Worn(wall(BIN_CENTRES), pin((np.arange(BINS) + 0.5) * 2.0 * math.pi / BINS), 0.0)
    path = clearsweep.simulate(scene(both, slot_length=0.0998))
    assert path.status == "ok", path.message
    assert np.max(np.abs(path["joints/slot/x"])) > 0.0499
    assert path.summary["energy_residual"] < 1e-7


@pytest.mark.slow
def test_a_slot_that_is_not_worn_moves_as_one_whose_wear_does_not_act():
    acting = clearsweep.simulate(scene())
    made = worn_grid()
    made["simulate"] = made["simulate"] | {"revolutions": 0.3, "discard": 0.0, "tolerance": 1e-8}
    still = clearsweep.simulate(clearsweep.load_case(made))
    for figure in ("slot_force_peak", "slot_wear_volume", "slot_pressure_peak"):
        assert acting.summary[figure] == pytest.approx(still.summary[figure], rel=1e-9)


# ---------------------------------------------------------------------------------------------- a life


def life(limit, of="wear_depth_max", **wear):
    made = worn_grid(**wear)
    made["joints"]["slot"]["wear"] |= {"bearing_coefficient": 1e-12, "journal_coefficient": 4e-13}
    made["simulate"] = {"revolutions": 1.5, "discard": 0.5, "tolerance": 1e-6}
    made["save"] = {"orbits": "none"}
    return made | {"life": {"limit": limit, "of": of, "joint": "slot", "tolerance": 0.05}}


@pytest.mark.slow
def test_a_life_of_a_slot_whose_wear_does_not_act_is_limit_over_rate():
    source = life(5e-6)
    path = clearsweep.simulate(clearsweep.load_case(source))
    assert path.status == "ok", path.message
    source.pop("life")
    source["simulate"]["revolutions"] = 10.5
    plain = clearsweep.simulate(clearsweep.load_case(source)).summary
    per_turn = plain["slot_wear_rate_max"] * 2.0 * math.pi / SPEED
    assert path.summary["slot_life_revolutions"] == pytest.approx(5e-6 / per_turn, rel=0.02)
    grown = clearsweep.simulate(clearsweep.load_case(life(5e-6, "clearance_growth"))).summary
    assert grown["slot_life_revolutions"] < path.summary["slot_life_revolutions"]
    assert grown["slot_clearance_growth"] == pytest.approx(5e-6, rel=1e-6)


@pytest.mark.slow
def test_a_life_of_a_slot_whose_wear_acts_is_that_of_many_short_jumps():
    path = clearsweep.simulate(clearsweep.load_case(life(10e-6, evolve=True)))
    assert path.status == "ok", path.message
    source = life(10e-6, evolve=True)
    source.pop("life")
    case, jump, turns = clearsweep.load_case(source).case, path.summary["slot_life_revolutions"] / 24.0, 0.0
    bearing, journal = np.zeros(BINS), np.zeros(BINS)
    while True:
        step = clearsweep.simulate(build(case, {"slot": Worn(bearing, journal, 0.0)})).wear["slot"]
        rates = np.array(step[0]), np.array(step[1])  # of one revolution
        left = [
            np.min((10e-6 - h[rate > 0.0]) / rate[rate > 0.0])
            for h, rate in zip((bearing, journal), rates, strict=True)
        ]
        go = min(*left, jump)
        turns += go
        if go < jump:
            break
        bearing, journal = bearing + go * rates[0], journal + go * rates[1]
    assert path.summary["slot_life_revolutions"] == pytest.approx(turns, rel=0.05)
