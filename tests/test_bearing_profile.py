"""The shape of a bearing that a law file declares: a displaced circle, a larger one, and what is refused."""

import functools
import math

import pytest
from test_own_laws import CRANK, FLORES, TANH, catalogue_of, figures_of, with_joint
from test_worn import gap

from clearsweep import grid, laws
from clearsweep.mechanics.joints import dry, registry
from clearsweep.mechanics.joints.worn import nearest, worn_load
from clearsweep.mechanics.laws.contract import PRESSED

C = 1e-4  # m, clearance of CRANK
SHIFT, TOWARDS = 0.3 * C, 0.8  # m, rad: of the centre of a displaced circle
SHIFTED = {"law": "wave", "size": SHIFT, "lobes": 1, "phase": TOWARDS}


@functools.cache
def waves():
    def wave():
        keys = {"size": "m", "lobes": "1", "phase": laws.key("rad", at_least=-10.0, default=0.0)}
        form = laws.profile("wave", **keys)
        return form(lambda angle, p: p.size * math.cos(p.lobes * (angle - p.phase)))

    def needle():
        return laws.profile("needle", size="m")(lambda angle, p: p.size * math.exp(-(((angle - 3.14) / 2e-3) ** 2)))

    return catalogue_of(wave, needle)


def with_profile(**profile):
    return with_joint(CRANK, contact=FLORES, friction=TANH, profile=profile)


def compiled(source):
    joint = grid.load(source, waves()).case(0).joints[0]
    return registry.compile_joint(joint, "slider")


@pytest.mark.parametrize("angles", [(0.0, 0.0), (0.4, -0.7)])
def test_a_cosine_is_a_circle_whose_centre_is_displaced(angles):
    round_bearing = compiled(with_joint(CRANK, contact=FLORES, friction=TANH))
    shifted = compiled(with_profile(**SHIFTED))
    bearing_angle = angles[0] if shifted.side > 0.0 else angles[1]
    x, y = SHIFT * math.cos(TOWARDS + bearing_angle), SHIFT * math.sin(TOWARDS + bearing_angle)
    side, depth = shifted.side, 2e-6
    place = [side * (x + (C + depth) * math.cos(1.9)), side * (y + (C + depth) * math.sin(1.9))]
    point = nearest(shifted, gap(*place, angles))
    assert point.depth == pytest.approx(depth, rel=1e-6)
    assert point.angle == pytest.approx(1.9, rel=1e-6)
    expected = dry.joint_load(round_bearing, gap(place[0] - side * x, place[1] - side * y, angles), PRESSED, depth, 0.1)
    load = worn_load(shifted, gap(*place, angles), PRESSED, depth, 0.1)
    assert (load.fx, load.fy) == pytest.approx((expected.fx, expected.fy), rel=1e-6)
    arm = x * load.fy - y * load.fx  # of the force on the journal; the bearing has the opposite one
    moments = (load.moment_proximal, load.moment_distal)[:: 1 if side > 0.0 else -1]
    without = (expected.moment_proximal, expected.moment_distal)[:: 1 if side > 0.0 else -1]
    assert moments[0] == pytest.approx(without[0] - side * arm, rel=1e-6, abs=1e-12)
    assert moments[1] == pytest.approx(without[1], rel=1e-6, abs=1e-12)


def test_details_finer_than_the_table_are_remarked():
    joint = grid.load(with_profile(law="wave", size="1e-9 m", lobes=200), waves()).case(0)
    assert any("256 points miss its details" in remark for remark in registry.own_law_remarks(joint))


@pytest.mark.slow
def test_a_shape_that_is_the_same_all_round_is_a_larger_clearance():
    larger = with_joint(CRANK, contact=FLORES, friction=TANH, clearance="0.12 mm")
    expected = figures_of(larger, waves())
    figures = figures_of(with_profile(law="wave", size="0.02 mm", lobes=0), waves())
    for name in ("rod_slider_force_peak", "rod_slider_force_rms", "slider_error_max"):
        assert figures[name] == pytest.approx(expected[name], rel=1e-4)
    assert figures["energy_residual"] < 1e-5


@pytest.mark.slow
@pytest.mark.parametrize(("clearance", "size"), [("0.25 mm", "25 um"), ("0.1 mm", "11.2 um")])
def test_lobes_that_touch_at_one_place_take_a_few_hundred_steps(clearance, size):
    """Two places in contact, of which the model has one, took 40,000 steps a revolution; such lobes are refused."""
    grid_of_lobes = with_joint(with_profile(law="wave", size=size, lobes=3), clearance=clearance)
    figures = figures_of(grid_of_lobes | {"simulate": {"revolutions": 1, "discard": 0, "tolerance": 1e-6}}, waves())
    assert figures["steps"] < 1000
    assert figures["energy_residual"] < 1e-6
