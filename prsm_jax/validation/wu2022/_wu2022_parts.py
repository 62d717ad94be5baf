"""Wu et al. 2022: support stiffnesses of Table 4, checked by its masses."""

from collections.abc import Iterator

import numpy as np

from .._difference import differs, not_comparable
from .._examples import example, given
from .._registry import rows_of
from .._row import Row
from ._cylinders import DENSITY, cantilever_length, sleeve_radius, solid_length, torsional

#: Table 4, for the roller, whose bending stiffness the paper's model never uses [N/m].
_ROLLER_BENDING = 2.199e5


@rows_of("wu2022")
def lengths() -> Iterator[Row]:
    """Table 4, mass and bending stiffness of screw and roller: each implies a length."""
    stage = example("wu2022").stages[0]
    material = given(stage.material)
    modulus = float(material.youngs_modulus)
    thread = stage.thread
    for name, body, radius, printed, bending, bounds in (
        (
            "roller",
            stage.roller,
            thread.roller_radius,
            "0.0326",
            _ROLLER_BENDING,
            (0.03293, 0.03294),
        ),
        ("screw", stage.screw, thread.screw_radius, "1.265", None, (1.091, 1.0912)),
    ):
        if bending is None:
            bending = float(given(given(body.support).radial_stiffness))
        radius = float(radius)
        bent = cantilever_length(modulus, radius, bending)
        weighed = solid_length(float(given(body.mass)), radius)
        yield not_comparable(
            f"Table 4: mass of the {name}, a cylinder as long as its bending stiffness implies",
            printed,
            DENSITY * np.pi * radius**2 * bent,
            "kg",
            between=bounds,
            missing=f"neither length nor density are printed. The bending stiffness, {bending:.4g} "
            "N/m, belongs to a cantilever (fixed at one end, as in the paper's finite elements) "
            f"of {1e3 * bent:.1f} mm at E 212 GPa; the mass at 7850 kg/m³ to a length of "
            f"{1e3 * weighed:.1f} mm, {100 * abs(bent / weighed - 1):.2g} % away",
        )


@rows_of("wu2022")
def torsional_stiffnesses() -> Iterator[Row]:
    """Table 4, torsional stiffnesses, whose unit is neither the printed nor the used one."""
    stage = example("wu2022").stages[0]
    thread, material = stage.thread, given(stage.material)
    modulus = float(material.youngs_modulus)
    shear = modulus / (2 * (1 + float(material.poisson_ratio)))
    screw, nut = float(thread.screw_radius), float(thread.nut_radius)
    length = solid_length(float(given(stage.screw.mass)), screw)
    radial = given(given(stage.screw.support).radial_stiffness)
    bent = cantilever_length(modulus, screw, float(radial))
    shaft = torsional(shear, screw, 0.0, length, screw)
    yield differs(
        "Table 4: torsional stiffness of the screw",
        "6.241e4",
        shaft,
        "N/m",
        between=(5.21e7, 5.22e7),
        evidence=1e-3 * shaft * length / bent,
        evidence_between=(6.0e4, 6.1e4),
        because="printed in N·m/rad but used on the displacement u = r θ, so it is in N/m. A solid "
        f"shaft of 24 mm and {length:.3f} m (its length by mass) has G I_p/l = "
        f"{shaft * screw**2:.0f} N·m/rad, in N/m the computed value: the printed number is "
        "neither. Read in N/mm, 6.241e7 N/m, it belongs to a length of "
        f"{1e3 * length * shaft / 6.241e7:.0f} mm, close to the {1e3 * bent:.0f} mm of its bending "
        "stiffness: a factor of 1000 seems to be lost (evidence: the stiffness of that length in "
        "N/mm, 3 % from the printed number)",
    )
    width = solid_length(float(given(stage.roller.mass)), float(thread.roller_radius))
    outer = sleeve_radius(float(given(stage.nut.mass)), nut, width)
    sleeve = torsional(shear, outer, nut, width, nut)
    yield differs(
        "Table 4: torsional stiffness of the nut",
        "9.359e6",
        sleeve,
        "N/m",
        between=(7.69e9, 7.70e9),
        evidence=1e-3 * sleeve,
        evidence_between=(7.69e6, 7.70e6),
        because=f"a sleeve of the nut's mass, as long as the roller ({1e3 * width:.1f} mm by its "
        f"mass) and thus of {2e3 * outer:.1f} mm outside diameter, has the computed value, "
        f"{sleeve * nut**2:.3g} N·m/rad: the printed number is 1.22 times this stiffness in N/mm "
        "(the evidence)",
    )
