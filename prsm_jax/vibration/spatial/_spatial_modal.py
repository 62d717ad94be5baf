"""Modal analysis in space of one stage of a mechanism."""

from ...contact import load_of
from ...fields import Scalar
from ...geometry import mesh
from ...mechanism import Mechanism, of_one_design, stage_at
from ...programs import one_program, physics
from ...stiffness import stiffness_under_load
from ._modes import SpatialModes, spatial_modes
from ._system import SpatialSystem, spatial_system


def tilts(mechanism: Mechanism, tilt: bool | None) -> bool:
    """Whether bodies tilt: as given, or as the axis says."""
    if tilt is not None:
        return tilt
    return mechanism.axis is not None and mechanism.axis.tilt


def stage_spatial_system(
    mechanism: Mechanism,
    stage: int = 1,
    load: float | Scalar | None = None,
    *,
    sticking: bool = True,
    standstill: bool = False,
    motor_held: bool = False,
    tilt: bool | None = None,
) -> SpatialSystem:
    """Masses and springs in space of one stage of a mechanism, and of the axis around it.

    **Arguments, raises:** as `spatial_modal`.
    """
    chosen = stage_at(mechanism, stage)
    meshing = mesh(chosen.thread)
    threads = stiffness_under_load(chosen, lambda: load_of(mechanism, load), meshing, tangent=True)
    return spatial_system(
        chosen,
        threads,
        meshing,
        sticking=sticking,
        standstill=standstill,
        axis=mechanism.axis,
        motor_held=motor_held,
        tilt=tilts(mechanism, tilt),
    )


@of_one_design
@one_program
@physics("spatial_modal")
def spatial_modal(
    mechanism: Mechanism,
    *,
    stage: int = 1,
    load: float | Scalar | None = None,
    sticking: bool = True,
    standstill: bool = False,
    shapes: bool = False,
    motor_held: bool = False,
    tilt: bool | None = None,
) -> SpatialModes:
    """Natural frequencies and families of one stage whose bodies move in space.

    Unlike in `modal` (Wu et al. 2022), bodies also move along the axis, thread contacts are stiff
    along their true normals only, and the lead couples rotation with axial motion. Vibration is
    small, so the contacts have their tangent stiffness at the load. What the file does not hold is
    free: a mechanism without axial supports has rigid motions, of frequency 0, and so has every
    roller that no pin ties to the carrier, because it rolls in the nut while the screw's thread
    slides on it (in an inverted roller screw the other way round). In a differential roller screw
    such rolling moves the nut along the axis, and in a recirculating one the rollers: friction,
    which has no stiffness, holds them while they slide.

    Where the mechanism has an `axis`, motor, elastic screw and load vibrate with the stage. The
    proportional gain of a position controller is a spring; damping is left out (see
    `prsm_jax.response.axis_compliance`).

    **Arguments:**

    - `mechanism`: the mechanism; the stage needs masses and inertias, and either given thread
      stiffnesses or materials and engaged threads.
    - `stage`: which stage, counted from 1. Each stage vibrates on its own.
    - `load`: axial load at which the contact stiffness is taken [N]; default that of the operating
      point, and not needed where the stiffnesses are given.
    - `sticking`: whether contacts that roll (at the nut of a standard roller screw) have Mindlin's
      tangential stiffness.
    - `standstill`: whether the mechanism stands still, as a servo drive that holds its position: no
      contact slides, and all have the tangential stiffness.
    - `shapes`: also give mass-normalised mode shapes and energy shares.
    - `motor_held`: whether the rotor of the axis' motor does not turn. The frequencies of the group
      `axial_torsional` are then the anti-resonances at the motor.
    - `tilt`: whether screw, nut and rollers also tilt (see `spatial_system`); default as
      `axis.tilt` says, and not without an axis. It needs their lengths, and the number of engaged
      threads.

    **Raises:** `MissingDataError` if data are missing; `ValueError` for a stage that does not
    exist, fewer than 3 or unequal rollers, supports that differ in x and y, a motor that is to be
    held and does not exist, and tilt with carriers other than two.
    """
    system = stage_spatial_system(
        mechanism,
        stage,
        load,
        sticking=sticking,
        standstill=standstill,
        motor_held=motor_held,
        tilt=tilt,
    )
    return spatial_modes(system, shapes=shapes)
