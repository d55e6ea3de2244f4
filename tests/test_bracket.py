"""The border of values within limits is found where it is sharp, and enclosed where it is not."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from clearsweep.searches.seeking import AGREEING_NEIGHBOURS, Border, expected_probe_count, scan_indices, search


def bisected(good, last):
    """Return the border where `good` says what is good, and all places that were looked at."""
    known = {}
    for _ in range(200):
        step = search(known, last)
        if step.border is not None:
            return step.border, known
        assert step.probes
        assert not known.keys() & set(step.probes)
        known |= {place: good(place) for place in step.probes}
    raise AssertionError("no end")


@given(st.integers(2, 12), st.data())
def test_a_sharp_border_is_found_exactly_with_few_looks(power, data):
    last = 2**power
    border = data.draw(st.integers(0, last - 1))
    answer, known = bisected(lambda place: place <= border, last)
    assert answer == Border(border, border + 1)
    assert len(known) <= 5 + power + 2 * AGREEING_NEIGHBOURS
    assert abs(len(known) - expected_probe_count(last)) <= 4


@pytest.mark.parametrize("last", [4, 64])
def test_all_good_and_all_bad_are_reported(last):
    assert bisected(lambda place: True, last)[0] == Border(last, None)
    answer, known = bisected(lambda place: False, last)
    assert answer == Border(None, 0)
    assert set(known) == set(scan_indices(last))


def test_what_is_good_again_beyond_a_bad_stretch_is_not_relied_upon():
    assert bisected(lambda place: place <= 20 or place >= 60, 64)[0] == Border(20, 21)


def test_good_places_that_begin_later_count():
    assert bisected(lambda place: 30 <= place <= 50, 64)[0] == Border(50, 51)


@given(st.integers(4, 9), st.integers(0, 2**32), st.floats(0.3, 0.7), st.integers(2, 30))
def test_in_noise_the_answer_encloses_the_border_and_what_agrees_with_it(power, seed, share, wide):
    import random

    last = 2**power
    chance = random.Random(seed)
    flips = {place: chance.random() < 0.5 for place in range(last + 1)}
    border = round(share * last)

    def good(place):
        return flips[place] if abs(place - border) < wide else place < border

    answer, known = bisected(good, last)
    if answer.last_good is None:
        return
    assert known[answer.last_good]
    assert all(
        known[place] for place in range(answer.last_good - AGREEING_NEIGHBOURS, answer.last_good) if place in known
    )
    if answer.first_bad is not None:
        assert answer.last_good < answer.first_bad
        assert not known[answer.first_bad]
        assert not any(
            known[place]
            for place in range(answer.first_bad + 1, answer.first_bad + 1 + AGREEING_NEIGHBOURS)
            if place in known
        )
    assert len(known) <= 5 + power + 2 * AGREEING_NEIGHBOURS + 6 * (power + 1)
