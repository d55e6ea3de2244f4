"""Further cases where the limits' border runs: a made-up force whose border is a known curve, found among few cases."""

import math

import numpy as np
import pytest
from fake_physics import GOOD, Fake, grid, sweep, trajectory
from test_sweep import same_results

import clearsweep
from clearsweep import grid as grids
from clearsweep.language.errors import InputError
from clearsweep.searches.refine import RefineFound
from clearsweep.sweeping.summary import of_run

MASS, SPEED = "mechanism.slider.mass", "drive.speed"
MASSES, SPEEDS = [0.1, 0.3, 0.5, 0.7, 0.9], [100.0, 300.0, 500.0, 700.0]


class Arc(Fake):
    """Made-up mechanics whose force is the distance from the origin, of mass over 1 kg and speed over 1000 rad/s."""

    @staticmethod
    def solve(case, log=None):
        """Return a made-up trajectory."""
        result = trajectory(case)
        result.summary["rod_slider_force_peak"] = distance(case.mechanism.values["slider.mass"], case.drive.speed)
        return result


RADIUS = 0.6137  # N, of the border


def distance(mass, speed):
    return np.hypot(mass, speed / 1000.0)


def refining_grid(cases=60, **changes):
    """Return a grid whose border is a quarter of a circle."""
    source = grid(1, orbits="none") | {
        "sweep": {MASS: MASSES, SPEED: SPEEDS},
        "limits": {"rod_slider_force_peak": RADIUS},
        "refine": {"along": "limits", "cases": cases},
    }
    return {key: value for key, value in (source | changes).items() if value is not None}


def quiet(source, out, simulator=Arc, **options):
    return sweep(source, out, simulator=simulator, executor="serial", show_progress=False, **options)


def off_border(summary):
    """Return how far cases are from the border, in steps of the grid, those between the grid's own first."""
    grid_distances = summary[MASS].isin(MASSES) & summary[SPEED].isin(SPEEDS)
    far = (distance(summary[MASS], summary[SPEED]) - RADIUS).abs() / 0.2
    return far[~grid_distances].to_numpy(), far[grid_distances].to_numpy()


def test_cases_are_added_along_the_border_and_nowhere_else(tmp_path):
    result = quiet(refining_grid(), tmp_path / "run")
    summary = clearsweep.open(tmp_path / "run").summary
    added_distances, grid_distances = off_border(summary)
    assert (len(grid_distances), result.cases) == (20, len(summary))
    assert 55 <= len(added_distances) == result.search_result.added <= 60
    assert added_distances.max() < 1.0  # a box that is crossed has no corner further away than its diagonal
    assert np.median(added_distances) < 0.25  # of a step of the grid
    assert np.median(grid_distances) > 1.0
    angles = np.linspace(np.arctan2(0.1, 0.6), np.arctan2(0.6, 0.11), 50)
    around = RADIUS * np.array([np.cos(angles), np.sin(angles)])
    nearest = [np.min(np.hypot(summary[MASS] - x, summary[SPEED] / 1000.0 - y)) for x, y in around.T]
    assert max(nearest) < 0.07  # a third of a step of the grid; without them it is over half of one


def test_what_is_known_of_the_border_does_not_depend_on_interruptions(tmp_path):
    quiet(refining_grid(), tmp_path / "whole")
    quiet(refining_grid(cases=24), tmp_path / "run")
    more = quiet(refining_grid(), tmp_path / "run")
    assert 60 - 24 <= more.ran < 60
    assert same_results(tmp_path / "run", tmp_path / "whole")
    lost = sorted((tmp_path / "run" / "parts").iterdir())[:2]
    for path in lost:
        path.unlink()
    assert 0 < quiet(refining_grid(), tmp_path / "run").ran < 40
    assert same_results(tmp_path / "run", tmp_path / "whole")
    assert quiet(refining_grid(), tmp_path / "run").ran == 0


def test_a_border_across_one_axis_is_enclosed_to_a_thousandth_of_a_step(tmp_path):
    source = refining_grid(cases=500, sweep={MASS: [0.1, 0.2, 0.4, 0.8], SPEED: [1e-3]})
    result = quiet(source, tmp_path / "run")
    summary = clearsweep.open(tmp_path / "run").summary
    good = summary[summary["limits_exceeded"] == ""][MASS].max()
    bad = summary[summary["limits_exceeded"] != ""][MASS].min()
    assert good <= RADIUS < bad
    assert bad / good == pytest.approx(2.0 ** (1.0 / 1024), rel=1e-9)  # halved by ratios, as the axis is
    assert result.search_result == RefineFound(500, 10, 1, whole=True)
    assert of_run(result)["answer"]["cases"]["added"] == 10


def test_steps_that_are_equal_are_halved_by_differences(tmp_path):
    quiet(refining_grid(cases=1, sweep={MASS: [0.1, 0.5, 0.9], SPEED: [1e-3]}), tmp_path / "run")
    assert sorted(clearsweep.open(tmp_path / "run").summary[MASS]) == [0.1, 0.5, 0.7, 0.9]


@pytest.mark.parametrize("limit", [10.0, 0.01])
def test_where_all_cases_agree_none_is_added(tmp_path, limit):
    result = quiet(refining_grid(limits={"rod_slider_force_peak": limit}), tmp_path / "run")
    assert (result.cases, result.search_result.added) == (20, 0)
    assert of_run(result)["answer"]["cases"]["added"] == 0


def test_each_law_has_its_own_border(tmp_path):
    path = "joints.rod-slider.bearing_radius"
    quiet(refining_grid(zip={path: [0.01, 0.02], "joints.rod-slider.length": [0.02, 0.03]}), tmp_path / "run")
    summary = clearsweep.open(tmp_path / "run").summary
    assert sorted(summary[path].unique()) == [0.01, 0.02]  # what goes in step stays as it is
    added_distances = summary[~(summary[MASS].isin(MASSES) & summary[SPEED].isin(SPEEDS))]
    assert abs((added_distances[path] == 0.01).mean() - 0.5) < 0.2


def test_a_refined_run_is_written_to_run_json_so_that_it_loads_again(tmp_path):
    quiet(refining_grid(), tmp_path / "run")
    run = clearsweep.open(tmp_path / "run")
    record = {key: run.grid[key] for key in run.grid["keys"]}
    again = grids.load(record, Fake.catalogue())
    assert sorted(map(again.case_id, range(len(again)))) == run.summary["case_id"].tolist()
    assert sorted(f"{number:016x}" for number in again.identities()) == run.summary["case_id"].tolist()
    assert quiet(record, tmp_path / "run").ran == 0


def test_shards_of_what_is_refined_are_refused_with_a_way_out(tmp_path):
    with pytest.raises(InputError, match="run the shards without `refine` and merge them"):
        quiet(refining_grid(), tmp_path / "run", shard="1/2")


def test_a_case_that_fails_is_beyond_the_border(tmp_path):
    class Failing(Arc):
        @staticmethod
        def solve(case, log=None):
            result = Arc.solve(case)
            if result.summary["rod_slider_force_peak"] > RADIUS:
                return type(result)("step-budget", "made to fail", {})
            return result

    quiet(refining_grid(limits={"rod_slider_force_peak": 10.0}), tmp_path / "run", simulator=Failing)
    added_distances, _ = off_border(clearsweep.open(tmp_path / "run").summary)
    assert len(added_distances) >= 55
    assert added_distances.max() < 1.0


def test_the_made_up_border_is_where_it_is_said_to_be():
    case = grids.load(refining_grid(), Fake.catalogue()).case(0)
    assert Arc.solve(case).summary["rod_slider_force_peak"] == math.hypot(0.1, 0.1)
    assert case.mechanism.values["gravity"] == GOOD
