"""Entries of a transient that follow from its powers."""

import functools
from typing import Any

import jax.numpy as jnp

from ...fields import Scalar

#: A torque that is smaller than this share of that at the other end is 0 up to rounding.
_NOTHING = 1e-12


def relative(residual: Scalar, scale: Scalar) -> Scalar:
    """Residual over its scale; without load the absolute residual."""
    return jnp.abs(residual) / jnp.where(scale > 0, scale, 1.0)


def power_entries(
    torque: Scalar,
    load_torque: Scalar,
    speed: Scalar,
    load_power: Scalar,
    losses: dict[str, Scalar],
    kinetic: Scalar,
    stored: Scalar | None = None,
) -> dict[str, Any]:
    """Torque, efficiency and powers at one time, and the residual of their balance.

    **Arguments:**

    - `torque`, `load_torque`: of the drive, and of the load without friction [N·m].
    - `speed`: Ω [rad/s].
    - `load_power`, `losses`: what the load absorbs and what friction does [W].
    - `kinetic`, `stored`: rates of the kinetic energy and of that of the bristles [W].
    """
    drive_power = torque * speed
    largest = functools.reduce(jnp.maximum, map(jnp.abs, (drive_power, load_power, kinetic)))
    imbalance = drive_power - load_power - sum(losses.values()) - kinetic
    if stored is not None:
        imbalance = imbalance - stored
    driving = speed * load_torque >= 0
    useful = jnp.where(driving, load_torque, torque)
    spent = jnp.where(driving, torque, load_torque)
    # A torque of 0, which the balance of forces gives up to rounding, spends nothing. NaN remains.
    takes = ~(jnp.abs(spent) <= _NOTHING * jnp.abs(useful))
    return {
        "drive_torque": torque,
        "efficiency": jnp.where(takes, useful / jnp.where(takes, spent, 1.0), 0.0),
        "losses": losses,
        "load_power": load_power,
        "power_balance_residual": relative(imbalance, largest),
    }
