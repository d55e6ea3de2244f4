"""Laws of one's own: what a decorator records, and what it refuses."""

import ctypes
import linecache

import pytest

from clearsweep import laws
from clearsweep.language.errors import InputError


def hunt_crossley(penetration, rate, onset_rate, p):
    return p.stiffness * penetration**p.exponent + p.damper * penetration**p.exponent * rate


def test_a_decorator_returns_the_function_and_records_it_only_while_collecting():
    with laws.collecting() as records:
        assert laws.contact("my-law", damper="N*s/m^2.5")(hunt_crossley) is hunt_crossley
    assert laws.contact("later", damper="N*s/m^2.5")(hunt_crossley) is hunt_crossley
    (law,) = records
    assert (law.kind, law.name, law.function) == ("contact", "my-law", hunt_crossley)
    assert [(field.name, field.unit) for field in law.keys] == [("damper", "N*s/m^2.5")]
    assert law.file == __file__
    assert "my-law" in linecache.getline(__file__, law.line)


@pytest.mark.parametrize(
    ("described", "message"),
    [
        ({"damper": "N*mm"}, "'N*mm' is not the SI unit; laws compute in SI: write 'N*m'"),
        ({"damper": "N*sm"}, "unknown unit 'sm'"),
        ({"law": "N"}, "'law' cannot be a key"),
        ({"damper": laws.key("N", above=1.0, default="0.5 N")}, "its default is 0.5 N; allowed: above 1"),
        ({"damper": laws.key("N", above=1.0, at_least=2.0)}, "two lower"),
        ({"dampr": "N"}, "uses p.damper, which is no key of this law; did you mean 'dampr'?"),
        ({"damper": "N", "kinks": ["dampr"]}, "'dampr' is neither a number nor a key; did you mean 'damper'?"),
        ({"damper": "N", "kinks": ["slip=0"]}, "has kinks over penetration or rate"),
        ({"damper": "N", "states": 1}, "of a friction law"),
    ],
)
def test_a_decorator_refuses_what_no_grid_could_use(described, message):
    with pytest.raises(InputError, match=r"test_own_laws.py:[0-9]+: laws.contact 'my-law'") as caught:
        laws.contact("my-law", **described)(hunt_crossley)
    assert message in str(caught.value)


def test_a_function_of_other_arguments_is_refused_with_those_that_are_expected():
    with pytest.raises(InputError, match=r"takes \(a, b\); expected \(normal, slip, state, p\)"):
        laws.friction("my-law", states=1)(lambda a, b: a)


def test_two_laws_of_one_name_are_refused_with_the_line_of_the_first():
    with laws.collecting():
        record = laws.elastic("spring", k="N/m")
        record(lambda penetration, p: p.k * penetration)
        with pytest.raises(InputError, match="is recorded already in line"):
            record(lambda penetration, p: p.k * penetration)


def test_a_function_of_c_has_an_address_and_no_body():
    with laws.collecting() as records:
        laws.elastic("sine")(ctypes.CDLL(None).sin)
    assert records[0].body is None
    assert laws.address_of(records[0].function) > 0
