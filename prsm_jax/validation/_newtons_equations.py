"""Newton's equations of one stage, solved independently of the rest of the toolkit."""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import numpy as np

from ..dynamics import slip_velocity
from ..friction import CoulombFriction, ViscousFriction
from ._examples import given, kinematics, scene


@dataclasses.dataclass(frozen=True)
class NewtonSolution:
    """Solution of Newton's equations at every time; tangential forces on one end of a roller."""

    #: ω̇ [rad/s²]
    carrier_acceleration: np.ndarray
    #: Of the ring gear, and of the pin of one carrier [N].
    ring_gear: np.ndarray
    pin: np.ndarray
    #: Friction of the screw on a roller, in the carrier's frame: radial, tangential, axial [N].
    friction: np.ndarray


@functools.cache
def newtons_equations(name: str, stage: int, printed: bool = False) -> NewtonSolution:
    """Solve Li et al. 2020, equations 17 (tangential), 18 and 28, at a constant screw speed.

    Unknown are the tangential forces of ring gear and pin and the carriers' acceleration; the
    normal force of the thread is taken from the transient.

    **Arguments:**

    - `name`: a shipped example of these papers.
    - `stage`: index of the stage, from 0.
    - `printed`: equation 17 as printed, without the ring gear's force and with the printed
      sign of the inertia, instead of Newton's law.
    """
    mechanism, run = scene(name)
    part = mechanism.stages[stage]
    thread, geometry = part.thread, kinematics(name)[stage]
    law = part.thread_law
    force = np.asarray(run.contact_force[stage])[:, None]
    slip = np.asarray(
        jax.vmap(slip_velocity, in_axes=(None, 0, 0))(
            geometry, jnp.asarray(run.screw_speed), jnp.asarray(run.carrier_speed[stage])
        )
    )
    if isinstance(law, CoulombFriction):
        length = np.linalg.norm(slip, axis=1, keepdims=True)
        friction = float(law.coefficient) * force * slip / length
    else:
        assert isinstance(law, ViscousFriction)
        friction = float(law.coefficient) * slip
    screw = force * np.asarray(geometry.meshing.screw.normal) + friction
    nut_normal = np.asarray(geometry.meshing.nut.normal)
    nut = -screw[:, 2:] / nut_normal[2] * nut_normal

    side, count = geometry.meshing.screw, part.present_roller_count
    radius, centre = float(thread.roller_radius), float(thread.centre_distance)
    arm, angle = float(side.roller_contact_radius), float(side.roller_angle_position)
    mass = float(given(part.roller.mass)) * centre
    spin = float(given(part.roller.inertia)) * (float(thread.starts) - 1)
    matrix = np.array(
        [
            [0.0 if printed else 2.0, 2.0, mass if printed else -mass],
            [2 * radius, 0.0, spin],
            [0.0, -count * centre, -float(given(given(part.carrier).inertia))],
        ]
    )
    moment = radius * nut[:, 1] - arm * (np.cos(angle) * screw[:, 1] + np.sin(angle) * screw[:, 0])
    known = np.stack([screw[:, 1] + nut[:, 1], moment, np.zeros_like(moment)])
    gear, pin, acceleration = np.linalg.solve(matrix, -known)
    return NewtonSolution(acceleration, gear, pin, friction)
