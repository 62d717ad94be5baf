"""Made-up results in which no two numbers are alike, so that none can stand for another."""

from typing import Any

import jax.numpy as jnp
import numpy as np

from prsm_jax.dynamics import SolverReport, SteadyState, Transient

TIMES, STAGES = 5, 2
_RANDOM = np.random.default_rng(31)


def _numbers(*shape: int):
    return jnp.asarray(_RANDOM.normal(size=shape) * 10.0 ** _RANDOM.integers(-9, 9, shape))


def made_transient() -> Transient:
    """Histories of two stages under a torque, with two losses."""
    per_stage = {
        name: _numbers(STAGES, TIMES)
        for name in (
            "carrier_speed",
            "carrier_ratio",
            "contact_force",
            "screw_roller_axial_force",
            "ring_gear_force",
            "carrier_force",
            "spline_friction",
            "stage_torque",
            "newton_residual",
            "carrier_acceleration",
        )
    }
    over_time = {
        name: _numbers(TIMES)
        for name in (
            "screw_speed",
            "efficiency",
            "drive_torque",
            "power_balance_residual",
            "load",
            "screw_acceleration",
            "load_power",
            "position",
        )
    }
    motion: dict[str, Any] = per_stage | over_time
    return Transient(
        time=jnp.linspace(0.0, 0.1, TIMES),
        **motion,
        losses={"thread_sliding": _numbers(TIMES), "spin": _numbers(TIMES)},
        slip_direction=_numbers(STAGES, TIMES, 3),
        sticking=jnp.asarray([True, False, False, True, True]),
        solver=SolverReport(jnp.asarray(50), jnp.asarray(3), jnp.asarray(0), "made up"),
    )


def made_steady() -> SteadyState:
    """A steady state of two stages."""
    per_stage = {
        name: _numbers(STAGES)
        for name in (
            "carrier_ratio",
            "contact_force",
            "screw_roller_axial_force",
            "nut_load",
            "slip_speed",
            "ring_gear_force",
            "carrier_force",
            "spline_friction",
        )
    }
    single = {
        name: _numbers()
        for name in (
            "efficiency",
            "screw_speed",
            "drive_torque",
            "input_power",
            "output_power",
            "power_balance_residual",
        )
    }
    return SteadyState(
        **per_stage,
        **single,
        losses={"drag": _numbers()},
        slip_direction=_numbers(STAGES, 3),
        valid=jnp.asarray(True),
    )
