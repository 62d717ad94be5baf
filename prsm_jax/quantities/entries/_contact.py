"""Quantities of the thread contacts."""

import jax.numpy as jnp

from .._analysis import Analysis
from .._catalogue import quantity
from .._onsets import truncated_pressure


def _over_stages(analysis: Analysis, side: str, name: str):
    return jnp.stack([getattr(getattr(c, side).hertz, name) for c in analysis.contacts])


def _pressure(analysis: Analysis, side: str):
    """Largest pressures of one side, above Hertz's if the end of a flank cuts the ellipse."""
    return jnp.stack(
        [
            truncated_pressure(analysis, i, side, getattr(c, side).hertz.max_pressure)
            for i, c in enumerate(analysis.contacts)
        ]
    )


@quantity(
    "max_pressure",
    "p₀",
    "Pa",
    "largest pressure of the thread contacts, all threads equally loaded (for the most loaded "
    "thread see max_pressure_shared): Hertz pressure, higher where the end of a flank cuts the "
    "ellipse, without the concentration at that edge",
    assumes=("equal_contacts", "flanks_of_contacts"),
)
def max_pressure(analysis: Analysis):
    return jnp.max(jnp.stack([_pressure(analysis, side) for side in ("screw", "nut")]))


@quantity(
    "max_pressure_screw",
    "p₀_s",
    "Pa",
    "largest pressure on the screw side, as `max_pressure`",
    ("stage",),
    assumes=("equal_contacts", "flanks_of_contacts"),
)
def max_pressure_screw(analysis: Analysis):
    return _pressure(analysis, "screw")


@quantity(
    "max_pressure_nut",
    "p₀_n",
    "Pa",
    "largest pressure on the nut side, as `max_pressure`",
    ("stage",),
    assumes=("equal_contacts", "flanks_of_contacts"),
)
def max_pressure_nut(analysis: Analysis):
    return _pressure(analysis, "nut")


@quantity(
    "semi_major_screw",
    "a_s",
    "m",
    "major semi-axis on the screw side",
    ("stage",),
    assumes=("equal_contacts",),
)
def semi_major_screw(analysis: Analysis):
    return _over_stages(analysis, "screw", "semi_major")


@quantity(
    "semi_minor_screw",
    "b_s",
    "m",
    "minor semi-axis on the screw side",
    ("stage",),
    assumes=("equal_contacts",),
)
def semi_minor_screw(analysis: Analysis):
    return _over_stages(analysis, "screw", "semi_minor")


@quantity(
    "approach_screw",
    "δ_s",
    "m",
    "normal approach on the screw side",
    ("stage",),
    assumes=("equal_contacts",),
)
def approach_screw(analysis: Analysis):
    return _over_stages(analysis, "screw", "approach")


@quantity(
    "approach_nut",
    "δ_n",
    "m",
    "normal approach on the nut side",
    ("stage",),
    assumes=("equal_contacts",),
)
def approach_nut(analysis: Analysis):
    return _over_stages(analysis, "nut", "approach")


@quantity(
    "max_von_mises_screw",
    "σ_v,s",
    "Pa",
    "largest equivalent stress (von Mises) in the screw below a thread contact, without friction",
    ("stage",),
    assumes=("equal_contacts",),
)
def max_von_mises_screw(analysis: Analysis):
    return analysis.stress_peaks["screw"]["von_mises"].value


@quantity(
    "max_von_mises_nut",
    "σ_v,n",
    "Pa",
    "largest equivalent stress (von Mises) in the nut below a thread contact, without friction",
    ("stage",),
    assumes=("equal_contacts",),
)
def max_von_mises_nut(analysis: Analysis):
    return analysis.stress_peaks["nut"]["von_mises"].value


@quantity(
    "max_shear_stress_screw",
    "τ_s",
    "Pa",
    "largest shear stress in the screw below a thread contact, without friction",
    ("stage",),
    assumes=("equal_contacts",),
)
def max_shear_stress_screw(analysis: Analysis):
    return analysis.stress_peaks["screw"]["max_shear"].value


@quantity(
    "max_shear_stress_nut",
    "τ_n",
    "Pa",
    "largest shear stress in the nut below a thread contact, without friction",
    ("stage",),
    assumes=("equal_contacts",),
)
def max_shear_stress_nut(analysis: Analysis):
    return analysis.stress_peaks["nut"]["max_shear"].value


@quantity(
    "max_shear_depth_screw",
    "z_s",
    "m",
    "depth of the largest shear stress in the screw, which a hardened layer must exceed",
    ("stage",),
    assumes=("equal_contacts",),
)
def max_shear_depth_screw(analysis: Analysis):
    return analysis.stress_peaks["screw"]["max_shear"].position[..., 2]


@quantity(
    "max_shear_depth_nut",
    "z_n",
    "m",
    "depth of the largest shear stress in the nut, which a hardened layer must exceed",
    ("stage",),
    assumes=("equal_contacts",),
)
def max_shear_depth_nut(analysis: Analysis):
    return analysis.stress_peaks["nut"]["max_shear"].position[..., 2]


@quantity(
    "thread_stiffness_screw",
    "k_sR",
    "N/m",
    "thread contact stiffness of one roller with the screw; of the first roller if they differ",
    ("stage",),
    assumes=("equal_stiffness",),
    shares=("operating_point",),
)
def thread_stiffness_screw(analysis: Analysis):
    return jnp.stack([threads.screw_roller for threads in analysis.threads])


@quantity(
    "thread_stiffness_nut",
    "k_nR",
    "N/m",
    "thread contact stiffness of one roller with the nut; of the first roller if they differ",
    ("stage",),
    assumes=("equal_stiffness",),
    shares=("operating_point",),
)
def thread_stiffness_nut(analysis: Analysis):
    return jnp.stack([threads.nut_roller for threads in analysis.threads])
