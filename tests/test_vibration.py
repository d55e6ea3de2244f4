"""Vibration: force and moment on the frame, velocities in a band, orders, zones and signatures.

The slider-crank is checked against its closed form without clearance, and with clearance against a dense trajectory,
from whose momenta the forces follow by differences and by parts.
"""

import copy
import math

import numpy as np
import pytest
from fake_runs import load
from mechanism_cases import changed
from right_grids import grid_of
from scipy.integrate import simpson
from scipy.signal import hilbert

import clearsweep
from clearsweep.contracts.vibration import SEVERITIES, zone_of
from clearsweep.language.errors import InputError
from clearsweep.mechanics.observe import POINTS
from clearsweep.mechanics.solver.signal_sums import BIN_MOMENTS, spectrum
from clearsweep.report.blocks.section import draw_svg
from clearsweep.report.sections.vibration import vibration_sections
from clearsweep.report.study import prepare
from clearsweep.simulation.machine.shaking import ideal_frame_force, ideal_shaking, longest_stretch
from clearsweep.simulation.running.vibration import motion_of, signature
from clearsweep.simulation.setup.scene import build
from clearsweep.store.results import answer_of
from clearsweep.tracing.compiled.family import empty_entries

MASSES = {"crank": 0.3, "rod": 0.21, "slider": 0.14}
INERTIAS = {"crank": 1e-4, "rod": 2.5e-4, "slider": 0.0}
PUSH = -40.0  # N, on the slider along x, which the frame does not react
ABOUT = 0.01, -0.02
STIFFNESS = 2e6, 4e6
SPEED = 2.0 * math.pi * 20.0
JOINT_CHANNELS = "x", "y", "vx", "vy", "force_normal"
GRID = grid_of("a vibration")


class Signals:
    """Force and moment of a slider-crank on its frame, from the momenta of its bodies at equidistant times."""

    def __init__(self, scene, turns, samples):
        self.period = turns * 2.0 * math.pi / SPEED
        begin = scene.case.simulate.discard * 2.0 * math.pi / SPEED
        self.times = begin + self.period * np.arange(samples + 1) / samples
        self.channels = c = clearsweep.simulate(scene, times=self.times).channels
        x, y = ({body: c[f"{body}/{axis}"] - ABOUT[k] for body in MASSES} for k, axis in enumerate("xy"))
        self.momentum = [sum(m * c[f"{body}/v{axis}"] for body, m in MASSES.items()) for axis in "xy"]
        self.weight = 0.0, -9.81 * sum(MASSES.values())
        self.load = PUSH, 0.0
        spin = sum(
            m * (x[body] * c[f"{body}/vy"] - y[body] * c[f"{body}/vx"]) + INERTIAS[body] * c[f"{body}/rate"]
            for body, m in MASSES.items()
        )
        weight_moment = -9.81 * sum(m * x[body] for body, m in MASSES.items())
        self.moment = -np.gradient(spin, self.times) + weight_moment - PUSH * y["slider"]
        self.force = [-np.gradient(self.momentum[k], self.times) + self.weight[k] + self.load[k] for k in range(2)]

    def force_order(self, axis, order):
        """Return the amplitude of an order of the force, by parts: only the momentum is integrated."""
        wave = np.exp(-1j * order * SPEED * (self.times - self.times[0]))
        momentum = self.momentum[axis]
        integral = simpson(momentum * wave, x=self.times)
        return abs(2.0 / self.period * (momentum[0] - momentum[-1] - 1j * order * SPEED * integral))

    def amplitudes(self, values):
        """Return the rates (rad/s) of the lines in the band and the amplitudes of a signal there."""
        amplitudes = 2.0 / (len(values) - 1) * np.abs(np.fft.rfft(values[:-1]))
        frequencies = np.arange(len(amplitudes)) / self.period
        band = (frequencies >= 10.0 * (1 - 1e-9)) & (frequencies <= 1000.0 * (1 + 1e-9))
        return 2.0 * math.pi * frequencies[band], amplitudes[band]


@pytest.fixture(scope="module")
def scene():
    return clearsweep.load_case(GRID)


@pytest.fixture(scope="module")
def figures(scene):
    return clearsweep.simulate(scene).summary


@pytest.fixture(scope="module")
def signals(scene):
    return Signals(scene, 3, 3 * 2**15)


def closed_form(samples=4096):
    """Return force x, y, moment (3, n) and slider velocity of the machine without clearance over a turn."""
    r, length, offset, g = 0.05, 0.13, 0.012, 9.81
    angle = 2.0 * math.pi * np.arange(samples) / samples
    sine = (offset - r * np.sin(angle)) / length
    cosine = np.sqrt(1.0 - sine**2)
    rate = -r * np.cos(angle) * SPEED / (length * cosine)
    acceleration = (r * np.sin(angle) * SPEED**2 + length * sine * rate**2) / (length * cosine)

    def rod_point(a):
        pin = r * np.exp(1j * angle)
        rod = cosine + 1j * sine
        return pin + a * rod, -(SPEED**2) * pin + a * rod * (1j * acceleration - rate**2)

    crank = 0.02 * np.exp(1j * angle)
    places = {"crank": (crank, -(SPEED**2) * crank), "rod": rod_point(0.05), "slider": rod_point(length)}
    force, moment = np.zeros(samples, complex), np.zeros(samples)
    for body, (place, a) in places.items():
        own = -MASSES[body] * (a + 1j * g)
        own = own.real + 1j * (-MASSES[body] * g) if body == "slider" else own
        arm = place - complex(*ABOUT)
        force, moment = force + own, moment + (np.conj(arm) * own).imag
    moment -= INERTIAS["rod"] * acceleration + PUSH * (places["slider"][0].imag - ABOUT[1])
    velocity = -r * SPEED * np.sin(angle) - length * sine * rate
    return np.array([force.real + PUSH, force.imag, moment]), velocity


def response(rates, axis):
    """Return velocity over force of a mass of 40 kg on its mount."""
    stiffness = STIFFNESS[axis]
    damping = 2.0 * 0.03 * math.sqrt(stiffness * 40.0)
    return np.abs(1j * rates / (stiffness - 40.0 * rates**2 + 1j * rates * damping))


def test_the_ideal_machine_shakes_its_frame_as_the_closed_form_does(figures):
    (fx, fy, moment), velocity = closed_form()
    orders = 2.0 / len(fx) * np.abs(np.fft.rfft([fx, fy]))
    expected = {
        "frame_force_peak": np.hypot(fx, fy).max(),
        "frame_force_x_peak": np.abs(fx).max(),
        "frame_force_y_peak": np.abs(fy).max(),
        "frame_moment_peak": np.abs(moment).max(),
    }
    for name, value in expected.items():
        assert value * (1 - 1e-12) <= figures[f"{name}_ideal"] <= value * (1 + 1e-6), name
    assert figures["frame_force_rms_ideal"] == pytest.approx(math.sqrt(np.mean(fx**2 + fy**2)), rel=1e-11)
    assert figures["frame_moment_rms_ideal"] == pytest.approx(math.sqrt(np.mean(moment**2)), rel=1e-11)
    for k in range(1, 7):
        assert figures[f"frame_force_x_order_{k}_ideal"] == pytest.approx(orders[0, k], rel=1e-10)
    rates = SPEED * np.arange(1, 51)  # 20 Hz to 1 kHz
    slider = 2.0 / len(velocity) * np.abs(np.fft.rfft(velocity))[1:51]
    assert figures["slider_velocity_rms_ideal"] == pytest.approx(math.sqrt(0.5 * np.sum(slider**2)), rel=1e-10)
    frame = [math.sqrt(0.5 * np.sum((orders[k, 1:51] * response(rates, k)) ** 2)) for k in range(2)]
    assert figures["frame_velocity_rms_ideal"] == pytest.approx(max(frame), rel=1e-10)


def inclined():
    """Return the grid in a field of gravity that is not across the slide."""
    grid = copy.deepcopy(GRID)
    grid["mechanism"]["gravity"] = ["3 m/s^2", "-9.81 m/s^2"]
    return grid


def test_the_frame_carries_a_weight_along_the_slide_and_its_moment():
    """The difference from gravity across the slide alone is the weight along it, at the centres of mass."""
    angles = np.linspace(0.0, 2.0 * math.pi, 50)
    total = sum(MASSES.values())
    force = ideal_frame_force(load(inclined()).case(0), angles) - ideal_frame_force(load(GRID).case(0), angles)
    assert force == pytest.approx(np.array([[3.0 * total], [0.0]]) * np.ones(50), abs=1e-10)


@pytest.mark.slow  # a form of its own
def test_the_impulse_on_the_frame_is_weight_and_loads_minus_the_gain_of_momentum():
    scene = clearsweep.load_case(inclined())
    times = np.linspace(0.05, 0.06, 4001)
    channels = clearsweep.simulate(scene, times=times).channels
    for axis, gravity, load_force in (("x", 3.0, PUSH), ("y", -9.81, 0.0)):
        gain = sum(mass * float(np.diff(channels[f"{body}/v{axis}"][[0, -1]])[0]) for body, mass in MASSES.items())
        impulse = (gravity * sum(MASSES.values()) + load_force) * 0.01 - gain
        assert simpson(channels[f"frame/force_{axis}"], x=times) == pytest.approx(impulse, rel=1e-5)


def test_the_ideal_velocity_of_a_crank_that_speeds_up_is_that_of_its_closed_form():
    """The slider's velocity over time, of a crank angle 100 t + 30 t^2, in the lines of five turns."""
    drive = {"speed": {"time [s]": [0.0, 1.0], "speed [rad/s]": [100.0, 160.0]}}
    grid = copy.deepcopy(GRID) | {"drive": drive, "simulate": {"revolutions": 7, "discard": 2}}
    case = load(grid).case(0)
    velocity_rms = ideal_shaking(case, None).velocities(case.vibration)["slider"]
    begin, end = ((math.sqrt(1e4 + 120.0 * turns * 2.0 * math.pi) - 100.0) / 60.0 for turns in (2.0, 7.0))
    times = begin + (end - begin) * np.arange(2**16) / 2**16
    angle, rate = 100.0 * times + 30.0 * times**2, 100.0 + 60.0 * times
    sine = (0.012 - 0.05 * np.sin(angle)) / 0.13
    cosine = np.sqrt(1.0 - sine**2)
    velocity = -0.05 * rate * np.sin(angle) + sine / cosine * 0.05 * np.cos(angle) * rate
    assert velocity_rms == pytest.approx(rms_in_band(velocity, end - begin), rel=1e-5)


def rms_in_band(values, span):
    """Return the root mean square from 10 Hz to 1 kHz of a signal of this span (s)."""
    lines = np.fft.rfft(values) / len(values)
    frequencies = np.arange(len(lines)) / span
    band = (frequencies >= 10.0 * (1 - 1e-9)) & (frequencies <= 1000.0 * (1 + 1e-9))
    return math.sqrt(2.0 * np.sum(np.abs(lines[band]) ** 2))


MOTOR = {
    "motor": {"table": {"speed [rpm]": [0.0, 3000.0], "torque [N*m]": [10.0, 0.0]}},
    "initial_speed": "1200 rpm",
    "inertia": "0.02 kg*m^2",
}


def test_where_only_the_loop_is_compiled_no_motion_of_a_free_crank_is_computed():
    case = clearsweep.load_case(copy.deepcopy(GRID) | {"drive": MOTOR})
    with empty_entries():  # as `compile_loop` does; the machine's own code would be called at address 0
        assert longest_stretch(case, None, 2) == 0.0


@pytest.mark.slow  # compiles a free crank
def test_a_motor_below_its_synchronous_speed_shakes_as_sampled_histories_do():
    """The crank turns at 0.57 of the speed to which lines and orders once referred."""
    grid = copy.deepcopy(GRID) | {"drive": MOTOR}
    grid |= {"simulate": {"revolutions": 8, "discard": 3}, "save": {"orbits": "all", "samples": 4000}}
    del grid["loads"]
    path = clearsweep.simulate(clearsweep.load_case(grid))
    turns = (path.channels["crank_angle"] - path.channels["crank_angle"][0]) / (2.0 * math.pi)
    begin, end = (float(np.interp(turn, turns, path.channels["t"])) for turn in (3.0, 8.0))
    even = begin + (end - begin) * np.arange(2**16) / 2**16
    velocity, acceleration = (
        np.interp(even, path.channels["t"], path.channels[f"slider/{key}"]) for key in ("vx", "a")
    )
    assert path.summary["slider_velocity_rms"] == pytest.approx(rms_in_band(velocity, end - begin), rel=1e-3)
    smooth = acceleration - acceleration.mean()
    envelope = np.abs(hilbert(smooth))
    order = 2.0 * np.abs(np.mean(envelope * np.exp(-2j * math.pi * 5.0 * np.arange(len(even)) / len(even))))
    assert path.summary["slider_envelope_order_1"] == pytest.approx(order, rel=0.05)


def test_orders_of_the_force_with_clearance_are_those_of_the_momentum(figures, signals):
    for axis in range(2):
        for order in range(1, 7):
            exact = signals.force_order(axis, order)
            assert figures[f"frame_force_{'xy'[axis]}_order_{order}"] == pytest.approx(exact, rel=1e-6, abs=1e-7)


def test_peaks_and_means_with_clearance_are_those_of_a_dense_trajectory(figures, signals):
    fx, fy = signals.force
    expected = {
        "frame_force_x_peak": np.abs(fx).max(),
        "frame_force_y_peak": np.abs(fy).max(),
        "frame_force_peak": np.hypot(fx, fy).max(),
        "frame_force_rms": math.sqrt(np.mean(fx**2 + fy**2)),
        "frame_moment_peak": np.abs(signals.moment).max(),
        "frame_moment_rms": math.sqrt(np.mean(signals.moment**2)),
        "crank_torque_rms": math.sqrt(np.mean(signals.channels["crank/torque"] ** 2)),
        "crank_torque_ripple": np.ptp(signals.channels["crank/torque"]),
        "drive_power_peak": np.abs(SPEED * signals.channels["crank/torque"]).max(),
        "drive_power_reactive": np.std(SPEED * signals.channels["crank/torque"]),
    }
    for name, value in expected.items():
        assert figures[name] == pytest.approx(value, rel=5e-4), name
    assert max(fx) > 1.1 * figures["frame_force_x_peak_ideal"]  # so that the clearance counts


def test_velocities_in_the_band_are_those_of_a_dense_trajectory(figures, signals):
    c, (arm_x, arm_y) = signals.channels, (0.03 - 0.05, 0.01)
    cosine, sine, rate = np.cos(c["rod/angle"]), np.sin(c["rod/angle"]), c["rod/rate"]
    velocities = {
        "slider": c["slider/vx"],
        "tip_x": c["rod/vx"] - rate * (sine * arm_x + cosine * arm_y),
        "tip_y": c["rod/vy"] + rate * (cosine * arm_x - sine * arm_y),
    }
    rms = {}
    for name, velocity in velocities.items():
        _, amplitudes = signals.amplitudes(velocity)
        rms[name] = math.sqrt(0.5 * np.sum(amplitudes**2))
    for k in range(2):
        rates, amplitudes = signals.amplitudes(signals.force[k])
        rms[f"frame_{'xy'[k]}"] = math.sqrt(0.5 * np.sum((amplitudes * response(rates, k)) ** 2))
    assert figures["slider_velocity_rms"] == pytest.approx(rms["slider"], rel=1e-7)
    for place in ("tip", "frame"):
        for axis in "xy":
            value = figures[f"{place}_velocity_{axis}_rms"]
            assert value == pytest.approx(rms[f"{place}_{axis}"], rel=1e-7 if place == "tip" else 1e-4)
        assert figures[f"{place}_velocity_rms"] == max(figures[f"{place}_velocity_{axis}_rms"] for axis in "xy")
    rates, amplitudes = signals.amplitudes(velocities["slider"])
    assert figures["slider_band_energy"] == pytest.approx(0.5 * np.sum((rates * amplitudes) ** 2), rel=1e-5)
    assert (figures["frame_zone"], figures["slider_zone"]) == ("C", "D")


def test_signatures_are_those_of_the_acceleration(figures, signals):
    acceleration = signals.channels["slider/a"]
    deviation = acceleration - acceleration.mean()
    assert figures["slider_kurtosis"] == pytest.approx(np.mean(deviation**4) / np.mean(deviation**2) ** 2, rel=1e-3)
    assert figures["slider_skewness"] == pytest.approx(np.mean(deviation**3) / np.mean(deviation**2) ** 1.5, rel=1e-3)
    crest = np.abs(acceleration).max() / math.sqrt(np.mean(acceleration**2))
    assert figures["slider_crest"] == pytest.approx(crest, rel=1e-4)


def test_the_histories_of_frame_and_places_are_those_of_the_bodies(figures, signals):
    c, inner = signals.channels, slice(1, -1)  # differences are less exact at the ends
    velocity = c["rod/vx"] - c["rod/rate"] * (np.sin(c["rod/angle"]) * -0.02 + np.cos(c["rod/angle"]) * 0.01)
    expected = {
        "frame/force_x": signals.force[0],
        "frame/force_y": signals.force[1],
        "frame/moment": signals.moment,
        "tip/ax": np.gradient(velocity, signals.times),
    }
    for name, exact in expected.items():
        assert np.abs(c[name] - exact)[inner].max() < 2e-3 * np.abs(exact).max(), name
    assert np.abs(c["slider/ax"] - c["slider/a"]).max() < 1e-9 * np.abs(c["slider/a"]).max()
    assert np.abs(c["frame/moment"]).max() == pytest.approx(figures["frame_moment_peak"], rel=1e-3)


def test_the_envelope_is_the_magnitude_of_the_analytic_signal(figures, signals):
    velocity = signals.channels["slider/vx"][:-1]
    frequencies = np.fft.fftfreq(len(velocity), signals.period / len(velocity))
    in_band = (frequencies >= 10.0 * (1 - 1e-9)) & (frequencies <= 1000.0 * (1 + 1e-9))
    lines = np.where(in_band, 4j * math.pi * frequencies * np.fft.fft(velocity), 0.0)
    amplitudes = 2.0 / len(velocity) * np.abs(np.fft.rfft(np.abs(np.fft.ifft(lines))))
    for order in (1, 2, 3):
        assert figures[f"slider_envelope_order_{order}"] == pytest.approx(amplitudes[3 * order], rel=1e-3)


def test_the_power_of_impacts_is_the_work_of_the_normal_force_on_the_contact(figures, signals):
    x, y, vx, vy, force = (signals.channels[f"joints/rod_slider/{name}"] for name in JOINT_CHANNELS)
    work = simpson(force * (x * vx + y * vy) / np.hypot(x, y), x=signals.times)
    elastic = 6.61e10 * np.maximum(np.hypot(x, y) - 0.05e-3, 0.0) ** 2.5 / 2.5
    lost = work - (elastic[-1] - elastic[0])
    assert figures["impact_power"] == pytest.approx(lost / signals.period, rel=2e-3)


def test_the_drive_supplies_what_dry_contact_friction_and_film_lose():
    """Over turns that repeat; the pressure of a film is no impact, whichever way it does its work."""
    film = {"law": "short", "viscosity": "1e-6 Pa*s", "transition": {"law": "ramp", "width": "20 um"}}
    changes = {
        "joints.rod-slider.contact": {"law": "flores", "stiffness": "5e9 N/m^1.5", "restitution": 0.5},
        "joints.rod-slider.friction": {"law": "coulomb", "coefficient": 0.1, "velocity_scale": "10 mm/s"},
        "joints.rod-slider.film": film,
        "joints.rod-slider.length": "20 mm",
        "vibration": {},
        "simulate": {"revolutions": 14, "discard": 8},
    }
    figures = clearsweep.simulate(clearsweep.load_case(changed(GRID, changes))).summary
    losses = [figures[name] for name in ("impact_power", "rod_slider_friction_power", "rod_slider_film_loss")]
    assert min(losses) > 1e-4 * figures["drive_power_mean"]
    assert sum(losses) == pytest.approx(figures["drive_power_mean"], rel=1e-3)


def test_the_power_of_friction_loads_does_not_depend_on_vibration():
    """Their powers are between the observables of joints and the signals of vibration."""
    grid = changed(grid_of("friction in a pin without clearance"), {"simulate": {"revolutions": 3, "discard": 0}})
    without, figures = (
        clearsweep.simulate(clearsweep.load_case(grid | more)).summary for more in ({}, {"vibration": {}})
    )
    powers = {name: value for name, value in without.items() if name.endswith("_friction_power")}
    assert powers["rocker_ground_friction_power"] > 1.0
    assert {name: figures[name] for name in powers} == powers


def test_the_motion_of_the_frame_that_does_not_act_back_is_a_remark(scene, figures):
    message = clearsweep.simulate(scene).message
    assert f"frame-feedback: the frame moves at {1e3 * figures['frame_velocity_rms']:.3g} mm/s" in message


def test_a_frame_without_mass_has_the_signature_of_its_force(figures, signals):
    grid = copy.deepcopy(GRID)
    grid["vibration"]["at"]["frame"] = {}
    run = clearsweep.simulate(clearsweep.load_case(grid))
    assert "frame-feedback" not in run.message
    assert not {"frame_velocity_rms", "frame_zone", "frame_band_energy"} & run.summary.keys()
    for name in ("frame_kurtosis", "frame_crest", "frame_skewness"):
        assert run.summary[name] == figures[name]
    force = max(signals.force, key=np.std)
    deviation = force - force.mean()
    assert figures["frame_kurtosis"] == pytest.approx(np.mean(deviation**4) / np.var(force) ** 2, rel=1e-3)
    assert figures["frame_crest"] == pytest.approx(np.abs(force).max() / math.sqrt(np.mean(force**2)), rel=1e-3)


@pytest.mark.slow  # compiles the scene with a table
def test_a_table_of_constant_speed_gives_the_orders_of_that_speed(figures):
    grid = copy.deepcopy(GRID)
    grid["drive"] = {"speed": {"table": {"time [s]": [0, 1], "speed [rpm]": [1200, 1200]}}}
    summary = clearsweep.simulate(clearsweep.load_case(grid)).summary
    for order in range(1, 7):
        for name in (f"frame_force_x_order_{order}", f"slider_envelope_order_{order}"):
            assert summary[name] == pytest.approx(figures[name], rel=1e-6), name


@pytest.mark.slow  # compiles the scene without vibration
def test_other_figures_do_not_depend_on_vibration(scene, figures):
    alone = copy.deepcopy(GRID)
    del alone["vibration"]
    without = clearsweep.simulate(clearsweep.load_case(alone)).summary
    times = {"run_time", "setup_time"}
    assert {name: figures[name] for name in without.keys() - times} == {
        name: value for name, value in without.items() if name not in times
    }
    assert not any("frame" in name or "vibration" in name for name in without)


def test_the_columns_of_a_machine_without_a_place_are_those_of_its_frame():
    grid = copy.deepcopy(GRID) | {"vibration": {}}
    columns = load(grid).layout.units
    assert columns["frame_force_peak"] == "N"
    assert not any("velocity" in name or "order" in name or "zone" in name for name in columns)


def test_the_counterweight_of_least_force_is_that_of_the_closed_form():
    """Without offset and loads only the first order depends on it: half of the reciprocating mass is balanced."""
    grid = {key: value for key, value in copy.deepcopy(GRID).items() if key != "loads"} | {"vibration": {}}
    grid["mechanism"]["slider"], grid["mechanism"]["gravity"] = {"mass": "0.14 kg"}, "0 m/s^2"
    places, squares = (-0.05, -0.02, 0.01), []
    for place in places:
        grid["mechanism"]["crank"]["center"] = f"{1e3 * place} mm"
        squares.append(ideal_shaking(load(grid).case(0), None).figures["frame_force_rms"] ** 2)
    curvature, slope, _ = np.polyfit(places, squares, 2)
    rotating, reciprocating = 0.21 * 80 / 130, 0.14 + 0.21 * 50 / 130
    assert -slope / (2 * curvature) == pytest.approx(-0.05 * (rotating + reciprocating / 2) / 0.3, rel=1e-9)


# ---------------------------------------------------------------------------------------------- pieces


def test_a_sine_has_its_known_signature_and_velocity():
    angles = 2.0 * math.pi * (np.arange(64) + 0.3) / 64
    powers = np.array([np.mean(np.sin(angles) ** power) for power in range(1, 5)])
    sums = signature(powers, 1.0)
    assert sums["kurtosis"] == pytest.approx(1.5, rel=1e-12)
    assert sums["crest"] == pytest.approx(math.sqrt(2.0), rel=1e-12)
    assert sums["skewness"] == pytest.approx(0.0, abs=1e-12)
    rates = np.array([2.0 * math.pi * 100.0])
    velocity, energy = motion_of((10.0 / rates) ** 2, rates)
    assert velocity == pytest.approx(11.254e-3, rel=1e-4)
    assert energy == pytest.approx(50.0, rel=1e-12)


def test_a_signal_that_rests_has_no_signature():
    assert set(signature(np.array([3.0, 9.0, 27.0, 81.0]), 3.0).values()) == {None}


def test_the_spectrum_of_bins_is_that_of_the_terms_in_them():
    generator = np.random.default_rng(1)
    places, terms, lines = generator.uniform(0.0, 1.0, 200), generator.normal(size=200), 20
    count = math.ceil(2.0 * math.pi * lines)
    bins = np.zeros((1, count, BIN_MOMENTS))
    cells = np.floor(places * count).astype(int)
    for power in range(BIN_MOMENTS):
        np.add.at(bins[0, :, power], cells, terms * (places * count - cells - 0.5) ** power)
    exact = [abs(np.sum(terms * np.exp(-2j * math.pi * j * places))) for j in range(lines + 1)]
    assert np.abs(spectrum(bins, lines)[0]) == pytest.approx(exact, rel=1e-6, abs=1e-6 * max(exact))


@pytest.mark.parametrize(("velocity", "zone"), [(0.0014, "A"), (0.00141, "B"), (0.0029, "C"), (0.0046, "D")])
def test_a_velocity_at_a_bound_belongs_to_the_better_zone(velocity, zone):
    assert zone_of(velocity, SEVERITIES["ISO 20816-3 group 2 rigid"]) == zone


@pytest.mark.parametrize("name", [name for name in SEVERITIES if name != "none"])
def test_a_run_says_which_zones_are_from_memory(name):
    vibration = {"at": {"frame": {"mass": "400 kg"}}, "severity": name}
    said = [text for text in load(GRID | {"vibration": vibration}).warnings if "from memory" in text]
    assert bool(said) == name.startswith("ISO 20816-8")


def test_the_bounds_of_all_zones_rise():
    for bounds in SEVERITIES.values():
        assert list(bounds) == sorted(set(bounds))
    assert len(POINTS) == 8  # the quadrature at the stages is exact up to degree 14


# ---------------------------------------------------------------------------------------------- mistakes


@pytest.mark.parametrize("simulate", [{"cycles": 5, "period": 0.05, "discard": 2}, {"time": 0.25, "discard": 0.1}])
def test_a_window_of_time_is_analysed_like_the_same_turns(simulate):
    tree = copy.deepcopy(GRID)
    turns = clearsweep.simulate(clearsweep.load_case(tree), []).summary
    if "time" in simulate:
        del tree["vibration"]["orders"]
    timed = clearsweep.simulate(clearsweep.load_case(tree | {"simulate": simulate}), []).summary
    names = [name for name in timed if name.startswith(("frame_", "slider_velocity", "tip_", "drive_", "crank_torque"))]
    assert len(names) > 30
    for name in names:
        expected = pytest.approx(turns[name], rel=1e-9) if isinstance(turns[name], float) else turns[name]
        assert timed[name] == expected, name


def test_the_frame_of_a_swinging_crank_is_shaken_as_in_closed_form():
    swing, rate, mass, arm = 0.8, 30.0, 0.7, 0.04
    times = np.linspace(0.0, 6.0 * 2.0 * math.pi / rate, 3001)
    table = {"time": times.tolist(), "angle": (swing * np.sin(rate * times)).tolist()}
    given = {
        "drive": {"angle": {"table": table}},
        "simulate": {"cycles": 5, "period": 2.0 * math.pi / rate, "discard": 2},
    }
    given |= {"mechanism.bodies.crank.mass": mass, "mechanism.bodies.crank.center": [arm, 0.0]}
    tree = changed(grid_of("a crank and a flap"), given)
    shaking = ideal_shaking(clearsweep.load_case(tree).case, None)
    phases = np.linspace(0.0, 2.0 * math.pi, 7201)[:-1]
    angle, speed = swing * np.sin(phases), swing * rate * np.cos(phases)
    acceleration = -swing * rate**2 * np.sin(phases)
    force = (
        mass
        * arm
        * np.stack(
            [
                acceleration * np.sin(angle) + speed**2 * np.cos(angle),
                -acceleration * np.cos(angle) + speed**2 * np.sin(angle),
            ]
        )
    )
    assert shaking.figures["frame_force_peak"] == pytest.approx(np.max(np.hypot(*force)), rel=1e-4)
    orders = 2.0 / len(phases) * np.abs(np.fft.rfft(force, axis=1))[:, :5]
    assert shaking.orders == pytest.approx(orders, abs=1e-4 * orders.max())
    lines = np.arange(len(phases) // 2 + 1) * rate
    in_band = (lines >= 2.0 * math.pi * 10.0) & (lines <= 2.0 * math.pi * 1000.0)
    spectrum_of_force = 2.0 / len(phases) * np.abs(np.fft.rfft(force, axis=1))[:, in_band]
    velocity = math.sqrt(0.5 * np.max(np.sum((spectrum_of_force / (20.0 * lines[in_band])) ** 2, axis=1)))
    assert shaking.velocities(clearsweep.load_case(tree).case.vibration)["frame"] == pytest.approx(velocity, rel=1e-4)


def test_a_place_on_an_elastic_link_is_refused():
    grid = copy.deepcopy(GRID)
    grid["mechanism"]["rod"]["elastic"] = {"axial_stiffness": "1e8 N/m"}
    del grid["loads"]["lift"]
    with pytest.raises(InputError, match=r"vibration.at.tip: rod is elastic; choose a place on a rigid body"):
        build(load(grid).case(0))


# ---------------------------------------------------------------------------------------------- report and answer


@pytest.mark.slow  # runs a sweep
def test_the_report_draws_the_shaking_force_and_the_answer_names_the_zone(tmp_path):
    grid = copy.deepcopy(GRID) | {"save": {"orbits": "last", "revolutions": 1}}
    grid["sweep"] = {"drive.speed": ["600 rpm", "900 rpm", "1200 rpm"]}
    grid["vibration"]["at"] = {"frame": {"mass": "400 kg"}, "slider": {}}
    run = clearsweep.sweep(grid, tmp_path / "run", executor="serial", show_progress=False).open()
    (section,) = vibration_sections(prepare(run))
    titles = [picture.title for _, picture in section.pictures]
    for title in (
        "Shaking force over the last turn",
        "Orders of the force along x",
        "Envelope of the acceleration of slider",
        "Waterfall of the force along x",
        "Velocity of frame in zones",
    ):
        assert title in titles
    assert all(draw_svg(picture, "p").startswith("<svg") for _, picture in section.pictures)
    rows = {row[0]: row for row in section.tables[0].rows}
    assert len(rows) == 3
    velocities = run.column("frame_velocity_rms")
    zone = zone_of(velocities.max(), (1.4e-3, 2.8e-3, 4.5))
    texts = answer_of(run)["sentences"]
    assert any(f"(zone {zone}) at crank speed 1200 rpm" in text for text in texts), texts
