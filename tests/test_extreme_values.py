"""Values that no machine has are refused in a sentence with their place, before anything is computed with them."""

import math

import pytest
from test_machines import FOUR_BAR, PLANAR, SLIDER_CRANK, changed

from clearsweep import grid
from clearsweep.contracts.catalogue import LARGEST, Field
from clearsweep.language.errors import InputError
from clearsweep.simulation.setup.scene import catalogue

LOAD = {"on": "slider"}


def over_angle(*rows):
    angles, forces = zip(*rows, strict=True)
    return {"gas": {"on": "slider", "table": {"crank_angle [deg]": list(angles), "fx [N]": list(forces)}}}


def speeds(*rows):
    times, values = zip(*rows, strict=True)
    return {"table": {"time [s]": list(times), "speed [rpm]": list(values)}}


EXTREMES = {
    "a speed of zero": (changed(SLIDER_CRANK, drive__speed=speeds((0, 0), (1, 0))), "speed: is 0 in every row"),
    "a speed near zero": (changed(SLIDER_CRANK, drive__speed=speeds((0, 1e-300), (1, 1e-300))), "of a size from 1e-60"),
    "a force beyond floats": (
        changed(SLIDER_CRANK, loads=over_angle((0, 1e308), (180, -1e308), (360, 1e308))),
        "of a size from 1e-60 to 1e+60 (N)",
    ),
    "a step below floats": (changed(SLIDER_CRANK, loads=over_angle((0, 1), (1e-300, 5), (360, 1))), "of a size from"),
    "a step that is lost": (
        changed(SLIDER_CRANK, loads=over_angle((0, 1), (1e-9, 5), (360, 1))),
        "of the table's span",
    ),
    "a scale": (
        changed(SLIDER_CRANK, loads={"gas": over_angle((0, 1), (180, 2), (360, 1))["gas"] | {"scale": 1e308}}),
        "loads.gas.scale: found 1e+308, out of range",
    ),
    "a list in a table": (changed(SLIDER_CRANK, loads=over_angle((0, [1]), (360, 1))), "found a list"),
    "a point far away": (
        changed(PLANAR, mechanism__bodies__crank__points__pin=["1e300 m", 0]),
        "mechanism.bodies.crank.points.pin.0: found 1e300 m, out of range",
    ),
    "a mass": (changed(FOUR_BAR, mechanism__crank__mass=1e308), "mechanism.crank.mass: found 1e+308, out of range"),
    "a list for a limit's name": (
        SLIDER_CRANK | {"limits": {"rod_slider_force_peak": {"at_most": 1, "times": ["a"]}}},
        "limits.rod_slider_force_peak.times: a list is not a column of this grid",
    ),
    "a section for a limit's name": (
        SLIDER_CRANK | {"limits": {"rod_slider_force_peak": {"at_most": 1, "times": {"a": 1}}}},
        "limits.rod_slider_force_peak.times: a section is not a column of this grid",
    ),
    "a list for a unit": (
        SLIDER_CRANK | {"sweep": {"joints.rod-slider.clearance": {"logspace": [1, 2, 3, ["mm"]]}}},
        "logspace: found a list as the unit",
    ),
    **{
        f"a load called {name}": (
            SLIDER_CRANK | {"loads": {name: LOAD | {"fx": 1}}},
            f"loads.{name}: '{name}' is not a valid name",
        )
        for name in ("a b", "é", "a.b", "=1+1", "9a", "a/b", "x" * 41)
    },
}


@pytest.mark.parametrize(("source", "sentence"), EXTREMES.values(), ids=EXTREMES)
def test_an_extreme_value_is_refused_with_its_place(source, sentence, recwarn):
    with pytest.raises(InputError) as refusal:
        grid.load(source, catalogue())
    assert sentence in str(refusal.value)
    assert "WrittenValue" not in str(refusal.value)
    assert not [each for each in recwarn if issubclass(each.category, RuntimeWarning)]


@pytest.mark.parametrize("value", [0.0, 1.0 / LARGEST, LARGEST, 1.0])
def test_the_bounds_themselves_are_allowed(value):
    assert Field("x", "m", low_open=False).contains(value)
    assert not Field("x", "m", -math.inf).contains(-2.0 * LARGEST)
    assert "of a size from 1e-60 to 1e+60" in Field("x", "m").allowed(2.0 * LARGEST)
    assert "of a size" not in Field("x", "m").allowed(-1.0)
