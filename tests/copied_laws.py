"""Laws of the package, written as laws of one's own: they must give the same bits."""

import math

from clearsweep import laws


@laws.contact("my-law", damper="N*s/m^2.5", doc="F = K d^n + D d^n d' (Hunt & Crossley 1975)")
def my_law(penetration, rate, onset_rate, p):
    return p.stiffness * penetration**p.exponent + p.damper * penetration**p.exponent * rate


@laws.contact("my-flores", e="1", doc="Flores")
def flores(penetration, rate, onset_rate, p):
    chi = 1.6 * (1.0 - p.e) / p.e
    force = p.elastic_force(penetration)
    return force + force * (chi / onset_rate) * rate


@laws.friction("my-tanh", mu="1", v="m/s")
def tanh(normal, slip, p):
    return p.mu * normal * math.tanh(slip / p.v)


def g(p, slip):
    decay = math.exp(-(abs(slip / p.vs) ** p.shape))
    return p.mu + (p.mus - p.mu) * decay


def bend_rate(p, z, slip):
    return slip - p.s0 * abs(slip) * z / g(p, slip)


@laws.friction(
    "my-lugre",
    mu="1",
    mus="1",
    vs="m/s",
    shape=laws.key("1", default=2.0),
    visc=laws.key("s/m", at_least=0, default=0),
    s0="1/m",
    s1="s/m",
    vd="m/s",
    states=1,
    kinks=[0.0],
)
def lugre(normal, slip, z, p):
    decay = math.exp(-((slip / p.vd) ** 2))
    coefficient = p.s0 * z
    rate = bend_rate(p, z, slip)
    coefficient += p.s1 * decay * rate
    return -normal * (coefficient + p.visc * slip), rate


@laws.wear("my-archard", k="m^2/N")
def archard(pressure, slip, p):
    return p.k * (pressure * slip)


def arc_from(ratio, sine, cosine):
    norm = math.sqrt(sine * sine + cosine * cosine)
    sine, cosine = sine / norm, cosine / norm
    one_minus_square = 1.0 - ratio * ratio
    root = math.sqrt(one_minus_square)
    inverse_thickness = (math.pi + 2.0 * math.atan(ratio * sine / root)) / root
    return cosine, sine, 1.0 - (ratio * cosine) ** 2, one_minus_square, inverse_thickness


@laws.film("my-short", doc="Ocvirk")
def short(e_x, e_y, v_x, v_y, speed, p):
    ratio, squeeze = e_x / p.clearance, 2.0 * (v_x / p.clearance)
    wedge = speed * ratio
    scale = p.viscosity * p.bearing_radius * p.length**3 / (p.clearance * p.clearance)
    if squeeze == 0.0 and wedge == 0.0:
        return 0.0, 0.0
    c, s, d, one_minus_square, inverse_thickness = arc_from(ratio, squeeze, wedge)
    ratio_cosine_squared = (ratio * c) ** 2
    squeeze_integral = 0.5 * inverse_thickness / one_minus_square + s * ratio * (
        1.0 - 2.0 * c * c + ratio_cosine_squared
    ) / (d * d * one_minus_square)
    wedge_integral = -2.0 * ratio * c * c * c / (d * d)
    square_integral = (inverse_thickness + 2.0 * ratio * s / d) / one_minus_square
    cube_integral = (
        0.5
        * (3.0 * square_integral - inverse_thickness + 2.0 * ratio * s * (1.0 + ratio_cosine_squared) / (d * d))
        / one_minus_square
    )
    radial = 0.5 * scale * (wedge * wedge_integral - squeeze * (cube_integral - squeeze_integral))
    tangential = 0.5 * scale * (wedge * squeeze_integral - squeeze * wedge_integral)
    return radial, tangential
