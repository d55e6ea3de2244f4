"""The ideal machine at many angles: stations of its turn are used again, and nothing else of it differs."""

import math

import numpy as np
import pytest
from planar_machines import slider_crank

from clearsweep.contracts.machine import Constant
from clearsweep.mechanics.machines import planar
from clearsweep.mechanics.machines.planar import form
from clearsweep.mechanics.machines.planar.closure import STATIONS
from clearsweep.mechanics.machines.planar.stations import Stations, stations_of
from clearsweep.tracing.compiled.pinned import ArrayHandle
from clearsweep.tracing.objects import machine_code


def case(speed=100.0):
    return slider_crank(drive=Constant(speed))


@pytest.mark.few("8")
@pytest.mark.parametrize("turns", [1, 8])
def test_many_angles_give_the_forces_of_few(turns):
    """At stations of all turns, between them, and where both are asked for at once."""
    start = case().drive.start_angle
    even = start + np.linspace(0.0, 2.0 * math.pi * turns, STATIONS * turns + 1)
    for angles in (even, np.union1d(even, start + np.linspace(0.01, 6.0, 77)), even + 1e-3):
        many = planar.ideal(case(), angles)
        for part in np.array_split(np.arange(len(angles)), 12 * turns):  # fewer than the stations: closed anew
            few = planar.ideal(case(), angles[part])
            for name, force in few.reactions.items():
                largest = np.max(np.abs(many.reactions[name]))
                assert many.reactions[name][part] == pytest.approx(force, rel=0.0, abs=1e-12 * largest)
            for value in ("position", "velocity", "acceleration", "torque"):
                all_of_it = getattr(many, value)
                limit = 1e-12 * np.max(np.abs(all_of_it))
                assert all_of_it[part] == pytest.approx(getattr(few, value), rel=0.0, abs=limit)


def test_only_angles_that_are_no_stations_are_closed(monkeypatch):
    machine, closed = case(), []
    known = planar.ideal_of(machine)
    angles = machine.drive.start_angle + np.linspace(0.0, 4.0 * math.pi, 2 * STATIONS + 1)
    anew = type(known)._close
    monkeypatch.setattr(type(known), "_close", lambda self, at: closed.extend(at) or anew(self, at))
    known.states_at(np.append(angles, [0.12345, 9.87654]))
    assert closed == [0.12345, 9.87654]


def test_machines_that_differ_in_masses_and_speed_share_their_stations():
    assert isinstance(stations_of(case()), Stations)
    body = case().bodies["rod"]
    heavier = case(50.0)._replace(bodies={**case().bodies, "rod": body._replace(mass=2.0 * body.mass)})
    assert stations_of(heavier) is stations_of(case())
    moved = {**body.points, next(iter(body.points)): (1e-4, 0.0)}
    longer = case()._replace(bodies={**case().bodies, "rod": body._replace(points=moved)})
    assert stations_of(longer) is not stations_of(case())


def value_at(quantities, angle):
    return form.evaluate_cycle(quantities, 1, angle)[0]


@pytest.mark.compiled
def test_a_cycle_is_read_within_its_table_whatever_the_angle_of_a_trial_step():
    """Beside the table, whose quantities are constant, memory is nan; integers of compiled code have 64 bits."""
    table, memory = np.zeros((STATIONS + 1, 2, form.WIDTH)), np.full(3_000_000, math.nan)
    table[..., 0] = 1.0
    begin = memory.size // 2
    memory[begin : begin + table.size] = table.ravel()
    address = ArrayHandle(memory[begin:].ctypes.data)
    address.array = memory[begin:]
    quantities, read = form.Cycle(address, float(STATIONS), 2.0, 0.0), machine_code(value_at)
    sizes = np.concatenate([np.logspace(0, 80, 4001), 2.0 * math.pi * 2.0**63 * (1.0 + np.arange(-40, 41) * 2.0**-52)])
    for angle in (*sizes, *-sizes):
        assert read(quantities, float(angle)) == 1.0
