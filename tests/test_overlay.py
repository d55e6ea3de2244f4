"""Claims about measured signals: how files are read, aligned with the computed motion, and compared with it."""

from types import SimpleNamespace

import numpy as np
import pytest

from clearsweep.answers import features
from clearsweep.grid.written.tables import read_signals
from clearsweep.language.errors import InputError
from clearsweep.report.sections.identified import compare_signals, overlay_section

UNITS = {"acceleration": "m/s^2", "slider/a": "m/s^2"}
SPEED = 100.0  # rad/s


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
        name: {"t": angle / SPEED, "crank_angle": angle, "slider/a": signal(angle, size)}
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
    file = write(tmp_path / "rig.csv", angle, signal(angle, 3.0), head, lambda each: 1e3 * each / SPEED)
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
