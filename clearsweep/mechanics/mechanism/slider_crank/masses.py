"""The masses that take part in impacts in the open joints of a slider-crank.

1 / (n^T J M^-1 J^T n) along each gap, worked out for what the opening leaves: a force in a joint moves a floating rod
as a whole and turns it, moves the slider along its guide, and shifts the crank, whose angle is prescribed.  What comes
of a force as long as the gap g, g^T J M^-1 J^T g (m^2/kg), is called its yield.
"""

from ...compiled.choosing import where
from ...compiled.dual import as_type_of
from ...compiled.family import family, kernel, map_joints
from ...joint.places import after_number
from ..contract import Ideal, Open, impact_masses
from .pose import SliderCrank


@family
def _yields(mechanism, p, relative):
    """Return the yield (m^2/kg) of every open joint, by the opening."""


@kernel
def _mass(gap, given, place, shared):
    """Return the mass (kg) of a gap's yield; 0 where the gap is closed and so has no direction."""
    square = gap.x * gap.x + gap.y * gap.y
    return where(given > 0.0, square / where(given > 0.0, given, 1.0), as_type_of(0.0, given))


_masses = map_joints(_mass, after_number)


@impact_masses.member(SliderCrank)
def _impact_masses(mechanism, p, relative):
    return _masses(relative, _yields(mechanism, p, relative), 0, 0)


@kernel
def _across(p, gap):
    """Return the part of a gap across the rod, m."""
    return p.c2 * gap.y - p.s2 * gap.x


@kernel
def _rod_on_slider(links, p, gap, hung):
    """Return the yield at the crank pin of a rod hinged to the slider, a mass `hung` (kg) moving along."""
    length, arm = links.rod_length, links.rod_length - links.rod_center
    swing = links.rod_mass * arm + hung * length
    m11 = links.rod_inertia + links.rod_mass * arm * arm + hung * length * length
    m12 = swing * p.s2
    m22 = links.rod_mass + links.slider_mass + hung
    inverse = 1.0 / (m11 * m22 - m12 * m12)
    # m22 turned^2 + 2 m12 turned x + m11 x^2 with turned = length * _across(p, gap), so that little waits for the gap
    reach = m22 * length
    xx = m11 + length * (reach - 2.0 * swing) * (p.s2 * p.s2)
    xy = 2.0 * length * (swing - reach) * (p.c2 * p.s2)
    yy = length * reach * (p.c2 * p.c2)
    return (gap.x * (xx * gap.x + xy * gap.y) + yy * gap.y * gap.y) * inverse


@kernel
def _shifted(gap, mass):
    """Return the yield of a mass (kg) that moves freely."""
    return (gap.x * gap.x + gap.y * gap.y) * (1.0 / mass)


@kernel
def _turned(p, gap, arm, inertia):
    """Return the yield of the rod's turning, the gap `arm` (m) from a centre about which its inertia (kg m^2) is."""
    t = _across(p, gap)
    return t * t * (arm * arm / inertia)


@kernel
def _slid(links, gap):
    """Return the yield of the slider, which moves along x alone."""
    return gap.x * gap.x * (1.0 / links.slider_mass)


@kernel
def _ends_of_rod(links, p, b, c):
    """Return the yields of the gaps at both ends of a floating rod, without the crank's."""
    near, far = links.rod_center, links.rod_length - links.rod_center
    return (
        _shifted(b, links.rod_mass) + _turned(p, b, near, links.rod_inertia),
        _slid(links, c) + _shifted(c, links.rod_mass) + _turned(p, c, far, links.rod_inertia),
    )


@_yields.member(SliderCrank, sites=(Ideal, Ideal, Open))
def _at_slider(mechanism, p, relative):
    links, arm = mechanism.links, mechanism.links.rod_center
    inertia = links.rod_inertia + links.rod_mass * arm * arm
    return (_slid(links, relative[0]) + _turned(p, relative[0], links.rod_length, inertia),)


@_yields.member(SliderCrank, sites=(Ideal, Open, Ideal))
def _at_crank_pin(mechanism, p, relative):
    return (_rod_on_slider(mechanism.links, p, relative[0], 0.0),)


@_yields.member(SliderCrank, sites=(Open, Ideal, Ideal))
def _at_ground(mechanism, p, relative):
    return (_rod_on_slider(mechanism.links, p, relative[0], mechanism.links.crank_mass),)


@_yields.member(SliderCrank, sites=(Open, Open, Ideal))
def _crank_afloat(mechanism, p, relative):
    links, a, b = mechanism.links, relative[0], relative[1]
    return _shifted(a, links.crank_mass), _shifted(b, links.crank_mass) + _rod_on_slider(links, p, b, 0.0)


@_yields.member(SliderCrank, sites=(Open, Ideal, Open))
def _crank_and_rod_afloat(mechanism, p, relative):
    links, a, c = mechanism.links, relative[0], relative[1]
    both = links.crank_mass + links.rod_mass
    center = links.rod_mass * links.rod_center / both  # of both masses, from the crank pin
    inertia = links.rod_inertia + links.rod_mass * links.rod_center * (links.rod_center - center)
    return (
        _shifted(a, both) + _turned(p, a, center, inertia),
        _slid(links, c) + _shifted(c, both) + _turned(p, c, links.rod_length - center, inertia),
    )


@_yields.member(SliderCrank, sites=(Ideal, Open, Open))
def _rod_afloat(mechanism, p, relative):
    return _ends_of_rod(mechanism.links, p, relative[0], relative[1])


@_yields.member(SliderCrank, sites=(Open, Open, Open))
def _all_afloat(mechanism, p, relative):
    links, a, b = mechanism.links, relative[0], relative[1]
    at_crank, at_slider = _ends_of_rod(links, p, b, relative[2])
    return _shifted(a, links.crank_mass), _shifted(b, links.crank_mass) + at_crank, at_slider
