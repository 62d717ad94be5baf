"""Analytic references, in addition to the papers."""

from collections.abc import Iterator

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from ..contact import hertz_contact
from ._difference import formula
from ._examples import steady, two_stages
from ._registry import rows_of
from ._row import Row

_NAME = "li2020_two_stage"
_CITATION = "closed forms: Hertz (Johnson, Contact Mechanics, 1985), friction on an inclined plane"
_ALONE = (("spline.coefficient", 0.0), ("thrust_bearing.coefficient", 0.0))


@rows_of("closed_forms", _CITATION)
def sphere_on_plane() -> Iterator[Row]:
    """Circular Hertz contact: steel sphere of 10 mm radius on a steel plane, 100 N."""
    force, radius = 100.0, 0.010
    modulus = 210e9 / (2 * (1 - 0.3**2))
    size = (3 * force * radius / (4 * modulus)) ** (1 / 3)
    contact = eqx.filter_jit(hertz_contact)(
        jnp.asarray(force), jnp.asarray(1 / radius), jnp.asarray(0.0), jnp.asarray(modulus)
    )
    note = "the general elliptical contact at its circular limit"
    for item, closed, value, scale, unit in (
        ("radius a = (3FR/4E*)^⅓", size, contact.semi_major, 1e3, "mm"),
        (
            "pressure p₀ = 3F/2πa²",
            1.5 * force / (np.pi * size**2),
            contact.max_pressure,
            1e-6,
            "MPa",
        ),
        ("approach δ = a²/R", size**2 / radius, contact.approach, 1e6, "µm"),
        ("stiffness dF/dδ = 2E*a", 2 * modulus * size, contact.stiffness_tangent, 1e-6, "N/µm"),
    ):
        printed = f"{closed * scale:.8g}"
        yield formula(f"sphere on plane: {item}", printed, float(value) * scale, unit, note=note)


@rows_of("closed_forms")
def inclined_plane() -> Iterator[Row]:
    """Efficiency of the thread alone, to first order in the helix angle squared."""
    tangent = np.tan(max(float(s.thread.screw_helix_angle) for s in two_stages(_NAME).stages))
    note = (
        "(1 − μ tan α)/(1 + μ cot α) forward, (1 − μ cot α)/(1 + μ tan α) backward, flank angle α; "
        "neglected are terms of μ cot α tan²λ, which is the tolerance"
    )
    for friction in (0.05, 0.10):
        for degrees in (45.0, 60.0):
            flank_angle = np.radians(90.0 - degrees)
            changes = (
                *_ALONE,
                ("thread.coefficient", friction),
                ("contact_angle", float(np.radians(degrees))),
            )
            forward = (1 - friction * np.tan(flank_angle)) / (1 + friction / np.tan(flank_angle))
            backward = (1 - friction / np.tan(flank_angle)) / (1 + friction * np.tan(flank_angle))
            for name, closed, sense in (("forward", forward, 1.0), ("backward", backward, -1.0)):
                yield formula(
                    f"efficiency {name}, μ {friction:.2f}, contact angle {degrees:.0f}°",
                    f"{closed:.6f}",
                    float(steady(_NAME, *changes, sense=sense).efficiency),
                    tolerance=friction * tangent**2 / np.tan(flank_angle),
                    note=note,
                )


@rows_of("closed_forms")
def rolling_without_lead() -> Iterator[Row]:
    """Carrier ratio r_s/2a as the lead vanishes."""
    still = steady(_NAME, *_ALONE, ("lead", 1e-6))
    for stage, ratio in zip(two_stages(_NAME).stages, still.carrier_ratio, strict=True):
        thread = stage.thread
        ideal = float(thread.screw_radius / (2 * thread.centre_distance))
        millimetres = 1e3 * float(thread.screw_radius)
        yield formula(
            f"carrier ratio at a lead of 1 µm, screw radius {millimetres:g} mm",
            f"{ideal:.7f}",
            float(ratio),
            note="r_s/2a, rolling without slip on the nominal circles",
        )
