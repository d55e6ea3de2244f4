"""A damper of given size in place of the restitution: F = K pen^n + D pen^n rate (Hunt & Crossley 1975)."""

import math

import numpy as np
import pytest
from ruamel.yaml import YAML
from scipy.special import lambertw

import clearsweep
from clearsweep.language.errors import InputError

STIFFNESS = 6.61e10  # N/m^1.5


def impact_grid(speed: float, **contact) -> dict:
    """Return a pair of bodies that collide at `speed` (m/s), with a contact of that stiffness."""
    section = {"law": "hunt-crossley", "stiffness": STIFFNESS, "exponent": 1.5} | contact
    return {
        "name": "pair",
        "mechanism": {"type": "impact-pair", "masses": [0.2, 0.2], "speed": speed},
        "joints": {"pair": {"clearance": 1e-3, "contact": section}},
        "simulate": {"impacts": 1, "tolerance": 1e-11},
        "save": {"orbits": "none"},
    }


def closed_form(chi: float) -> float:
    """Return the restitution (1 + W(-(1 + chi) exp(-(1 + chi)))) / chi of the phase curve."""
    return float(1.0 + lambertw(-(1.0 + chi) * math.exp(-(1.0 + chi))).real) / chi


@pytest.mark.parametrize(("chi", "known"), [(0.1, 0.937475580), (0.5, 0.748434932), (3.0, None)])
def test_the_restitution_is_that_of_the_closed_form(chi, known):
    """chi = D v0 / K; two values are from outside."""
    restitution = closed_form(chi)
    assert known is None or restitution == pytest.approx(known, abs=5e-10)
    for speed in (0.2, 1.0):
        scene = clearsweep.load_case(impact_grid(speed, damping=chi * STIFFNESS / speed))
        assert clearsweep.simulate(scene).summary["pair_restitution"] == pytest.approx(restitution, rel=1e-8)


def test_damping_and_damping_factor_are_the_same_motion():
    """They differ by the stiffness, which is a power of two here."""
    stiffness = 2.0**36
    summaries = [
        clearsweep.simulate(clearsweep.load_case(impact_grid(0.7, stiffness=stiffness, **damper))).summary
        for damper in ({"damping": 0.5 * stiffness}, {"damping_factor": 0.5})
    ]
    assert summaries[0]["pair_restitution"] == summaries[1]["pair_restitution"]


def test_the_restitution_at_two_speeds_is_derived():
    """At 0.1 and 1 m/s, for any exponent."""
    from clearsweep.simulation import derived

    case = clearsweep.load_case(impact_grid(1.0, exponent=1.2, damping=2.0 * STIFFNESS)).case
    values = derived(case)
    for speed in (0.1, 1.0):
        value, unit = values[f"joints.pair.contact.restitution at {speed:g} m/s"]
        assert (value, unit) == (pytest.approx(closed_form(2.0 * speed), rel=1e-12), "1")


def test_the_damper_can_be_swept_in_its_unit(tmp_path):
    """More damping leaves less of the speed."""
    grid = impact_grid(1.0, damping=1e9) | {
        "sweep": {"joints.pair.contact.damping": ["1e9 N*s/m^2.5", "1e10 N*s/m^2.5", "1e11 N*s/m^2.5"]}
    }
    clearsweep.sweep(grid, out=tmp_path / "run", executor="serial")
    summary = clearsweep.open(tmp_path / "run").summary.sort_values("joints.pair.contact.damping")
    restitutions = summary["pair_restitution"].tolist()
    expected = [closed_form(damping / STIFFNESS) for damping in (1e9, 1e10, 1e11)]
    assert restitutions == pytest.approx(expected, rel=1e-7)


def test_a_swept_key_without_its_path_is_told_with_its_laws(tmp_path):
    """`sweep: {damping: ...}` names the path and the laws that take it."""
    grid = tmp_path / "grid.yaml"
    with grid.open("w", encoding="utf-8") as stream:
        YAML(typ="safe").dump(impact_grid(1.0, damping=1e9) | {"sweep": {"damping": [1e9, 2e9]}}, stream)
    with pytest.raises(InputError, match=r"joints\.pair\.contact\.damping \(law .*hunt-crossley"):
        clearsweep.sweep(grid, out=tmp_path / "run", executor="serial")


@pytest.mark.parametrize("tolerance", [1e-10, 1e-6, 1e-3])
def test_an_overdamped_contact_that_pulls_ends_with_restitution_0(tolerance):
    # x = v / (a - b) (exp(-b t) - exp(-a t)), a and b > 0 the roots of m s^2 - c s + k: never 0 again
    contact = {"law": "kelvin-voigt-unclipped", "stiffness": 1e6, "damping": 1500.0}
    path = clearsweep.simulate(
        clearsweep.load_case(
            {
                "mechanism": {"type": "impact-pair", "masses": [1.0, 1.0], "speed": 1.0},
                "joints": {"pair": {"clearance": 1e-3, "contact": contact}},
                "simulate": {"impacts": 1, "tolerance": tolerance},
            }
        )
    )
    assert path.status == "ok", path.message
    assert path.summary["pair_restitution"] == 0.0
    a, b = np.roots([0.5, -1500.0, 1e6]).real
    depth = 1.0 / (a - b) * ((b / a) ** (b / (a - b)) - (b / a) ** (a / (a - b)))
    assert path.summary["pair_penetration_max"] == pytest.approx(depth, rel=10.0 * tolerance + 1e-9)
