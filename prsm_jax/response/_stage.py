"""The vibrating system of one stage of a mechanism, and its damping from the file."""

from typing import Literal

import jax.numpy as jnp

from ..contact import load_of
from ..fields import Scalar
from ..mechanism import Mechanism, Stage, stage_at
from ..stiffness import loaded_threads, thread_stiffness
from ..vibration import VibrationSystem, vibration_system
from ._dissipation import AnyDamping

#: Use the damping of the mechanism, if it has any.
AsGiven = Literal["given"]


def stage_system(
    mechanism: Mechanism, stage: int, load: float | Scalar | None = None
) -> VibrationSystem:
    """Masses and springs of one stage, with the contact stiffness at a load [N].

    **Raises:** `MissingDataError` if data are missing; `ValueError` for an unknown stage.
    """
    chosen = stage_at(mechanism, stage)
    threads = thread_stiffness(
        chosen, lambda: loaded_threads(chosen, jnp.abs(load_of(mechanism, load)))
    )
    return vibration_system(chosen, threads)


def stage_damping(stage: Stage, damping: AnyDamping | AsGiven | None) -> AnyDamping | None:
    """The damping to use: that of the stage, or the given one."""
    return stage.damping if isinstance(damping, str) else damping
