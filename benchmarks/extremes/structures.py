# Examples have the parts that are changed here, and plain numbers become arrays when built:
# pyright: reportArgumentType=false, reportOptionalOperand=false, reportOperatorIssue=false
"""What is compiled: pytrees of one structure each, and the columns that a program gives of them."""

import dataclasses
import functools
from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax.contact import hertz_contact
from prsm_jax.fields._fields import Number, number
from prsm_jax.friction import CoulombFriction, Drag, Friction, LuGreFriction, ThrustBearingFriction
from prsm_jax.mechanism import (
    Mechanism,
    OperatingPoint,
    Roller,
    Stage,
    Support,
    UnequalRoller,
    set_parameters,
)
from prsm_jax.quantities import available_quantities, catalogue
from prsm_jax.scenario import Scenario, SineProfile, TorqueScenario

from .flagged import flagged_quantities

#: Values by column, and a code by column: 0 where the value is said to be usable.
Outputs = tuple[dict[str, Any], dict[str, Any]]


@dataclasses.dataclass(frozen=True)
class Structure:
    """A pytree whose numbers are varied, and the program that all rows of it share.

    - `base`: the pytree at ordinary numbers.
    - `outputs`: values and codes from such a pytree; pure and jittable.
    - `reference`: name of a function in `references`, or "".
    - `infinite`: columns that are documented to be ∞ where a load or a mode is absent.
    - `tolerance`: relative error of values that counts as agreement.
    - `slow`: whether one evaluation takes long, so that fewer rows and directions are taken.
    - `stepping`: whether a method that chooses its steps finds the values.
    - `twin`: a structure with the same numbers that finds the same values without steps, or "".
    - `slope_tolerance`: relative error of derivatives that counts as agreement, if not by
      `tolerance`.
    - `histories`: whether values are histories, whose errors are relative to their largest entry.
    """

    name: str
    title: str
    base: Any
    outputs: Callable[[Any], Outputs]
    reference: str = ""
    infinite: frozenset[str] = frozenset()
    tolerance: float = 1e-9
    slow: bool = False
    stepping: bool = False
    twin: str = ""
    slope_tolerance: float | None = None
    histories: bool = False


_NO_SPIN = Friction(
    thread=CoulombFriction(0.06),
    thrust_bearing=ThrustBearingFriction(0.003, 15e-3),
    drag=Drag(0.05),
)


def _actuator(
    *,
    count: int = 10,
    friction: Friction | None = None,
    sharing: bool = False,
    crests: bool = True,
) -> Mechanism:
    mechanism = file.load("actuator")
    (stage,) = mechanism.stages
    changes: dict[str, Any] = {"friction": friction or stage.friction, "roller_count": count}
    if not sharing:
        changes |= {"load_sharing": None, "sharing": "equal"}
    thread = dataclasses.replace(
        stage.thread, roller_profile_radius=float(stage.thread.profile_radius)
    )
    if not crests:
        # So that no ellipse is cut, and Hertz is the reference.
        thread = dataclasses.replace(thread, screw_addendum=None, roller_addendum=None)
    mechanism = _with(mechanism, thread=thread, **changes)
    point = _point(mechanism)
    return dataclasses.replace(mechanism, design_problem=None, operating_point=point)


def _with(mechanism: Mechanism, **changes: Any) -> Mechanism:
    """A mechanism whose only stage has other parts."""
    (stage,) = mechanism.stages
    return dataclasses.replace(mechanism, stages=(dataclasses.replace(stage, **changes),))


def _point(mechanism: Mechanism) -> OperatingPoint:
    point = mechanism.operating_point
    assert point is not None
    return OperatingPoint(point.speed, point.load)


def _infinite(names) -> frozenset[str]:
    return frozenset(q.name for q in catalogue() if q.name in names and "∞" in q.description)


def _of_quantities(name, title, mechanism, names=None, **more) -> Structure:
    names = tuple(names or available_quantities(mechanism))
    return Structure(
        name,
        title,
        mechanism,
        lambda m: flagged_quantities(m, names),
        infinite=_infinite(names),
        **more,
    )


_VIBRATION = (
    "natural_frequencies",
    "torsional_frequencies",
    "transverse_frequencies",
    "carrier_frequency",
    "lowest_mesh_torsional_frequency",
    "lowest_critical_speed",
    "efficiency_forward",
    "efficiency_backward",
    "carrier_ratio",
    "max_pressure_screw",
    "roller_clearance",
)
_SHARED = (
    "thread_sharing_factor_screw",
    "thread_sharing_factor_nut",
    "roller_sharing_factor",
    "largest_thread_load",
    "max_pressure_shared",
    "axial_deflection",
    "nut_axial_stiffness_secant",
    "nut_axial_stiffness_tangent",
    "thread_stiffness_screw",
)


def quantities() -> Structure:
    return _of_quantities(
        "quantities",
        "one stage, 10 rollers, threads sharing equally: the catalogue",
        _actuator(friction=_NO_SPIN),
        reference="stage",
    )


def quantities_spin() -> Structure:
    names = (
        "efficiency",
        "efficiency_backward",
        "carrier_ratio",
        "drive_torque",
        "loss_power",
        "loss_spin",
        "loss_rolling_hysteresis",
        "ring_gear_force",
        "carrier_force",
        "self_locking_margin",
        "duty_efficiency",
    )
    return _of_quantities("spin", "one stage with spin and rolling hysteresis", _actuator(), names)


def quantities_three() -> Structure:
    return _of_quantities(
        "three_rollers",
        "three rollers",
        _actuator(count=3, friction=_NO_SPIN, crests=False),
        _VIBRATION,
        reference="stage",
    )


def quantities_sixty() -> Structure:
    mechanism = _actuator(count=60, friction=_NO_SPIN, crests=False)
    numbers = {"starts": 30.0, "roller_radius": 1.5e-3, "roller_profile_radius": 2.1e-3}
    mechanism = set_parameters(mechanism, numbers)
    return _of_quantities(
        "sixty_rollers", "sixty rollers", mechanism, _VIBRATION, reference="stage"
    )


def quantities_sharing() -> Structure:
    mechanism = _actuator(sharing=True, friction=_NO_SPIN)
    sharing = dataclasses.replace(
        mechanism.stages[0].load_sharing,
        backlash=6e-6,
        screw_pitch_error=[0.1e-6 * ((7 * k) % 5 - 2) for k in range(20)],
    )
    return _of_quantities(
        "load_sharing",
        "threads that share by elasticity, with backlash and pitch errors",
        _with(mechanism, load_sharing=sharing),
        _SHARED,
        tolerance=1e-7,
    )


def unequal() -> Structure:
    rollers = UnequalRoller(2, stiffness_factor=1.05), UnequalRoller(5, mass_factor=0.97)
    return _of_quantities(
        "unequal_rollers",
        "two of ten rollers deviate: modes without symmetry",
        _with(_actuator(friction=_NO_SPIN), unequal_roller=rollers),
        ("natural_frequencies", "lowest_torsional_frequency", "lowest_mesh_torsional_frequency"),
        reference="unequal",
    )


def anisotropic() -> Structure:
    mechanism = _actuator(friction=_NO_SPIN)
    screw = mechanism.stages[0].screw
    support = dataclasses.replace(screw.support, radial_stiffness_y=200e6 * (1 + 1e-3))
    return _of_quantities(
        "two_supports",
        "supports that differ in x and y: pairs of roots that nearly repeat",
        _with(mechanism, screw=dataclasses.replace(screw, support=support)),
        ("natural_frequencies", "lowest_transverse_frequency"),
        reference="unequal",
    )


def pinned() -> Structure:
    mechanism = _actuator(friction=_NO_SPIN)
    support = Support(radial_stiffness=5e7)
    roller = dataclasses.replace(mechanism.stages[0].roller, support=support)
    return _of_quantities(
        "roller_pins",
        "rollers that move on their pins: modes by symmetry, six degrees and more",
        _with(mechanism, roller=roller),
        ("natural_frequencies", "torsional_frequencies", "transverse_frequencies"),
    )


# Steady states and transients of several stages -----------------------------------------------


def _chain(count: int) -> Mechanism:
    two = file.load("li2020_two_stage")
    first, second = two.stages
    stages = (first, *(second for _ in range(count - 1)))
    return Mechanism(stages[:count], _point(two))


_STEADY = (
    "efficiency",
    "carrier_ratio",
    "drive_torque",
    "contact_force",
    "nut_load",
    "slip_speed",
    "ring_gear_force",
    "carrier_force",
    "spline_friction",
    "input_power",
)


def _steady_outputs(mechanism) -> Outputs:
    found = prsm.steady_state(mechanism)
    values = {name: getattr(found, name) for name in _STEADY}
    values["losses"] = sum(found.losses.values())
    # Self-locking is a state as good as any other.
    code = jnp.where(found.code == 1, 0, found.code)
    # Nothing is left of an efficiency where the load is held.
    codes = dict.fromkeys(values, code)
    codes["efficiency"] = found.code
    return values, codes


def steady(count: int) -> Structure:
    return Structure(
        f"steady_{count}",
        f"steady state, {count} stage{'s' if count > 1 else ''}",
        _chain(count),
        _steady_outputs,
        reference="chain",
    )


_HISTORIES = ("carrier_ratio", "efficiency", "drive_torque", "contact_force", "carrier_force")


def _run_outputs(mechanism, method: str, gradient: str = "both", **options) -> Outputs:
    run = prsm.simulate(mechanism, method=method, gradient=gradient, throw=False, **options)
    values = {name: getattr(run, name) for name in _HISTORIES}
    if run.position is not None:
        values["screw_speed"] = run.screw_speed
        values["position"] = run.position
    return values, dict.fromkeys(values, run.solver.code)


def _runs(name, title, mechanism, method, **more) -> Structure:
    options = more.pop("options", {})
    return Structure(
        name,
        title,
        mechanism,
        lambda m: _run_outputs(m, method, **options),
        tolerance=more.pop("tolerance", 2e-6),
        slow=True,
        histories=True,
        **more,
    )


def _settling(samples: int = 11) -> Mechanism:
    two = _chain(2)
    return dataclasses.replace(two, scenario=Scenario(100.0, 7e3, 1e-3, samples=samples))


def _swinging(samples: int = 11) -> Mechanism:
    two = _chain(2)
    stages = tuple(
        dataclasses.replace(stage, screw=dataclasses.replace(stage.screw, mass=0.5))
        for stage in two.stages
    )
    speed = SineProfile(amplitude=30.0, frequency=200.0, mean=100.0)
    return dataclasses.replace(
        two, stages=stages, scenario=Scenario(speed, 7e3, 2e-3, samples=samples)
    )


def _torque() -> Mechanism:
    mechanism = _chain(1)
    return dataclasses.replace(
        mechanism, scenario=TorqueScenario(14.0, 7e3, 5e-3, initial_speed=1.0, samples=11)
    )


def _bristles() -> Mechanism:
    mechanism = _settling()
    law = LuGreFriction(
        coefficient=0.05,
        static_coefficient=0.08,
        stribeck_speed=1e-2,
        bristle_stiffness=1e7,
        # Times the slip of 2 m/s at the start, small beside the coefficient: larger ones jam.
        bristle_damping=1e-3,
        viscous_coefficient=0.0,
    )
    stages = tuple(
        dataclasses.replace(stage, friction=dataclasses.replace(stage.friction, thread=law))
        for stage in mechanism.stages
    )
    return dataclasses.replace(mechanism, stages=stages)


def transient(method: str) -> Structure:
    if method == "quasi_steady":
        return _runs(method, f"transient of two stages, {method}", _swinging(), method)
    steps = {}
    if method != "closed_form":
        # Errors beside the exact derivative: 1.5e-5 of it at the most in a few scenes; 2.1e-4 (40
        # starts) by Kvaerno's method.
        tolerance = 3e-4 if method == "implicit" else 5e-5
        steps = {"stepping": True, "twin": "closed_form", "slope_tolerance": tolerance}
    return _runs(
        method,
        f"transient of two stages, {method}",
        _settling(),
        method,
        reference="settling",
        **steps,
    )


def reversing() -> Structure:
    """The screw swings through standstill, and carriers that follow it are integrated."""
    two = _swinging()
    speed = SineProfile(amplitude=100.0, frequency=500.0, mean=20.0)
    return _runs(
        "reversing",
        "transient of two stages through reversals, rosenbrock",
        dataclasses.replace(two, scenario=dataclasses.replace(two.scenario, speed=speed)),
        "rosenbrock",
        stepping=True,
        # Friction bends where a force passes zero. A step across the bend has an error in
        # derivatives of the order of its length, in values of the order of its square. At a
        # tolerance of 1e-11 in place of 1e-8 the worst derivative is 147 times closer to
        # differences.
        slope_tolerance=3e-3,
    )


def torque(method: str) -> Structure:
    return _runs(
        f"torque_{method}",
        f"prescribed torque, {method}",
        _torque(),
        method,
        tolerance=1e-5,
        stepping=True,
    )


def bristles() -> Structure:
    return _runs(
        "bristles", "transient with LuGre friction", _bristles(), "rosenbrock", stepping=True
    )


# Contacts -------------------------------------------------------------------------------------


class Ellipse(eqx.Module):
    """A bare Hertz contact: force, A + B and (B − A)² of the gap A x² + B y², E*."""

    force: Number = number("N", "normal force")
    total: Number = number("1/m", "A + B")
    difference_squared: Number = number("1/m²", "(B − A)²")
    modulus: Number = number("Pa", "E*")


def hertz() -> Structure:
    def outputs(ellipse: Ellipse) -> Outputs:
        given = ellipse.force, ellipse.total, ellipse.difference_squared, ellipse.modulus
        found = hertz_contact(*given)
        names = ("max_pressure", "approach", "semi_major", "semi_minor", "stiffness")
        values = {name: getattr(found, name) for name in names}
        # The law has no code; quantities that rest on it are held to this.
        usable = found.semi_major >= 0
        return values, {n: jnp.where(usable & jnp.isfinite(v), 0, 1) for n, v in values.items()}

    return Structure(
        "hertz",
        "a bare Hertz contact, circular to 1:1e5",
        Ellipse(60.0, 320.0, 160.0**2, 115e9),
        outputs,
        reference="hertz",
        tolerance=1e-11,
    )


def half_space() -> Structure:
    mechanism = _actuator(friction=_NO_SPIN, crests=False)
    bare = Mechanism((_bare_contact(mechanism.stages[0]),), _point(mechanism))

    def outputs(m: Mechanism) -> Outputs:
        values, codes = {}, {}
        assert m.operating_point is not None
        for side in ("screw", "nut"):
            found = prsm.halfspace.flank_contact(
                m.stages[0], side, m.operating_point.load, (24, 24)
            )
            surface = found.surface
            for name in ("max_pressure", "approach", "load"):
                values[f"{name}_{side}"] = getattr(surface, name)
                codes[f"{name}_{side}"] = surface.code
        return values, codes

    return Structure(
        "half_space",
        "true flanks on a grid of 24 × 24 cells",
        bare,
        outputs,
        reference="half_space",
        # Cells of a ninth of the ellipse; the grid's own error is about 1 %.
        tolerance=3e-2,
        slow=True,
    )


def _bare_contact(stage: Stage) -> Stage:
    return Stage(
        thread=stage.thread,
        roller_count=stage.roller_count,
        roller=Roller(),
        material=stage.material,
        engaged_threads=stage.engaged_threads,
        sharing="equal",
    )


_MAKERS: dict[str, Callable[[], Structure]] = {
    "hertz": hertz,
    "quantities": quantities,
    "three_rollers": quantities_three,
    "sixty_rollers": quantities_sixty,
    "spin": quantities_spin,
    "load_sharing": quantities_sharing,
    "unequal_rollers": unequal,
    "two_supports": anisotropic,
    "roller_pins": pinned,
    "steady_1": functools.partial(steady, 1),
    "steady_2": functools.partial(steady, 2),
    "steady_6": functools.partial(steady, 6),
    "closed_form": functools.partial(transient, "closed_form"),
    "quasi_steady": functools.partial(transient, "quasi_steady"),
    "rosenbrock": functools.partial(transient, "rosenbrock"),
    "implicit": functools.partial(transient, "implicit"),
    "explicit": functools.partial(transient, "explicit"),
    "reversing": reversing,
    "torque_rosenbrock": functools.partial(torque, "rosenbrock"),
    "torque_quasi_steady": functools.partial(torque, "quasi_steady"),
    "bristles": bristles,
    "half_space": half_space,
}
STRUCTURES = tuple(_MAKERS)


@functools.cache
def structure(name: str) -> Structure:
    """A structure by its name."""
    return _MAKERS[name]()


def columns_of(one: Structure) -> tuple[str, ...]:
    """Names of its columns, without compiling anything."""
    values, _ = eqx.filter_eval_shape(one.outputs, one.base)
    return tuple(values)


def single_precision(tree: Any) -> Any:
    """The same numbers in float32."""
    return jax.tree.map(lambda x: x.astype(jnp.float32), tree)
