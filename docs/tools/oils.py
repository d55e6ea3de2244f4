"""Writes the oils of clearsweep: `python docs/tools/oils.py`.

A standard fixes one viscosity of an oil and its tolerance; the other follows from a viscosity index by ASTM D2270.
"""

import math
from collections.abc import Iterator
from pathlib import Path

FILE = Path(__file__).parents[2] / "clearsweep/grid/library/oils.csv"
VG_INDEX = 95.0  # viscosity index of a solvent-refined mineral oil (API group I)
VG_INDEX_RANGE = (90.0, 105.0)  # range for such oils
#: L and H (mm^2/s at 40 degC) are quadratic in the viscosity at 100 degC (mm^2/s) below the first number of a row:
#: ASTM D2270-10, appendix X2, table X2.1.
D2270 = """
3.8   1.14673  1.7576   -0.109   0.84155  1.5521  -0.077
4.4   3.38095 -15.4952  33.196   0.78571  1.7929  -0.183
5.0   2.5000  -7.2143   13.812   0.82143  1.5679   0.119
6.4   0.10100  16.6350 -45.469   0.04985  9.1613 -18.557
7.0   3.35714 -23.5643  78.466   0.22619  7.7369 -16.656
7.7   0.01191  21.4750 -72.870   0.79762 -0.7321  14.610
9.0   0.41858  16.1558 -56.040   0.05794  10.5156 -28.240
12    0.88779  7.5527  -16.600   0.26665  6.7015 -10.810
15    0.76720  10.7972 -38.180   0.20073  8.4658 -22.490
18    0.97305  5.3135   -2.200   0.28889  5.9741  -4.930
22    0.97256  5.2500   -0.980   0.24504  7.4160 -16.730
28    0.91413  7.4759  -21.820   0.20323  9.1267 -34.230
40    0.87031  9.7157  -50.770   0.18411  10.1015 -46.750
55    0.84703  12.6752 -133.310  0.17029  11.4866 -80.620
70    0.85921  11.1009 -83.190   0.17130  11.3680 -76.940
inf   0.83531  14.6731 -216.246  0.16841  11.8493 -96.947
"""
D2270_ROWS = [tuple(map(float, row.split())) for row in D2270.strip().splitlines()]
VG_CHECKED = (
    "the limits of the grades with a reprint of ISO 3448, three rows of the table of ASTM D2270 with a program that "
    "has it; the density is from memory"
)
VG_GRADES = (10, 15, 22, 32, 46, 68, 100, 150, 220, 320, 460, 680, 1000, 1500)
#: SAE grade -> lowest and highest viscosity at 100 degC (mm^2/s; SAE J300), viscosity index typical, low, high.
SAE_GRADES = {
    "SAE 20": (6.9, 9.3, 100.0, 90.0, 110.0),
    "SAE 30": (9.3, 12.5, 100.0, 90.0, 110.0),
    "SAE 40": (12.5, 16.3, 100.0, 90.0, 110.0),
    "SAE 50": (16.3, 21.9, 98.0, 90.0, 110.0),
    "SAE 60": (21.9, 26.1, 98.0, 90.0, 110.0),
    "SAE 5W-30": (9.3, 12.5, 165.0, 150.0, 180.0),
    "SAE 10W-40": (12.5, 16.3, 155.0, 140.0, 170.0),
    "SAE 15W-40": (12.5, 16.3, 138.0, 125.0, 150.0),
    "SAE 20W-50": (16.3, 21.9, 125.0, 115.0, 140.0),
}
SAE_CHECKED = "the limits at 100 degC with reprints of SAE J300; the viscosity index and the density are from memory"
Range = tuple[float, float, float]  # typical, low, high


def warm_viscosity(hot: float, index: float) -> float:
    """Return the kinematic viscosity (mm^2/s) at 40 degC from that at 100 degC and the viscosity index.

    Procedure A (VI up to 100, equation 3) and B (above, equations 4 and 5) of ASTM D2270, solved for U.
    """
    *_, a, b, c, d, e, f = next(row for row in D2270_ROWS if hot < row[0])
    viscosity_at_index_0, viscosity_at_index_100 = a * hot**2 + b * hot + c, d * hot**2 + e * hot + f
    if index <= 100.0:
        return viscosity_at_index_0 - index / 100.0 * (viscosity_at_index_0 - viscosity_at_index_100)
    power = math.log10(1.0 + 0.00715 * (index - 100.0))
    warm: float = viscosity_at_index_100 / hot**power
    return warm


def hot_viscosity(warm: float, index: float) -> float:
    """Return the kinematic viscosity (mm^2/s) at 100 degC from that at 40 degC and the viscosity index.

    It is found by bisection between 2 mm^2/s, the lower end of ASTM D2270, and `warm`.
    """
    low, high = 2.0, warm
    for _ in range(80):
        midpoint = 0.5 * (low + high)
        low, high = (midpoint, high) if warm_viscosity(midpoint, index) < warm else (low, midpoint)
    return 0.5 * (low + high)


def density(warm: float) -> Range:
    """Return the density at 15 degC of a mineral oil: 850 kg/m^3 at 10 mm^2/s at 40 degC, and 30 more a decade."""
    typical = float(round(850.0 + 30.0 * math.log10(warm / 10.0)))
    return typical, 0.98 * typical, 1.02 * typical


def oils() -> Iterator[tuple[str, str, Range, Range, Range, str, str]]:
    """Yield name, summary, viscosities at 40 and 100 degC (mm^2/s), density (kg/m^3), source and check of each oil."""
    for grade in VG_GRADES:
        warm = grade, 0.9 * grade, 1.1 * grade
        hot = [hot_viscosity(*pair) for pair in zip(warm, (VG_INDEX, *VG_INDEX_RANGE), strict=True)]
        yield f"ISO VG {grade}", "mineral oil, viscosity index 95", warm, tuple(hot), density(grade), "V", VG_CHECKED
    for name, (low, high, index, low_index, high_index) in SAE_GRADES.items():
        hot = math.sqrt(low * high), low, high
        warm = [warm_viscosity(*pair) for pair in zip(hot, (index, high_index, low_index), strict=True)]
        summary = f"engine oil, viscosity index {index:g}"
        yield name, summary, tuple(warm), hot, density(warm[0]), "S", SAE_CHECKED


def table() -> str:
    """Return the file, its numbers in SI."""
    lines = ["name|summary|at_40C|at_100C|density|source|checked"]
    for name, summary, warm, hot, weight, source, checked in oils():
        ranges = ([1e-6 * number for number in warm], [1e-6 * number for number in hot], weight)
        texts = [" ".join(map(repr, numbers)) for numbers in ranges]
        lines.append("|".join([name, summary, *texts, source, checked]))
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    FILE.write_text(table(), encoding="utf-8")
