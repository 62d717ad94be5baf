"""One pair of threads in Hertz contact, by curvature convention: one program for two papers."""

import dataclasses
import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from ..contact import stage_contact
from ..fields import as_scalar
from ..mechanism import CURVATURE_CONVENTIONS, Stage, Thread
from ._examples import example, given

#: Axial forces on the pair of threads [N].
LOADS = (25.0, 50.0, 100.0)


@dataclasses.dataclass(frozen=True)
class PairOfThreads:
    """Largest pressure [Pa], axial secant stiffness [N/m], semi-axes [m] at each of `LOADS`."""

    pressure: np.ndarray
    axial_stiffness: np.ndarray
    semi_major: np.ndarray
    semi_minor: np.ndarray


@eqx.filter_jit
def _contacts(stage: Stage, loads):
    def at(load):
        return {
            name: stage_contact(dataclasses.replace(stage, curvature=name), load)
            for name in CURVATURE_CONVENTIONS
        }

    return jax.vmap(at)(loads)


@functools.cache
def pairs_of_threads(name: str) -> dict[str, dict[str, PairOfThreads]]:
    """Contacts of one pair of threads of an example, by curvature convention and side.

    Only thread and material of the example are used: a roller with one loaded thread.
    """
    original = example(name).stages[0]
    thread = Thread(
        lead=original.thread.lead,
        starts=original.thread.starts,
        roller_radius=original.thread.roller_radius,
        contact_angle=original.thread.contact_angle,
    )
    material = dataclasses.replace(given(original.material), density=None)
    stage = Stage(thread=thread, roller_count=1, material=material, engaged_threads=as_scalar(1.0))
    contacts = _contacts(stage, jnp.asarray(LOADS))
    return {
        convention: {
            side: PairOfThreads(
                np.asarray(getattr(contact, side).hertz.max_pressure),
                np.asarray(getattr(contact, side).axial_stiffness),
                np.asarray(getattr(contact, side).hertz.semi_major),
                np.asarray(getattr(contact, side).hertz.semi_minor),
            )
            for side in ("screw", "nut")
        }
        for convention, contact in contacts.items()
    }
