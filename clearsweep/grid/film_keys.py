"""The keys of an oil film in a joint."""

from ..contracts.catalogue import Field

DEFAULT_LAW = "reynolds"
FILM = (
    Field(
        "limit",
        "1",
        "largest eccentricity ratio of the film's formula; beyond, it is evaluated there",
        0.0,
        0.999,
        high_open=False,
        default=0.99,
    ),
)
VISCOSITY = Field("viscosity", "Pa*s", "dynamic viscosity of the oil; or kinematic ones at two temperatures")
OIL = (
    Field("at_40C", "m^2/s", "kinematic viscosity of the oil at 40 degC", 2e-6),
    Field("at_100C", "m^2/s", "kinematic viscosity at 100 degC, lower", 2e-6),
    Field("density", "kg/m^3", "density of the oil"),
)
TEMPERATURE = Field("temperature", "K", "temperature of the oil; needed for two viscosities", optional=True)
THERMAL = (
    Field("conductance", "W/K", "heat flow per temperature difference"),
    Field("ambient", "K", "temperature of the surroundings"),
)
TRANSITION = (
    Field(
        "from",
        "m",
        "eccentricity minus clearance at which the dry contact begins to carry load",
        low_open=False,
        default=0.0,
    ),
    Field("width", "m", "range over which the load passes from the film to the dry contact", default=2e-6),
)
