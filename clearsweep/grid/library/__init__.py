"""Materials, oils, wear pairs and rolling bearings by name: values with their ranges and sources."""

import csv
import re
import textwrap
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

from ...language.errors import InputError, did_you_mean, quoted
from .fits import GROUPS

# ----------------------------------------------------------------------------------------------------------------------
# Materials, wear pairs and oils by name: typical values, each with its range.


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
    checked: str  # which values were compared with a published text, and which text; '' for none
    hard_body_wears: bool = True  # of a wear pair: the coefficient is that of both bodies, not of the softer alone


_MATERIAL_COLUMNS = (  # key, unit, factor from the file's unit to SI
    ("young", "Pa", 1e9),
    ("poisson", "1", 1.0),
    ("density", "kg/m^3", 1.0),
    ("yield_strength", "Pa", 1e6),
    ("hardness", "Pa", 1e6),
    ("expansion", "1/K", 1e-6),
)
_MATERIAL_SOURCES = {
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


def _rows_of(name: str) -> "csv.DictReader[str]":
    return csv.DictReader(Path(__file__).with_name(name).read_text(encoding="utf-8").splitlines(), delimiter="|")


def _entries_of(name: str, columns: Iterable[tuple[str, str, float]], sources: Mapping[str, str]) -> dict[str, Entry]:
    """Return the entries of a file by name; columns : key, unit, factor from the file's unit to SI."""
    return {
        row["name"]: Entry(
            row["name"],
            row["summary"],
            {
                key: Value(unit, *(float(number) * factor for number in row[key].split()))
                for key, unit, factor in columns
            },
            sources[row["source"]],
            row["checked"],
        )
        for row in _rows_of(name)
    }


MATERIALS = _entries_of("materials.csv", _MATERIAL_COLUMNS, _MATERIAL_SOURCES)


_PAIR_SOURCES = {
    "A": "Archard 1953, J. Appl. Phys. 24:981, table (K and hardness, unlubricated, 400 g, 1.8 m/s)",
    "R": "Rabinowicz 1981, J. Lubr. Technol. 103:188 (K of lubricated pairs and its scatter)",
    "P": "Theberge 1970, SPE ANTEC (wear factors of thermoplastics, ASTM D3702, in "
    "1e-10 in^3 min/(ft lb h) = 2.014e-17 m^2/N)",
}
_CHECKED_WITH_REPRINT = (
    "K with a reprint of the table (Wikipedia, Wear coefficient), which has K / (3 H): that is within the range; the "
    "hardness is from memory"
)
_LIKE_BODIES = ("steel/steel dry", "hardened steel/steel dry", "hardened steel/steel greased")
PAIRS = {
    row["name"]: Entry(
        row["name"],
        row["summary"],
        {"coefficient": Value("m^2/N", *map(float, row["coefficient"].split()))},
        f"{_PAIR_SOURCES[row['source']]}: {row['values']}",
        _CHECKED_WITH_REPRINT if row["source"] == "A" else "",
        hard_body_wears=row["name"] in _LIKE_BODIES,
    )
    for row in _rows_of("pairs.csv")
}


_CITATION = "viscosity index by ASTM D2270"
_OIL_SOURCES = {
    "V": f"ISO 3448 (viscosity at 40 degC within 10 %); {_CITATION}, 95 for a solvent-refined mineral oil",
    "S": f"SAE J300 (viscosity at 100 degC); {_CITATION}, typical of data sheets, without shear thinning",
}
_OIL_COLUMNS = (("at_40C", "m^2/s", 1.0), ("at_100C", "m^2/s", 1.0), ("density", "kg/m^3", 1.0))
#: The file is made by docs/tools/oils.py.
OILS = _entries_of("oils.csv", _OIL_COLUMNS, _OIL_SOURCES)


# ----------------------------------------------------------------------------------------------------------------------
# Rolling bearings by name: deep groove ball bearings and needle roller bearings without an inner ring.
#
# Balls: boundary dimensions and ratings are those of a catalogue.  Number and diameter of the balls are in no
# catalogue; they are those, in steps of 1/64 in, whose ratings by ISO 281 and ISO 76 are the catalogue's.


GROOVES = (0.52, 0.53)  # radii over the ball's diameter, up to which ISO 281 has its ratings
_COLUMNS = {  # column of the file -> key of the joint, unit, factor from the file's unit to SI
    "elements": ("elements", "1", 1.0),
    "element_diameter": ("element_diameter", "m", 1e-3),
    "pitch_diameter": ("pitch_diameter", "m", 1e-3),
    "bore": ("bore", "m", 1e-3),
    "outside_diameter": ("outside_diameter", "m", 1e-3),
    "width": ("width", "m", 1e-3),
    "length": ("length", "m", 1e-3),
    "dynamic": ("capacity.dynamic", "N", 1e3),
    "static": ("capacity.static", "N", 1e3),
}
WIDTH = "width"  # listed, but of no effect in the plane of the rings
_BALL_SOURCE = (
    "KYK, general catalogue, deep groove ball bearings (dimensions of ISO 15, ratings); balls by the ratings, ISO 281 "
    "and ISO 76; pitch diameter: mean of bore and outside diameter; grooves: ISO 281"
)
_BALL_CHECKED = "dimensions and ratings with the catalogue; the balls, by the ratings that follow from them, within 4 %"
_NEEDLE_SOURCE = (
    "UBC, catalogue of needle roller bearings (dimensions, ratings); diameter of the needles from memory, their number "
    "and effective length by the static rating, ISO 76; the bore is the raceway of the shaft"
)


def _entry(row: Mapping[str, str]) -> Entry:
    values = {
        key: _exactly(unit, float(row[name]) * factor) for name, (key, unit, factor) in _COLUMNS.items() if row[name]
    }
    if has_inner_ring(row["name"]):
        values |= {f"groove.{k}": _exactly("1", radius) for k, radius in enumerate(GROOVES)}
        return Entry(row["name"], "deep groove ball bearing", values, _BALL_SOURCE, _BALL_CHECKED)
    form = "drawn cup needle roller bearing" if row["name"].startswith("HK") else "needle roller bearing"
    return Entry(row["name"], f"{form} without inner ring", values, _NEEDLE_SOURCE, "")


def _exactly(unit: str, number: float) -> Value:
    value = float(f"{number:.12g}")
    return Value(unit, value, value, value)


def has_inner_ring(name: str) -> bool:
    """Return whether a bearing has an inner ring; shaft and housing determine the clearance of the others."""
    return name[:1].isdigit()


BEARINGS = {row["name"]: _entry(row) for row in _rows_of("bearings.csv")}


class BearingName(NamedTuple):
    """The name of a bearing in its parts."""

    designation: str  # '6204'
    group: str  # of its clearance, 'C3'; '' if it is not written


def parse_bearing_name(name: str) -> BearingName:
    """Return the parts of a name such as '6204 C3'."""
    words = name.split()
    if len(words) > 1 and (words[-1].upper() in GROUPS or " ".join(words[:-1]) in BEARINGS):
        return BearingName(" ".join(words[:-1]), words[-1].upper())
    return BearingName(name, "")


def bearing_names() -> tuple[str, ...]:
    """Return all names, those of bearings with an inner ring also with a group."""
    groups = {name: ("", *GROUPS) if has_inner_ring(name) else ("",) for name in BEARINGS}
    return tuple(f"{name} {group}".strip() for name in BEARINGS for group in groups[name])


def check_group(designation: str, group: str) -> None:
    """Raise InputError if a bearing without an inner ring has a group."""
    if group and not has_inner_ring(designation):
        raise InputError(
            f"found {quoted(f'{designation} {group}')}, but {designation} has no group: shaft and housing determine "
            "its clearance; write the name alone and `clearance`"
        )


#: Names of whole libraries for `clearsweep list NAME`.
LIBRARIES: Mapping[str, Mapping[str, Entry]] = {
    "materials": MATERIALS,
    "oils": OILS,
    "pairs": PAIRS,
    "bearings": BEARINGS,
}


def library_text(name: str) -> str | None:
    """Return the library or the entry called `name` as text, or None if there is neither."""
    if name in LIBRARIES:
        return "\n\n".join(entry_text(entry) for entry in LIBRARIES[name].values())
    entries = [library[name] for library in LIBRARIES.values() if name in library]
    return "\n\n".join(map(entry_text, entries)) or None


def library_names() -> tuple[str, ...]:
    """Return every name that `library_text` accepts."""
    return (*LIBRARIES, *(name for library in LIBRARIES.values() for name in library))


def _kinds_text(word: str, library: Mapping[str, Entry]) -> str:
    """Return `; there are S355, C45` for the entries that are of the kind `word`, such as steel, or ''."""
    of_kind = [
        entry.name for entry in library.values() if word.casefold() in f"{entry.name} {entry.summary}".casefold()
    ]
    return f"; there are {', '.join(of_kind)}" if len(word) > 2 and of_kind else ""


def is_of_pair(materials: Collection[str], pair: str) -> bool:
    """Return whether materials of one or both bodies, by name, are those of a wear pair such as steel/bronze dry."""
    kinds = [kind.split()[-1] for kind in pair.rpartition(" ")[0].split("/")]  # the steel of hardened steel
    words = [re.split(r"[ ,;]+", f"{name} {MATERIALS[name].summary}") for name in materials]
    return any(all(kind in body for kind, body in zip(order, words, strict=False)) for order in (kinds, kinds[::-1]))


def find_entry(library: Mapping[str, Entry], name: str) -> Entry:
    """Return an entry by its name in any letter case.  Raises InputError with the nearest name."""
    names_by_folded_name = {" ".join(name.split()).casefold(): name for name in library}
    entry_name = names_by_folded_name.get(" ".join(name.split()).casefold())
    if entry_name is None:
        kind = next(kind for kind, entries in LIBRARIES.items() if entries is library)
        hint = did_you_mean(name, library) or _kinds_text(name, library)
        raise InputError(f"unknown name {quoted(name)}{hint} (`clearsweep list {kind}` prints all {len(library)})")
    return library[entry_name]


_WIDTH = 100  # characters in a line
_SCALES = {  # SI -> unit for display
    "Pa": (1e9, "GPa"),
    "1/K": (1e-6, "1e-6/K"),
    "m^2/s": (1e-6, "mm^2/s"),
    "m": (1e-3, "mm"),
    "N": (1e3, "kN"),
}


def entry_text(entry: Entry) -> str:
    """Return an entry as text: values with ranges, source, and which values were checked."""
    lines = [_wrapped("", f"{entry.name}: {entry.summary}")]
    width = max(map(len, entry.values))
    lines += [f"  {key:{width}}  {value_text(value)}" for key, value in entry.values.items()]
    if not entry.hard_body_wears:
        lines.append("  of the softer body; the harder one does not wear")
    checked = entry.checked or "no: written from memory of the source; next to the name write `unchecked: true`"
    lines += [_wrapped("  ", f"source: {entry.source}"), _wrapped("  ", f"checked: {checked}")]
    return "\n".join(lines)


def value_text(value: Value) -> str:
    """Return a value with its range: '210 GPa (205 to 213)'; an exact one alone."""
    scale, unit = _SCALES.get(value.unit, (1.0, value.unit))
    if value.unit == "Pa" and value.high < 1e9:
        scale, unit = 1e6, "MPa"
    typical, low, high = (f"{number / scale:.4g}" for number in value[1:])
    spread = f" ({low} to {high})" if value.low < value.high else ""
    return f"{typical}{'' if unit == '1' else f' {unit}'}{spread}"


def _wrapped(indent: str, content: str) -> str:
    return textwrap.fill(content, _WIDTH, initial_indent=indent, subsequent_indent="  ", break_on_hyphens=False)
