"""Spin in the contacts of inverted and differential roller screws, by quadrature in NumPy."""

import dataclasses

import numpy as np
import pytest
import scipy.special
from scenes import array, mesh

import prsm_jax as prsm
from prsm_jax.contact import contact_frames, side_contact
from prsm_jax.friction import CoulombFriction, Friction, SpinFriction
from prsm_jax.geometry import flanks_of
from prsm_jax.geometry._flanks import nut_side_hessian, screw_side_hessian
from prsm_jax.mechanism import Mechanism
from tests.type_motion import mechanism, slips_of

SPEED, LOAD, MU = 100.0, 20e3, 0.08


def _ellipse(stage, meshing, side, force):
    """Semi-axes [m] and their unit vectors in space, flattest direction of the gap first."""
    contact = getattr(meshing, side)
    angle = float(contact.contact_angle_position)
    x, y = (contact.contact_radius * f(angle) for f in (np.cos, np.sin))
    of_side = screw_side_hessian if side == "screw" else nut_side_hessian
    bend = of_side(flanks_of(stage.thread), x, y)
    hessian = np.array([[bend.xx, bend.xy], [bend.xy, bend.yy]], float)
    normal = np.array([float(part) for part in contact.normal_parts])
    slope = -normal[:2] / normal[2]
    # Two orthonormal tangents, and the gap over them.
    across = np.append(slope, slope @ slope)
    tangents = [np.array([-slope[1], slope[0], 0.0]), across]
    tangents = [one / np.linalg.norm(one) for one in tangents]
    flat = np.array([one[:2] for one in tangents])
    values, vectors = np.linalg.eigh(flat @ hessian @ flat.T)
    assert values[0] < values[1]
    frames = contact_frames(stage.thread, meshing, "exact")
    frame = frames[0 if side == "screw" else 1]
    hertz = side_contact(stage, side, frame, array(force / float(stage.engaged_threads)), "exact")
    axes = [vectors[:, k] @ np.array(tangents) for k in range(2)]
    return (float(hertz.hertz.semi_major), float(hertz.hertz.semi_minor)), axes, normal


def _rubbing_power(semi_axes, axes, slip, spin_vector, force):
    """∫ μ p |v + ω n × r| dA with Hertz pressure, μ = 1 [W]."""
    radii, weights = np.polynomial.legendre.leggauss(60)
    # r dr √(1 − r²) from 0 to 1, with s = √(1 − r²) as the variable.
    s, ws = (radii + 1) / 2, weights / 2
    turns = 2 * np.pi * np.arange(240) / 240
    total = 0.0
    for height, weight in zip(s, ws, strict=True):
        r = np.sqrt(1 - height**2)
        places = (
            semi_axes[0] * r * np.cos(turns)[:, None] * axes[0]
            + semi_axes[1] * r * np.sin(turns)[:, None] * axes[1]
        )
        local = slip + np.cross(spin_vector, places)
        total += weight * height**2 * np.linalg.norm(local, axis=1).mean()
    return force * total / (1 / 3)


@pytest.mark.parametrize("kind", ["standard", "inverted", "differential"])
def test_power_of_slip_and_spin_by_quadrature(kind):
    """Of the side that slides, over its true ellipse, to the error of the package's rule, 1e-10."""
    one = mechanism(kind, extra=False)
    friction = Friction(thread=CoulombFriction(MU), spin=SpinFriction(MU))
    (stage,) = one.stages
    stage = dataclasses.replace(stage, friction=friction)
    found = prsm.steady_state(Mechanism((stage,)), array(SPEED), array(LOAD))
    assert found.result_name == "successful"
    assert float(found.power_balance_residual) < 1e-12
    meshing, family = mesh(stage.thread), stage.thread.family
    slips, _ = slips_of(stage.thread, meshing, [float(found.carrier_ratio[0])], kind)
    (side,) = family.sliding
    other = "nut" if side == "screw" else "screw"
    count, carrier = stage.roller_count, float(found.carrier_ratio[0]) * SPEED
    ratio = {"inverted": float(stage.thread.screw_ratio)}.get(kind, -float(stage.thread.nut_ratio))
    roller = carrier * (1 + ratio)
    force = float(found.contact_force[0])
    axes, directions, normal = _ellipse(stage, meshing, side, force)
    spin = (SPEED - roller) * normal[2] * normal
    power = MU * count * _rubbing_power(axes, directions, SPEED * slips[side], spin, force)
    # The other side spins only: 3/8 μ F a E(m). Its force follows from the axial balance.
    held = -LOAD / count / float(getattr(meshing, other).normal_parts[2])
    held_axes, _, held_normal = _ellipse(stage, meshing, other, abs(held))
    modulus = 1 - (held_axes[1] / held_axes[0]) ** 2
    moment = 3 / 8 * MU * abs(held) * held_axes[0] * scipy.special.ellipe(modulus)
    power += count * moment * abs(roller * held_normal[2])
    losses = float(found.losses["thread_sliding"] + found.losses["spin"])
    assert losses == pytest.approx(power, rel=1e-9)
