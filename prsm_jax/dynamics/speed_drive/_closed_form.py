"""Carriers settling at constant speed and load, in closed form.

With Coulomb friction the carrier of a stage under the axial force F_a obeys, with S the slip along
d over the slip q Ω across,

    dS/dt (n √(1 + S²) − k)/S = −d² μ |F_a| / (I |Ω| q),   n = |n_z|,   k = ± μ L/(2π q).

The variables separate: with x = ln S the left side is the derivative of

    H(x) = n P(x) − k x,   P(x) = √(1 + S²) + x − ln(1 + √(1 + S²)),

and the right side needs only the impulse ∫F_a dt. The same holds for the next stage: the impulse of
a screw's torque is an elementary function of S too, and impulses obey the balances of the forces.
So a chain is solved from the last stage to the first without integration, at any time, to rounding.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ...fields import Scalar
from ...mechanism import Mechanism, Stage
from ...numerics import above_or_nan
from ...programs import physics
from ..forces import (
    ReducedChain,
    ReducedForces,
    ReducedStage,
    Scenario,
    is_reducible,
    reduced_forces,
    screw_of,
)
from ..friction import friction_coefficient
from ..histories import SolverReport
from ..solvers import ClosedForm


def settles_in_closed_form(mechanism: Mechanism, scenario: Scenario) -> bool:
    """Whether speed and load are constant, and so are friction coefficients of all threads."""
    if callable(scenario.speed) or callable(scenario.load):
        return False
    laws = [stage.thread_law for stage in mechanism.stages]
    constant = all(law is None or law.constant for law in laws)
    return constant and all(is_reducible(stage) for stage in mechanism.stages)


def _path(x: Scalar) -> tuple[Scalar, Scalar]:
    """P(x), and its derivative √(1 + S²)."""
    # Beyond this S² would overflow; no carrier slips e¹⁵⁰ times faster along d than across it.
    slip = jnp.exp(jnp.minimum(x, 150.0))
    root = jnp.sqrt(1 + slip**2)
    return root + x - jnp.log1p(root), root


@jax.custom_jvp
def inverse_path(value: Scalar, share: Scalar) -> Scalar:
    """x at which P(x) − share · x is `value`, for share = k/n < 1.

    Halley's iteration from the asymptotes: four steps reach rounding for shares up to 0.9, eight
    for shares up to 1e-5 below 1, where the mechanism locks.
    """
    ends = (value - (1 - jnp.log(2.0))) / (1 - share)
    begins = jnp.maximum(value, 1e-3)
    x = jnp.where(ends < 0, ends, jnp.log(begins + 0.5 / (begins + 0.5)))
    for _ in range(4):
        x = _halley_step(x, value, share)
    # Designs within 10 % of locking may need more steps.
    more = (share > 0.9) & (share < 1)

    def close(_, x):
        return jnp.where(more, _halley_step(x, value, share), x)

    return jax.lax.fori_loop(0, jnp.where(more, 4, 0), close, x)


def _halley_step(x: Scalar, value: Scalar, share: Scalar) -> Scalar:
    path, root = _path(x)
    residual, slope, curvature = path - share * x - value, root - share, root - 1 / root
    return x - 2 * residual * slope / (2 * slope**2 - residual * curvature)


@inverse_path.defjvp
def _inverse_path_jvp(primals, tangents):
    value, share = primals
    value_dot, share_dot = tangents
    x = inverse_path(value, share)
    return x, (value_dot + x * share_dot) / (_path(x)[1] - share)


def _path_ahead(x: Scalar, step: Scalar) -> tuple[Scalar, Scalar]:
    """P(x + step) − P(x), accurate to its own rounding, and P′(x + step)."""
    slip = jnp.exp(jnp.minimum(x, 150.0))
    root, there = jnp.sqrt(1 + slip**2), _path(x + step)[1]
    longer = slip**2 * jnp.expm1(2 * step) / (root + there)
    return longer + step - jnp.log1p(longer / (1 + root)), there


def _step_to(x: Scalar, end: Scalar, share: Scalar, moved: Scalar) -> tuple[Scalar, Scalar]:
    """The step from x over which P − share · x falls by `moved`, and the change of P.

    The rounding of `end` would spoil a short step, so one Newton step is made on the difference.
    """
    near = end - x
    change, slope = _path_ahead(x, near)
    step = near - (change - share * near + moved) / (slope - share)
    return step, _path_ahead(x, step)[0]


def _settled_stage(
    stage: Stage,
    reduced: ReducedStage,
    inertia: Scalar,
    speed: Scalar,
    initial_ratio: Scalar,
    axial_force: Scalar,
    time: Scalar,
) -> tuple[Scalar, Scalar, Bool[Array, ""]]:
    """Carrier ratio after some time under an axial force with a given mean.

    **Returns:** the ratio, the mean torque of all rollers on the screw, and whether the thread can
    carry load.
    """
    law = stage.thread_law
    zero = jnp.zeros_like(speed)
    coefficient = zero if law is None else friction_coefficient(law, jnp.abs(speed))
    flank_sign = jnp.where(axial_force < 0, -1.0, 1.0).astype(speed.dtype)
    sense = jnp.where(speed < 0, -1.0, 1.0).astype(speed.dtype)
    size = jnp.where(speed == 0, 1.0, jnp.abs(speed))
    normal, across, drive = reduced.normal_axial, reduced.across, reduced.drive
    share = coefficient * flank_sign * sense * reduced.axial / (across * normal)
    carries = share < 1
    share = jnp.where(share >= 1, 0.0, share)

    excess = (reduced.along - initial_ratio * drive) / across
    # Zero initial slip along d is replaced by a tiny one.
    start = jnp.log(jnp.where(excess == 0, 1e-30, jnp.abs(excess)))
    first, first_root = _path(start)
    # H changes by d² μ ∫|F_a| dt / (I |Ω| q), here in units of n.
    force = jnp.abs(axial_force)
    moved = drive**2 * coefficient * force * time / (inertia * size * across * normal)
    end = inverse_path(first - share * start - moved, share)
    step, change = _step_to(start, end, share, moved)
    slip, lost = excess * jnp.exp(step), -excess * jnp.expm1(step)
    # From the initial ratio while little slip is lost (exactly that ratio at the start); from the
    # final slip later.
    swept = above_or_nan(moved)
    early = initial_ratio + jnp.where(swept, lost, 0.0) * across / drive
    ratio = jnp.where(step > -0.5, early, (reduced.along - slip * across) / drive)

    # Mean of √(1 + S²) F/(n √(1 + S²) − k), and so on, over the impulse: dI = −dH/…, so the
    # brackets cancel.
    spread = (reduced.contact_radius**2 - reduced.along**2) / across
    per_slip = coefficient * sense
    over = jnp.where(swept, moved, 1.0) * normal
    swept_moment = per_slip * (reduced.along * lost - spread * step) - (
        flank_sign * reduced.normal_moment * change
    )
    still_moment = flank_sign * reduced.normal_moment * first_root + per_slip * (
        spread + reduced.along * excess
    )
    still_moment = still_moment / ((first_root - share) * normal)
    mean = jnp.where(swept, swept_moment / over, still_moment)
    return ratio, -mean * force, carries


@physics("settling")
def settled_ratios(
    chain: ReducedChain, scenario: Scenario, time: Scalar
) -> tuple[Float[Array, " stages"], Bool[Array, ""]]:
    """Carrier ratios ω/Ω at a time, and whether the assumptions of the closed form hold.

    They are that no thread locks, and that no screw's torque and no axial force changes its sign
    between the start and that time: only then is the mean of |M| the magnitude of the mean of M.

    **Arguments:**

    - `chain`: the mechanism by its scalars, with Coulomb friction.
    - `scenario`: constant speed and load, and the carrier ratio at the start.
    - `time`: [s].
    """
    mechanism = chain.mechanism
    stages, speed, load = mechanism.stages, scenario.speed_at(time), scenario.load_at(time)
    ratios: list[Scalar] = []
    valid = jnp.asarray(True)
    mean_screw, mean_load = None, load
    screws = (None, None)
    loads = (load, load)
    for index in reversed(range(len(stages))):
        stage, reduced = stages[index], chain.stages[index]
        ratio, torque, carries = _settled_stage(
            stage,
            reduced,
            chain.inertia[index],
            speed,
            scenario.initial_carrier_ratio,
            mean_load,
            time,
        )
        valid = valid & carries
        ratios.append(ratio)
        if index == 0:
            break
        mean = ReducedForces(torque, mean_load, jnp.zeros_like(ratio))
        mean_screw = screw_of(mechanism, index, mean, speed, mean_screw, None)
        mean_load = mean_screw.support_force
        ends = []
        for end_ratio, end_load, screw in zip(
            (scenario.initial_carrier_ratio, ratio), loads, screws, strict=True
        ):
            forces = reduced_forces(stage, reduced, speed, speed * end_ratio, end_load)
            ends.append(screw_of(mechanism, index, forces, speed, screw, None))
        screws = tuple(ends)
        loads = tuple(end.support_force for end in ends)
        for quantity in ("drive_torque", "support_force"):
            before, after = (getattr(end, quantity) for end in ends)
            valid = valid & (before * after >= 0)
    return jnp.stack(ratios[::-1]), valid


def closed_form_history(
    chain: ReducedChain | None, scenario: Scenario, times: Float[Array, " times"]
) -> tuple[Float[Array, "times stages"], SolverReport]:
    """Carrier speeds at the sample times [rad/s].

    **Raises:** `ValueError` if the closed form does not apply to speed, load or friction.
    """
    if chain is None or not settles_in_closed_form(chain.mechanism, scenario):
        raise ValueError(
            "method is 'closed_form', which needs constant speed and load, and Coulomb friction in "
            "all threads without losses inside the contact ellipses; choose 'auto' or 'rosenbrock'"
        )
    ratios, valid = jax.vmap(lambda time: settled_ratios(chain, scenario, time))(times)
    zero = jnp.zeros((), int)
    report = SolverReport(
        steps=zero,
        rejected=zero,
        code=jnp.where(jnp.all(valid), zero, 6),
        name=ClosedForm.label,
    )
    return ratios * scenario.speed_at(times[0]), report
