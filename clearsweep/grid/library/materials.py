"""Materials and wear pairs by name: typical values, each with its range."""

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple


class Value(NamedTuple):
    """A typical value and its range, in SI."""

    unit: str
    typical: float
    low: float
    high: float


class Entry(NamedTuple):
    """A material, an oil or a wear pair."""

    name: str
    summary: str
    values: Mapping[str, Value]  # by key
    source: str
    checked: str  # which values were compared with a published text, and which text


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


_ARCHARD = "Archard 1953, J. Appl. Phys. 24:981, table (K and hardness, unlubricated, 400 g, 1.8 m/s)"
_SCATTER = "Rabinowicz 1981, J. Lubr. Technol. 103:188 (K of lubricated pairs and its scatter)"
_POLYMERS = (
    "Theberge 1970, SPE ANTEC (wear factors of thermoplastics, ASTM D3702, in "
    "1e-10 in^3 min/(ft lb h) = 2.014e-17 m^2/N)"
)
_REPRINTED = (
    "K with a reprint of the table (Wikipedia, Wear coefficient), which has K / (3 H): that is within the range; the "
    "hardness is from memory"
)
_REMEMBERED = "no: written from memory of the source; do not quote it as published"
#: Name, description, typical, low, high (m^2/N), source.
_PAIRS = (
    ("steel/steel dry", "mild steel on mild steel", 3.8e-12, 1e-13, 1.5e-11, f"{_ARCHARD}: 7e-3, 1.82 GPa"),
    ("hardened steel/steel dry", "tool steel on tool steel", 1.6e-14, 4e-15, 6.4e-14, f"{_ARCHARD}: 1.3e-4, 8.3 GPa"),
    ("hardened steel/steel greased", "boundary lubricated", 1e-16, 1e-17, 1e-15, f"{_SCATTER}: 1e-7 to 1e-5, 7 GPa"),
    ("steel/brass dry", "60/40 leaded brass on tool steel", 6.4e-13, 1.6e-13, 2.6e-12, f"{_ARCHARD}: 6e-4, 0.93 GPa"),
    ("steel/bronze dry", "tin bronze on steel", 8e-14, 1e-14, 3e-13, f"{_SCATTER}: 1e-5 to 4e-4, 1.2 GPa"),
    ("steel/bronze greased", "tin bronze on steel, boundary lubricated", 4e-15, 4e-16, 4e-14,
     f"{_SCATTER}: 5e-7 to 5e-5, 1.2 GPa"),
    ("steel/cast iron greased", "grey cast iron on steel, boundary lubricated", 1e-15, 1e-16, 1e-14,
     f"{_SCATTER}: 2e-7 to 2e-5, 2 GPa"),
    ("steel/PTFE dry", "unfilled PTFE on steel", 5.1e-13, 1.3e-13, 2e-12, f"{_ARCHARD}: 2.5e-5, 49 MPa"),
    ("steel/POM dry", "unfilled acetal on steel", 1.3e-15, 3e-16, 1e-14, f"{_POLYMERS}: 65"),
    ("steel/PA66 dry", "unfilled polyamide 66 on steel", 4e-15, 1e-15, 2e-14, f"{_POLYMERS}: 200"),
)  # fmt: skip
PAIRS = {
    name: Entry(
        name,
        summary,
        {"coefficient": Value("m^2/N", typical, low, high)},
        source,
        _REPRINTED if source.startswith(_ARCHARD) else _REMEMBERED,
    )
    for name, summary, typical, low, high, source in _PAIRS
}
