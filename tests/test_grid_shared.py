"""Claims about what the cases of a grid share: it is made once, and no case is reminded of another's values."""

import json
import pickle

from grid_fake import CONFIGS, CONTACT, TEXT, load

from clearsweep.grid.resolve import case_of


def test_what_does_not_vary_is_made_once_and_what_varies_for_every_case(at):
    swept = at(TEXT + f"sweep:\n  {CONTACT}.restitution: [0.5, 0.9]\n")
    pair = load(CONFIGS / "impact_pair.yaml").resolved() | {"sweep": {"mechanism.masses.1": [0.1, 0.2]}}
    for cases in (swept, load(pair, {"joints.pair.contact.restitution": 0.5})):
        made = [cases.case(k) for k in (0, 1, 0)]
        assert made[0] == made[2] != made[1]
        assert made[0].simulate is made[1].simulate
        for k, case in enumerate(made[:2]):
            assert case == case_of(json.loads(json.dumps(cases.written_case(k))), case.outline)
            assert case == pickle.loads(pickle.dumps(cases)).case(k)
    first, second = swept.case(0).joints[0], swept.case(1).joints[0]
    assert first.wear is second.wear
    assert (first.contact.values["restitution"], second.contact.values["restitution"]) == (0.5, 0.9)
