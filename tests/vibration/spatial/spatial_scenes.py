"""A stage with every spring that the model in space knows, and its compiled functions."""

import dataclasses
import functools

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from present import present
from scenes import example

from prsm_jax import vibration
from prsm_jax.mechanism import (
    Axis,
    AxisLoad,
    AxisShaft,
    FarBearing,
    Motor,
    PositionController,
    Support,
)
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


#: An axis with every part.
AXIS = Axis(
    motor=Motor(
        inertia=3e-3,
        shaft_stiffness=1.2e5,
        coupling_stiffness=4e4,
        controller=PositionController(proportional_gain=60.0, derivative_gain=0.7),
    ),
    shaft=AxisShaft(nut_distance=0.23, far_bearing=FarBearing(0.37, 2e8)),
    load=AxisLoad(mass=150.0, tube_stiffness=4.5e8),
)


def axis_stage(roller_count=7):
    """The held stage with an elastic screw that a motor may turn, and a nut that a load moves."""
    stage = held_stage(roller_count)

    def without(body, name):
        support = dataclasses.replace(present(body.support), **{name: None})
        return dataclasses.replace(body, support=support)

    screw = without(stage.screw, "torsional_stiffness")
    return dataclasses.replace(
        stage,
        screw=dataclasses.replace(screw, length=0.4, bore_radius=3e-3),
        nut=without(stage.nut, "axial_stiffness"),
        carrier=without(present(stage.carrier), "axial_stiffness"),
    )


def rolling_stage():
    """The same with rollers that only the threads hold: no pins, teeth, or support of carriers."""
    stage = axis_stage()
    return dataclasses.replace(
        stage,
        roller=dataclasses.replace(stage.roller, support=None),
        carrier=dataclasses.replace(present(stage.carrier), support=None),
        ring_gear=dataclasses.replace(present(stage.ring_gear), support=None),
        gear=None,
        stiffness=dataclasses.replace(present(stage.stiffness), ring_roller=None),
    )


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


def assert_shapes_solve(found, network):
    """Shapes of all degrees of freedom are orthonormal and solve K φ = ω² M φ."""
    values = (2 * np.pi * np.asarray(found.frequencies)) ** 2
    shapes, mass = np.asarray(found.shapes), np.asarray(network.mass)
    np.testing.assert_allclose(shapes.T @ (mass[:, None] * shapes), np.eye(len(mass)), atol=1e-12)
    force = np.asarray(network.stiffness_matrix()) @ shapes
    size = np.abs(values * mass[:, None] * shapes).max()
    np.testing.assert_allclose(force, values * mass[:, None] * shapes, atol=1e-12 * size)
