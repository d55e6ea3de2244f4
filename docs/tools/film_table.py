"""The table of the film law `reynolds`: solutions of Reynolds' equation in two dimensions, and their expansion.

`python docs/tools/film_table.py` writes the file that the law reads, in some minutes.

With H = 1 + eps cos(theta), y = 2 z / L and the pressure in units of 6 mu R^2 / c^2, the film obeys

    (H^3 p_theta)_theta + (H^3 p_y)_y / (L / D)^2 = -f,  f = W sin(theta) - S cos(theta),  W = w eps,  S = 2 eps'

where p > 0, and p >= 0 with no outflow from the cavity elsewhere: Reynolds' boundary condition as an obstacle problem.
p maximises the power l(p) - a(p, p) / 2 over all p >= 0 (Kinderlehrer & Stampacchia 1980, section VII).  Therefore the
force is the gradient of half the power l(p) by (-S, W): one function determines both components, and a film of positive
power is passive.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from clearsweep.mechanics.laws import reynolds as law

GRIDS = ((64, 8), (128, 16))  # cells around and along half of the pin; the second-order error is extrapolated to zero
RATIO_NODES, DIRECTION_NODES = 16, 24  # nodes at which the expansion is fitted
EVEN_SHARE = 0.5  # of the cells that are spaced evenly around the pin; the others cluster where the film is thin
CLUSTERING = 2.2  # clustering of cells at the end of the pin


class Solution(NamedTuple):
    """Result of a film for one motion."""

    radial: float  # integral of p cos(theta) over theta and half of the pin, y from 0 to 1
    tangential: float  # of p sin(theta)
    max_pressure: float  # largest p


class Film:
    """A discretised film, whose pressure is computed for any motion."""

    def __init__(self, slenderness: float, ratio: float, grid: tuple[int, int]) -> None:
        """Take length / diameter, the eccentricity ratio, and the numbers of cells around and along half of the pin."""
        circumferential, axial = grid
        faces, self.angles = _circumferential_cells(ratio, circumferential)
        fractions = np.arange(2 * axial + 1) / (2.0 * axial)
        heights = np.tanh(CLUSTERING * fractions) / math.tanh(CLUSTERING)
        widths, spans, self.heights = np.diff(faces), np.diff(heights[::2]), heights[1::2]
        distances = (self.angles - np.roll(self.angles, 1)) % (2.0 * math.pi)
        circumferential_flow = ((1.0 + ratio * np.cos(faces[:-1])) ** 3 / distances)[:, None] * spans
        axial_weights = np.append(1.0 / np.diff(self.heights), 1.0 / (1.0 - self.heights[-1]))
        axial_flow = ((1.0 + ratio * np.cos(self.angles)) ** 3 * widths)[:, None] * axial_weights / slenderness**2
        diagonal = circumferential_flow + np.roll(circumferential_flow, -1, 0) + axial_flow
        diagonal[:, 1:] += axial_flow[:, :-1]
        cells = np.arange(circumferential * axial).reshape(circumferential, axial)
        pairs = ((cells, np.roll(cells, 1, 0), circumferential_flow), (cells[:, 1:], cells[:, :-1], axial_flow[:, :-1]))
        rows = [cells, *(part for cell, neighbour, _ in pairs for part in (cell, neighbour))]
        columns = [cells, *(part for cell, neighbour, _ in pairs for part in (neighbour, cell))]
        values = [diagonal, *(-part for _, _, flow in pairs for part in (flow, flow))]
        flattened = [np.concatenate([array.ravel() for array in arrays]) for arrays in (values, rows, columns)]
        self.matrix = sparse.csr_matrix((flattened[0], (flattened[1], flattened[2])), shape=(cells.size, cells.size))
        self.areas = widths[:, None] * spans
        self.cosines, self.sines = np.cos(self.angles), np.sin(self.angles)
        self.is_pressurised: np.ndarray | None = (
            None  # (cells,) those under pressure at the last motion, the initial guess for the next
        )

    def solve(self, squeeze: float, wedge: float) -> Solution:
        """Return the Solution for 2 eps' and w eps; the set of cells under pressure is iterated until consistent."""
        source = (self.areas * (wedge * self.sines - squeeze * self.cosines)[:, None]).ravel()
        was_filled = source > 0.0 if self.is_pressurised is None else self.is_pressurised
        for _ in range(60):
            filled_cells = np.flatnonzero(was_filled)
            pressure = np.zeros(source.size)
            pressure[filled_cells] = spsolve(
                self.matrix[filled_cells][:, filled_cells].tocsc(), source[filled_cells], "MMD_AT_PLUS_A"
            )
            would_refill = source - self.matrix @ pressure > 1e-14 * np.abs(source).max()
            is_filled = np.where(was_filled, pressure > 0.0, would_refill)
            if np.array_equal(is_filled, was_filled):
                break
            was_filled = is_filled
        else:
            raise RuntimeError("the cavity of a film was not found")
        self.is_pressurised, field = was_filled, pressure.reshape(self.areas.shape)
        integrated = (self.areas * field).sum(axis=1)
        return Solution(float(integrated @ self.cosines), float(integrated @ self.sines), self._max_pressure(field))

    def _max_pressure(self, field: np.ndarray) -> float:
        """Return the largest pressure, by a parabola along y and one along theta."""
        low, high = self.heights[:2]
        midplane = field[:, 0] - low**2 * (field[:, 1] - field[:, 0]) / (high**2 - low**2)
        neighbours = np.arange(-1, 2) + int(np.argmax(midplane))
        angles = np.unwrap(np.take(self.angles, neighbours, mode="wrap"))
        a, b, c = np.polyfit(angles - angles[1], np.take(midplane, neighbours, mode="wrap"), 2)
        return float(c - b * b / (4.0 * a))


def _circumferential_cells(ratio: float, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the angles of the faces of cells, and of their centres."""
    fine_angles = np.linspace(0.0, 2.0 * math.pi, 40001)
    density = EVEN_SHARE + (1.0 - EVEN_SHARE) * math.sqrt(1.0 - ratio * ratio) / (1.0 + ratio * np.cos(fine_angles))
    cumulative_density = np.concatenate([[0.0], np.cumsum(density[1:] + density[:-1])])
    angles = np.interp(
        np.arange(2 * cells + 1) / (2.0 * cells), cumulative_density / cumulative_density[-1], fine_angles
    )
    return angles[::2], angles[1::2]


def short_film(slenderness: float, ratio: float, squeeze: float, wedge: float) -> tuple[float, float]:
    """Return the integral of p f and the largest p of a film with axial flow only."""
    x, weights = np.polynomial.legendre.leggauss(400)
    angles = math.atan2(squeeze, wedge) + 0.5 * math.pi * (x + 1.0)
    source = wedge * np.sin(angles) - squeeze * np.cos(angles)
    cubed = (1.0 + ratio * np.cos(angles)) ** 3
    power = slenderness**2 / 3.0 * 0.5 * math.pi * float(weights @ (source**2 / cubed))
    return power, 0.5 * slenderness**2 * _largest_short_pressure(ratio, squeeze, wedge)


def _largest_short_pressure(ratio: float, squeeze: float, wedge: float) -> float:
    """Return the largest f / H^3."""
    low, high = math.atan2(squeeze, wedge), math.atan2(squeeze, wedge) + math.pi
    for _ in range(6):
        angles = np.linspace(low, high, 1001)
        values = (wedge * np.sin(angles) - squeeze * np.cos(angles)) / (1.0 + ratio * np.cos(angles)) ** 3
        index = int(np.argmax(values))
        low, high = angles[max(index - 1, 0)], angles[min(index + 1, 1000)]
    return float(values.max())


def logarithms_over_short(slenderness: float, ratio: float, directions: np.ndarray) -> np.ndarray:
    """Return (2, directions) logarithms of power and largest pressure over those of the short film.

    directions : the sine that the law expands in, S / (S^2 + (1 - eps^2)^(1/2) W^2)^(1/2).
    """
    results = []
    for grid in GRIDS:
        film, rows = Film(slenderness, ratio, grid), []
        for direction in directions:
            squeeze, wedge = direction, math.sqrt(1.0 - direction**2) / (1.0 - ratio * ratio) ** 0.25
            solution = film.solve(squeeze, wedge)
            (power, short_max_pressure) = short_film(slenderness, ratio, squeeze, wedge)
            work = wedge * solution.tangential - squeeze * solution.radial
            rows.append((math.log(work / power), math.log(solution.max_pressure / short_max_pressure)))
        results.append(np.array(rows).T)
    extrapolated: np.ndarray = (4.0 * results[1] - results[0]) / 3.0
    return extrapolated


def expansion_coefficients(slenderness: float) -> np.ndarray:
    """Return the (2, terms, powers) coefficients of the expansions in the law's file, for one length / diameter."""
    directions = math.pi * (np.arange(DIRECTION_NODES) + 0.5) / DIRECTION_NODES
    depths = np.cos(math.pi * (np.arange(RATIO_NODES) + 0.5) / (2 * RATIO_NODES))
    ratios = np.tanh(law.MAX_ARTANH * depths)
    values = np.array([logarithms_over_short(slenderness, ratio, np.cos(directions)) for ratio in ratios])
    harmonics = 2.0 / DIRECTION_NODES * values @ np.cos(np.outer(directions, np.arange(law.TERMS)))
    harmonics[:, :, 0] *= 0.5
    powers = np.polynomial.chebyshev.chebvander(2.0 * depths**2 - 1.0, law.POWERS - 1)
    coefficients = np.empty((2, law.TERMS, law.POWERS))
    for term in range(law.TERMS):
        basis = powers * depths[:, None] ** (term % 2)
        coefficients[:, term] = np.linalg.lstsq(basis, harmonics[:, :, term], rcond=None)[0].T
    return coefficients


def main() -> None:
    """Write the file that the law reads."""
    np.save(
        law.FILE,
        np.array([expansion_coefficients(slenderness) for slenderness in law.tabulated_lengths()]).astype(np.float32),
    )


if __name__ == "__main__":
    main()
