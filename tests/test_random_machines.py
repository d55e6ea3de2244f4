"""Random planar machines end with figures, or with an error that says what is wrong."""

import math
import re

import pytest
from random_machines import random_machine

import clearsweep

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]


@pytest.mark.parametrize("seed", range(12))
def test_a_random_machine_ends_well_or_says_why(seed):
    try:
        path = clearsweep.simulate(clearsweep.load_case(random_machine(seed)))
    except clearsweep.InputError as error:
        refusal = str(error)
    else:
        refusal = ""
    if refusal:
        assert re.search("closed|singular|turn on|without mass|was fitted|requires|cannot be seated", refusal), refusal
        return
    assert (path.status == "ok") or path.message
    numbers = {key: value for key, value in path.summary.items() if isinstance(value, int | float)}
    assert {key: value for key, value in numbers.items() if not math.isfinite(value)} == {}
