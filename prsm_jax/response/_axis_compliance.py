"""Dynamic compliance of the axis around a mechanism, at the nut, at the load and at the motor."""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float

from .._errors import MissingDataError
from ..fields import Scalar, listed_numbers
from ..mechanism import Mechanism, of_one_design
from ..programs import AbstractResult, one_program
from ..vibration import Coordinate, SpringNetwork, spatial_harmonic_network, stage_spatial_system
from ._dissipation import (
    AnyDamping,
    AsGiven,
    Dissipation,
    checked_damping,
    dissipation,
    stage_damping,
)
from ._receptance import direct_response, magnitude


class AxisCompliance(AbstractResult):
    """Complex displacement per harmonic force at the same place.

    Infinite at an undamped natural frequency whose mode moves the place. The motor's is an angle
    per torque.
    """

    #: [Hz].
    frequency: Float[Array, " frequencies"]
    #: At the nut, along the axis; of an inverted roller screw, at the screw [m/N].
    nut: Complex[Array, " frequencies"]
    #: At the load, beyond the thrust tube, or at the end of an elastic inverted screw [m/N]; `None`
    #: if the load is fixed to the nut.
    load: Complex[Array, " frequencies"] | None
    #: At the rotor of the motor [rad/(N·m)]; `None` without a motor.
    motor: Complex[Array, " frequencies"] | None
    #: Whether one of these is infinite: the axis is driven at a pole, without a steady amplitude.
    at_pole: Bool[Array, " frequencies"]

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of a batch of responses; empty for a single design."""
        return self.frequency.shape[:-1]

    @property
    def magnitudes(self) -> dict[str, Float[Array, "*batch frequencies"]]:
        """Absolute values by place: `nut`, and `load` and `motor` if there are any."""
        given = {"nut": self.nut, "load": self.load, "motor": self.motor}
        return {name: magnitude(value) for name, value in given.items() if value is not None}


def _with_dashpot(
    losses: Dissipation, network: SpringNetwork, place: int, constant: Scalar
) -> Dissipation:
    size = len(network.coordinates)
    known = (
        jnp.zeros((size, size), network.mass.dtype) if losses.viscous is None else losses.viscous
    )
    return Dissipation(known.at[place, place].add(constant), losses.hysteretic)


@of_one_design
def axis_compliance(
    mechanism: Mechanism,
    frequency: float | Float[Array | np.ndarray, " frequencies"] | Sequence[float],
    *,
    load: float | Scalar | None = None,
    damping: AnyDamping | AsGiven | None = "given",
    sticking: bool = True,
    tilt: bool | None = None,
) -> AxisCompliance:
    """Displacement per harmonic force at nut, load and motor, all bodies moving in space.

    The position controller acts with both gains: K_p is a spring from the rotor to the housing, K_d
    a dashpot, and the damping of the stage applies to all springs in the way of its law. A force
    along the axis and a torque move harmonic 0 of the rollers alone, so the cost does not depend on
    their number. Zeros at the motor are the anti-resonances (`spatial_modal` with `motor_held`).

    Jittable, and differentiable by the numbers of the mechanism and the frequencies.

    **Arguments:**

    - `mechanism`: the mechanism, with an axis.
    - `frequency`: frequencies of the force, or one frequency [Hz]. At 0 an axis that nothing holds
      has a pole; rollers that spin freely do not matter.
    - `load`: axial load at which the contact stiffness is taken [N]; default that of the
      operating point.
    - `damping`: default that of the stage; or a law, or `None` for the controller's alone.
    - `sticking`, `tilt`: as in `spatial_modal`.

    **Raises:** `MissingDataError` if there is no axis or data are missing; `ValueError` for a stage
    without symmetry, a frequency that is not finite, or a number in place of a law of damping.
    """
    if mechanism.axis is None:
        raise MissingDataError("the mechanism has no axis around it; give [axis]")
    hertz = listed_numbers("frequency", frequency, "frequencies", "Hz")
    return _compliance(
        mechanism, hertz, load, damping=checked_damping(damping), sticking=sticking, tilt=tilt
    )


@one_program
def _compliance(
    mechanism: Mechanism,
    hertz: Float[Array, " frequencies"],
    load: float | Scalar | None,
    *,
    damping: AnyDamping | AsGiven | None,
    sticking: bool,
    tilt: bool | None,
) -> AxisCompliance:
    assert mechanism.axis is not None
    system = stage_spatial_system(mechanism, 1, load, sticking=sticking, tilt=tilt)
    assert system.axis is not None
    network, axis = spatial_harmonic_network(system, 0), system.axis
    hertz = hertz.astype(network.mass.dtype)
    moved = mechanism.stages[0].thread.family.held
    places = {"nut": Coordinate(moved, "z"), "load": Coordinate(axis.load, "z")}
    if axis.load == moved:
        del places["load"]
    losses = dissipation(network, stage_damping(mechanism.stages[0], damping))
    if axis.motor is not None:
        places["motor"] = Coordinate(axis.motor, "u")
        motor = mechanism.axis.motor
        controller = None if motor is None else motor.controller
        if controller is not None and controller.derivative_gain is not None:
            constant = controller.derivative_gain / axis.radius**2
            rotor = network.coordinates.index(places["motor"])
            losses = _with_dashpot(losses, network, rotor, constant)
    rows = {name: network.coordinates.index(one) for name, one in places.items()}
    kind = jnp.complex64 if network.mass.dtype == jnp.float32 else jnp.complex128
    columns = jnp.asarray(list(rows.values()))
    unit = jnp.zeros((len(network.coordinates), len(rows)), kind)
    unit = unit.at[columns, jnp.arange(len(rows))].set(1.0)
    loads = jnp.broadcast_to(unit, (hertz.shape[0], *unit.shape))
    steady = direct_response(network, 2 * jnp.pi * hertz, loads, losses)
    own = {name: steady.displacement[:, row, at] for at, (name, row) in enumerate(rows.items())}
    turned = own.get("motor")
    if turned is not None:
        # u = r θ under the force T/r; by parts, because infinity over a complex number is NaN.
        turned = jax.lax.complex(turned.real / axis.radius**2, turned.imag / axis.radius**2)
    at_pole = jnp.any(
        jnp.stack([steady.infinite[:, row, at] for at, row in enumerate(rows.values())]), axis=0
    )
    return AxisCompliance(hertz, own["nut"], own.get("load"), turned, at_pole)
