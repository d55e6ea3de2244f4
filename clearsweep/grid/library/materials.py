"""Materials: elastic constants, density, strength, hardness and thermal expansion at room temperature.

A row of materials.csv has name, description, `typical low high` of each of _COLUMNS, and the letter of its source.
Hardness is a Brinell or Vickers number times 9.80665 MPa; for plastics, ball indentation hardness (ISO 2039-1).
The yield strength of plastics is the yield stress in tension.
"""

import csv
from pathlib import Path

from .entry import Entry, Value

_CHECKED = "no: written from memory of the source; check a data sheet before you quote a value"
_COLUMNS = (  # key, unit, factor from the file's unit to SI
    ("young", "Pa", 1e9),
    ("poisson", "1", 1.0),
    ("density", "kg/m^3", 1.0),
    ("yield_strength", "Pa", 1e6),
    ("hardness", "Pa", 1e6),
    ("expansion", "1/K", 1e-6),
)
_SOURCES = {
    "S": "EN 1993-1-1, 3.2.6 (E, nu, expansion of structural steel); EN 10025-2 (S355), EN ISO 683-1 (C45), "
    "EN ISO 683-2 (42CrMo4): yield strengths by thickness; hardness from tensile strength, ISO 18265",
    "R": "EN ISO 683-17 (100Cr6) and EN ISO 683-3 (16MnCr5); hardness 58 to 64 HRC by ISO 18265; Harris & "
    "Kotzalas 2006, Rolling Bearing Analysis, 5th ed., chapter 16 (elastic constants, strength, expansion)",
    "X": "EN 10088-1, annex E (physical properties of stainless steels); EN 10088-3 (strength, hardness)",
    "I": "EN 1561, annex A (grey cast iron), EN 1563, annex (spheroidal graphite cast iron)",
    "B": "Deutsches Kupferinstitut, data sheets of the alloys; EN 12163 and EN 12167 (wrought), EN 1982 (cast): "
    "strength, hardness by temper",
    "A": "EN 755-2 (strength by section); ASM Handbook, vol. 2, 1990 (physical properties, hardness)",
    "P": "Domininghaus 1993, Plastics for Engineers (chapters on PTFE, POM, PA); dry and conditioned states and the "
    "filler-free grades make the range",
}


def _material(row: dict[str, str]) -> Entry:
    values = {}
    for key, unit, factor in _COLUMNS:
        typical, low, high = (float(number) * factor for number in row[key].split())
        values[key] = Value(unit, typical, low, high)
    return Entry(row["name"], row["summary"], values, _SOURCES[row["source"]], _CHECKED)


def _materials() -> dict[str, Entry]:
    text = Path(__file__).with_name("materials.csv").read_text(encoding="utf-8")
    rows = csv.DictReader(text.splitlines(), delimiter="|")
    return {entry.name: entry for entry in map(_material, rows)}


MATERIALS = _materials()
