"""The kernels as plain Python: short scenes that reach all of them; `make test-plain` measures what they reach.

Compiled, each would be a form of its own; with CLEARSWEEP_DISABLE_JIT=1 none costs more than a second or two.
"""

import itertools
import math

import numpy as np
import pytest
from law_cases import RECIPES, names, written
from mechanism_cases import PAIR, changed, check_that_no_contact_passes_unseen, slider_crank

import clearsweep

pytestmark = pytest.mark.plain

NAMES = ("ground-crank", "crank-rod", "rod-slider")
OPENINGS = [joints for count in (1, 2, 3) for joints in itertools.combinations(NAMES, count)]
SHORT = {"simulate.revolutions": 0.03, "simulate.tolerance": 1e-6, "mechanism.gravity": 9.81}
COEFFICIENTS = {"coefficient": 0.1, "static_coefficient": 0.15}
STICKS = COEFFICIENTS | {"law": "karnopp", "stribeck_velocity": 2e-3, "band": 2e-4}


def run(source, changes=None, times=None):
    trajectory = clearsweep.simulate(clearsweep.load_case(changed(source, changes)), times=times)
    assert trajectory.status == "ok", trajectory.message
    return trajectory


def crank(*joints, times=None, **changes):
    return run(
        slider_crank(*joints), SHORT | {path.replace("__", "."): value for path, value in changes.items()}, times
    )


def seated(friction, *joints, **changes):
    """Return the trajectory of joints that begin in contact, all with this friction."""
    return crank(
        *joints,
        simulate__start="seated",
        **{f"joints.{name}.friction": friction for name in joints},
        **changes,
    )


# ---------------------------------------------------------------------------------------------- energy


@pytest.mark.parametrize("joints", OPENINGS, ids="+".join)
def test_energies_balance_in_every_opening(joints):
    friction = {"law": "tanh", "coefficient": 0.1, "velocity_scale": 1e-2}
    assert seated(friction, *joints).summary["energy_residual"] < 1e-5


@pytest.mark.parametrize("name", [name for name in names("friction") if name != "none"])
def test_energies_balance_with_every_friction(name):
    friction = written(friction=name)["friction"]
    result = seated(friction, "rod-slider", **{"drive.speed": "300 rpm"}).summary
    assert result["energy_residual"] < 1e-5


@pytest.mark.parametrize("joint", NAMES)
def test_energies_balance_where_surfaces_stick(joint):
    slow = {"drive.speed": "3 rpm", "simulate.revolutions": 0.005}
    assert seated(STICKS, joint, **slow).summary["energy_residual"] < 1e-5


@pytest.mark.parametrize("name", names("law"))
def test_an_impact_gives_back_no_more_than_came_and_its_energies_balance(name):
    unused = {"length"} if RECIPES["law", name].law.uses_elastic else {"length", "bearing_radius"}
    pair = {key: value for key, value in written(law=name).items() if key not in unused}
    result = run(PAIR, {"joints.pair": pair, "simulate.impacts": 1, "simulate.tolerance": 1e-7}).summary
    assert 0.0 < result["pair_restitution"] < 1.0 + 1e-6
    assert result["energy_residual"] < 1e-5


def test_restitution_is_the_mean_over_the_impacts_of_what_each_gives_back():
    result = run(PAIR, {"simulate.impacts": 3, "simulate.tolerance": 1e-8, "save.orbits": "all"})
    rates = result.events["rate"]  # of an onset, then of its separation, and so on
    given_back = -rates[1::2] / rates[::2]
    assert len(given_back) == 3
    assert result.summary["pair_restitution"] == pytest.approx(given_back.mean(), rel=1e-12)
    assert given_back == pytest.approx(0.5, rel=1e-4)


# ---------------------------------------------------------------------------------------------- events


@pytest.mark.parametrize(
    ("tolerance", "speed", "clearance", "restitution", "revolutions"),
    [(1e-9, 4074.0, 3.8e-5, 0.99, 0.185), (1e-6, 2926.0, 7.9e-5, 0.98, 0.195), (1e-4, 1526.0, 3.5e-5, 1.0, 0.23)],
)
def test_no_contact_passes_unseen(tolerance, speed, clearance, restitution, revolutions):
    """Scenes in which one does as soon as the search for it looks less closely."""
    gravity = 0.0 if speed == 2926.0 else 9.81
    scene = (("rod-slider",), tolerance, speed, clearance, restitution, gravity)
    check_that_no_contact_passes_unseen(*scene, revolutions=revolutions, samples=4001)


def test_contacts_begin_and_end_where_the_journal_is_at_its_bearing():
    changes = {"simulate.revolutions": 0.3, "simulate.tolerance": 1e-8, "save.orbits": "all"}
    events = crank("rod-slider", **changes).events
    assert len(events) > 6
    result = crank("rod-slider", times=events["t"], **changes)
    eccentricity = np.hypot(result["joints/rod_slider/x"], result["joints/rod_slider/y"])
    assert np.abs(eccentricity - 0.5e-3).max() < 1e-4 * result.summary["rod_slider_penetration_max"]


def test_surfaces_bear_what_they_hold_and_slide_by_their_law_beyond():
    """At half stroke the rod turns back in the slider: the surfaces slow down, stick, and slide the other way."""
    slow = {"drive.speed": "60 rpm", "simulate.revolutions": 0.3, "simulate.tolerance": 1e-8}
    times = np.linspace(0.2, 0.3, 4001)
    result = seated(STICKS, "rod-slider", times=times, **slow)
    x, y, vx, vy = (result[f"joints/rod_slider/{name}"] for name in ("x", "y", "vx", "vy"))
    normal, tangential = result["joints/rod_slider/force_normal"], result["joints/rod_slider/force_tangential"]
    slip = (x * vy - y * vx) / np.hypot(x, y) + result["rod/rate"] * 9.5e-3
    sliding, inside = np.abs(slip) > 1.002 * STICKS["band"], np.abs(slip) < 0.998 * STICKS["band"]
    law = -np.sign(slip) * (0.1 + 0.05 * np.exp(-((slip / 2e-3) ** 2))) * normal
    assert slip[sliding].min() < -0.01 < 0.01 < slip[sliding].max()
    assert np.allclose(tangential[sliding], law[sliding], rtol=1e-6)
    assert np.count_nonzero(inside) > 5
    assert np.all(np.abs(tangential[inside]) <= 0.15 * normal[inside])


def test_a_flight_without_contact_has_an_eccentricity_and_no_penetration():
    summary = crank("rod-slider", **{"simulate.revolutions": 0.01}).summary
    assert summary["rod_slider_penetration_max"] == summary["rod_slider_contact_fraction"] == 0.0
    assert 0.0 < summary["rod_slider_eccentricity_max"] < 0.5e-3


# ---------------------------------------------------------------------------------------------- methods


@pytest.mark.parametrize("law", ["kelvin-voigt", "lankarani-nikravesh"])
def test_the_implicit_method_finds_the_same_motion(law):
    contact = {
        "kelvin-voigt": {"law": "kelvin-voigt", "stiffness": 1e8, "damping": 1e4},
        "lankarani-nikravesh": {"law": "lankarani-nikravesh", "stiffness": 6.61e10, "restitution": 0.5},
    }[law]
    friction = {"law": "tanh", "coefficient": 0.1, "velocity_scale": 1e-2}
    peaks = [
        seated(friction, "rod-slider", **{"simulate.method": method, "joints.rod-slider.contact": contact}).summary[
            "rod_slider_force_peak"
        ]
        for method in ("explicit", "implicit")
    ]
    assert peaks[1] == pytest.approx(peaks[0], rel=1e-3)


@pytest.mark.parametrize("damping", [1e6, 1e7])
def test_a_stiff_contact_costs_few_steps_by_every_method_and_moves_alike(damping):
    """Steps without a preconditioner are at most some 3 m / damping: 0.6 and 0.06 us of these 360 us."""
    contact = {"law": "kelvin-voigt", "stiffness": 1e8, "damping": damping}
    begin = {"joints.rod-slider.contact": contact, "simulate.start": "seated"}
    auto, explicit, implicit = (
        crank("rod-slider", **begin, simulate__method=method).summary for method in ("auto", "explicit", "implicit")
    )
    for result in (auto, explicit, implicit):
        assert result["steps"] < 30
        assert result["energy_residual"] < 1e-6
        assert result["rod_slider_force_rms"] == pytest.approx(explicit["rod_slider_force_rms"], rel=1e-6)
    has_tried_both = auto["rhs_evaluations"] > explicit["rhs_evaluations"]
    assert has_tried_both == (damping == 1e7)


# ---------------------------------------------------------------------------------------------- figures


def test_figures_are_those_of_the_window_alone():
    """Against dense samples of a window much shorter than what is discarded before it."""
    turn, first, last = 60.0 / 5000, 0.24, 0.3
    times = np.linspace(first * turn, last * turn, 4001)
    trajectory = crank("rod-slider", times=times, simulate__discard=first, simulate__revolutions=last)
    summary, force = trajectory.summary, trajectory["joints/rod_slider/force_normal"]
    assert np.count_nonzero(np.diff(force > 0.0)) > 3  # several contacts
    mean_square = np.trapezoid(force**2, times) / (times[-1] - times[0])
    assert summary["rod_slider_force_rms"] == pytest.approx(math.sqrt(mean_square), rel=1e-3)
    assert summary["rod_slider_contact_fraction"] == pytest.approx(np.mean(force > 0.0), abs=2e-3)
    assert summary["rod_slider_force_peak"] == pytest.approx(force.max(), rel=1e-3)
    assert summary["rod_slider_force_p99"] == pytest.approx(np.quantile(force, 0.99), rel=2.5e-3)
    acceleration = trajectory["slider/a"]
    mean_square = np.trapezoid(acceleration**2, times) / (times[-1] - times[0])
    assert summary["slider_acceleration_rms"] == pytest.approx(math.sqrt(mean_square), rel=1e-3)
    assert summary["slider_acceleration_peak"] == pytest.approx(np.abs(acceleration).max(), rel=1e-3)
    eccentricity = np.hypot(trajectory["joints/rod_slider/x"], trajectory["joints/rod_slider/y"])
    assert summary["rod_slider_eccentricity_max"] == pytest.approx(eccentricity.max(), rel=1e-5)
    assert summary["rod_slider_penetration_max"] == pytest.approx(eccentricity.max() - 0.5e-3, rel=1e-3)
    events = trajectory.events
    assert summary["rod_slider_impacts_per_rev"] == pytest.approx(
        np.count_nonzero((events["kind"] == "on") & (events["t"] >= times[0])) / (last - first)
    )


def test_wear_is_what_archard_says_of_force_and_way():
    """Against the integral of both over dense samples of a pin that begins in contact."""
    bearing, journal, radius, turn, last = 1e-14, 4e-14, 0.0095, 60.0 / 5000, 0.05
    times = np.linspace(0.0, last * turn, 4001)
    wear = {"law": "archard", "bearing_coefficient": bearing, "journal_coefficient": journal, "bins": 36}
    material = {"young": 207e9, "poisson": 0.3}
    changes = {"simulate.start": "seated", "simulate.revolutions": last}
    changes |= {"joints.rod-slider.wear": wear, "joints.rod-slider.contact.material": material}
    result = crank("rod-slider", times=times, **changes)
    x, y, vx, vy, force = (result[f"joints/rod_slider/{name}"] for name in ("x", "y", "vx", "vy", "force_normal"))
    sliding = np.abs((x * vy - y * vx) / np.hypot(x, y) + radius * result["rod/rate"])
    worn = np.trapezoid(force * sliding, times)
    summary, depths = result.summary, result.wear["rod_slider"]
    area = 2.0 * math.pi / 36 * 0.02  # of a bin, over the radius
    volumes = area * 0.01 * depths[0].sum(), area * radius * depths[1].sum()
    expected = (bearing * worn, journal * worn)  # m^3, so small that only a relative tolerance says anything
    assert volumes == pytest.approx(expected, rel=0.01, abs=0.0)
    assert summary["rod_slider_wear_volume"] == pytest.approx(sum(volumes), rel=1e-12, abs=0.0)
    assert depths[1].max() > depths[0].max()
    assert summary["rod_slider_wear_depth_max"] == depths[1].max()
    assert summary["rod_slider_wear_rate_max"] == pytest.approx(depths[1].max() / times[-1], rel=1e-12, abs=0.0)
