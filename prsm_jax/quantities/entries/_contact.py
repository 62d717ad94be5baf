"""Quantities of the thread contacts."""

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float

from .._analysis import Analysis
from .._catalogue import quantity
from .._onsets import equal_pressure


def _pressure(analysis: Analysis, side: str):
    """Largest pressures of one side, above Hertz's if the end of a flank cuts the ellipse."""
    stages = range(len(analysis.mechanism.stages))
    return jnp.stack([equal_pressure(analysis, index, side) for index in stages])


@quantity(
    "max_pressure",
    "p₀",
    "Pa",
    "largest pressure of the thread contacts, all threads equally loaded (for the most loaded "
    "thread see max_pressure_shared): Hertz pressure, higher where the end of a flank cuts the "
    "ellipse, without the concentration at that edge",
    assumes=(
        "equal_contacts",
        "flanks_of_contacts",
        "contacts_without_preload",
        "contacts_without_friction",
    ),
)
def max_pressure(analysis: Analysis):
    return jnp.max(stage_pressures(analysis))


def stage_pressures(analysis: Analysis) -> Float[Array, " stages"]:
    """`max_pressure` of every stage [Pa]."""
    return jnp.maximum(_pressure(analysis, "screw"), _pressure(analysis, "nut"))


def _on_sides(
    name: str,
    symbol: str,
    unit: str,
    description: str,
    function: Callable[..., Any],
    assumes: tuple[str, ...] = (
        "equal_contacts",
        "contacts_without_preload",
        "contacts_without_friction",
    ),
    *,
    sides: tuple[str, ...] = ("screw", "nut"),
    **declared,
) -> None:
    """Add a function of an analysis and a side; `{side}` and `{s}` stand for the side's name."""
    for side in sides:
        names = {"side": side, "s": side[0]}
        add = quantity(
            f"{name}_{side}",
            symbol.format(**names),
            unit,
            description.format(**names),
            ("stage",),
            assumes=assumes,
            **declared,
        )
        add(lambda analysis, side=side: function(analysis, side))


def _of_hertz(name: str) -> Callable[..., Any]:
    return lambda analysis, side: jnp.stack(
        [getattr(getattr(contact, side).hertz, name) for contact in analysis.contacts]
    )


_on_sides(
    "max_pressure",
    "p₀_{s}",
    "Pa",
    "largest pressure on the {side} side, as `max_pressure`",
    _pressure,
    (
        "equal_contacts",
        "flanks_of_contacts",
        "contacts_without_preload",
        "contacts_without_friction",
    ),
)
for _name, _symbol, _axis in (("semi_major", "a_{s}", "major"), ("semi_minor", "b_{s}", "minor")):
    _description = _axis + " semi-axis on the {side} side"
    _on_sides(_name, _symbol, "m", _description, _of_hertz(_name), sides=("screw",))
_on_sides("approach", "δ_{s}", "m", "normal approach on the {side} side", _of_hertz("approach"))
_on_sides(
    "max_von_mises",
    "σ_v,{s}",
    "Pa",
    "largest equivalent stress (von Mises) in the {side} below a thread contact, without friction",
    lambda analysis, side: analysis.stress_peaks[side]["von_mises"].value,
)
_on_sides(
    "max_shear_stress",
    "τ_{s}",
    "Pa",
    "largest shear stress in the {side} below a thread contact, without friction",
    lambda analysis, side: analysis.stress_peaks[side]["max_shear"].value,
)
_on_sides(
    "max_shear_depth",
    "z_{s}",
    "m",
    "depth of the largest shear stress in the {side}, which a hardened layer must exceed",
    lambda analysis, side: analysis.stress_peaks[side]["max_shear"].position[..., 2],
)
_on_sides(
    "thread_stiffness",
    "k_{s}R",
    "N/m",
    "thread contact stiffness of one roller with the {side}; of the first roller if they differ",
    lambda analysis, side: jnp.stack([getattr(one, f"{side}_roller") for one in analysis.threads]),
    ("equal_stiffness", "stiffness_without_preload"),
    shares=("operating_point",),
)
