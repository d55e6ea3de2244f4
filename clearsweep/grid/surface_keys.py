"""Keys of a joint's surfaces: roughness, and an oil film."""

from ..contracts.catalogue import Catalogue
from . import film_keys
from .joint_keys import add_laws, add_numbers
from .keys import Name, Section, Shape, Word, section_key
from .library import OILS
from .naming import OIL


def add_roughness(tree: Shape, path: str, catalogue: Catalogue) -> None:
    """Add the keys of a joint's surface roughness."""
    rough = f"{path}.roughness"
    tree[rough] = Section("rough surfaces, in series with the elastic law; left out: smooth ones", "optional")
    tree[f"{rough}.law"] = Word(catalogue.names("roughness"), "the roughness law", sweep=True, noun="law")
    add_laws(tree, rough, "law", catalogue.of("roughness"))


def add_film(tree: Shape, path: str, catalogue: Catalogue) -> None:
    """Add the keys of a joint's oil film, with or without dry contact."""
    tree[f"{path}.contact"] = section_key(tree, f"{path}.contact")._replace(unless="film")
    film = f"{path}.film"
    tree[film] = Section("a film of oil; left out: none", "optional")
    tree[f"{film}.law"] = Word(
        catalogue.names("film"), "the law of the film's force", film_keys.DEFAULT_LAW, sweep=True, noun="law"
    )
    tree[f"{film}.{OIL}"] = Name(tuple(OILS), "an oil of `clearsweep list oils`: gives viscosities and density")
    add_numbers(tree, film, (film_keys.VISCOSITY,))
    add_numbers(tree, f"{film}.viscosity", film_keys.OIL)
    add_numbers(tree, film, (film_keys.TEMPERATURE, *film_keys.FILM))
    tree[f"{film}.thermal"] = Section("heat balance: temperature = ambient + mean loss / conductance", "optional")
    add_numbers(tree, f"{film}.thermal", film_keys.THERMAL)
    tree[f"{film}.friction"] = Word(
        ("by-law", *catalogue.names("film-friction")),
        "the couple of the film's shear; by-law: butenschoen",
        "by-law",
        sweep=True,
        noun="law",
    )
    tree[f"{film}.transition"] = Section("how the dry contact takes over", "implied", needs="contact")
    transition = f"{film}.transition"
    tree[f"{transition}.law"] = Word(
        catalogue.names("transition"), "how the dry contact takes over", "ramp", sweep=True, noun="law"
    )
    add_numbers(tree, transition, film_keys.TRANSITION)
    add_laws(tree, transition, "law", catalogue.of("transition"))
