"""Modal analysis of one stage of a mechanism."""

import jax.numpy as jnp

from .._physics import physics
from ..contact import load_of, stage_contact
from ..mechanism import Mechanism, Scalar
from ..stiffness import thread_stiffness
from ._modes import Modes, symmetric_modes
from ._system import vibration_system


@physics("modal")
def modal(mechanism: Mechanism, *, stage: int = 1, load: float | Scalar | None = None) -> Modes:
    """Natural frequencies and families of one stage, bending–torsional (Wu et al. 2022).

    **Arguments:**

    - `mechanism`: the mechanism; the stage needs masses, inertias and supports, and either given
      thread stiffnesses or materials and engaged threads.
    - `stage`: which stage, counted from 1. Each stage vibrates on its own in this model.
    - `load`: axial load at which the contact stiffness is taken [N]; default that of the operating
      point, and not needed where the stiffnesses are given.

    **Raises:** `MissingDataError` if data are missing; `ValueError` for a stage that is not
    there, or fewer than 3 rollers.
    """
    if not 1 <= stage <= len(mechanism.stages):
        raise ValueError(f"stage is {stage}; the mechanism has stages 1 to {len(mechanism.stages)}")
    chosen = mechanism.stages[stage - 1]
    threads = thread_stiffness(
        chosen, lambda: stage_contact(chosen, jnp.abs(load_of(mechanism, load)))
    )
    return symmetric_modes(vibration_system(chosen, threads))
