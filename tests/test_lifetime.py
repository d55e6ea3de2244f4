"""How lives are reported: intervals of the numerics whose ends differ, and what uncertain coefficients make of them."""

import math
import re

import numpy as np
import pytest

from clearsweep.answers.lifetime import (
    FIELD_BY_COLUMN,
    Lifetime,
    faster_wear_sentences,
    hours_text,
    interval_sentences,
    remarks,
    smoothing_sentences,
)
from clearsweep.contracts.layout import Column, Layout
from clearsweep.sweeping.lives import LifeExtremes, life_lines


def life(share, hours=85.5, **more):
    """Return a life of some hours whose interval is a share of it to either side."""
    return Lifetime(hours, 1000.0, 1000.0 / (1.0 + share), 1000.0 / (1.0 - share), **more)


def plainly(text):
    return text.replace("\u00a0", " ")


def sentences(life):
    """Return what is said on the interval of a life, with ordinary spaces."""
    return [plainly(sentence) for sentence in interval_sentences(life)]


@pytest.mark.parametrize("share", [0.3, 0.02, 2e-3, 1.3e-4, 2.5e-5, 1e-7, 0.0])
def test_the_ends_of_an_interval_differ_or_it_is_reported_by_its_width(share):
    (text,) = sentences(life(share))
    assert text.startswith("95 % interval of the numerics alone: ")
    numbers = [float(number) for number in re.findall(r"([\d.]+) h", text)]
    if numbers:
        low, high = numbers
        assert low < 85.5 < high
        assert (low, high) == pytest.approx((85.5 / (1.0 + share), 85.5 / (1.0 - share)), rel=0.5 * share)
    else:
        known = float(re.search(r"± (?:under )?([\d.]+) %", text)[1])
        assert "under" in text if 100.0 * share < 1e-3 else known == pytest.approx(100.0 * share, rel=0.05)


def test_a_life_without_an_upper_end_says_so():
    assert sentences(Lifetime(85.5, 1000.0, 994.0, math.inf))[0].endswith(": at least 85.0 h.")
    assert "at least" in sentences(Lifetime(85.5, 1000.0, 994.0, math.nan))[0]


def test_an_end_that_is_not_known_is_not_said_to_be_endless():
    low = sentences(life(0.02, revolutions_low_with_wear_uncertainty=1000.0 / 3.0))[-1]
    high = sentences(life(0.02, revolutions_high_with_wear_uncertainty=3000.0))[-1]
    assert low == "With the uncertain wear coefficients: from 28.5 h, other end unknown."
    assert high == "With the uncertain wear coefficients: to 256 h, other end unknown."


def test_an_uncertain_coefficient_is_reported_next_to_the_numerics():
    known = life(
        0.02, revolutions_low_with_wear_uncertainty=1000.0 / 3.0, revolutions_high_with_wear_uncertainty=3100.0
    )
    assert faster_wear_sentences(known) == []  # its uncertainty is known
    text = sentences(known)[-1]
    assert text == "With the uncertain wear coefficients: 28.5 h to 265 h."
    assert "uncertain" not in " ".join(sentences(life(0.02)))


def test_wide_smoothing_is_reported_once_for_all_lives():
    widths = [math.radians(angle) for angle in (3.0, 17.9, 11.0)]
    assert smoothing_sentences([*widths, math.nan]) == [
        "Not included: the effect of smoothing the worn shapes over 11 to 18 deg, which is unknown: take the hours as "
        "an estimate."
    ]
    assert " over 11 deg, which" in smoothing_sentences(widths[2:])[0]
    assert smoothing_sentences(widths[:1]) == []


def test_no_sentence_on_a_life_has_more_than_25_words():
    known = life(
        0.02,
        revolutions_low_with_wear_uncertainty=1000.0 / 3.0,
        revolutions_high_with_wear_uncertainty=3100.0,
        smoothing_width=0.3,
    )
    all_sentences = [*remarks(known), *remarks(life(0.02)), *smoothing_sentences([known.smoothing_width])]
    assert len(all_sentences) == 7
    assert max(len(sentence.split()) for sentence in all_sentences) <= 25
    assert hours_text(known) == "85.5 h"


def test_the_closing_lines_name_the_shortest_and_the_longest_life():
    columns = tuple(Column(f"pin_{name}", "1", "") for name in [*[*FIELD_BY_COLUMN][:4], "wear_smoothing"])
    lives = LifeExtremes(
        Layout("planar", True, "", (), columns, (), life="pin"), {"of": "wear_depth_max", "limit": 2e-5}
    )
    hours = np.array([40.0, 85.5, np.nan, 20.0, 60.0])
    block = {"pin_life_hours": hours, "pin_life_revolutions": np.full(5, 1000.0)}
    block |= {"pin_wear_smoothing": np.radians([9.0, 8.0, 90.0, 7.0, 6.0])}  # the third has no life
    block |= {"pin_life_low": np.full(5, 990.0), "pin_life_high": np.full(5, 1010.0)}
    lives.add(block, lambda place: {"case_id": f"{place}" * 16, "swept": {"drive.speed": place}})
    lines = [plainly(line) for line in life_lines(lives.facts(), lambda point: f"speed {point['drive.speed']}")]
    assert lines[1] == "Answer"
    assert lines[2] == (
        "  Shortest life of joint pin, until wear of one body reaches 20.0 \u00b5m: 20.0 h at speed 3 (case 33333333). "
        "This is 1000 revolutions. "
        "With wear 3 to 10 times as fast, the usual uncertainty of its coefficient, it is about 6.67 to 2.00 h. "
        "95 % interval of the numerics alone: 19.8 h to 20.2 h."
    )
    assert lines[3].startswith("  Longest life: 85.5 h")
    assert "over 6 to 9 deg" in lines[4]
    assert lines[5] == "  1 case did not reach the limit."
    assert life_lines(LifeExtremes(Layout("planar", True, "", (), columns, ()), {}).facts(), str) == []
