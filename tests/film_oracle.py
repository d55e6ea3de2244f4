"""An independent solution of Reynolds' equation in two dimensions with p >= 0: finite elements and relaxation.

The table of the film law `reynolds` is computed with finite volumes on a graded mesh and an iterated guess of the
cavity.  This oracle uses bilinear elements on an even mesh, Gauss's rule for the film's thickness, and Cryer's
projected
successive over-relaxation.  Pressure is in units of 6 mu R^2 / c^2, z = (L / 2) y.
"""

import math

import numpy as np
from scipy import sparse

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)
OMEGA = 1.85


class Mesh:
    """Bilinear elements over the pin and half of its length."""

    def __init__(self, slenderness, ratio, around, distance, groove=False):
        """Build the mesh; `groove`: zero pressure where the film is thickest, at theta = 0."""
        step, height = 2.0 * math.pi / around, 1.0 / distance
        angles = step * (np.arange(around)[:, None] + 0.5 * (POINTS + 1.0))  # (elements, points)
        weights, shapes = 0.5 * step * WEIGHTS, 0.5 * np.array([1.0 - POINTS, 1.0 + POINTS])
        cubed = (1.0 + ratio * np.cos(angles)) ** 3
        stiff = np.einsum("ep,p,ij->eij", cubed, weights / step**2, np.array([[1.0, -1.0], [-1.0, 1.0]]))
        heavy = np.einsum("ep,p,ip,jp->eij", cubed, weights, shapes, shapes)
        across, mass = self._periodic(stiff, around), self._periodic(heavy, around)
        up, thick = (
            self._bounded(np.array(rows), distance) for rows in ([[1.0, -1.0], [-1.0, 1.0]], [[2.0, 1.0], [1.0, 2.0]])
        )
        self.matrix = sparse.csr_matrix(
            sparse.kron(across, height / 6.0 * thick) + sparse.kron(mass, up / height) / slenderness**2
        )
        self.loads = [self._load(function(angles) * weights, shapes) for function in (np.cos, np.sin)]
        self.independent = np.full(distance, height)
        self.independent[0] = 0.5 * height
        self.free = np.ones((around, distance))
        self.free[0] = 1.0 - groove
        self.free = self.free.ravel()
        colours = 2 * (np.arange(around) % 2)[:, None] + (np.arange(distance) % 2)[None, :]
        self.groups = [np.flatnonzero(colours.ravel() == colour) for colour in range(4)]
        self.rows = [self.matrix[group] for group in self.groups]

    @staticmethod
    def _periodic(elements, count):
        first, second = np.arange(count), (np.arange(count) + 1) % count
        rows = np.stack([first, first, second, second])
        columns = np.stack([first, second, first, second])
        return sparse.csr_matrix((elements.reshape(count, 4).T.ravel(), (rows.ravel(), columns.ravel())))

    @staticmethod
    def _bounded(element, count):
        whole = np.zeros((count + 1, count + 1))
        for place in range(count):
            whole[place : place + 2, place : place + 2] += element
        return whole[:-1, :-1]  # zero pressure at the end of the pin

    @staticmethod
    def _load(values, shapes):
        share = values @ shapes.T
        return share[:, 0] + np.roll(share[:, 1], 1)

    def forces(self, squeeze, wedge):
        """Return the integrals of p cos(theta) and p sin(theta), and of the dissipation, over half of the pin."""
        cosines, sines = (np.outer(load, self.independent).ravel() for load in self.loads)
        source = wedge * sines - squeeze * cosines
        pressure, diagonal = np.zeros(source.size), self.matrix.diagonal()
        for _ in range(4000):
            before = pressure.copy()
            for group, rows in zip(self.groups, self.rows, strict=True):
                change = OMEGA * (source[group] - rows @ pressure) / diagonal[group]
                pressure[group] = np.maximum(pressure[group] + change, 0.0) * self.free[group]
            if np.abs(pressure - before).max() < 1e-9 * pressure.max():
                break
        return np.array([cosines @ pressure, sines @ pressure, pressure @ (self.matrix @ pressure)])


def solution(slenderness, ratio, squeeze, wedge, mesh=(192, 8), groove=False):
    """Return the integrals of `Mesh.forces` with the second-order error extrapolated to zero."""
    meshes = (Mesh(slenderness, ratio, n * mesh[0], n * mesh[1], groove) for n in (1, 2))
    coarse, fine = (mesh.forces(squeeze, wedge) for mesh in meshes)
    return (4.0 * fine - coarse) / 3.0
