"""What a grid says about the vibration of its machine: places, band of frequencies and zones of severity."""

from collections.abc import Mapping
from typing import NamedTuple

FRAME = "frame"  # the place in `vibration.at` that is the frame of the machine
MAX_ORDERS = 100  # that may be columns
MAX_BAND_ORDERS = 2500  # upper end of the band over the crank speed
MAX_LINES = 1 << 14  # of a spectrum
MIN_TURNS = 3  # whole revolutions in the window
NO_SEVERITY = "none"
IDEAL = "_ideal"  # suffix of the columns of the ideal machine
BEARING_PARTS = ("cage", "element", "inner", "outer")  # of a rolling bearing: what passes or turns at a frequency
#: Figures of a place, whose columns begin with its name.
PLACE_FIGURES = (
    "velocity_rms",
    f"velocity_rms{IDEAL}",
    "velocity_x_rms",
    "velocity_y_rms",
    "zone",
    "kurtosis",
    "crest",
    "skewness",
    "band_energy",
    *(f"{part}_velocity" for part in BEARING_PARTS),
)

UNCHECKED_STANDARD = "ISO 20816-8"  # whose bounds are from memory, compared with no published text
#: Name of a standard, with its group and support -> upper bounds (m/s, rms) of zones A, B and C.  ISO 20816-3:2022,
#: tables A.1 and A.2, has the machine's group (1: above 300 kW, 2: up to 300 kW) and its support; its bounds are those
#: of ISO 10816-3:2009 and were compared with public reprints of it and of GB/T 6075.3-2011, which is equal.  ISO
#: 20816-8:2018 has the part of a reciprocating compressor.
SEVERITIES: Mapping[str, tuple[float, ...]] = {NO_SEVERITY: ()} | {
    f"ISO 20816-{name}": tuple(1e-3 * bound for bound in bounds)
    for name, bounds in {
        "3 group 1 rigid": (2.3, 4.5, 7.1),
        "3 group 1 flexible": (3.5, 7.1, 11.0),
        "3 group 2 rigid": (1.4, 2.8, 4.5),
        "3 group 2 flexible": (2.3, 4.5, 7.1),
        "8 foundation": (2.0, 3.0, 4.5),
        "8 frame": (5.3, 8.0, 12.0),
        "8 cylinder lateral": (8.7, 13.0, 19.5),
        "8 cylinder rod": (10.7, 16.0, 24.0),
        "8 damper": (12.7, 19.0, 28.5),
        "8 piping": (12.7, 19.0, 28.5),
    }.items()
}
ZONES = "ABCD"


def zone_of(velocity: float, bounds: tuple[float, ...]) -> str:
    """Return the zone of a velocity (m/s, rms); a velocity at a bound (m/s) belongs to the better zone."""
    return ZONES[sum(velocity > bound for bound in bounds)]


class PlaceOutline(NamedTuple):
    """A place whose vibration is observed."""

    name: str
    moves: bool = True  # it has a velocity; a frame without mass has none
    body: str = ""  # '': that of its name; of the frame, the joint with whose housing it moves, '' without
    is_whole: bool = True  # no point of the body is given

    @property
    def column(self) -> str:
        """Return the prefix of its columns."""
        return self.name.replace("-", "_")


class VibrationOutline(NamedTuple):
    """The parts of `vibration` that determine keys and columns."""

    places: tuple[PlaceOutline, ...] = ()
    orders: int = 0  # orders of the force on the frame that are columns
    has_zones: bool = False


class Mount(NamedTuple):
    """The mount of a frame, along x and y."""

    stiffness: tuple[float, float]  # N/m
    damping: float  # 1, ratio


class Frame(NamedTuple):
    """The frame of a machine, as one mass on its mount."""

    about: tuple[float, float] | None = None  # m, point of its moment; None: the crank's pivot
    mass: float | None = None  # kg; None: it does not move
    mount: Mount | None = None  # None: it is free


class Location(NamedTuple):
    """A point of a body whose vibration is observed."""

    name: str
    body: str  # of the frame of a machine with mounts, the housing
    point: tuple[float, float] | None  # m, in the frame of the body; None: the pin of a slider, else the centre of mass


class Vibration(NamedTuple):
    """What is observed of the vibration of a machine."""

    band: tuple[float, float]  # rad/s
    zones: tuple[float, ...] = ()  # m/s, upper bounds of zones A, B and C
    frame: Frame = Frame()
    places: tuple[Location, ...] = ()
