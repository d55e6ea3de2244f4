"""The table of docs/published.md against the runs it names; the time steps of the programs that disagree.

`python tests/test_published.py` prints the rows of the table with the values of today and the largest differences.
"""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import published_machines as machines
import published_mechanisms as mechanisms
import pytest

pytestmark = pytest.mark.heavy

CASES = {
    "forced oscillator with friction": machines.den_hartog,
    "block on a belt": machines.belt,
    "free oscillator with friction": machines.siconos_oscillator,
    "mass on a linear floor": machines.exudyn_floors,
    "bouncing ball": machines.bouncing_ball,
    "ball between spring and roof": machines.compliant_ball,
    "stick that falls on its end": machines.impacting_stick,
    "chain of tapered balls": machines.chains,
    "rocking block": machines.housner,
    "ball on a vibrating table": machines.bouncing_on_a_table,
    "body that slides until it rolls": mechanisms.sliding_to_rolling,
    "friction circle": mechanisms.friction_circle,
    "squeeze film": mechanisms.squeeze,
    "squeeze film of finite length": mechanisms.squeeze_of_finite_length,
    "pendulum": mechanisms.adams_pendulum,
    "mass on a spring": mechanisms.adams_springs,
    "slider-crank under a torque": mechanisms.slider_crank_under_torque,
    "N-four-bar": mechanisms.n_four_bar,
    "block in its guide": mechanisms.block_in_guide,
}
PAGE = (Path(__file__).parents[1] / "docs/published.md").read_text(encoding="utf-8")


class Claim(NamedTuple):
    """A row of the page: of several values it prints the last, and the tolerance is that of all."""

    machine: str
    source: str
    quantity: str
    reference: float
    computed: float
    tolerance: float


def table(heading, columns):
    """Return the rows of the first table below a heading of the page that has that many columns."""
    rows = re.findall(rf"^\|{' ([^|]+) [|]' * columns}$", PAGE.split(f"## {heading}\n")[1].split("\n## ")[0], re.M)
    return rows[2:]


CLAIMS = [Claim(*row[:3], *map(float, row[3:])) for row in table("Machines with a known solution", 6)]


def test_every_machine_of_the_table_is_run():
    assert {claim.machine for claim in CLAIMS} == set(CASES)


@pytest.mark.few("friction circle", "mass on a spring", "pendulum", "squeeze film")
@pytest.mark.parametrize("name", CASES)
def test_a_machine_moves_as_its_reference_and_as_the_page_says(name):
    claims, values = [claim for claim in CLAIMS if claim.machine == name], CASES[name]()
    assert [claim.quantity for claim in claims] == list(values)
    for claim in claims:
        reference, computed = map(np.atleast_1d, values[claim.quantity])
        assert computed == pytest.approx(reference, abs=claim.tolerance, rel=0.0), claim.quantity
        printed = (claim.reference, claim.computed)
        assert printed == pytest.approx((reference[-1], computed[-1]), abs=claim.tolerance, rel=1e-6)


# ---------------------------------------------------------------------------------------------- steps of other programs


def errors(column):
    """Return step (s) -> error of a time stepper, as the page prints them; those of the programs come first."""
    rows = table("Where a program differs by its step", 4)
    return {float(row[0].split()[0]): float(row[column]) for row in rows if row[column] != "-"}


def test_siconos_oscillator_is_off_by_its_step():
    printed, times = machines.PRINTED["siconos_oscillator"]["x"], machines.PRINTED["siconos_oscillator"]["t"]
    assert machines.siconos_oscillator_steps(1e-2, times) == pytest.approx(printed, abs=1e-11)
    exact = machines.coulomb_oscillator(np.array(times))
    for step, error in errors(1).items():
        off = np.max(np.abs(machines.siconos_oscillator_steps(step, times) - exact))
        assert off == pytest.approx(error, rel=0.05), step


def test_siconos_ball_on_a_spring_is_off_by_its_step():
    printed, times = machines.PRINTED["siconos_ball"]["x"], np.array(machines.PRINTED["siconos_ball"]["t"])
    assert machines.siconos_ball_steps(5e-4, times) == pytest.approx(printed, abs=1e-11)
    exact = machines.ball_on_a_spring(times)
    for step, error in errors(2).items():
        off = np.max(np.abs(machines.siconos_ball_steps(step, times) - exact))
        assert off == pytest.approx(error, rel=0.05), step


def test_siconos_stick_follows_newton_s_law_with_the_friction_of_the_last_slip():
    """Its printed figures, at a step of 0.1 ms, are -0.50687 m/s and 3.21207 rad/s."""
    newton, exact = (machines.stick_after_impacts(law) for law in (machines.newton_rebound, machines.slide_and_rebound))
    assert newton["vx"] == pytest.approx(-0.50687, abs=2e-5)
    assert newton["rate"] == pytest.approx(3.21207, abs=6e-3)
    assert exact["vx"] - newton["vx"] == pytest.approx(6.4e-3, abs=1e-4)
    for law, gain in ((machines.newton_rebound, 7.08e-4), (machines.slide_and_rebound, -7.39e-4)):
        works = []

        def watched(u, w, coupling, friction, law=law, works=works):
            impulse = np.array(law(u, w, coupling, friction))
            works.append(impulse @ (np.array([u, w]) + 0.5 * coupling @ impulse))
            return impulse

        machines.stick_after_impacts(watched)
        assert works[0] == pytest.approx(gain, abs=1e-6)  # J: friction takes energy, and Newton's law adds more


@pytest.mark.slow
def test_moreau_s_rule_converges_to_the_motion_of_the_block():
    """The program's own value at 0.1 ms is 1.49164 revolutions; its scheme errs to the other side of ours."""
    (computed,) = [claim.computed for claim in CLAIMS if claim.quantity.startswith("revolutions of the crank")]
    for step, error in errors(3).items():
        off = abs(mechanisms.moreau_guide(step, [0.1])[0, 0] - computed)
        assert off == pytest.approx(error, rel=0.05), step


def print_rows():
    """Print the rows of today, with tolerances of the page where it has them."""
    known = {(claim.machine, claim.quantity): claim for claim in CLAIMS}
    for name, case in CASES.items():
        for quantity, pair in case().items():
            reference, computed = map(np.atleast_1d, pair)
            off = np.max(np.abs(computed - reference))
            claim = known.get((name, quantity))
            ends = (claim.source, f"{claim.tolerance:g}") if claim else ("", "")
            print(
                f"| {name} | {ends[0]} | {quantity} | {reference[-1]:.7g} | {computed[-1]:.7g} | {ends[1]} | {off:.1e}"
            )


if __name__ == "__main__":
    print_rows()
