"""Modal analysis of one stage of a mechanism."""

from ..contact import load_of
from ..fields import Scalar
from ..mechanism import Mechanism, of_one_design, stage_at
from ..programs import one_program, physics
from ..stiffness import stiffness_under_load
from ._dense import stage_modes
from ._modes import Modes
from .model import VibrationSystem, vibration_system


@of_one_design
@one_program
@physics("modal")
def modal(
    mechanism: Mechanism,
    *,
    stage: int = 1,
    load: float | Scalar | None = None,
    shapes: bool = False,
) -> Modes:
    """Natural frequencies and families of one stage, bending–torsional (Wu et al. 2022).

    A stage with equal, evenly spaced rollers and supports that are equal in x and y is solved by
    symmetry, at a cost that does not depend on N; any other (`unequal_roller`,
    `radial_stiffness_y`) with all its degrees of freedom. The entries that are present decide
    which of the two is traced, not their numbers. Rollers also translate if `roller.support` is
    given.

    **Arguments:**

    - `mechanism`: the mechanism; the stage needs masses, inertias and supports, and either given
      thread stiffnesses or materials and engaged threads.
    - `stage`: which stage, counted from 1. Each stage vibrates on its own in this model.
    - `load`: axial load at which the contact stiffness is taken [N]; default that of the operating
      point, and not needed where the stiffnesses are given.
    - `shapes`: also give mass-normalised mode shapes and energy shares.

    **Raises:** `MissingDataError` if data are missing; `ValueError` for a stage that does not
    exist.
    """
    return stage_modes(stage_system(mechanism, stage, load), shapes=shapes)


def stage_system(
    mechanism: Mechanism, stage: int, load: float | Scalar | None = None
) -> VibrationSystem:
    """Masses and springs of one stage, with the contact stiffness at a load [N].

    **Raises:** `MissingDataError` if data are missing; `ValueError` for an unknown stage.
    """
    chosen = stage_at(mechanism, stage)
    threads = stiffness_under_load(chosen, lambda: load_of(mechanism, load))
    return vibration_system(chosen, threads)
