"""Keys of what is observed of the vibration of a mechanism, and the places in its compiled form."""

import math
from collections.abc import Iterable

from ...contracts.case import Case
from ...contracts.catalogue import CHOICE, CONDITION, GROUND, NUMERICS, Choice, Field, Keys, Mechanism, Outline, ranged
from ...contracts.layout import is_along_output
from ...contracts.machine import Body
from ...contracts.vibration import FRAME, MAX_ORDERS, NO_SEVERITY, SEVERITIES, Location, PlaceOutline
from .loads import CENTER_TEXT

_PATH = "vibration"
_ORDERS = Field(
    "orders",
    "1",
    "number of orders of the crank speed whose forces on the frame are columns; default: none",
    1,
    MAX_ORDERS,
    low_open=False,
    high_open=False,
    optional=True,
    integer=True,
)
_BAND = tuple(
    Field(str(k), "rad/s", f"{end} frequency of the band", default=2.0 * math.pi * frequency)
    for k, (end, frequency) in enumerate((("lowest", 10.0), ("highest", 1000.0)))
)
_ZONES = tuple(Field(str(k), "m/s", f"largest velocity (rms) in zone {zone}") for k, zone in enumerate("ABC"))
_ABOUT = tuple(
    ranged(str(k), "m", f"{axis} coordinate in the fixed frame", "(-inf, inf)") for k, axis in enumerate("xy")
)
_POINT = tuple(
    ranged(str(k), "m", f"{axis} coordinate in the frame of the body", "(-inf, inf)") for k, axis in enumerate("xy")
)
_MASS = Field("mass", "kg", "mass of the frame; without it the frame does not move", optional=True, role=CHOICE)
_STIFFNESS = tuple(
    ranged(str(k), "N/m", f"stiffness of the mount along {axis}", "[0, inf)") for k, axis in enumerate("xy")
)
_DAMPING = ranged("damping", "1", "damping ratio of frame and mount", "[0, inf)", default=0.0)


def vibration_keys(outline: Outline, bodies: Iterable[str]) -> tuple[Keys, ...]:
    """Return the sections of `vibration` for a mechanism of these `bodies`."""
    moving_bodies = tuple(name for name in bodies if name != GROUND)
    severity = Choice(
        "severity",
        tuple(SEVERITIES),
        "standard, group and support that the zones A to D are those of; or write `zones`",
        NO_SEVERITY,
    )
    sections = [
        Keys(
            _PATH,
            "force and moment on the frame, and the vibration of places. Without this section, none is computed",
            (_ORDERS,),
            "optional",
            (severity,),
            role=NUMERICS,
        ),
        Keys(f"{_PATH}.band", "band of frequencies of the velocities", _BAND, "implied", role=CONDITION),
        Keys(f"{_PATH}.zones", "upper bounds of the zones A, B and C", _ZONES, "optional", role=CONDITION),
        Keys(f"{_PATH}.at", "places whose vibration is observed, by name", need="implied"),
    ]
    if outline.vibration is None:
        return tuple(sections)
    for place in outline.vibration.places:
        sections += _frame_keys() if place.name == FRAME else _place_keys(place, moving_bodies)
    return tuple(sections)


def _frame_keys() -> tuple[Keys, ...]:
    path = f"{_PATH}.at.{FRAME}"
    text = "the frame of the machine, as one mass on its mount"
    return (
        Keys(path, text, (_MASS,), "optional", role=CHOICE),
        Keys(f"{path}.about", "point of the moment; default: the crank's pivot", _ABOUT, "optional", role=CHOICE),
        Keys(f"{path}.mount", "mount of the frame", (_DAMPING,), "optional", role=CHOICE),
        Keys(f"{path}.mount.stiffness", "stiffness along x and y", _STIFFNESS, role=CHOICE),
    )


def _place_keys(place: PlaceOutline, bodies: tuple[str, ...]) -> tuple[Keys, ...]:
    path = f"{_PATH}.at.{place.name}"
    body_key = Choice("body", bodies, "body of the place", place.name if place.name in bodies else None)
    text = f"place on the body; default: the pin of a slider, else its {CENTER_TEXT}"
    return (
        Keys(path, "a place", need="optional", words=(body_key,)),
        Keys(f"{path}.point", text, _POINT, "optional", role=CHOICE),
    )


def point_of(place: Location, body: Body) -> tuple[float, float]:
    """Return the point (m) of a place in the frame of its body; the pin of a slider is its centre of mass."""
    return place.point or body.center


def axes_of(place: Location, mechanism: Mechanism) -> int:
    """Return in how many directions a place of a mechanism is observed: along x and y, of its output only along x."""
    return 1 if is_along_output(mechanism, PlaceOutline(place.name, body=place.body, is_whole=not place.point)) else 2


def unreacted_loads(case: Case) -> tuple[int, ...]:
    """Return the numbers of the loads that the frame does not react."""
    return tuple(i for i, load in enumerate(case.loads) if load.values.get("reacted") is False)
