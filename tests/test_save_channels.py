"""Claims about `save.channels`: only the time histories that it lists are stored, and every reader copes with that."""

import h5py
import pytest
from fake_physics import grid, sweep
from fake_runs import TEXT

import clearsweep
from clearsweep import grid as grids
from clearsweep import report
from clearsweep.report.one_case.motion import motion_pictures, saved_channels
from clearsweep.report.study import prepare
from clearsweep.sweeping.pool.case_runner import SIMULATION

LISTED = ("slider/a", "joints/rod_slider/force_normal")


def saving(text):
    """Return the demo grid with another `save`."""
    return TEXT.replace("save: {orbits: last, samples: 720}", f"save: {text}")


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Directories of one run with all histories, and of one with two of them."""
    folder = tmp_path_factory.mktemp("channels")
    for name, more in (("all", {}), ("some", {"channels": list(LISTED)})):
        source = grid(3)
        source["save"] = source["save"] | more
        sweep(source, folder / name, executor="serial", show_progress=False)
    return folder


def test_only_the_listed_channels_are_stored_besides_time_and_angle(ran):
    whole, some = clearsweep.open(ran / "all"), clearsweep.open(ran / "some")
    case_id = str(some.summary["case_id"][0])
    assert [*some.orbit(case_id)] == [name for name in whole.orbit(case_id) if name in ("t", "crank_angle", *LISTED)]
    assert some.orbit(case_id).equals(whole.orbit(case_id)[[*some.orbit(case_id)]])
    assert len(some.events(case_id)) == len(whole.events(case_id))
    with h5py.File(ran / "some/orbits.h5") as file:
        assert "slider/x" not in file
        assert "slider/a" in file


def test_fewer_channels_take_less_room_on_the_disk_but_not_in_memory():
    source = grid(3)
    angle_rate = grids.load(source, SIMULATION.catalogue())
    some = grids.load(source | {"save": source["save"] | {"channels": ["slider/a"]}}, SIMULATION.catalogue())
    fewer = len(angle_rate.layout.channels) - len(some.layout.stored)
    assert len(some.layout.stored) == 3
    assert grids.largest_history(angle_rate) - grids.largest_history(some) == 8.0 * 2 * 20 * fewer
    assert grids.recorded_history(some) == grids.largest_history(angle_rate)


def test_the_report_draws_what_exists(ran, tmp_path):
    prepared = prepare(clearsweep.open(ran / "some"))
    case_id = str(prepared.cases.index[0])
    titles = [picture.title for picture in motion_pictures(prepared, case_id, saved_channels(prepared.run, case_id))]
    assert "Normal force" in titles
    assert not any("orbit" in title for title in titles)
    assert report.write(clearsweep.open(ran / "some"), tmp_path / "page.html").exists()


def test_a_resolved_grid_stores_the_same(at):
    first = at(saving("{orbits: last, channels: [slider/a, slider/x, slider/a]}"))
    assert first.resolved()["save"]["channels"] == ["slider/a", "slider/x"]
    again = grids.load(first.resolved(), SIMULATION.catalogue())
    assert again.layout.listed == first.layout.listed == ("slider/a", "slider/x")
    assert first.case_id(0) == at(TEXT).case_id(0)  # what is saved is no part of a case
