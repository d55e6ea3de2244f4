"""Claims about `identify`: what a machine is like, found of what was measured, whatever interrupts it."""

import re
from types import SimpleNamespace

import numpy as np
import pyarrow.parquet as pq
import pytest
from fake_physics import Fake, grid, sweep, trajectory
from fake_runs import TEXT
from test_play import coupling

import clearsweep
from clearsweep import grid as grids
from clearsweep.answers import features
from clearsweep.contracts.results import Trajectory
from clearsweep.grid.written.tables import read_signals
from clearsweep.language.errors import InputError
from clearsweep.report.sections.identified import compare_signals, identified_sections, overlay_section
from clearsweep.report.study import prepare
from clearsweep.searches import emulator
from clearsweep.searches.identifying import feature_vector
from clearsweep.sweeping.summary import of_run, run_text

MASS, ROD = "mechanism.slider.mass", "mechanism.rod.mass"
TURNS, SAMPLES, SPEED = 8, 180, 500.0  # of a case; rad/s
HEAD = "crank_angle [deg],acceleration"  # the made-up mechanics have no units of acceleration


def motion(angle, mass):
    """Return the acceleration (m/s^2) of a made-up rig, whose one impact is larger and later the larger its mass."""
    since = (angle - 1.0 - mass) % features.TURN
    return (
        100.0 * np.cos(angle) + 30.0 * np.cos(2.0 * angle) + 200.0 * mass * np.exp(-4.0 * since) * np.sin(20.0 * since)
    )


class Rig(Fake):
    """Mechanics that give the made-up rig."""

    @staticmethod
    def solve(case, log=None):
        """Return the motion of a case; one of a heavy rod fails."""
        if case.mechanism.values["rod.mass"] > 0.8:
            return Trajectory("step-budget", "made to fail", {})
        result = trajectory(case)
        angle = np.linspace(0.0, TURNS * features.TURN, TURNS * SAMPLES + 1)
        channels = {name: np.zeros(len(angle)) for name in result.channels}
        own = {
            "t": angle / SPEED,
            "crank_angle": angle,
            "slider/a": motion(angle, case.mechanism.values["slider.mass"]),
        }
        return Trajectory("ok", "", result.summary, channels | own)


def measure(path, mass=0.4, turns=12.0, samples=240, gain=1.03, noise=0.02, upcoming=2.0):
    """Write what an accelerometer gives, and return its file."""
    chance = np.random.default_rng(1)
    angle = np.arange(0.0, turns * features.TURN, features.TURN / samples)
    values = gain * motion(angle, mass) + 7.0
    values = values + noise * values.std() * chance.standard_normal(len(values))
    rows = "\n".join(f"{np.degrees(a + upcoming):.5f},{v:.6g}" for a, v in zip(angle, values, strict=True))
    path.write_text(f"{HEAD}\n{rows}\n", encoding="utf-8")
    return path


def asked(file, cases=64, **changes):
    whole = grid(1, (0.0,))
    for key in ("sweep", "save"):
        whole.pop(key)
    over = {MASS: ["0.1 kg", "0.9 kg"]} | changes.pop("over", {})
    return whole | {
        "identify": {"over": over, "from": {str(file): {"slider/a": "acceleration"}}, "cases": cases} | changes
    }


def quiet(source, out, **options):
    return sweep(source, out, simulator=Rig, executor="serial", show_progress=False, **options)


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """A finished identification, its directory, its source."""
    folder = tmp_path_factory.mktemp("identified")
    source = asked(measure(folder / "rig.csv"))
    return quiet(source, folder / "run"), folder / "run", source


def test_the_true_value_is_within_a_narrow_interval(ran):
    result, out, _ = ran
    assert result.ran == 64
    (computed,) = result.search_result.parameters
    assert computed.low < 0.4 < computed.high
    assert computed.high - computed.low < 0.1
    assert computed.determined == "well"
    assert result.search_result.explained
    sample = pq.read_table(out / "identify.parquet").to_pydict()
    assert set(sample) == {MASS, "weight"}
    assert sum(sample["weight"]) == pytest.approx(1.0)
    assert np.average(sample[MASS], weights=sample["weight"]) == pytest.approx(0.4, abs=0.05)
    assert clearsweep.open(out).identify.attrs["units"][MASS] == "kg"


def test_gain_angle_and_noise_are_found_next_to_it(ran):
    (read,) = ran[0].search_result.signals
    assert read.angle == pytest.approx(2.0, abs=0.05)
    assert read.noise[1] < 0.02 < read.noise[2]
    assert read.revolutions == 11


def test_the_closing_lines_say_value_interval_and_fit(ran):
    text = run_text(of_run(ran[0]))
    assert re.search(r"[Ss]lider mass 0\.\d+ kg \(95 %: 0\.\d+ to 0\.\d+ kg\)", text)
    assert "The model explains the measurement" in text
    for feature in ("rms:", "peak per revolution, median:", "impacts a revolution:", "rms, orders 17 to 22:"):
        assert feature in text


def test_the_report_has_the_machine(ran):
    prepared = prepare(clearsweep.open(ran[1]))
    (section,) = identified_sections(prepared)
    assert section.key == "identify"
    text = str(section.blocks[0])
    assert "Slider mass 0." in text


def test_interrupted_it_gives_the_same_bytes(ran, tmp_path):
    _, out, source = ran
    again = quiet(source, out)
    assert again.ran == 0
    quiet(source | {"identify": source["identify"] | {"cases": 16}}, tmp_path / "other")
    quiet(source, tmp_path / "other")
    assert (tmp_path / "other/identify.parquet").read_bytes() == (out / "identify.parquet").read_bytes()


def test_cases_store_the_signals_that_are_compared_and_no_others(ran):
    _, out, source = ran
    assert clearsweep.open(out).layout.listed == ("slider/a",)
    more = source | {"save": {"channels": ["slider/a", "slider/x"]}}
    assert grids.load(more, Rig.catalogue()).layout.listed == ("slider/a", "slider/x")
    with pytest.raises(InputError, match=r"save\.channels: lacks slider/a, which `identify` compares; add it"):
        grids.load(source | {"save": {"channels": ["slider/x"]}}, Rig.catalogue())


def test_a_key_that_the_signal_does_not_depend_on_is_said_to_be_undetermined(tmp_path):
    file = measure(tmp_path / "rig.csv")
    result = quiet(asked(file, 64, over={ROD: ["0.1 kg", "0.9 kg"]}), tmp_path / "run")  # 48: "weakly" for some seeds
    mass, rod = result.search_result.parameters
    assert (mass.determined, rod.determined) == ("well", "not")
    assert result.failed > 0  # and failed cases are left out
    assert result.search_result.finished + result.failed == 64
    assert "the data do not determine it" in run_text(of_run(result))


def test_likelihoods_of_lengths_and_predictions_are_those_of_scikit_learn():
    kernels = pytest.importorskip("sklearn.gaussian_process.kernels")
    gaussian = pytest.importorskip("sklearn.gaussian_process")
    chance = np.random.default_rng(3)
    points, values = chance.random((40, 3)), chance.standard_normal(40)
    kernel = 1.7 * kernels.Matern([0.2, 0.7, 5.0], nu=2.5) + kernels.WhiteKernel(0.03)
    process = gaussian.GaussianProcessRegressor(kernel, optimizer=None, alpha=emulator.JITTER).fit(points, values)
    likelihood, slopes = process.log_marginal_likelihood(kernel.theta, eval_gradient=True)
    own, own_slopes = emulator.Evidence.of(points, values).negative_log_likelihood(kernel.theta)
    assert -own == pytest.approx(likelihood, rel=1e-10)
    assert -own_slopes == pytest.approx(slopes, rel=1e-8)
    asked = chance.random((50, 3))
    for known, predicted in zip(
        process.predict(asked, return_std=True), emulator.predict_process(process, asked), strict=True
    ):
        np.testing.assert_array_equal(predicted, known)


def test_what_no_case_explains_is_called_a_misfit(tmp_path, monkeypatch):
    true = motion
    monkeypatch.setitem(globals(), "motion", lambda angle, mass: true(angle, mass) + 25.0 * np.cos(40.0 * angle))
    file = measure(tmp_path / "rig.csv")
    monkeypatch.setitem(globals(), "motion", true)
    result = quiet(asked(file, 48), tmp_path / "run")
    assert not result.search_result.explained
    assert "Misfit: " in run_text(of_run(result))
    assert "orders 33 to 45" in run_text(of_run(result))


def test_a_signal_over_time_of_a_slowly_varying_speed_is_taken_to_the_crank_angle():
    times = np.linspace(0.0, 1.0, 20_000)
    angle = 300.0 * times + 3.0 * np.sin(2.0 * times)
    result = features.track_crank_angle(times, motion(angle, 0.4), 296.0)
    off = result - angle
    assert np.ptp(off[2000:-2000]) < 0.02


def test_peaks_are_those_of_the_band_that_both_signals_have():
    angle = np.linspace(0.0, 4.0 * features.TURN, 4 * 2880 + 1)
    spike = 1000.0 * np.exp(-(((angle % features.TURN) - 2.0) ** 2) / (2.0 * 0.01**2))
    whole = features.features_of(features.split_revolutions(angle, spike))
    assert whole.peak_median == pytest.approx(1000.0, rel=0.02)
    coarse = features.split_revolutions(angle[::4], spike[::4], None, 100.0)
    fine = features.split_revolutions(angle, spike, None, 100.0)
    assert features.features_of(coarse).peak_median == pytest.approx(features.features_of(fine).peak_median, rel=0.02)


def test_the_signature_of_a_sine_and_of_a_spike_have_their_closed_forms():
    """Crest sqrt(2), kurtosis 3/2; of a pulse over the share p of a turn kurtosis about 1/p, whatever the gain."""
    angle = np.linspace(0.0, 8.0 * np.pi, 4 * 4096 + 1)
    sine = features.features_of(features.split_revolutions(angle, 7.0 * np.sin(angle)))
    assert (sine.crest, sine.kurtosis) == (pytest.approx(2.0**0.5, rel=1e-3), pytest.approx(1.5, rel=1e-3))
    louder = features.features_of(features.split_revolutions(angle, 280.0 * np.sin(angle)))
    compared = [feature_vector(each, 100.0, ("signature",)) for each in (sine, louder)]
    assert compared[0] == pytest.approx(compared[1], abs=1e-12)
    share = 1.0 / 64.0
    pulse = features.features_of((np.arange(4096) < share * 4096).astype(float)[None])
    variance = share * (1.0 - share)
    moment = share * (1.0 - share) ** 4 + (1.0 - share) * share**4
    assert pulse.kurtosis == pytest.approx(moment / variance**2, rel=1e-9)
    assert pulse.crest == pytest.approx((1.0 - share) / variance**0.5, rel=1e-9)


def test_a_resolved_grid_asks_for_the_same_cases(ran):
    own = grids.load(ran[2], Fake.catalogue())
    again = grids.load(own.resolved(), Fake.catalogue())
    assert [*again.identities()] == [*own.identities()]
    assert again.fixed_settings() == own.fixed_settings()
    assert own.fixed_settings()["save.revolutions"] == 8.0  # all that a case has after its start


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"turns": 2.5}, r"acceleration has 2\.\d+ revolutions; at least 3 are needed"),
        ({"samples": 16}, r"16 samples a revolution .* at least 20 are needed"),
    ],
)
def test_too_little_is_refused_with_what_is_needed(tmp_path, changes, message):
    with pytest.raises(InputError, match=message):
        grids.load(asked(measure(tmp_path / "rig.csv", **changes)), Fake.catalogue())


IDENTIFIED = (
    TEXT
    + """\
identify:
  over: {joints.rod-slider.clearance: [20 um, 300 um]}
  from: {FILE: {slider/a: acceleration}}
  cases: 400
"""
)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[20 um, 300 um]", "20 um", "expected [low, high], the range of its prior"),
        ("cases: 400", "cases: 4", "allowed: a whole number from 16"),
        ("cases: 400", "cases: 400\n  features: [rms, peak]", "did you mean 'peaks'?"),
        ("slider/a: acceleration", "slider/b: acceleration", "there is no channel 'slider/b'"),
        ("slider/a: acceleration", "slider/a: accelaration", "no column 'accelaration'; did you mean 'acceleration'?"),
        ("identify:\n", "sweep: {drive.speed: [1 rpm, 2 rpm]}\nidentify:\n", "conflicts with `sweep`"),
        ("orbits: last", "orbits: none", "needs last"),
        ("FILE", "none.csv", "none.csv"),
    ],
)
def test_a_mistake_is_reported(tmp_path, problems_in, old, new, message):
    file = measure(tmp_path / "rig.csv")
    problems = problems_in(IDENTIFIED.replace(old, new).replace("FILE", str(file)))
    assert any(message in problem for problem in problems), problems
    assert len(problems) == 1 or "channel" not in message  # the file is right


def test_shards_cannot_identify(ran):
    with pytest.raises(InputError, match="identify"):
        quiet(ran[2], ran[1].parent / "shard", shard="1/2")


def test_too_few_finished_cases_end_with_a_summary(tmp_path):
    source = asked(measure(tmp_path / "rig.csv"), 32, over={ROD: ["0.78 kg", "0.9 kg"]})
    result = quiet(source, tmp_path / "run")
    finished = result.cases - result.failed
    assert 0 < finished < 12
    assert "nothing is identified" in result.search_result.note
    assert result.exit_code == 3
    text = run_text(of_run(result))
    assert f"{finished} of 32 cases finished and at least 12 are needed" in text
    assert "made to fail" in text
    run = clearsweep.open(tmp_path / "run")
    assert len(run.summary) == 32
    assert run.identify is None
    assert any("nothing is identified" in each for each in run.grid["warnings"])
    assert identified_sections(prepare(run)) == []


@pytest.mark.slow
def test_two_encoders_with_noise_find_play_and_stiffness(tmp_path):
    """A shaft turns a rotor on a spring to and fro through a coupling of 1 mrad and 2 kN m/rad."""
    tree, period, noise = coupling(), 0.5, np.random.default_rng(2)
    times = np.linspace(0.0, 6.01 * period, 601)
    angles = 0.05 * np.sin(2.0 * np.pi * times / period)
    del tree["mechanism"]["bodies"]["wheel"]["initial"], tree["save"]
    tree["drive"] = {"angle": {"table": {"time": times.tolist(), "angle": angles.tolist()}}}
    contact = {"law": "hunt-crossley", "stiffness": 2e3, "restitution": 0.3}
    tree["joints"]["mesh"] = {"play": 1e-3, "contact": contact, "drag": 0.0}
    friction = {"law": "tanh", "torque": 0.5, "velocity_scale": 1e-2}
    spring = {"between": ["ground", "wheel"], "torsional_stiffness": 20.0, "free_angle": 0.0}
    tree["loads"] = {"brake": {"on": "bearing", "friction": friction}, "spring": spring}
    tree["simulate"] = {"cycles": 6, "period": period, "discard": 1, "tolerance": 1e-7}
    measured = np.arange(0.0, 2.9, period / 1000)
    output = clearsweep.simulate(clearsweep.load_case(tree), measured)["wheel/angle"]
    given = np.array([measured, 0.05 * np.sin(2.0 * np.pi * measured / period), output])
    given[1:] += 2e-6 * noise.standard_normal(given[1:].shape)  # rad
    rows = "\n".join(f"{t:.6f},{first:.9f},{second:.9f}" for t, first, second in given.T.tolist())
    (tmp_path / "encoders.csv").write_text(f"time [s],input [rad],output [rad]\n{rows}\n", encoding="utf-8")
    over = {"joints.mesh.play": [3e-4, 3e-3], "joints.mesh.contact.stiffness": [600.0, 6000.0]}
    signals = {str(tmp_path / "encoders.csv"): {"joints/mesh/x": ["input", "output"]}}
    tree |= {"name": "encoders", "identify": {"over": over, "from": signals, "cases": 96}}
    answer = clearsweep.sweep(tree, tmp_path / "run", jobs=1, show_progress=False).search_result
    play, stiffness = answer.parameters
    assert play.low < 1e-3 < play.high < 1.5 * play.low
    assert stiffness.low < 2e3 < stiffness.high < 2.0 * stiffness.low
    assert answer.explained
    wrong = {str(tmp_path / "encoders.csv"): {"wheel/angle": ["input", "output"]}}
    with pytest.raises(InputError, match="wheel/angle has the columns of two encoders"):
        clearsweep.sweep(tree | {"identify": {"over": over, "from": wrong, "cases": 96}}, tmp_path / "no", jobs=1)
    wrong = {str(tmp_path / "encoders.csv"): {"joints/mesh/x": ["input"]}}
    with pytest.raises(InputError, match=r"expected the name of a column, or \[input, output\]"):
        clearsweep.sweep(tree | {"identify": {"over": over, "from": wrong, "cases": 96}}, tmp_path / "no", jobs=1)


# ---------------------------------------------------------------------------------------- measured signals over a case


UNITS = {"acceleration": "m/s^2", "slider/a": "m/s^2"}
OVERLAID = 100.0  # rad/s


def signal(angle, size=1.0):
    return size * (np.cos(angle) + 0.3 * np.cos(2.0 * angle) + 0.1 * np.sin(7.0 * angle))


def write(path, angle, values, head="crank_angle [deg],acceleration [m/s^2]", scale=np.degrees):
    rows = "\n".join(
        f"{place!r},{value!r}" for place, value in zip(scale(angle).tolist(), values.tolist(), strict=True)
    )
    path.write_text(f"{head}\n{rows}\n", encoding="utf-8")
    return path


@pytest.fixture
def study():
    """A run of three cases whose acceleration is 1, 2 and 3 times the signal."""
    angle = np.linspace(0.0, 2.0 * features.TURN, 1441)
    orbits = {
        name: {"t": angle / OVERLAID, "crank_angle": angle, "slider/a": signal(angle, size)}
        for name, size in (("a" * 16, 1.0), ("b" * 16, 2.0), ("c" * 16, 3.0))
    }
    channels = [SimpleNamespace(name=name, unit=unit) for name, unit in (("t", "s"), ("slider/a", "m/s^2"))]
    run = SimpleNamespace(layout=SimpleNamespace(stored=channels), orbit_columns=orbits.__getitem__)
    return SimpleNamespace(run=run, cases=SimpleNamespace(index=list(orbits)), setting=lambda case_id: "clearance 1 mm")


def test_the_nearest_case_and_the_angle_between_are_found(tmp_path, study):
    angle = np.linspace(0.0, 5.2 * features.TURN, 4000)
    noise = np.random.default_rng(0).normal(0.0, 0.05, len(angle))
    file = write(tmp_path / "rig.csv", angle, signal(angle - 0.5, 2.0) + noise)
    (laid,) = compare_signals(study, file)
    assert laid.case_id == "b" * 16
    assert laid.angle == pytest.approx(0.5, abs=features.TURN / 720)
    assert laid.misfit < 0.03
    assert len(laid.measured) == 4
    result = features.features_of(laid.measured)
    expected = features.features_of(laid.computed)
    assert result.rms == pytest.approx(expected.rms, rel=0.02)
    assert result.spectrum[0] == pytest.approx(expected.spectrum[0], rel=0.02)
    blocks = overlay_section(study, [laid]).blocks
    assert [block.__class__.__name__ for block in blocks] == ["Sentences", "Gallery", "Table"]


def test_a_signal_over_time_is_laid_by_the_speed_of_the_case(tmp_path, study):
    angle = np.linspace(0.0, 4.0 * features.TURN, 3000)
    head = "time [ms],slider/a [m/s^2]"
    file = write(tmp_path / "rig.csv", angle, signal(angle, 3.0), head, lambda each: 1e3 * each / OVERLAID)
    (laid,) = compare_signals(study, file)
    assert (laid.case_id, laid.angle) == ("c" * 16, 0.0)
    assert laid.misfit < 1e-3


def test_features_are_those_of_a_sum_of_cosines():
    angle = features.TURN * np.arange(3 * features.MIN_SAMPLES) / features.MIN_SAMPLES
    result = features.features_of((2.0 + 3.0 * np.cos(angle) + 4.0 * np.cos(6.0 * angle)).reshape(3, -1))
    assert result.rms == pytest.approx(np.sqrt(12.5))
    assert result.peak_median == pytest.approx(7.0)
    assert result.spectrum == pytest.approx(
        (3.0 / np.sqrt(2.0), 0.0, 0.0, 0.0, 4.0 / np.sqrt(2.0), *(0.0,) * 15), abs=1e-9
    )


GOOD = [f"{10 * k},{k % 7}" for k in range(120)]


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (["crank_angle [deg],acceleration [m/s^2]", *GOOD[:5]], "rig.csv: has 5 rows; at least 16"),
        (["crank_angle [deg],accelaration [m/s^2]", *GOOD], "rig.csv:1:2: .*did you mean 'acceleration'"),
        (["crank_angle [deg],acceleration [mm]", *GOOD], "rig.csv:1:2: found '1 mm', whose unit mm has another"),
        (["crank_angle [deg],acceleration [m/s^2]", *GOOD[:20], "200,nan", *GOOD[21:]], "rig.csv:22:2: found 'nan'"),
        (["crank_angle [deg],acceleration [m/s^2]", *GOOD[:20], "10,1", *GOOD[21:]], "rig.csv:22: .*does not increase"),
        (["crank_angle [deg],acceleration [m/s^2]", *GOOD[:20], *GOOD[40:]], "rig.csv:22: .*samples are missing"),
        (["acceleration [m/s^2]", *(row.split(",")[0] for row in GOOD)], "expected crank_angle"),
    ],
)
def test_what_cannot_be_used_is_refused_by_line(tmp_path, rows, message):
    file = tmp_path / "rig.csv"
    file.write_text("\n".join(rows) + "\n", encoding="utf-8")
    with pytest.raises(InputError, match=message):
        read_signals(file, UNITS)


def test_fewer_than_three_revolutions_are_refused(tmp_path, study):
    angle = np.linspace(0.0, 2.5 * features.TURN, 500)
    with pytest.raises(InputError, match=r"has 2\.5 revolutions; at least 3 whole"):
        compare_signals(study, write(tmp_path / "rig.csv", angle, signal(angle)))
