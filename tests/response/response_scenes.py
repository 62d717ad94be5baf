"""Scenes and compiled functions that the tests of forced vibration share."""

import dataclasses
import functools

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from scenes import example

import prsm_jax as prsm
from prsm_jax.mechanism import (
    ModalDamping,
    RayleighDamping,
    Roller,
    StructuralDamping,
    Support,
    UnequalRoller,
)
from prsm_jax.response import (
    campbell,
    dissipation,
    frequency_response,
    harmonic_response,
    mesh_response,
)
from prsm_jax.vibration import spring_network, stage_system

LAWS = {
    "undamped": None,
    "modal": ModalDamping(0.02),
    "rayleigh": RayleighDamping(50.0, 1e-7),
    "structural": StructuralDamping(0.03),
}


def with_rollers(*unequal, translating=False, y_stiffness=None):
    """Wu's mechanism with unequal rollers, rollers that translate, or an anisotropic support."""
    one = example("wu2022")
    stage = one.stages[0]
    changes = {"unequal_roller": tuple(unequal)}
    if translating:
        changes["roller"] = Roller(stage.roller.mass, stage.roller.inertia, support=Support(2.2e5))
    if y_stiffness is not None:
        support = Support(stage.screw.support.radial_stiffness, 6.241e4, y_stiffness)
        changes["screw"] = eqx.tree_at(lambda s: s.support, stage.screw, support)
    return replaced(one, **changes)


def replaced(mechanism, **changes):
    """A mechanism whose first stage has some fields exchanged."""
    stage = dataclasses.replace(mechanism.stages[0], **changes)
    return dataclasses.replace(mechanism, stages=(stage, *mechanism.stages[1:]))


@functools.cache
def _unequal():
    return with_rollers(
        UnequalRoller(2, stiffness_factor=0.8, mass_factor=1.1),
        UnequalRoller(4, position_offset=0.05),
        UnequalRoller(6, missing=True),
        y_stiffness=5e5,
    )


SCENES = {
    "symmetric": functools.cache(with_rollers),
    "unequal": _unequal,
    "translating": functools.cache(lambda: with_rollers(translating=True)),
}


def network_of(mechanism):
    """Springs and masses of the first stage."""
    return _network(mechanism)


response = eqx.filter_jit(frequency_response)
chart = eqx.filter_jit(campbell)
vibration = eqx.filter_jit(mesh_response)
modal = eqx.filter_jit(functools.partial(prsm.modal, shapes=True))
_network = eqx.filter_jit(lambda mechanism: spring_network(stage_system(mechanism, 1)))


@eqx.filter_jit
def all_receptances(network, omega, damping, method):
    """Displacement of every coordinate per force at every one, and the poles."""
    size = len(network.coordinates)
    loads = jnp.broadcast_to(jnp.eye(size, dtype=complex), (omega.shape[0], size, size))
    found = harmonic_response(network, omega, loads, damping, method)
    return found.displacement, found.at_pole


def matrices(network, damping=None):
    """K, M, C, H as NumPy arrays."""
    size = len(network.coordinates)
    found = dissipation(network, damping)
    return (
        np.asarray(network.stiffness_matrix()),
        np.diag(np.asarray(network.mass)),
        np.zeros((size, size)) if found.viscous is None else np.asarray(found.viscous),
        np.zeros((size, size)) if found.hysteretic is None else np.asarray(found.hysteretic),
    )


@functools.cache
def natural(name):
    """Natural circular frequencies of a scene [rad/s]."""
    return 2 * np.pi * np.asarray(modal(SCENES[name]()).frequencies)
