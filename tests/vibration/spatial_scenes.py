"""A stage with every spring that the model in space knows, and its compiled functions."""

import dataclasses
import functools

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from present import present
from scenes import example

from prsm_jax import vibration
from prsm_jax.mechanism import Support
from prsm_jax.stiffness import ThreadStiffness

#: Axial stiffness of one roller at the screw and at the nut [N/m].
THREADS = ThreadStiffness(jnp.asarray(2.078e8), jnp.asarray(2.198e8))

system_of = eqx.filter_jit(vibration.spatial_system)
network_of = eqx.filter_jit(vibration.spatial_network)
modes_of = eqx.filter_jit(vibration.spatial_modes)


def held_stage(roller_count=7):
    """Wu's stage with pins, and with axial supports of screw, nut and rollers."""
    stage = example("wu2022").stages[0]

    def supported(body, **stiffness):
        support = present(body.support) if body.support is not None else Support()
        return dataclasses.replace(body, support=dataclasses.replace(support, **stiffness))

    return dataclasses.replace(
        stage,
        roller_count=roller_count,
        screw=supported(stage.screw, axial_stiffness=3e8),
        nut=supported(stage.nut, axial_stiffness=1.5e8),
        roller=supported(stage.roller, radial_stiffness=2.199e7, axial_stiffness=4e6),
        carrier=supported(present(stage.carrier), radial_stiffness=5e7, axial_stiffness=2e7),
    )


@functools.cache
def held_system(roller_count=7):
    return system_of(held_stage(roller_count), THREADS)


def free_stage(stage):
    """The stage without supports of the bodies on the axis."""
    without = {
        name: dataclasses.replace(getattr(stage, name), support=None)
        for name in ("screw", "nut", "ring_gear", "carrier")
    }
    return dataclasses.replace(stage, **without)


def frequencies_of(stiffness, rows, mass):
    """Ascending frequencies [Hz] by LAPACK's singular values of √k G M^(-1/2)."""
    root = np.sqrt(np.asarray(stiffness))[:, None] * np.asarray(rows) / np.sqrt(np.asarray(mass))
    values = np.linalg.svd(root, compute_uv=False)
    return np.sort(values) / (2 * np.pi)


def number(value):
    """A number of a mechanism that must be present, as a plain float."""
    return float(present(value))
