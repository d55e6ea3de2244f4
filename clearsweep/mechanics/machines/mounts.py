"""Keys and records of housings that yield: springs and dampers under the ground's side of a joint."""

import math
from collections.abc import Iterable, Mapping

from ...contracts.catalogue import ANY, CHOICE, Field, Keys, Outline
from ...contracts.machine import Mount

_PATH = "mechanism.mounts"
_MASS = Field("mass", "kg", "mass of the housing, which moves with it and does not turn")


def _along_axes(unit: str, text: str, **options) -> tuple[Field, ...]:
    return tuple(Field(str(k), unit, f"{text} along {axis}", **options) for k, axis in enumerate("xy"))


_STIFFNESS = _along_axes("N/m", "stiffness of the springs")
_DAMPING = _along_axes("N*s/m", "coefficient of the dampers", low_open=False, default=0.0)
_RATIO = _along_axes("1", "damping ratio of housing and springs", low_open=False)


def mount_keys(outline: Outline, joints: Iterable[str]) -> Iterable[Keys]:
    """Yield the sections of the housings of a mechanism whose `joints` are at the ground."""
    yield Keys(
        _PATH,
        "housings that yield: springs and dampers under the ground's side of a joint, by the name of the joint",
        need="implied" if outline.mounts else "optional",
    )
    for joint in joints:
        if not {joint, ANY} & set(outline.mounts):
            yield Keys(f"{_PATH}.{joint}", "a housing", need="optional")
            continue
        path = f"{_PATH}.{joint}"
        text = (
            "the housing of a joint at the ground; it starts at rest where its springs have no force, and its weight "
            "is carried. Without this section, the joint is fixed"
        )
        yield Keys(path, text, (_MASS,), "optional", role=CHOICE)
        yield _pair(f"{path}.stiffness", "stiffness of the springs along x and y", _STIFFNESS, "required")
        ratio_text = "written in %, it is `damping_ratio`"
        yield _pair(f"{path}.damping", f"dampers along x and y; {ratio_text}", _DAMPING, "implied")
        yield _pair(f"{path}.damping_ratio", "damping over that of which nothing rings", _RATIO, "optional")


def _pair(path: str, text: str, fields: tuple[Field, ...], need: str) -> Keys:
    return Keys(path, text, fields, need, scalar_factors=(1, 1), role=CHOICE)


def mounts_of(values: Mapping, outline: Outline) -> tuple[Mount, ...]:
    """Return the housings of a case."""
    mounts = []
    for joint in outline.mounts:
        path = f"mounts.{joint}"
        mass, stiffness = values[f"{path}.mass"], _pair_of(values, f"{path}.stiffness")
        damping = _pair_of(values, f"{path}.damping")
        if f"{path}.damping_ratio.0" in values:
            ratios = _pair_of(values, f"{path}.damping_ratio")
            damping = tuple(2.0 * ratio * math.sqrt(k * mass) for ratio, k in zip(ratios, stiffness, strict=True))
        mounts.append(Mount(joint, mass, stiffness, damping))
    return tuple(mounts)


def _pair_of(values: Mapping, path: str) -> tuple[float, ...]:
    return values[f"{path}.0"], values[f"{path}.1"]
