"""The mechanisms a user can name, described as the laws are."""

from ...catalogue import Field, Law

MECHANISMS = (
    Law(
        "mechanism",
        "slider-crank",
        "crank at constant speed, rod, slider; clearance in any of its three revolute joints",
        "Newton-Euler in minimal coordinates; ideal: x = r cos(t) + sqrt(l^2 - r^2 sin^2(t))",
        "Newton-Euler; coordinates by which joints are open, see mechanics/mechanism",
        (
            Field(
                "crank",
                "1",
                "length (m), mass (kg), inertia about the centre of mass (kg m^2), center (m from the pivot)",
            ),
            Field("rod", "1", "the same; center from the crank pin"),
            Field("slider", "1", "mass (kg)"),
            Field("gravity", "m/s^2", "along -y", low=float("-inf"), default=0.0),
            Field("drive.speed", "rad/s", "of the crank"),
        ),
        notes="The rod is longer than the crank; the slider moves along the x axis through the crank's pivot.",
    ),
    Law(
        "mechanism",
        "impact-pair",
        "two bodies on a line with one gap: what a contact law gives back, without anything else",
        "m x'' = -F, m = m1 m2 / (m1 + m2); gap 2 x clearance in all",
        "Newton; a free impact has a closed form for most laws",
        (
            Field("masses.0", "kg", "mass of the first body"),
            Field("masses.1", "kg", "mass of the second body"),
            Field("speed", "m/s", "at which they approach each other"),
        ),
    ),
)
