"""How lives are reported: intervals of the numerics whose ends differ, and what uncertain coefficients make of them."""

import math
import re

import numpy as np
import pytest

from clearsweep.answers.words import FIELD_BY_COLUMN, Lifetime, hours_text, interval_text, spread_text
from clearsweep.contracts.layout import Column, Layout
from clearsweep.sweeping.facts import LifeExtremes


def life(share, hours=85.5, **more):
    """Return a life of some hours whose interval is a share of it to either side."""
    return Lifetime(hours, 1000.0, 1000.0 / (1.0 + share), 1000.0 / (1.0 - share), **more)


def plainly(text):
    return text.replace("\u00a0", " ")


@pytest.mark.parametrize("share", [0.3, 0.02, 2e-3, 1.3e-4, 2.5e-5, 1e-7, 0.0])
def test_the_ends_of_an_interval_differ_or_it_is_reported_by_its_width(share):
    text = plainly(interval_text(life(share)))
    assert text.startswith("computing error alone, 95 %: ")
    text = text.removeprefix("95 %")
    numbers = [float(number) for number in re.findall(r"([\d.]+) h", text)]
    if numbers:
        low, high = numbers
        assert low < 85.5 < high
        assert (low, high) == pytest.approx((85.5 / (1.0 + share), 85.5 / (1.0 - share)), rel=0.5 * share)
    else:
        known = float(re.search(r"± (?:under )?([\d.]+) %", text)[1])
        assert "under" in text if 100.0 * share < 1e-3 else known == pytest.approx(100.0 * share, rel=0.05)


def test_a_life_without_an_upper_end_says_so():
    assert interval_text(Lifetime(85.5, 1000.0, 994.0, math.inf)).endswith(": at least 85.0 h")
    assert "at least" in interval_text(Lifetime(85.5, 1000.0, 994.0, math.nan))


def test_an_end_that_is_not_known_is_not_said_to_be_endless():
    low = spread_text(life(0.02, revolutions_low_with_wear_uncertainty=1000.0 / 3.0))
    high = spread_text(life(0.02, revolutions_high_with_wear_uncertainty=3000.0))
    assert plainly(low) == "With the uncertain wear coefficients: 28.5 h to unknown"
    assert plainly(high) == "With the uncertain wear coefficients: unknown to 256 h"


def test_a_coefficient_without_uncertainty_has_the_usual_one():
    known = life(0.02, revolutions_low_with_wear_uncertainty=400.0, revolutions_high_with_wear_uncertainty=3100.0)
    assert plainly(spread_text(known)) == "With the uncertain wear coefficients: 34.2 h to 265 h"
    assert plainly(spread_text(life(0.02))).endswith("coefficient: 28.5 to 8.55 h")


def test_the_extremes_are_the_shortest_and_the_longest_life():
    columns = tuple(Column(f"pin_{name}", "1", "") for name in [*FIELD_BY_COLUMN][:4])
    lives = LifeExtremes(
        Layout("planar", True, "", (), columns, (), life="pin"), {"of": "wear_depth_max", "limit": 2e-5}
    )
    hours = np.array([40.0, 85.5, np.nan, 20.0, 60.0])
    block = {"pin_life_hours": hours, "pin_life_revolutions": np.full(5, 1000.0)}
    block |= {"pin_life_low": np.full(5, 990.0), "pin_life_high": np.full(5, 1010.0)}
    lives.add(block, lambda place: {"case_id": f"{place}" * 16, "swept": {"drive.speed": place}})
    facts = lives.facts()
    assert [facts[end]["hours"] for end in ("shortest", "longest")] == [20.0, 85.5]
    assert (facts["unreached"], facts["shortest"]["text"]) == (1, "20.0 h")
    assert hours_text(life(0.02)) == "85.5 h"
    assert LifeExtremes(Layout("planar", True, "", (), columns, ()), {}).facts() is None
