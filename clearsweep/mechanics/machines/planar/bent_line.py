"""The line of a body that bends, in a program: fields over the bar, and the forces of its deformation."""

import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from ....tracing.compiled.formulas import ONE, ZERO, Expr, constant, sum_of
from ..programs import PlaneVector
from .form import LINE_SHAPE, ONE_SHAPE, STATIONS, Shape, integral_of_product, shortening_shapes, value_of
from .structure import BentKind, Coordinate

Field = dict[Shape, Expr]  # coefficients of shapes


def field_sum(fields: Iterable[Field]) -> Field:
    """Return the sum of fields."""
    terms: dict[Shape, list[Expr]] = {}
    for field in fields:
        for shape, coefficient in field.items():
            terms.setdefault(shape, []).append(coefficient)
    sums = {shape: sum_of(coefficients) for shape, coefficients in terms.items()}
    return {shape: coefficient for shape, coefficient in sums.items() if coefficient != ZERO}


def scaled(factor: Expr, field: Field) -> Field:
    """Return a field times a factor."""
    return {shape: factor * coefficient for shape, coefficient in field.items()} if factor != ZERO else {}


def mean_product(first: Field, second: Field) -> Expr:
    """Return the mean over the bar of the product of two fields."""
    terms = []
    for shape, coefficient in first.items():
        weighted = [
            constant(integral_of_product(shape, other)) * other_coefficient
            for other, other_coefficient in second.items()
            if integral_of_product(shape, other) != 0.0
        ]
        terms.append(coefficient * sum_of(weighted))
    return sum_of(terms)


class PlaneField(NamedTuple):
    """A field of vectors, along and across the chord."""

    axial: Field
    transverse: Field

    def __add__(self, other: "PlaneField") -> "PlaneField":  # type: ignore[override]
        return PlaneField(field_sum([self.axial, other.axial]), field_sum([self.transverse, other.transverse]))

    def turned(self, spin: Expr) -> "PlaneField":
        """Return the vector product of an angular rate with this field."""
        return PlaneField(scaled(-spin, self.transverse), scaled(spin, self.axial))

    def dot(self, other: "PlaneField") -> Expr:
        """Return the mean over the bar of the scalar product with another field."""
        return sum_of([mean_product(self.axial, other.axial), mean_product(self.transverse, other.transverse)])


class BentLine:
    """The line of a body that bends, in a program: fields of position, velocity and acceleration, and its forces."""

    def __init__(
        self,
        kind: BentKind,
        properties: Expr,
        axis: PlaneVector,
        values: Mapping[Coordinate, Expr],
        rates: Mapping[Coordinate, Expr],
    ):
        """properties : its Bent; axis : of the line in the fixed frame; values, rates : of the deformation."""
        self.kind, self.properties, self.axis, self.normal = kind, properties, axis, axis.left()
        self.values, self.rates = ({c: each[c] for c in kind.coordinates} for each in (values, rates))
        self.inverse_length = 1.0 / properties.length
        self.modes, self.stretches = kind.coordinates[: kind.modes], kind.coordinates[kind.modes :]
        half_shortening = scaled(constant(0.5), self._shortening(self.values, self.values))
        stretched = {self._ramp(i): values[c] for i, c in enumerate(self.stretches)}
        self.position = PlaneField(
            field_sum([{LINE_SHAPE: properties.length}, half_shortening, stretched]), self._sines(self.values)
        )

    def _ramp(self, i: int) -> Shape:
        return ("ramp", i, len(self.stretches))

    def _sines(self, values: Mapping[Coordinate, Expr]) -> Field:
        return {("sine", k + 1): values[c] for k, c in enumerate(self.modes) if values.get(c, ZERO) != ZERO}

    def _shortening(self, first: Mapping[Coordinate, Expr], second: Mapping[Coordinate, Expr]) -> Field:
        """Return minus the integral of the product of two slopes up to each place, bilinear in the modes' values."""
        terms: list[Field] = []
        for k, a in enumerate(self.modes):
            for j, b in enumerate(self.modes):
                if first is second and j < k:
                    continue
                product = first.get(a, ZERO) * second.get(b, ZERO)
                product = 2.0 * product if first is second and j > k else product
                if product != ZERO:
                    weights = shortening_shapes(k, j)
                    terms.append({shape: constant(weight) * product for shape, weight in weights.items()})
        return scaled(-self.inverse_length, field_sum(terms))

    def _deformation(self, rates: Mapping[Coordinate, Expr]) -> PlaneField:
        """Return the derivative of the position in the chord's frame by the deformation, times `rates`."""
        stretched = {self._ramp(i): rates[c] for i, c in enumerate(self.stretches) if c in rates}
        return PlaneField(field_sum([self._shortening(rates, self.values), stretched]), self._sines(rates))

    def _uniform(self, vector: PlaneVector) -> PlaneField:
        """Return the field of a vector of the fixed frame."""
        components = ({ONE_SHAPE: axis.dot(vector)} for axis in (self.axis, self.normal))
        return PlaneField(*({k: v for k, v in field.items() if v != ZERO} for field in components))

    def column(self, coordinate: Coordinate, centre: PlaneVector, spin: Expr) -> PlaneField:
        """Return the derivative of the position by a coordinate, from that of the centre and of the chord's angle."""
        field = self._uniform(centre) + self.position.turned(spin)
        if coordinate in self.kind.cuts:
            place = STATIONS[self.kind.cuts.index(coordinate)]
            return field + PlaneField({("step", place): ONE} if place < 1.0 else {}, {})
        return field + self._deformation({coordinate: ONE}) if coordinate in self.kind.coordinates else field

    def velocity(self, centre: PlaneVector, spin: Expr) -> PlaneField:
        """Return the velocity, from that of the centre and the rate of the chord's angle."""
        return self._uniform(centre) + self.position.turned(spin) + self._deformation(self.rates)

    def acceleration(
        self, centre: PlaneVector, spin: Expr, spin_rate: Expr, accelerations: Mapping[Coordinate, Expr]
    ) -> PlaneField:
        """Return the acceleration; accelerations : of the deformation, where it has them."""
        rates = self.rates
        relative = self._deformation(rates)
        twice_spin = 2.0 * spin
        parts = [
            self._uniform(centre),
            self.position.turned(spin_rate),
            PlaneField(*(scaled(-(spin * spin).assigned(), field) for field in self.position)),
            relative.turned(twice_spin.assigned()),
            PlaneField(self._shortening(rates, rates), {}),
            self._deformation({c: accelerations[c] for c in self.kind.coordinates if c in accelerations}),
        ]
        return PlaneField(field_sum(part.axial for part in parts), field_sum(part.transverse for part in parts))

    def mean(self, field: PlaneField) -> PlaneVector:
        """Return the mean of a field over the bar, in the fixed frame."""
        uniform = {ONE_SHAPE: ONE}
        return mean_product(uniform, field.axial) * self.axis + mean_product(uniform, field.transverse) * self.normal

    def mean_moment(self, field: PlaneField) -> Expr:
        """Return the mean moment of a field about the place of the centre of mass without deformation."""
        x, y = self.position
        return sum_of([mean_product(x, field.transverse), -mean_product(y, field.axial)])

    def lumped_mass(self, coordinate: Coordinate) -> Expr:
        """Return the mass of an axial segment's extension beyond that of the fields: masses are at the segments' ends.

        Half the mass of a segment at each end moves with m / 2 (v1^2 + v2^2), the bar between with
        m / 3 (v1^2 + v1 v2 + v2^2).
        """
        if coordinate not in self.stretches:
            return ZERO
        return (1.0 / (6.0 * len(self.stretches))) * self.properties.mass

    def tension(self, coordinate: Coordinate) -> Expr:
        """Return the force (N) of stiffness and damping against a deformation."""
        i = self.kind.coordinates.index(coordinate)
        properties = self.properties
        stored = properties.stiffness[i] * self.values[coordinate]
        return stored + properties.damping[i] * self.rates[coordinate]

    def tensions_of_segments(self) -> list[Expr]:
        """Return the elastic normal force (N) at the stations, that of their axial segments."""
        count, first = len(self.stretches), len(self.modes)
        segments = [min(int(count * place), count - 1) for place in STATIONS]
        return [self.properties.stiffness[first + i] * self.values[self.stretches[i]] for i in segments]

    def histories(self) -> list[Expr]:
        """Return deflection (m) and bending stress (Pa) of the middle, and the elongation (m) if it stretches."""
        values, middle = self.values, [(1.0, 0.0, -1.0, 0.0)[k % 4] for k in range(len(self.modes))]  # of the sines
        histories = [sum_of(constant(sine) * values[c] for sine, c in zip(middle, self.modes, strict=True))]
        squares = [float((k + 1) ** 2) * sine for k, sine in enumerate(middle)]
        curvature = sum_of(constant(square) * values[c] for square, c in zip(squares, self.modes, strict=True))
        wave_number = math.pi * self.inverse_length
        histories.append(-(self.properties.edge_modulus * (wave_number * wave_number) * curvature))
        if self.stretches:
            shortening = self._shortening(values, values)
            at_end = {shape: float(value_of(shape, np.array(1.0))) for shape in shortening}
            shortened = [constant(0.5 * at_end[shape]) * factor for shape, factor in shortening.items()]
            histories.append(sum_of([*(values[c] for c in self.stretches), *shortened]))
        return histories
