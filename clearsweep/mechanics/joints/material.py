"""Values derived from material and radii of a joint."""

import math

from ...contracts.case import Joint, Materials


def plane_strain_modulus(material: Materials) -> float:
    """Return E* (Pa) of two bodies: 1/E* = (1 - nu_b^2) / E_b + (1 - nu_j^2) / E_j (Johnson 1985, 4.24)."""
    bearing, journal = material
    if bearing == journal:  # same bits as for one common material
        return bearing.young / (2.0 * (1.0 - bearing.poisson**2))
    return 1.0 / ((1.0 - bearing.poisson**2) / bearing.young + (1.0 - journal.poisson**2) / journal.young)


def relative_radius(joint: Joint) -> float:
    """Return R_b R_j / (R_b - R_j) in m."""
    bearing = joint.bearing_radius
    return bearing * (bearing - joint.clearance) / joint.clearance


def material_stiffness(joint: Joint) -> float:
    """Return (4/3) E* sqrt(R) in N/m^1.5, the sphere-in-socket stiffness of a joint from its material and radii.

    Flores, Ambrosio, Claro & Lankarani 2008, Kinematics and Dynamics of Multibody Systems with Imperfect Joints, (3.4).
    """
    return 4.0 / 3.0 * plane_strain_modulus(joint.contact.material) * math.sqrt(relative_radius(joint))


def line_modulus(joint: Joint) -> float:
    """Return E* times the length of the joint, N/m."""
    return plane_strain_modulus(joint.contact.material) * joint.length
