"""Largest stresses below the thread contacts of all stages, in one program for each measure."""

import jax
import jax.numpy as jnp

from ..contact import AxisMeasure, StageContact, StressPeak, stress_peak_on_axis
from ..mechanism import Stage, material_of


def stress_peaks_of(
    contacts: tuple[StageContact, ...], stages: tuple[Stage, ...]
) -> dict[str, dict[AxisMeasure, StressPeak]]:
    """Largest stresses in screw and nut, without friction, by side and measure.

    **Arguments:**

    - `contacts`: Hertz contacts of every stage.
    - `stages`: the stages.
    """
    # Both sides of all stages at once: one program for each measure.
    places = [(side, k) for side in ("screw", "nut") for k in range(len(contacts))]
    hertz = [getattr(contacts[k], side).hertz for side, k in places]
    arguments = (
        jnp.stack([contact.semi_major for contact in hertz]),
        jnp.stack([contact.semi_minor for contact in hertz]),
        jnp.stack([contact.max_pressure for contact in hertz]),
        jnp.stack([material_of(stages[k], side).poisson_ratio for side, k in places]),
    )
    by_side: dict[str, dict[AxisMeasure, StressPeak]] = {"screw": {}, "nut": {}}
    measures: tuple[AxisMeasure, ...] = ("von_mises", "max_shear")
    for measure in measures:

        def below(major, minor, pressure, ratio, measure: AxisMeasure = measure):
            return stress_peak_on_axis(major, minor, pressure, ratio, measure)

        peaks = jax.vmap(below)(*arguments)
        count = len(contacts)
        by_side["screw"][measure] = jax.tree.map(lambda leaf, n=count: leaf[:n], peaks)
        by_side["nut"][measure] = jax.tree.map(lambda leaf, n=count: leaf[n:], peaks)
    return by_side
