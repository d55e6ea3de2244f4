"""Groups of the clearance of rolling bearings, their mounting, and bearings by name."""

import copy
import itertools
import json
import math
import re
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from right_grids import grid_of
from ruamel.yaml import YAML
from test_rolling import BALL

import clearsweep
from clearsweep import grid, report, simulation
from clearsweep.contracts.case import Capacity, Rolling
from clearsweep.grid.library import BEARINGS, bearing_names
from clearsweep.grid.library.fits import BearingSizes, Fit, find_group, mounted
from clearsweep.mechanics.laws.bearings import equivalent_loads, load_powers, rating_life
from clearsweep.report.blocks.section import Picture, draw_svg
from clearsweep.report.one_case.joints import LOAD_SECTORS, LoadedElements, draw_bearing, draw_load_distribution
from clearsweep.simulation.figures import parts
from clearsweep.store.datasets import largest_of
from clearsweep.sweeping.pool.case_runner import SIMULATION
from clearsweep.sweeping.sweep import facts

JOINT = "joints.crank-rod"
CLEARANCE = f"{JOINT}.clearance"
CONTACT = {"law": "hunt-crossley", "damping_factor": "0.5 s/m"}
BEARING = BALL | {"clearance": {"group": "C3"}, "bore": "25 mm", "contact": CONTACT}
NAMED = {"type": "rolling", "bearing": "6305", "contact": CONTACT}
MACHINE = grid_of("a crank without its bearing")


def load(joint=BEARING, **sections):
    return grid.load(copy.deepcopy(MACHINE | {"joints": {"crank-rod": joint}} | sections), simulation.catalogue())


def clearance(joint, **sections):
    return load(joint, **sections).written_case(0)["joints"]["crank-rod"]["clearance"]


#: kind, bore (mm), group: limits (um), of ISO 5753-1 as catalogues reprint it.
PUBLISHED = [
    *(("ball", 6, "C3", 8, 23), ("ball", 10, "C2", 0, 7), ("ball", 20, "CN", 5, 20), ("ball", 20, "C3", 13, 28)),
    *(("ball", 24.001, "C4", 23, 41), ("ball", 65, "C5", 55, 90), ("ball", 100, "C4", 53, 84)),
    *(("roller", 24, "C2", 0, 25), ("needle", 30, "CN", 20, 45), ("roller", 90, "C3", 75, 110)),
    *(("roller", 450, "C5", 565, 665), ("needle", 12, "C5", 65, 90)),
]


@pytest.mark.parametrize(("kind", "bore", "group", "low", "high"), PUBLISHED)
def test_a_group_has_the_limits_of_the_standard(kind, bore, group, low, high):
    limits = find_group(group, Fraction(str(bore)), kind)
    assert (limits.low, limits.high) == pytest.approx((low / 1e6, high / 1e6), rel=1e-12)
    assert limits.mean == pytest.approx((low + high) / 2e6, rel=1e-12)


def test_groups_grow_in_step_at_every_bore():
    for kind, largest in (("ball", 100), ("roller", 500)):
        for bore in range(11, largest + 1):
            groups = [find_group(name, Fraction(bore), kind) for name in ("C2", "CN", "C3", "C4", "C5")]
            for smaller, larger in itertools.pairwise(groups):
                assert smaller.low < larger.low < larger.high
                assert smaller.high < larger.high
                assert smaller.mean < larger.mean


def test_a_group_is_its_mean_clearance_and_the_same_case_as_the_number():
    assert clearance(BEARING) == 20.5e-6
    assert load().case_id(0) == load(BEARING | {"clearance": "20.5 um"}).case_id(0)
    assert load().case(0).joints[0].clearance == 10.25e-6
    assert load().fits[CLEARANCE] == (Fit("C3", 0.025, 13e-6, 20.5e-6, 28e-6),)


def test_an_axis_of_groups_and_its_record():
    sweep = {"sweep": {CLEARANCE: {"groups": ["C2", "CN", "C3", "C4"]}}}
    cases = load(**sweep)
    assert cases.axes[CLEARANCE] == pytest.approx((6e-6, 12.5e-6, 20.5e-6, 32e-6))
    assert [fit.name for fit in cases.fits[CLEARANCE]] == ["C2", "CN", "C3", "C4"]
    again = grid.load(json.loads(json.dumps(cases.resolved())), simulation.catalogue())
    assert [again.case_id(k) for k in range(4)] == [cases.case_id(k) for k in range(4)]
    mixed = load(sweep={CLEARANCE: [{"group": "C2"}, "10 um", {"group": "C4", "inner_warmer": "5 K"}]})
    assert mixed.axes[CLEARANCE][:2] == pytest.approx((6e-6, 10e-6))


@pytest.mark.parametrize("bores", [["20 mm", "25 mm"], ["17 mm", "20 mm"]])
def test_groups_in_step_with_the_bore_are_those_of_their_row(bores):
    cases = load(BEARING, zip={CLEARANCE: {"groups": ["C3", "C3"]}, f"{JOINT}.bore": bores})
    expected = [find_group("C3", Fraction(bore.removesuffix(" mm")), "ball").mean for bore in bores]
    assert cases.axes[CLEARANCE] == pytest.approx(expected)


@pytest.mark.parametrize("distribution", ["uniform", "normal"])
def test_a_sample_draws_from_the_range_of_a_group(distribution):
    over = {CLEARANCE: {"group": "CN", "distribution": distribution}}
    cases = load(sample={"method": "sobol", "n": 32, "over": over})
    values = np.array(cases.axes[CLEARANCE])
    assert 5e-6 <= values.min() < 10e-6
    assert 15e-6 < values.max() <= 20e-6
    assert values.mean() == pytest.approx(12.5e-6, rel=0.05)


def test_a_search_among_groups_tries_each_at_its_largest_clearance():
    section = {"largest": CLEARANCE, "among": {"groups": ["C4", "C2", "CN"]}, "for": "all"}
    cases = load(seek=section, limits={"crank_rod_force_peak": "5 kN"})
    assert cases.search.first() == {CLEARANCE: pytest.approx((11e-6, 20e-6, 41e-6))}
    assert cases.search.labels()[CLEARANCE] == pytest.approx({"C2": 11e-6, "CN": 20e-6, "C4": 41e-6})
    mounting = {"fit": "k5/H7", "inner_warmer": "5 K"}
    fitted = load(NAMED, seek=section | {"among": section["among"] | mounting}, limits={"crank_rod_force_peak": 5e3})
    again = grid.load(json.loads(json.dumps(fitted.resolved())), simulation.catalogue())
    assert again.search.first() == fitted.search.first() != cases.search.first()


# Mounted clearances.

SIZES = BearingSizes(0.025, 0.062, 11.1125e-3, 43.5e-3)
LOOSE = Fit("C3", 0.025, 13e-6, 20.5e-6, 28e-6)


def shrunk(interference, inner, seat, outer, poisson=0.3):
    """Return the change of the far diameter of a ring by Lame's equations for one modulus.

    The ring lies between `inner` and `outer`; its seat, one of the two, is on a solid shaft or in an endless housing.
    """
    square = (outer**2 + inner**2) / (outer**2 - inner**2)
    if seat == inner:  # the ring on a shaft: pressure inside
        pressure = interference / (seat * (square + poisson + 1.0 - poisson))
        return pressure * 2.0 * inner**2 * outer / (outer**2 - inner**2)
    pressure = interference / (seat * (square - poisson + 1.0 + poisson))
    return pressure * 2.0 * outer**2 * inner / (outer**2 - inner**2)


def test_a_mounted_clearance_is_that_of_shrunk_rings():
    """k5 at 25 mm is 2 to 11 um on a bore of -10 to 0 um, N7 at 62 mm is -39 to -9 um around -13 to 0 um."""
    inner, outer = 43.5e-3 - 11.1125e-3, 43.5e-3 + 11.1125e-3
    loss = shrunk(11.5e-6, 0.025, 0.025, inner) + shrunk(17.5e-6, outer, 0.062, 0.062)
    assert mounted(LOOSE, "k5/N7", SIZES).mean == pytest.approx(20.5e-6 - loss, rel=1e-12)


def test_a_loose_housing_leaves_the_clearance_and_a_warm_inner_ring_takes_from_it():
    loose = mounted(LOOSE, "g6/H7", SIZES)
    assert loose == LOOSE
    warm = mounted(LOOSE, "", SIZES, 10.0)
    assert LOOSE.mean - warm.mean == pytest.approx(12.5e-6 * 10.0 * (43.5e-3 + 11.1125e-3), rel=1e-9)
    assert warm.high - warm.low == pytest.approx(LOOSE.high - LOOSE.low, rel=1e-9)


def test_a_mounting_stands_next_to_the_group_in_a_grid():
    fitted = {"group": "C3", "fit": "k5/N7", "inner_warmer": "10 K"}
    named = NAMED | {"bearing": "6305 C3", "clearance": {key: fitted[key] for key in ("fit", "inner_warmer")}}
    expected = mounted(LOOSE, "k5/N7", SIZES, 10.0).mean
    assert clearance(NAMED | {"clearance": fitted}) == pytest.approx(expected, rel=1e-12)
    assert clearance(named) == pytest.approx(expected, rel=1e-12)


# Bearings by name.

#: ISO 281:2007, table 2: factor of deep groove ball bearings at the ratio of ball and pitch diameter.
BALL_FACTORS = {0.12: 57.5, 0.14: 58.8, 0.16: 59.6, 0.18: 59.9, 0.2: 59.9, 0.22: 59.6, 0.24: 59.0, 0.26: 58.2}
BALL_FACTORS |= {0.28: 57.1, 0.3: 56.0, 0.32: 54.6}
#: ISO 76:2006, table 1, likewise.
STATIC_FACTORS = {0.12: 15.9, 0.14: 15.4, 0.16: 14.9, 0.18: 14.4, 0.2: 14.0, 0.22: 13.5, 0.24: 13.0, 0.26: 12.5}
STATIC_FACTORS |= {0.28: 12.1, 0.3: 11.6, 0.32: 11.2}
BALL_BEARINGS = [name for name in BEARINGS if name.startswith("6")]


def sizes_of(name):
    return {key: value.typical for key, value in BEARINGS[name].values.items()}


@pytest.mark.parametrize("name", BALL_BEARINGS)
def test_the_ratings_of_a_ball_bearing_follow_from_its_balls(name):
    sizes = sizes_of(name)
    diameter, count = 1e3 * sizes["element_diameter"], sizes["elements"]
    ratio = sizes["element_diameter"] / sizes["pitch_diameter"]
    dynamic, static = (
        float(np.interp(ratio, list(factors), list(factors.values()))) for factors in (BALL_FACTORS, STATIC_FACTORS)
    )
    assert 1.3 * dynamic * count ** (2 / 3) * diameter**1.8 == pytest.approx(sizes["capacity.dynamic"], rel=0.04)
    assert static * count * diameter**2 == pytest.approx(sizes["capacity.static"], rel=0.04)


@pytest.mark.parametrize("name", BEARINGS)
def test_a_bearing_by_name_can_be_built(name):
    sizes = sizes_of(name)
    assert sizes["elements"] < math.pi / math.asin(sizes["element_diameter"] / sizes["pitch_diameter"])
    assert sizes["bore"] <= sizes["pitch_diameter"] - sizes["element_diameter"] + 1e-12
    assert sizes["pitch_diameter"] + sizes["element_diameter"] < sizes["outside_diameter"]
    needle = {"clearance": "20 um", "unchecked": True} if "length" in sizes else {}
    case = load(NAMED | {"bearing": name} | needle).case(0)
    assert case.joints[0].rolling.elements == sizes["elements"]
    assert case.joints[0].rolling.capacity == (sizes["capacity.dynamic"], sizes["capacity.static"])


def test_the_name_of_a_bearing_has_its_group_and_keys_next_to_it_override():
    assert clearance(NAMED) == find_group("CN", Fraction(25), "ball").mean
    assert clearance(NAMED | {"bearing": "6305 C4"}) == find_group("C4", Fraction(25), "ball").mean
    assert clearance(NAMED | {"bearing": 6305, "clearance": "3 um"}) == 3e-6
    own = NAMED | {"element_diameter": "11.5 mm", "capacity": {"dynamic": "23.4 kN"}, "groove": [0.515, 0.525]}
    bearing = load(own).case(0).joints[0].rolling
    assert (bearing.element_diameter, bearing.capacity, bearing.groove) == (11.5e-3, (23.4e3, 10.9e3), (0.515, 0.525))
    assert "6204 C3" in bearing_names()


def test_both_clearances_are_printed_and_a_shared_definition_is_remarked():
    ranges, _ = facts(load(), SIMULATION)
    assert ranges[f"{CLEARANCE} (C3, diametral)"] == {"unit": "m", "min": 13e-6, "max": 28e-6}
    assert ranges[f"{CLEARANCE} (C3, radial)"] == {"unit": "m", "min": 6.5e-6, "max": 14e-6}
    pin = {"clearance": "= play", "bearing_radius": "10 mm", "length": "20 mm"}
    pin["contact"] = {"law": "flores", "restitution": 0.8, "material": "S355"}
    both = {"crank-rod": BEARING | {"clearance": "= play"}, "rod-slider": pin}
    shared = grid.load(copy.deepcopy(MACHINE | {"define": {"play": "20 um"}, "joints": both}), simulation.catalogue())
    _, warnings = facts(shared, SIMULATION)
    assert any("both follow from define.play" in warning for warning in warnings)
    ranges, warnings = facts(load(BEARING | {"clearance": "20 um"}), SIMULATION)
    assert ranges["joints.crank-rod.clearance (of the rings, radial)"]["max"] == 10e-6
    assert not any("define." in warning for warning in warnings)


NAMES = f"{JOINT}.bearing"


@pytest.mark.parametrize(
    "written",
    [{}, {"clearance": {"group": "C3"}}, {"clearance": "10 um"}, {"fit": "k5/H7", "inner_warmer": "5 K"}],
    ids=["by name", "one group", "a length", "mounted"],
)
def test_a_swept_bearing_is_the_case_of_each_name_alone(written):
    names = ["6204", "6205"] if "clearance" in written else ["6204 C3", "6205 C2"]
    swept = load(NAMED | written, sweep={NAMES: names})
    single = [load(NAMED | written | {"bearing": name}) for name in names]
    assert [swept.case_id(k) for k in range(2)] == [each.case_id(0) for each in single]
    again = grid.load(swept.resolved(), simulation.catalogue())
    assert [again.case_id(k) for k in range(2)] == [swept.case_id(k) for k in range(2)]


def test_names_of_a_sweep_may_be_numbers_and_all_elements_have_a_channel():
    swept = load(NAMED, sweep={NAMES: [6204, 6205, 6304]})
    assert swept.axes[NAMES] == ("6204", "6205", "6304")
    forces = [channel.name for channel in swept.layout.channels if channel.name.endswith("_force")]
    assert f"{len(forces)} elements" == f"{BEARINGS['6205'].values['elements'].typical:g} elements"


def test_a_mounting_on_the_joint_is_that_of_every_group():
    groups = {CLEARANCE: {"groups": ["C2", "C3"], "fit": "k5/N7"}}
    mounted_axes = load(NAMED, sweep=groups).axes
    del groups[CLEARANCE]["fit"]
    assert load(NAMED | {"fit": "k5/N7"}, sweep=groups).axes == mounted_axes


def test_sizes_in_step_have_to_fit_row_by_row():
    sizes = {f"{JOINT}.element_diameter": ["11.5 mm", "20 mm"], f"{JOINT}.pitch_diameter": ["43.5 mm", "80 mm"]}
    plain = {"kind": "ball", "clearance": "10 um"}
    assert len(load(BEARING | plain, zip=sizes)) == 2


# ---------------------------------------------------------------------------------------------- the report


ROOT = Path(__file__).parents[1]
DRAWN = Rolling("ball", 9, 9.525e-3, 46e-3, (0.52, 0.53), capacity=Capacity(19.5e3, 11.3e3))


def test_loads_are_collected_by_the_angle_of_the_element():
    turn = 2.0 * np.pi
    cage = np.linspace(0.0, 3.0 * turn, 3 * LOAD_SECTORS * 4, endpoint=False) + turn / (8 * LOAD_SECTORS)
    angles = cage[:, None] + turn * np.arange(9) / 9
    elements = LoadedElements(angles, np.maximum(np.cos(angles), 0.0))
    largest, mean = elements.by_sector()
    edges = np.linspace(0.0, turn, LOAD_SECTORS + 1)
    in_reach = np.maximum(np.cos(edges[:-1]), 0.0), np.maximum(np.cos(edges[1:]), 0.0)
    assert np.all(largest <= np.maximum(*in_reach) + 1e-12)
    assert np.all(mean >= np.minimum(*in_reach) - 1e-12)
    assert mean.mean() == pytest.approx(1.0 / np.pi, rel=1e-3)
    assert elements.loads[elements.peak].max() == elements.loads.max()


def test_a_bearing_is_drawn_with_its_loaded_elements():
    angles = 2.0 * np.pi * np.arange(9) / 9
    loads = np.maximum(np.cos(angles), 0.0) * 1e3
    svg = draw_svg(Picture("bearing", "", "", lambda ax: draw_bearing(ax, DRAWN, angles, loads)), "a")
    circles, loaded = len(re.findall("<ellipse|<circle", svg)), int((loads > 0.0).sum())
    assert circles == 4 + 9
    assert len(re.findall(r'stroke-width="2\.6|2\.6', svg)) >= loaded
    elements = LoadedElements(angles[None, :], loads[None, :])
    svg = draw_svg(Picture("loads", "", "", lambda ax: draw_load_distribution(ax, elements)), "b")
    assert "load of an element [N]" in svg or "load of an element [kN]" in svg


@pytest.mark.slow
def test_figures_are_integrals_over_the_samples_and_the_page_shows_them(tmp_path):
    """The outer ring is on the crank, so the rings turn relative to each other as the cage does relative to it."""
    grid = YAML(typ="safe").load((ROOT / "configs/bearing_class.yaml").read_text(encoding="utf-8"))
    grid["save"] = {"orbits": "last", "revolutions": 4, "samples": 4000}  # the whole window
    clearsweep.sweep(grid, out=tmp_path / "out", jobs=1)
    run = clearsweep.open(tmp_path / "out")
    for case_id, row in run.summary.set_index("case_id").iterrows():
        orbit = run.orbit(case_id).iloc[:-1]
        loads = np.stack([orbit[f"joints/crank_rod/element_{k + 1}_force"] for k in range(9)], axis=-1)
        relative = orbit["joints/crank_rod/cage_angle"] - orbit["crank_angle"]
        speed = np.abs(np.gradient(relative, orbit["t"]))[:, None]
        means = [np.mean(speed * loads**power) / np.mean(speed) for power in load_powers(DRAWN)]
        life = rating_life(DRAWN, equivalent_loads(DRAWN, *means))
        assert row["crank_rod_life_l10r_revolutions"] == pytest.approx(life, rel=1e-4)
        turned = np.mean(speed) / (0.5 * (1.0 - 9.525 / 46.0)) / (2.0 * np.pi)
        seconds = 1e6 * row["crank_rod_life_l10r_revolutions"] / turned
        assert row["crank_rod_life_l10r"] == pytest.approx(seconds / 3600.0, rel=1e-4)
        light = np.mean(orbit["joints/crank_rod/force_normal"] < 195.0)
        assert row["crank_rod_light_load_fraction"] == pytest.approx(light, abs=1e-3)
        assert row["crank_rod_element_load_max"] >= loads.max() * (1.0 - 1e-9)
    page = report.write(run, tmp_path / "report.html")
    for title in ("Rating life over the clearance", "Loads of the elements", "Load distribution"):
        assert f'aria-label="{title}"' in page.read_text(encoding="utf-8")


@pytest.mark.parametrize("life", [parts.life_in_revolutions, parts.life_in_hours])
def test_a_bearing_without_load_has_an_infinite_life(life):
    joint = SimpleNamespace(rolling=DRAWN)
    totals = SimpleNamespace(joint=[SimpleNamespace(inner_fatigue=0.0)])
    assert life(SimpleNamespace(case=SimpleNamespace(joints=[joint]), totals=totals), 0) == math.inf
    assert largest_of("crank_rod_life_l10r") == largest_of("crank_rod_life_l10r_revolutions") == math.inf
