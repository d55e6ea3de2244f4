"""Rolling bearings on the page, and figures of a run against integrals over its saved samples."""

import re
from pathlib import Path

import numpy as np
import pytest
from ruamel.yaml import YAML

import clearsweep
from clearsweep import report
from clearsweep.contracts.case import Capacity, Rolling
from clearsweep.mechanics.laws.bearings import equivalent_loads, load_powers, rating_life
from clearsweep.report.blocks.section import Picture, draw_svg
from clearsweep.report.one_case.joints import LOAD_SECTORS, LoadedElements, draw_bearing, draw_load_distribution

ROOT = Path(__file__).parents[1]
BEARING = Rolling("ball", 9, 9.525e-3, 46e-3, (0.52, 0.53), capacity=Capacity(19.5e3, 11.3e3))


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
    svg = draw_svg(Picture("bearing", "", "", lambda ax: draw_bearing(ax, BEARING, angles, loads)), "a")
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
        means = [np.mean(speed * loads**power) / np.mean(speed) for power in load_powers(BEARING)]
        life = rating_life(BEARING, equivalent_loads(BEARING, *means))
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
