"""Friction laws of a user's own, in everything that the package's laws work in."""

import dataclasses
import re
from typing import Any, ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from extensions import extension
from scenes import Swing, array, example, mechanism, simulate, stage, steady_state, thread

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax.dynamics import stage_kinematics
from prsm_jax.fields import Scalar, number
from prsm_jax.friction import (
    CoulombFriction,
    Friction,
    LuGreFriction,
    RegularisedCoulombFriction,
    RollingHysteresis,
    SpinFriction,
    SplineFriction,
    ThrustBearingFriction,
)
from tests.roots import root_between

LOAD = 7e3


class AskingCoulomb(prsm.FrictionLaw):
    """Coulomb's law, which asks for everything and makes no use of it."""

    asks: ClassVar[tuple[str, ...]] = ("normal_force", "pressure", "rolling_speed")
    coefficient: Scalar = number("1", "friction coefficient")

    def friction_coefficient(self, sliding):
        asked = sliding.normal_force + sliding.pressure + sliding.rolling_speed
        return self.coefficient + 0.0 * asked


class RollingTraction(prsm.FrictionLaw):
    """μ that falls with the rolling speed."""

    asks: ClassVar[tuple[str, ...]] = ("rolling_speed",)
    coefficient: Scalar = number("1", "friction coefficient at rest")
    speed: Scalar = number("m/s", "rolling speed at which it has halved")

    def friction_coefficient(self, sliding):
        return self.coefficient / (1 + sliding.rolling_speed / self.speed)


def _one(law, **more):
    return mechanism(stage(friction=Friction(thread=law, **more)))


def _solid():
    return extension("solid_lubricant").SolidLubricantFriction(array(25e6), array(0.01))


def test_pressure_enters_the_axial_balance():
    """Against the balance solved by SciPy, with Hertz's pressure of a stage of its own."""
    one = _one(_solid())
    found = steady_state(one, 100.0, LOAD)
    (geometry,) = (stage_kinematics(s) for s in one.stages)
    normal = np.asarray(geometry.meshing.screw.normal)
    along = np.asarray(found.slip_direction[0])

    def pressure(force):
        axial = force * abs(normal[2]) * one.stages[0].roller_count
        return float(prsm.thread_contacts(one, array(axial))[0].screw.hertz.max_pressure)

    def coefficient(force):
        return 25e6 / (2 / 3 * pressure(force)) + 0.01

    def missed(force):
        share = abs(normal[2]) - coefficient(force) * along[2]
        return force * share - LOAD / one.stages[0].roller_count

    force = root_between(missed, 100.0, 5e3, xtol=1e-10, rtol=1e-14)
    assert float(found.contact_force[0]) == pytest.approx(force, rel=1e-12)
    sliding = coefficient(force) * force * found.slip_speed[0] * one.stages[0].roller_count
    assert float(found.losses["thread_sliding"]) == pytest.approx(float(sliding), rel=1e-12)
    assert float(found.power_balance_residual) < 1e-13
    # Higher loads rub less: that is what this law is for.
    assert float(steady_state(one, 100.0, 4 * LOAD).efficiency) > float(found.efficiency)


def test_rolling_speed_is_that_of_both_surfaces():
    """Mean velocity of two points of rigid bodies, in the frame of the carrier."""
    one = _one(RollingTraction(array(0.1), array(0.5)))
    found = steady_state(one, 100.0, LOAD)
    geometry = stage_kinematics(one.stages[0])
    side, part = geometry.meshing.screw, one.stages[0].thread
    turning = 100.0 * (1 - float(found.carrier_ratio[0]))
    angle = float(side.contact_angle_position)
    radius = float(side.contact_radius)
    # In the carrier's frame the screw turns at Ω − ω, the roller at −n ω about its own axis.
    axis = np.array([0.0, 0.0, 1.0])
    point = radius * np.array([np.cos(angle), np.sin(angle), 0.0])
    travel = 100.0 * float(part.lead) / (2 * np.pi)
    screw = turning * np.cross(axis, point) + travel * axis
    centre = np.array([float(part.centre_distance), 0.0, 0.0])
    spin = -float(part.starts) * 100.0 * float(found.carrier_ratio[0])
    roller = spin * np.cross(axis, point - centre)
    np.testing.assert_allclose(
        np.linalg.norm(screw - roller), float(found.slip_speed[0]), rtol=1e-10
    )
    mean = np.linalg.norm(screw + roller) / 2
    power = float(found.losses["thread_sliding"])
    coefficient = power / float(found.contact_force[0] * found.slip_speed[0] * 10)
    assert coefficient == pytest.approx(0.1 / (1 + mean / 0.5), rel=1e-12)


SCENES = {
    "speed": prsm.Scenario(Swing(array(100.0), array(30.0), array(400.0)), LOAD, 3e-3, samples=31),
    "torque": prsm.TorqueScenario(
        Swing(array(15.0), array(5.0), array(300.0)), LOAD, 3e-3, samples=31
    ),
}
METHODS = [
    ("speed", "rosenbrock"),
    ("speed", "implicit"),
    ("speed", "explicit"),
    ("speed", "quasi_steady"),
    ("torque", "rosenbrock"),
    ("torque", "quasi_steady"),
]


@pytest.mark.parametrize(("scene", "method"), METHODS)
def test_a_law_that_asks_in_vain_is_coulombs_in_every_method(scene, method):
    """The unknown share of the normal force changes nothing; events are located to 1e-9."""
    tolerance = 1e-8 if (scene, method) == ("torque", "rosenbrock") else 1e-12
    runs = [
        simulate(_one(law(array(0.05))), SCENES[scene], method=method)
        for law in (CoulombFriction, AskingCoulomb)
    ]
    for run in runs:
        assert int(run.solver.code) == 0
    for name in ("carrier_ratio", "contact_force", "drive_torque", "screw_speed", "efficiency"):
        plain, asking = (np.asarray(getattr(run, name)) for run in runs)
        size = np.max(np.abs(plain[np.isfinite(plain)]))
        np.testing.assert_allclose(asking, plain, rtol=0, atol=tolerance * size, err_msg=name)


@pytest.mark.parametrize("more", [{}, {"spin": SpinFriction(array(0.05))}])
def test_newton_and_lagrange_agree_with_a_law_that_asks(more):
    one = _one(_solid(), rolling_hysteresis=RollingHysteresis(array(0.01)), **more)
    run = simulate(one, SCENES["speed"], method="rosenbrock")
    bodies = prsm.dynamics.body_forces(one, run)
    np.testing.assert_allclose(
        np.linalg.norm(np.asarray(bodies.screw_normal_on_roller), axis=-1),
        np.asarray(run.contact_force),
        rtol=1e-12,
    )


def test_derivatives_in_both_modes():
    names = ["friction.thread.shear_strength", "friction.thread.coefficient", "lead"]
    one = _one(_solid())
    values = jnp.stack([prsm.get_parameter(one, name) for name in names])

    def efficiency(scales):
        moved = one
        for name, value, scale in zip(names, values, scales, strict=True):
            moved = prsm.set_parameter(moved, name, value * scale)
        return prsm.steady_state(moved, array(100.0), array(LOAD)).efficiency

    at = jnp.ones(3)
    forward, reverse = jax.jacfwd(efficiency)(at), jax.grad(efficiency)(at)
    np.testing.assert_allclose(reverse, forward, rtol=1e-11)
    step = 1e-3
    for k in range(3):
        near, far = (
            [float(efficiency(at.at[k].add(sign * h))) for sign in (-1, 1)]
            for h in (step, 2 * step)
        )
        # Of fourth order, so that the step is wide beside the tolerance of the search, 1e-14.
        expected = (8 * (near[1] - near[0]) - (far[1] - far[0])) / (12 * step)
        assert float(forward[k]) == pytest.approx(expected, rel=1e-8)


def test_derivatives_of_a_transient():
    scene = SCENES["speed"]
    one = _one(_solid())

    def mean_torque(strength):
        moved = prsm.set_parameter(one, "shear_strength", strength)
        run = prsm.simulate(moved, scene, method="rosenbrock", gradient="forward", throw=False)
        return jnp.mean(run.drive_torque)

    value = jax.jvp(mean_torque, (array(25e6),), (array(1.0),))[1]
    step = 25e6 * 1e-4
    ends = [float(mean_torque(array(25e6 + sign * step))) for sign in (-1, 1)]
    assert float(value) == pytest.approx((ends[1] - ends[0]) / (2 * step), rel=1e-6)


def test_a_law_with_a_state_is_lugres_without_damping():
    """Dahl's law is LuGre's with equal coefficients and undamped bristles."""
    scene = prsm.Scenario(
        Swing(array(0.0), array(100.0), array(20.0)), array(LOAD), array(0.05), samples=51
    )
    dahl = extension("dahl").DahlFriction(array(0.08), array(1e5))
    lugre = LuGreFriction(0.08, 0.08, 0.1, 1e5, 0.0)
    runs = [simulate(_one(law), scene) for law in (dahl, lugre)]
    for name in ("carrier_speed", "contact_force", "drive_torque"):
        own, known = (np.asarray(getattr(run, name)) for run in runs)
        np.testing.assert_allclose(own, known, rtol=0, atol=1e-12 * np.max(np.abs(known)))
    assert int(runs[0].solver.code) == 0


def test_vmapped_and_swept():
    one = _one(_solid())
    strengths = jnp.linspace(10e6, 40e6, 4)
    batch = jax.vmap(
        lambda x: prsm.steady_state(prsm.set_parameter(one, "shear_strength", x)).efficiency
    )(strengths)
    assert np.all(np.diff(np.asarray(batch)) < 0)
    table = prsm.sweep(one, {"shear_strength": strengths}, ["efficiency"])
    np.testing.assert_allclose(np.asarray(table["efficiency"]).ravel(), batch, rtol=1e-12)


class HeldSolid(prsm.FrictionLaw):
    """The solid lubricant's friction times a factor."""

    asks: ClassVar[tuple[str, ...]] = ("pressure",)
    factor: Scalar = number("1", "factor")

    def friction_coefficient(self, sliding):
        return self.factor * (25e6 / (2 / 3 * sliding.pressure) + 0.01)


def test_locking_margins_follow_the_law():
    """At the normal force that the load has without friction; and the search on all friction."""
    one = _one(_solid())
    names = ["jamming_margin", "self_locking_margin", "jamming_friction_coefficient"]
    found = prsm.compute(one, names)
    pressure = float(prsm.thread_contacts(one, array(LOAD))[0].screw.hertz.max_pressure)
    coefficient = 25e6 / (2 / 3 * pressure) + 0.01
    share = coefficient / float(found["jamming_friction_coefficient"][0])
    assert float(1 - found["jamming_margin"]) == pytest.approx(share, rel=1e-12)
    # Where friction times s holds the load, no torque is left: s = 1/(1 − margin).
    held = 1 / (1 - float(found["self_locking_margin"]))
    holding = steady_state(_one(HeldSolid(array(held))), -100.0, LOAD)
    frictionless = LOAD * float(one.stages[0].thread.lead) / (2 * np.pi)
    assert abs(float(holding.drive_torque)) < 1e-9 * frictionless


def test_a_file_knows_a_law_by_its_name():
    one = _one(_solid())
    text = file.dumps(one)
    assert 'law = "solid_lubricant"\nshear_strength = "25 MPa"' in text
    again = file.loads(text)
    assert eqx.tree_equal(again.stages[0].friction, one.stages[0].friction)
    wrong = text.replace('shear_strength = "25 MPa"', 'shear_strength = "25 mm"')
    with pytest.raises(prsm.FileError, match=r"friction.thread: shear_strength = \"25 mm\": .*Pa"):
        file.loads(wrong)
    thread_friction = next(
        part for part in prsm.explain(one, programs=[]).parts if part.name.endswith("thread")
    )
    assert thread_friction.place.law == "solid_lubricant"


def test_a_law_without_a_name_cannot_be_written():
    with pytest.raises(prsm.FileError, match=r"AskingCoulomb.*friction_law"):
        file.dumps(_one(AskingCoulomb(array(0.1))))
    with pytest.raises(prsm.FileError, match=r"thrust_bearing .*UnnamedCoulomb"):
        file.dumps(_one(None, thrust_bearing=ThrustBearingFriction(UnnamedCoulomb(), array(0.01))))


class UnnamedCoulomb(prsm.FrictionLaw):
    """μ = 0.1."""

    def friction_coefficient(self, sliding):
        return 0.1 + 0.0 * sliding.speed


def test_a_law_of_a_users_own_in_splines_and_bearings():
    def both(law):
        friction = Friction(
            CoulombFriction(0.05),
            spline=SplineFriction(law, 0.012),
            thrust_bearing=ThrustBearingFriction(law, 0.02),
        )
        first = stage(friction=Friction(CoulombFriction(0.05)))
        return mechanism(first, stage(friction=friction, geometry=thread(lead=15e-3)))

    own, known = (steady_state(both(law)) for law in (UnnamedCoulomb(), CoulombFriction(0.1)))
    assert float(own.drive_torque) == pytest.approx(float(known.drive_torque), rel=1e-14)


@pytest.mark.parametrize("law", [_solid, lambda: LuGreFriction(0.1, 0.08, 0.1, 1e5, 4.0)])
def test_only_threads_tell_more_than_the_slip_speed(law):
    with pytest.raises(ValueError, match="which only threads give; choose another law"):
        ThrustBearingFriction(law(), 0.02)


def test_a_radius_is_needed():
    with pytest.raises(ValueError, match="radius is missing; the law CoulombFriction needs it"):
        SplineFriction(CoulombFriction(0.1))


def test_what_is_not_asked_for_cannot_be_used():
    class Careless(prsm.FrictionLaw):
        def friction_coefficient(self, sliding):
            return 1e-9 * sliding.pressure

    with pytest.raises(ValueError, match=r'asks = \("pressure",\)'):
        steady_state(_one(Careless()))


def test_a_law_from_outside_is_optimised():
    """The optimum is no worse than the steady states at the bounds, and is one itself."""
    bounds = (0.6, 1.2)
    one = _one(AskingCoulomb(array(0.05)))
    best = prsm.optimise(one, {"contact_angle": bounds}, maximise="efficiency")
    assert best.converged
    angles = (best.optimum.variables["contact_angle"], *bounds)
    values = [
        float(steady_state(prsm.set_parameter(one, "contact_angle", angle)).efficiency)
        for angle in angles
    ]
    # The same operations in another program.
    assert best.optimum.objective == pytest.approx(values[0], rel=1e-12)
    assert values[0] == max(values)
    assert min(values) < values[0] - 1e-3


def test_naming_a_law():
    def made(name, **members):
        body = {"friction_coefficient": lambda self, sliding: sliding.speed, **members}
        return prsm.friction_law(name)(type("Made", (prsm.FrictionLaw,), body))

    with pytest.raises(ValueError, match=r"'coulomb': .*CoulombFriction has this name"):
        made("coulomb")
    with pytest.raises(ValueError, match="lower-case words"):
        made("Of Mine")
    with pytest.raises(ValueError, match="asks for 'temperature'; choose from normal_force"):
        made("hot", asks=("temperature",))
    with pytest.raises(TypeError, match="must be a class of FrictionLaw"):
        prsm.friction_law("a_function")(lambda: 0)  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="plain has no unit"):
        made("unitless", plain=0.1, __annotations__={"plain": float})
    # A cell of a notebook may be run twice: the last one counts.
    first, second = made("run_twice"), made("run_twice")
    assert first is not second
    assert file.loads(_with_law("run_twice")).stages[0].friction.thread == second()


def test_the_remedy_for_a_field_without_a_unit_can_be_copied():
    def made(**body):
        body["friction_coefficient"] = lambda self, sliding: self.plain
        return prsm.friction_law("copied")(type("Copied", (prsm.FrictionLaw,), body))

    with pytest.raises(ValueError, match="plain has no unit") as refused:
        made(plain=0.1, __annotations__={"plain": float})
    field, imports = re.findall("`(.+?)`", str(refused.value))
    body = {}
    exec(f"{imports}\n{field}", body)
    law: Any = made(plain=body["plain"], __annotations__=body["__annotations__"])
    assert float(law(0.2).friction_coefficient(None)) == 0.2


def _with_law(name):
    text = file.dumps(_one(CoulombFriction(0.1)))
    return text.replace('law = "coulomb"\ncoefficient = 0.1', f'law = "{name}"')


def test_physics_that_a_law_does_not_ask_for_is_not_traced():
    def traced(law):
        return prsm.programs.traced_physics(
            lambda one: prsm.steady_state(one).efficiency, _one(law)
        )

    assert "hertz" not in traced(CoulombFriction(array(0.05)))
    assert "hertz" not in traced(RollingTraction(array(0.1), array(0.5)))
    assert {"hertz", "solid_lubricant_friction"} <= traced(_solid())


def test_the_closed_form_of_settling_is_for_constant_coefficients():
    """A law of a user's own that says it is constant settles in closed form."""

    class Constant(prsm.FrictionLaw):
        constant: ClassVar[bool] = True

        def friction_coefficient(self, sliding):
            return 0.05 + 0.0 * sliding.speed

    scene = prsm.Scenario(array(100.0), array(LOAD), array(1e-3), samples=11)
    own, known = (_one(law) for law in (Constant(), CoulombFriction(0.05)))
    assert prsm.dynamics.choose_method(own, scene).method == "closed_form"
    assert prsm.dynamics.choose_method(_one(_solid()), scene).method == "rosenbrock"
    runs = [simulate(one, scene) for one in (own, known)]
    np.testing.assert_allclose(runs[0].carrier_ratio, runs[1].carrier_ratio, rtol=1e-13)


def test_numbers_of_a_law_are_those_of_the_mechanism():
    one = _one(_solid())
    paths = {p.path: p for p in prsm.mechanism.all_parameters(one)}
    parameter = paths["stage.1.friction.thread.shear_strength"]
    assert (parameter.unit, parameter.description) == ("Pa", "shear strength of the film, τ₀")
    found = prsm.sensitivity(one, ["efficiency"], ["shear_strength"])
    step = 25e6 * 1e-4
    ends = [
        float(
            steady_state(prsm.set_parameter(one, "shear_strength", 25e6 + sign * step)).efficiency
        )
        for sign in (-1, 1)
    ]
    slope = (ends[1] - ends[0]) / (2 * step)
    assert float(found.gradient[0, 0]) == pytest.approx(slope, rel=1e-6)
    assert slope < 0


def test_replaced_numbers_keep_the_law():
    bearing = ThrustBearingFriction(CoulombFriction(0.1), 0.02)
    assert float(bearing.coefficient) == 0.1
    assert dataclasses.replace(bearing, radius=0.03).law == bearing.law
    with pytest.raises(AttributeError):
        _ = bearing.static_coefficient


def test_no_balance_is_a_jam():
    """Friction that grows as the square of the force may leave no root: none is made up."""

    class Growing(prsm.FrictionLaw):
        asks: ClassVar[tuple[str, ...]] = ("normal_force",)
        slope: Scalar = number("1/N", "friction coefficient over normal force")

        def friction_coefficient(self, sliding):
            return self.slope * sliding.normal_force

    def state(share):
        one = _one(Growing(array(1.0)))
        (geometry,) = (stage_kinematics(s) for s in one.stages)
        carried = abs(float(geometry.meshing.screw.normal[2]))
        force = LOAD / 10 / carried
        limit = float(prsm.compute(one, ["jamming_friction_coefficient"], speed=100.0, load=LOAD)[
            "jamming_friction_coefficient"
        ][0])  # fmt: skip
        return steady_state(_one(Growing(array(share * limit / force))), 100.0, LOAD)

    # F (1 − s F/F₀) = F₀ has roots up to s = 1/4.
    held = state(0.24)
    assert held.result_name == "successful"
    assert float(held.power_balance_residual) < 1e-9
    for share in (0.3, 0.5, 0.9, 1.5):
        assert state(share).result_name == "jammed", share


@pytest.mark.parametrize("load", [0.0, 1e-3])
def test_the_example_of_a_law_by_pressure_is_finite_without_load(load):
    found = steady_state(_one(_solid()), 100.0, load)
    assert found.result_name == "successful"
    assert 0.5 < float(found.efficiency) < 1.0


def test_smooth_friction_has_higher_derivatives_at_standstill():
    """μ/√(v² + ε²) v: slope μ/ε, no curvature, third derivative −3μ/ε³."""
    from prsm_jax.dynamics.friction._thread_friction import thread_friction

    law = RegularisedCoulombFriction(array(0.1), array(1e-3))

    def force(slip):
        return thread_friction(law, slip[None], jnp.sign(slip)[None])[0][0]

    first = jax.grad(force)
    second, third = jax.grad(first), jax.grad(jax.grad(first))
    for at in (0.0, 1e-15):
        assert float(first(array(at))) == pytest.approx(0.1 / 1e-3, rel=1e-12)
        assert abs(float(second(array(at)))) < 1e-3
        assert float(third(array(at))) == pytest.approx(-3 * 0.1 / 1e-9, rel=1e-12)
    short = RegularisedCoulombFriction(jnp.float32(0.1), jnp.float32(1e-3))
    one = jnp.zeros(1, jnp.float32)
    bent = jax.hessian(lambda slip: thread_friction(short, slip, slip)[0][0])(one)
    assert np.all(np.isfinite(bent))


def test_a_law_with_a_state_asks_for_nothing():
    class Asking(LuGreFriction):
        asks: ClassVar[tuple[str, ...]] = ("pressure",)

    with pytest.raises(ValueError, match="receives only slip and deflection"):
        Asking(0.1, 0.08, 0.1, 1e5, 4.0)


def test_a_law_with_a_state_in_an_ellipse_that_spins():
    """Dahl's law settles where its steady slip is, spin included."""
    dahl = extension("dahl").DahlFriction(array(0.08), array(1e5))
    one = _one(dahl, spin=SpinFriction(array(0.08)))
    run = simulate(one, prsm.Scenario(array(100.0), array(LOAD), array(3e-3), samples=11))
    steady = steady_state(one, 100.0, LOAD)
    assert float(run.efficiency[-1]) == pytest.approx(float(steady.efficiency), rel=1e-6)


class _NoLaw(eqx.Module):
    """Has the method of a law, but is none."""

    mu: Scalar

    def friction_coefficient(self, sliding):
        return self.mu


def test_a_part_that_is_no_law_is_named():
    one = eqx.tree_at(lambda m: m.stages[0].friction.thread, example("wu2022"), _NoLaw(array(0.05)))
    words = r"steady_state: stages\[0\].friction.thread is a _NoLaw, and must be a FrictionLaw"
    with pytest.raises(ValueError, match=words):
        prsm.steady_state(one)


def test_a_number_in_place_of_a_law_is_named():
    one = eqx.tree_at(lambda m: m.stages[0].friction.thread, example("wu2022"), array(0.05))
    words = r"stages\[0\].friction.thread is a number, and must be a FrictionLaw"
    with pytest.raises(ValueError, match=words):
        prsm.steady_state(one)


class _TwoNumbers(prsm.FrictionLaw):
    mu: Scalar = number("1", "friction coefficient")

    def friction_coefficient(self, sliding):
        return jnp.stack([self.mu, self.mu])


def test_a_law_that_gives_two_numbers_is_named():
    law = _TwoNumbers(array(0.05))
    one = eqx.tree_at(lambda m: m.stages[0].friction.thread, example("wu2022"), law)
    with pytest.raises(ValueError, match=r"of _TwoNumbers gives an array of the shape \(2,\), and"):
        prsm.steady_state(one)
