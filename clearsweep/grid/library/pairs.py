"""Wear pairs: specific wear rates, volume per load and sliding distance, of the softer body.

A specific wear rate k (m^2/N) is K / H; K is dimensionless, H the hardness of the softer body.  It scatters: where a
source gives only K, the range is at least a factor of 4 either way (after Rabinowicz 1981).  `checked` says which
numbers were compared with a published text; all others are quoted from memory.
"""

from .entry import Entry, Value

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
_ROWS = (
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
    for name, summary, typical, low, high, source in _ROWS
}
