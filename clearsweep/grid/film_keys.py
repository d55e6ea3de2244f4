"""The quantities that describe the film of oil in a joint."""

from ..contracts.catalogue import Field

DEFAULT_LAW = "reynolds"
FILM = (
    Field(
        "limit",
        "1",
        "eccentricity ratio up to which the film's formula is valid; beyond, it is evaluated there",
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
    Field("density", "kg/m^3", "of the oil"),
)
TEMPERATURE = Field("temperature", "K", "of the oil; needed by viscosities at two temperatures", optional=True)
THERMAL = (
    Field("conductance", "W/K", "heat that is led away per temperature"),
    Field("ambient", "K", "temperature of what it is led to"),
)
TRANSITION = (
    Field(
        "from",
        "m",
        "eccentricity less clearance at which the dry contact begins to bear",
        low_open=False,
        default=0.0,
    ),
    Field("width", "m", "over which the load passes from the film to the dry contact", default=2e-6),
)
