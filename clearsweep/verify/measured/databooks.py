"""Spread of film models: tables of bearings with two grooves compared with a plain bearing."""

import math

from .film_at_rest import settled
from .points import Row, reference

NAME = "Spread of film models"
TEXT = """Two databooks of bearings with two axial grooves, of 20 and 10 deg, and a plain bearing by `reynolds`
and `finite` under the same load number S. This is no test: grooves and the film's boundary differ. The differences
say what the choice of groove and cavity costs.

* Eccentricity: at most 0.033 of the clearance. Attitude: up to 15 deg for length / diameter 1, where the grooves cut
  more of the film; 3 deg and less beyond an eccentricity ratio of 0.7 at length / diameter 0.5.
* A designer who does not know the grooves of his bearing has its least film within 0.033 of the clearance, but the
  direction in which it rests only within 15 deg."""
LAWS = ("reynolds", "finite")
BOOKS = ("lund-thomsen", "someya")


def measure(*, quick: bool = False) -> list[Row]:
    """Return the rows of both databooks; `quick`: every sixth point."""
    rows = []
    for book in BOOKS:
        table = reference(NAME, book)
        points = list(dict.fromkeys(point for point, *_ in table.points))[:: 6 if quick else 1]
        for law in LAWS:
            values: dict[tuple[str, str], float] = {}
            for point in points:
                words = point.replace(",", "").split()  # L/D 0.5 S 1.656
                there = settled(law, float(words[1]), 0.5 / (math.pi * float(words[3])))
                values |= {(point, name): value for name, value in there.items()}
            rows += table.rows(values, law)
    return rows
