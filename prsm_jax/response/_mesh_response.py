"""Vibration excited by the contacts: amplitudes and dynamic forces over screw speed."""

from collections.abc import Sequence
from typing import Annotated, Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float

from ..fields import In, Scalar, listed_numbers
from ..mechanism import Mechanism, of_one_design, stage_at
from ..programs import one_program, physics
from ..results import DesignResult
from ..vibration import (
    Coordinate,
    Spring,
    SpringNetwork,
    VibrationSystem,
    spring_network,
    stage_system,
)
from ._dissipation import AnyDamping, AsGiven, checked_damping, stage_damping
from ._orders import (
    ExcitationOrder,
    excitation_orders,
    find_order,
    roller_phases,
    working_carrier_ratio,
)
from ._poles import shape_rounding
from ._receptance import Solver, harmonic_response, magnitude


class MeshResponse(DesignResult):
    """Steady vibration under one harmonic of an excitation in the contacts, by screw speed.

    Amplitudes are complex: the vibration is `Re(amplitude · e^{iωt})`. If an undamped mode is
    driven at its natural frequency, they are infinite where it moves a coordinate, and so are the
    forces in springs that it stretches.
    """

    #: Screw speed [rad/s].
    speed: Annotated[Float[Array, " speeds"], In("rad/s")]
    #: Frequency of the excitation [Hz].
    frequency: Annotated[Float[Array, " speeds"], In("Hz")]
    #: Amplitude of every coordinate [m]; rotations as u = r θ.
    displacement: Annotated[Complex[Array, "speeds coordinates"], In("m")]
    #: Force in every spring, positive in tension; in contacts from elongation minus error [N].
    spring_force: Annotated[Complex[Array, "speeds springs"], In("N")]
    #: Whether any of them is infinite.
    at_pole: Annotated[Bool[Array, " speeds"], In("1")]
    coordinates: tuple[Coordinate, ...] = eqx.field(static=True)
    springs: tuple[Spring, ...] = eqx.field(static=True)

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of a batch of responses; empty for a single design."""
        return self.speed.shape[:-1]

    def amplitude(self, coordinate: str) -> Float[Array, "*batch speeds"]:
        """Amplitude of one coordinate, such as `"screw u"` [m].

        **Raises:** `ValueError` if there is none of that name.
        """
        return magnitude(self.displacement[..., _place(self.coordinates, coordinate)])

    def force(self, spring: str) -> Float[Array, "*batch speeds"]:
        """Amplitude of the dynamic force of one spring, such as `"ring_roller 3"` [N].

        The name of a kind of spring, such as `"ring_roller"`, gives the largest of all rollers.

        **Raises:** `ValueError` if there is none of that name.
        """
        kind = [k for k, one in enumerate(self.springs) if one.name == spring]
        places = kind or [_place(self.springs, spring)]
        return jnp.max(magnitude(self.spring_force[..., jnp.asarray(places)]), axis=-1)


def _place(known: tuple[Any, ...], name: str) -> int:
    names = [str(one) for one in known]
    if name not in names:
        raise ValueError(f"{name!r} does not exist; choose one of {', '.join(names)}")
    return names.index(name)


def mesh_errors(
    system: VibrationSystem,
    network: SpringNetwork,
    order: ExcitationOrder,
    harmonic: int,
    amplitude: Scalar,
) -> Complex[Array, " springs"]:
    """Complex elongation error of every spring under one harmonic of an excitation [m].

    `e_i = amplitude · e^{i h φ_i lobes}` in the contacts on which the excitation acts, 0 elsewhere.
    """
    phase = dict(
        zip(
            system.roller_numbers,
            roller_phases(order, harmonic, system.roller_positions),
            strict=True,
        )
    )
    zero = jnp.zeros((), network.stiffness.dtype)
    acts = [spring.name in order.springs for spring in network.springs]
    angle = jnp.stack(
        [
            phase[spring.roller] if on and spring.roller is not None else zero
            for on, spring in zip(acts, network.springs, strict=True)
        ]
    )
    size = amplitude * jnp.asarray(acts, angle.dtype)
    return jax.lax.complex(size * jnp.cos(angle), size * jnp.sin(angle))


@physics("mesh_excitation")
def excited_response(
    system: VibrationSystem,
    order: ExcitationOrder,
    speed: Float[Array, " speeds"],
    amplitude: Scalar,
    *,
    harmonic: int = 1,
    damping: AnyDamping | None = None,
    method: Solver = "direct",
) -> MeshResponse:
    """Vibration of a system that is excited by errors of its contacts.

    The error e of a contact is a deflection without force, so its spring force is `k (g q − e)` and
    the load on the coordinates is `gᵀ k e`, summed over all rollers with their phases.

    **Arguments:**

    - `system`: masses and springs of a stage.
    - `order`: the excitation.
    - `speed`: screw speeds [rad/s].
    - `amplitude`: amplitude of the error in each contact, along its line of action [m].
    - `harmonic`: which harmonic of the excitation.
    - `damping`, `method`: as `harmonic_response`.

    **Raises:** `ValueError` for a harmonic below 1.
    """
    if harmonic < 1:
        raise ValueError(f"harmonic is {harmonic}; the first is 1")
    network = spring_network(system)
    errors = mesh_errors(system, network, order, harmonic, amplitude)
    stiffness, rows = (a.astype(errors.dtype) for a in (network.stiffness, network.rows))
    load = rows.T @ (stiffness * errors)
    omega = harmonic * order.order * speed
    loads = jnp.broadcast_to(load[None, :, None], (speed.shape[0], load.shape[0], 1))
    steady = harmonic_response(network, jnp.abs(omega), loads, damping, method)
    moved, residue = steady.displacement[:, :, 0], steady.residue[:, :, 0]
    force = stiffness[None, :] * (steady.limit[:, :, 0] @ rows.T - errors[None, :])
    # An undamped mode at its natural frequency stretches some springs, and moves others as a whole.
    stretch = jnp.abs(residue @ rows.T)
    rounded = shape_rounding(network.rows) * (jnp.abs(residue) @ jnp.abs(network.rows).T)
    force = jnp.where(stretch <= rounded, force, jnp.full_like(force, jnp.inf))
    return MeshResponse(
        speed,
        jnp.abs(omega) / (2 * jnp.pi),
        moved,
        force,
        steady.at_pole,
        network.coordinates,
        network.springs,
    )


@of_one_design
def mesh_response(
    mechanism: Mechanism,
    speed: float | Float[Array | np.ndarray, " speeds"] | Sequence[float],
    *,
    order: str = "ring_gear_mesh",
    harmonic: int = 1,
    amplitude: float | Scalar = 1e-6,
    stage: int = 1,
    load: float | Scalar | None = None,
    damping: AnyDamping | AsGiven | None = "given",
    carrier_ratio: float | Scalar | None = None,
    method: Solver = "direct",
) -> MeshResponse:
    """Vibration of one stage under a kinematic excitation of its contacts, by screw speed.

    **Arguments:**

    - `mechanism`: the mechanism; as for `modal`.
    - `speed`: screw speeds, or one speed [rad/s].
    - `order`: name of the excitation, one of `excitation_orders`.
    - `harmonic`: which harmonic of it, from 1.
    - `amplitude`: transmission error along the line of action of each contact [m].
    - `stage`, `load`, `damping`, `method`: as `frequency_response`.
    - `carrier_ratio`: ζ; default that of the steady state.

    **Raises:** `ValueError` for an order that the stage does not have, or a speed that is not
    finite; `MissingDataError` if the mechanism lacks data.
    """
    return _response(
        mechanism,
        listed_numbers("speed", speed, "speeds", "rad/s"),
        amplitude,
        load,
        carrier_ratio,
        order=order,
        harmonic=harmonic,
        stage=stage,
        damping=checked_damping(damping),
        method=method,
    )


@one_program
def _response(
    mechanism: Mechanism,
    speed: Float[Array, " speeds"],
    amplitude: float | Scalar,
    load: float | Scalar | None,
    carrier_ratio: float | Scalar | None,
    *,
    order: str,
    harmonic: int,
    stage: int,
    damping: AnyDamping | AsGiven | None,
    method: Solver,
) -> MeshResponse:
    chosen = stage_at(mechanism, stage)
    ratio = working_carrier_ratio(mechanism, stage) if carrier_ratio is None else carrier_ratio
    system = stage_system(mechanism, stage, load)
    dtype = system.roller_equivalent_mass.dtype
    return excited_response(
        system,
        find_order(excitation_orders(chosen, ratio), order),
        speed.astype(dtype),
        jnp.asarray(amplitude, dtype),
        harmonic=harmonic,
        damping=stage_damping(chosen, damping),
        method=method,
    )
