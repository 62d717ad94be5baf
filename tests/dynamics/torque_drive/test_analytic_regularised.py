"""What smoothing Coulomb friction over a slip ε costs: creep and power where it should stick."""

import equinox as eqx
import numpy as np
import pytest
from scenes import array, mechanism, stage, thread

import prsm_jax as prsm
from prsm_jax.dynamics import locking_coefficient, stage_kinematics
from prsm_jax.dynamics.steady._carrier_balance import slip_per_turn
from prsm_jax.friction import Friction, RegularisedCoulombFriction

FRICTION, LOAD = 0.7, 300.0


def _one(width):
    """Self-locking: exact friction would hold the load for ever."""
    law = RegularisedCoulombFriction(FRICTION, width)
    geometry = thread(contact_angle=np.pi / 3)
    return mechanism(stage(friction=Friction(thread=law), geometry=geometry))


@eqx.filter_jit
def _held(one):
    scenario = prsm.TorqueScenario(
        array(0.0), prsm.scenario.HingeLoad(array(LOAD)), array(0.2), samples=21
    )
    return prsm.simulate(one, scenario, rtol=1e-8, atol=1e-10, method="rosenbrock", throw=False)


def test_a_held_load_creeps_in_proportion_to_the_width():
    """Friction that is just needed, m μ with m = μ_lock/μ, takes a slip v = ε m/√(1 − m²).

    So the error against exact friction falls linearly with ε, in position and in power: the load
    gives N m μ F v, about μ F ε per contact.
    """
    geometry = stage_kinematics(_one(1e-3).stages[0])
    share = float(locking_coefficient(geometry)) / FRICTION
    per_turn = float(np.linalg.norm(slip_per_turn(geometry).at(None)))
    for width in (1e-2, 1e-3, 1e-4, 1e-5):
        run = _held(_one(width))
        assert int(run.solver.code) == 0
        slip = width * share / np.sqrt(1 - share**2)
        assert float(run.screw_speed[-1]) == pytest.approx(-slip / per_turn, rel=1e-5)
        lost = float(run.losses["thread_sliding"][-1])
        force = float(run.contact_force[0, -1])
        assert lost == pytest.approx(10 * share * FRICTION * force * slip, rel=1e-5)
        assert lost == pytest.approx(-float(run.load_power[-1]), rel=1e-5)
