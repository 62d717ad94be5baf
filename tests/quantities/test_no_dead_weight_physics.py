"""What a mechanism does not model leaves no trace in the program; what it models does.

Every law is labelled in the jaxpr. Each case shows both sides, so a label that is lost, or a law
that is always there, fails. Tracing only: nothing is compiled.
"""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import FIRST_STAGE_LOSSES, array, equal_shares, example, mechanism, stage, thread

import prsm_jax as prsm
from prsm_jax.friction import (
    CoulombFriction,
    Drag,
    Friction,
    LuGreFriction,
    RegularisedCoulombFriction,
    RollingHysteresis,
    SpinFriction,
    SplineFriction,
    StribeckFriction,
    ThrustBearingFriction,
    ViscousFriction,
)
from prsm_jax.mechanism import Carrier, GivenStiffness, Nut, Roller, UnequalRoller

COULOMB = CoulombFriction(0.05)

#: Loss of a stage, the label of its law, and what else it brings along.
LOSSES = {
    "coulomb": (Friction(thread=COULOMB), "coulomb_friction", set()),
    "viscous": (Friction(thread=ViscousFriction(25.0)), "viscous_friction", set()),
    "regularised": (
        Friction(thread=RegularisedCoulombFriction(0.05, 1e-3)),
        "regularised_coulomb_friction",
        set(),
    ),
    "stribeck": (
        Friction(thread=StribeckFriction(0.1, 0.05, 0.1)),
        "stribeck_friction",
        set(),
    ),
    "spin": (
        Friction(thread=COULOMB, spin=SpinFriction(0.05)),
        "spin_friction",
        {"hertz", "carrier_balance", "coulomb_friction"},
    ),
    "rolling hysteresis": (
        Friction(thread=COULOMB, rolling_hysteresis=RollingHysteresis(0.01)),
        "rolling_hysteresis",
        {"hertz", "carrier_balance", "coulomb_friction"},
    ),
    "spline": (Friction(spline=SplineFriction(0.1, 12e-3)), "spline_friction", set()),
    "thrust bearing": (
        Friction(thrust_bearing=ThrustBearingFriction(0.005, 20e-3)),
        "thrust_bearing_friction",
        set(),
    ),
    "drag": (Friction(drag=Drag(0.05)), "drag", set()),
}
ALL_LABELS = {label for _, label, _ in LOSSES.values()} | {"hertz", "carrier_balance"}
#: Always there in a steady state with gears.
ALWAYS = {"steady_state", "meshing", "gear_tooth_force"}


def _steady(one):
    return prsm.programs.traced_physics(prsm.steady_state, one)


def _two_stages(friction):
    return mechanism(stage(friction=Friction()), stage(friction=friction, geometry=thread(5e-3)))


@pytest.mark.parametrize("name", LOSSES)
def test_each_loss_is_traced_only_where_it_is_modelled(name):
    friction, label, company = LOSSES[name]
    assert _steady(_two_stages(friction)) == ALWAYS | {label} | company
    assert not _steady(_two_stages(Friction())) & ALL_LABELS


@pytest.mark.parametrize("name", LOSSES)
def test_each_loss_is_traced_in_transients_only_where_it_is_modelled(name):
    friction, label, company = LOSSES[name]
    scenario = prsm.Scenario(array(100.0), array(7e3), array(1e-3), samples=3)

    def run(one):
        return prsm.simulate(one, scenario, method="explicit", throw=False).efficiency

    # The carrier's balance is a differential equation here.
    expected = ({label} | company) - {"carrier_balance"}
    found = prsm.programs.traced_physics(run, _two_stages(friction))
    assert found & (ALL_LABELS - {"carrier_balance"}) == expected
    assert {"carrier_dynamics", "carrier_inertia"} <= found


def test_bristles_are_states_only_where_threads_have_them():
    """In a steady state, and in balance at every instant, LuGre friction has none."""
    bristles = {"bristles", "bristle_dynamics"}
    scenario = prsm.Scenario(array(100.0), array(7e3), array(1e-3), samples=3)

    def run(one, method):
        return prsm.programs.traced_physics(
            lambda m: prsm.simulate(m, scenario, method=method, throw=False).efficiency, one
        )

    lugre = _two_stages(Friction(thread=LuGreFriction(0.1, 0.08, 0.1, 1e5, 4.0)))
    assert _steady(lugre) == ALWAYS | {"lugre_friction"}
    assert bristles <= run(lugre, "rosenbrock")
    assert not bristles & run(lugre, "quasi_steady")
    assert not bristles & run(_two_stages(Friction(thread=COULOMB)), "rosenbrock")


def test_no_friction_at_all():
    one = mechanism(stage())
    without = eqx.tree_at(lambda m: m.stages[0].friction, one, None)
    assert _steady(without) == ALWAYS
    assert _steady(one) == ALWAYS | {"coulomb_friction"}


def test_no_gear():
    assert "gear_tooth_force" in _steady(mechanism(stage()))
    assert "gear_tooth_force" not in _steady(mechanism(stage(gear=None)))


@pytest.mark.parametrize("method", ["rosenbrock", "quasi_steady"])
def test_a_transient_traces_its_own_method_only(method):
    """No balance of the carriers where they are integrated, at constant speed not even then."""

    def run(one, speed):
        scenario = prsm.Scenario(speed, array(7e3), array(1e-3), samples=3)
        return prsm.simulate(one, scenario, method=method, throw=False).efficiency

    one = mechanism(stage())
    steady = prsm.programs.traced_physics(lambda m: run(m, array(100.0)), one)
    moving = prsm.programs.traced_physics(lambda m: run(m, _Ramp()), one)
    balanced = method == "quasi_steady"
    assert ("quasi_steady" in steady) == ("quasi_steady" in moving) == balanced
    assert "carrier_balance" not in steady
    assert ("carrier_balance" in moving) == balanced
    assert "torque_drive" not in steady | moving


NEWTON = {"newton", "free_bodies"}


@pytest.mark.parametrize("name", LOSSES)
def test_forces_on_every_part_are_traced_on_request_only(name):
    """Neither a transient nor a steady state cuts bodies free; of friction only what is there."""
    friction, label, company = LOSSES[name]
    one = _two_stages(friction)
    scenario = prsm.Scenario(array(100.0), array(7e3), array(1e-3), samples=3)

    def run(m):
        return prsm.simulate(m, scenario, method="explicit", throw=False)

    assert not prsm.programs.traced_physics(run, one) & NEWTON
    assert not _steady(one) & NEWTON
    instant = prsm.dynamics.Instant(array(100.0), array([20.0, 30.0]), array(7e3))
    found = prsm.programs.traced_physics(prsm.dynamics.body_forces, one, instant)
    laws = ({label} | company) - {"carrier_balance"}
    assert found == {"meshing", "gear_tooth_force"} | NEWTON | laws


def test_forces_at_constant_speed_leave_the_masses_of_screws_untraced():
    moving = prsm.dynamics.Instant(array(100.0), array([20.0]), array(7e3), array(1e3))
    steady = eqx.tree_at(lambda i: i.screw_acceleration, moving, None)
    one = mechanism(stage())
    assert "screw_inertia" in prsm.programs.traced_physics(prsm.dynamics.body_forces, one, moving)
    assert "screw_inertia" not in prsm.programs.traced_physics(
        prsm.dynamics.body_forces, one, steady
    )


class _Ramp(eqx.Module):
    rate: float = 1.0

    def __call__(self, time):
        return 100.0 + self.rate * time


@pytest.mark.parametrize(("speed", "traced"), [(array(100.0), False), (_Ramp(), True)])
def test_constant_speed_leaves_inertia_but_the_carriers_untraced(speed, traced):
    scenario = prsm.Scenario(speed, array(7e3), array(1e-3), samples=3)
    found = prsm.programs.traced_physics(
        lambda m: prsm.simulate(m, scenario, method="explicit", throw=False).drive_torque,
        mechanism(stage()),
    )
    assert ("screw_inertia" in found) == traced
    assert ("axial_inertia" in found) == traced
    assert "carrier_inertia" in found


def test_constant_speed_does_not_even_need_the_masses_of_screw_and_nut():
    bare = eqx.tree_at(
        lambda m: [
            m.stages[0].screw.mass,
            m.stages[0].screw.inertia,
            m.stages[0].nut.mass,
            m.stages[0].nut.inertia,
        ],
        mechanism(stage()),
        [None] * 4,
    )

    def run(speed):
        scenario = prsm.Scenario(speed, array(7e3), array(1e-3), samples=3)
        return eqx.filter_eval_shape(
            lambda m: prsm.simulate(m, scenario, method="explicit", throw=False), bare
        )

    assert run(array(100.0)).efficiency.shape == (3,)
    with pytest.raises(prsm.MissingDataError, match="nut has neither mass"):
        run(_Ramp())


def _wu(**parts):
    """Wu's stage with parts exchanged or taken away."""
    one = example("wu2022")
    names = list(parts)
    return eqx.tree_at(
        lambda m: [getattr(m.stages[0], name) for name in names],
        one,
        [parts[name] for name in names],
        is_leaf=lambda x: x is None,
    )


def _modal(one):
    return prsm.programs.traced_physics(prsm.modal, one)


BLOCKS = {
    "modal",
    "torsional_modes",
    "torsional_springs",
    "transverse_modes",
    "transverse_springs",
    "roller_modes",
    "carrier_mode",
}


def test_given_stiffnesses_leave_contact_and_gear_untraced():
    """All three given: neither meshing nor Hertz nor ISO 6336."""
    assert _modal(_wu()) == BLOCKS
    derived = _modal(_wu(stiffness=None))
    # Wu's curvatures are closed forms: no meshing either.
    assert derived == BLOCKS | {"hertz", "gear_mesh_stiffness"}
    partly = _modal(_wu(stiffness=GivenStiffness(2.078e8, 2.198e8)))
    assert partly == BLOCKS | {"gear_mesh_stiffness"}
    threads = _modal(_wu(stiffness=GivenStiffness(ring_roller=2.464e8)))
    assert threads == BLOCKS | {"hertz"}


def test_no_ring_gear():
    """Without a ring gear its mesh stiffness is not computed, and its row is not there."""
    without = _wu(ring_gear=None, stiffness=GivenStiffness(2.078e8, 2.198e8))
    assert _modal(without) == BLOCKS
    modes = eqx.filter_eval_shape(prsm.modal, without)
    assert modes.group("torsional").frequencies.shape == (3,)
    assert eqx.filter_eval_shape(prsm.modal, _wu()).group("torsional").frequencies.shape == (4,)


def test_no_carrier():
    assert _modal(_wu(carrier=None)) == BLOCKS - {"carrier_mode"}
    assert "carrier_mode" in _modal(_wu(carrier=Carrier(inertia=1e-5)))


DENSE = {"modal", "dense_assembly", "dense_modes", "carrier_mode"}


def test_the_scene_decides_between_the_two_paths():
    """Nothing of the dense path for a symmetric stage, nothing of the blocks for any other."""
    unequal = _wu(unequal_roller=(UnequalRoller(3, stiffness_factor=0.9),))
    assert _modal(unequal) == DENSE
    held = prsm.mechanism.Support(1e8, 1e6, radial_stiffness_y=2e8)
    assert _modal(_wu(nut=Nut(2.0, 8e-4, support=held))) == DENSE
    assert _modal(prsm.set_parameter(example("wu2022"), "roller_count", 2)) == DENSE


def test_shapes_are_traced_on_request_only():
    one = example("wu2022")
    found = prsm.programs.traced_physics(lambda m: prsm.modal(m, shapes=True).shapes, one)
    assert found == BLOCKS | {"dense_assembly"}
    assert "dense_assembly" not in _modal(one)


def test_rollers_that_translate():
    """Harmonic networks instead of the arrowhead blocks, and no carrier by itself."""
    moving = _wu(roller=Roller(0.03, 5e-7, support=prsm.mechanism.Support(1e8)))
    families = {"torsional_modes", "transverse_modes", "roller_modes"}
    assert _modal(moving) == {"modal", "harmonic_network"} | families


def test_one_family_alone():
    """A quantity of one family does not trace the others."""
    found = prsm.programs.traced_physics(
        lambda m: prsm.compute(m, ["lowest_torsional_frequency"]), example("wu2022")
    )
    assert "torsional_modes" in found
    assert not found & {"transverse_modes", "roller_modes", "carrier_mode", "dense_modes"}


def test_three_rollers_have_no_roller_modes():
    three = prsm.set_parameter(example("wu2022"), "roller_count", 3)
    assert _modal(three) == BLOCKS - {"roller_modes"}


@pytest.mark.parametrize(
    ("convention", "meshed"), [("exact", True), ("wu2022", False), ("lisowski2014", False)]
)
def test_only_exact_curvatures_need_the_meshing(convention, meshed):
    one = mechanism(stage(curvature=convention))
    found = prsm.programs.traced_physics(lambda m: prsm.compute(m, ["max_pressure"]), one)
    assert found == {"hertz"} | ({"meshing"} if meshed else set())


#: Pressures of ellipses that the ends of the flanks may cut.
_PRESSURE = {"meshing", "hertz", "flank_ends", "truncation"}
#: Quantity, and the laws that it may trace in the actuator, which has data for everything.
NEEDS = {
    "centre_distance": set(),
    "mass": set(),
    "roller_clearance": set(),
    "equivalent_load": set(),
    "buckling_safety": {"buckling"},
    "critical_speed_margin": {"whirling"},
    "axial_backlash": {"meshing", "backlash"},
    "static_safety": _PRESSURE | {"static_capacity"},
    "rating_life": _PRESSURE | {"dynamic_capacity", "rating_life"},
    "duty_cycle_damage": _PRESSURE | {"dynamic_capacity", "damage"},
    "nut_speed": set(),
    "axial_gap": {"meshing"},
    "gear_mesh_stiffness": {"gear_mesh_stiffness"},
    "max_pressure": _PRESSURE,
    "axial_stiffness": {"meshing", "hertz"},
    "carrier_frequency": {"meshing", "hertz", "gear_mesh_stiffness", "carrier_mode"},
    "lowest_torsional_frequency": {
        "meshing",
        "hertz",
        "gear_mesh_stiffness",
        "torsional_modes",
        "torsional_springs",
    },
    "lowest_transverse_frequency": {
        "meshing",
        "hertz",
        "gear_mesh_stiffness",
        "transverse_modes",
        "transverse_springs",
    },
    "lowest_critical_speed": ALWAYS
    | {
        "hertz",
        "gear_mesh_stiffness",
        "torsional_modes",
        "torsional_springs",
        "transverse_modes",
        "transverse_springs",
        "carrier_balance",
        "coulomb_friction",
        "spin_friction",
        "rolling_hysteresis",
        "thrust_bearing_friction",
        "drag",
    },
    "roller_frequency": {"meshing", "hertz", "gear_mesh_stiffness", "roller_modes"},
    "efficiency": ALWAYS
    | {
        "hertz",
        "carrier_balance",
        "coulomb_friction",
        "spin_friction",
        "rolling_hysteresis",
        "thrust_bearing_friction",
        "drag",
    },
}


@pytest.mark.parametrize("name", NEEDS)
def test_a_quantity_evaluates_nothing_that_it_does_not_need(name):
    found = prsm.programs.traced_physics(
        lambda m: prsm.compute(m, [name]), equal_shares("actuator")
    )
    assert found == NEEDS[name]


#: Quantities that look at the shared load, where the stage has one.
SHARED = (
    "static_safety",
    "rating_life",
    "duty_cycle_damage",
    "axial_stiffness",
    "carrier_frequency",
    "lowest_torsional_frequency",
    "lowest_transverse_frequency",
    "lowest_critical_speed",
    "roller_frequency",
)


@pytest.mark.parametrize("name", NEEDS)
def test_only_what_looks_at_the_shared_load_traces_it(name):
    """The shipped actuator says how its threads share."""
    found = prsm.programs.traced_physics(lambda m: prsm.compute(m, [name]), example("actuator"))
    chains = {"thread_chains", "flank_force", "tooth_compliance"}
    assert found == NEEDS[name] | (chains if name in SHARED else set())


def test_carrier_ratio_without_contact_losses_is_geometry():
    one = mechanism(stage())
    assert prsm.programs.traced_physics(lambda m: prsm.compute(m, ["carrier_ratio"]), one) == {
        "meshing"
    }
    lossy = mechanism(stage(friction=FIRST_STAGE_LOSSES))
    assert "steady_state" in prsm.programs.traced_physics(
        lambda m: prsm.compute(m, ["carrier_ratio"]), lossy
    )


def _equations(jaxpr):
    """All equations of a jaxpr, nested ones included."""
    count = 0
    for equation in jaxpr.eqns:
        count += 1
        for value in equation.params.values():
            for inner in value if isinstance(value, tuple | list) else (value,):
                inner = getattr(inner, "jaxpr", inner)
                if hasattr(inner, "eqns"):
                    count += _equations(inner)
    return count


def _size(one, names):
    jaxpr, _, _ = eqx.filter_make_jaxpr(lambda m: prsm.compute(m, names))(one)
    return _equations(jaxpr.jaxpr)


def test_what_quantities_share_is_evaluated_once():
    """Two pressures cost little more than one; all of the steady state no second steady state."""
    one = equal_shares("actuator")
    pressure = _size(one, ["max_pressure_screw"])
    assert _size(one, ["max_pressure_screw", "max_pressure_nut"]) < 1.1 * pressure
    efficiency = _size(one, ["efficiency"])
    shared = _size(one, ["efficiency", "drive_torque", "contact_force", "loss_power"])
    assert shared < 1.05 * efficiency
    assert _size(one, ["efficiency", "axial_stiffness"]) < efficiency + pressure


def test_a_smaller_mechanism_is_a_smaller_program():
    """Not only labels: the number of equations falls with every part that is left out."""
    full = mechanism(stage(friction=FIRST_STAGE_LOSSES))
    sizes = [_size(full, ["efficiency"])]
    for name in ("spin", "rolling_hysteresis", "thrust_bearing", "drag", "thread"):
        full = eqx.tree_at(lambda m, name=name: getattr(m.stages[0].friction, name), full, None)
        sizes.append(_size(full, ["efficiency"]))
    assert all(np.diff(sizes) < 0)


def test_the_search_finds_labels_inside_transformations():
    """`traced_physics` would be blind if it missed laws under jit, grad, vmap or loops."""
    one = mechanism(stage())

    def efficiency(m):
        return prsm.steady_state(m).efficiency

    batch = eqx.filter_vmap(lambda lead: prsm.set_parameter(one, "lead", lead))(
        jnp.asarray([5e-3, 1e-2])
    )
    for function, argument in (
        (eqx.filter_jit(efficiency), one),
        (eqx.filter_grad(efficiency), one),
        (eqx.filter_vmap(efficiency), batch),
    ):
        assert {"coulomb_friction", "meshing"} <= prsm.programs.traced_physics(function, argument)


def test_real_sharing_is_cheap_enough_for_everybody():
    """Equations of how threads share, without those of the contacts that equal shares need too.

    Of the split nut 8,640 in the first release and 3,441 with the search written out once; now that
    the spacer and the loads are one loop 1,252. Three loads of one stage had 14,400.
    """
    split, design = example("actuator_load_sharing"), example("actuator")
    contacts = _size(split, ["max_pressure", "approach_screw"])
    assert _size(split, ["max_pressure_shared"]) - contacts < 1350
    # Deflection and both stiffnesses too, and the balance without a load that they start from.
    names = ["max_pressure_shared", "nut_axial_stiffness_tangent", "axial_deflection"]
    assert _size(split, [*names, "nut_axial_stiffness_secant"]) - contacts < 2400
    one = _size(design, ["max_pressure_shared"])
    assert one - contacts < 700
    # Operating point, largest and equivalent load together: one search for all of them, and what
    # the capacities make of it, thread by thread. Extremes of gaps are found by index, for their
    # derivatives: 18 equations more.
    three = _size(design, ["max_pressure_shared", "static_capacity", "dynamic_capacity"])
    capacities = _size(equal_shares("actuator"), ["static_capacity", "dynamic_capacity"])
    assert three - capacities < 2560


def test_no_end_of_a_flank_where_none_is_given():
    """Addenda bring truncation to what rests on pressures, and to nothing else."""
    from truncation_scenes import screw_of_30_mm, without_addenda

    names = ["max_pressure", "static_capacity", "dynamic_capacity", "rating_life"]
    one, laws = screw_of_30_mm(5e-3), {"flank_ends", "truncation"}

    def asked(scene, quantities):
        return prsm.programs.traced_physics(lambda m: prsm.compute(m, quantities), scene)

    assert laws <= asked(one, names)
    assert not laws & asked(without_addenda(one), names)
    assert not laws & asked(one, ["efficiency", "axial_stiffness", "approach_screw"])
