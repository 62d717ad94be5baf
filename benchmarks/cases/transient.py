"""Transients: diffrax inside the package against SciPy's solvers, by tolerance."""

import functools
from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax import Scenario, simulate
from prsm_jax.file import load
from prsm_jax.programs import to_precision

from ..harness import Case, Method, Prepared, Problem, Reference
from ..method_options import taken
from ..references.transients.compiled import followed
from ..references.transients.designs_of_two_stages import regularised
from ..references.transients.dynamics import Chain

_RATIO, _EFFICIENCY = "carrier ratios", "efficiency"
_MECHANISM = "li2020_two_stage"
_SAMPLES = 201
#: Absolute tolerance over relative tolerance; all solvers have the same.
_ABSOLUTE = 1e-2
#: Widths over which regularised friction changes its sign [m/s].
_WIDTHS = (1e-1, 1e-2, 1e-3, 1e-4)
OurMethod = Literal["closed_form", "rosenbrock", "implicit", "explicit"]
#: Tight enough that the solution below it is rounding: agrees with Radau at 1e-12 to 1e-12.
_TIGHT = 3e-14


def _histories(chains: list[Chain], duration: float, solver: str, rtol: float):
    """Carrier ratios and efficiency at the sample times, one trajectory after the other."""
    times = np.linspace(0.0, duration, _SAMPLES)
    ratios = [
        followed(chain.rate, len(chain.stages), times, solver, rtol, rtol * _ABSOLUTE)
        for chain in chains
    ]
    efficiencies = [
        [chain.efficiency(state) for state in found.T.tolist()]
        for chain, found in zip(chains, ratios, strict=True)
    ]
    return np.array(ratios), np.array(efficiencies)


def _named(out):
    return {_RATIO: np.asarray(out[0]), _EFFICIENCY: np.asarray(out[1])}


def _rival(name: str, chains, duration, solver, tolerances) -> Method:
    def prepare(rtol):
        return Prepared(lambda: _histories(chains, duration, solver, rtol), len(chains), _named)

    return Method(name, prepare, tolerances, "rtol", "rival")


@functools.cache
def _jitted(method: OurMethod, batched: bool, smooth: bool = False, dtype: Any = jnp.float64):
    """`simulate` with speed, load, duration and tolerance traced: one compilation for all.

    With `smooth` friction is regularised, and its width stands in for the tolerance.
    """
    coulomb = to_precision(load(_MECHANISM), dtype)

    def solve(speed, force, duration, rtol):
        mechanism = coulomb
        if smooth:
            mechanism, rtol = regularised(coulomb, rtol), 1e-10
        run = simulate(
            mechanism,
            Scenario(speed, force, duration, samples=_SAMPLES),
            method=method,
            gradient="forward",
            throw=False,
            **taken(method, rtol=rtol, atol=rtol * _ABSOLUTE),
        )
        failed = run.solver.code != 0
        ratio = jnp.where(failed, jnp.nan, run.carrier_ratio)
        steps = run.solver.steps + run.solver.rejected
        return ratio, jnp.where(failed, jnp.nan, run.efficiency), steps

    if batched:
        return jax.jit(jax.vmap(solve, in_axes=(0, 0, None, None)))
    # Not a batch of one: vmap turns every branch into a select.
    return jax.jit(lambda s, f, *rest: jax.tree.map(lambda x: x[None], solve(s[0], f[0], *rest)))


def _ours(
    method: OurMethod,
    operations,
    duration,
    tolerances,
    smooth: bool = False,
    dtype: Any = jnp.float64,
) -> Method:
    """The package's transient over a batch of operating points."""
    speeds, loads = (jnp.asarray(column, dtype) for column in zip(*operations, strict=True))
    jitted = _jitted(method, len(operations) > 1, smooth, dtype)

    def prepare(rtol):
        def note(out):
            steps = np.asarray(out[2])
            few, many = int(steps.min()), int(steps.max())
            return f"{few} steps" if few == many else f"{few} to {many} steps"

        given = jnp.asarray(1e-8 if rtol is None else rtol, dtype)
        return Prepared(
            lambda: jitted(speeds, loads, jnp.asarray(duration, dtype), given),
            len(operations),
            _named,
            note,
        )

    name = "" if tolerances == (None,) else "width in m/s" if smooth else "rtol"
    label = f"{method}, regularised" if smooth else method
    label += ", float32" if dtype == jnp.float32 else ""
    return Method(label, prepare, tolerances, name)


def _settle(quick: bool, count: int) -> Problem:
    """The two-stage settle of Li et al. 2020: 1 ms from rollers at rest."""
    mechanism = load(_MECHANISM)
    random = np.random.default_rng(38)
    operations = [(100.0, 7000.0)]
    operations += list(
        zip(random.uniform(50, 200, count - 1), random.uniform(3e3, 1e4, count - 1), strict=True)
    )
    first = Chain(mechanism, 100.0, 7000.0)
    chains = [first.with_operation(speed, force) for speed, force in operations]
    duration, compared = 1e-3, min(count, 3 if quick else 10)
    tolerances = (1e-3, 1e-6, 1e-9) if quick else tuple(10.0**-k for k in range(3, 11))
    some = chains[: min(count, 5)]

    def reference():
        ratios, efficiencies = _histories(chains[:compared], duration, "DOP853", _TIGHT)
        # A history starts at zero; its errors are measured by its final value.
        return {
            _RATIO: Reference(ratios, scale=np.abs(ratios[:, :, -1:])),
            _EFFICIENCY: Reference(efficiencies),
        }

    return Problem(
        name="settle" if count == 1 else f"settle_batch_{count}",
        title="Two-stage settle (Li et al. 2020), 1 ms, "
        + ("one trajectory" if count == 1 else f"batch of {count}"),
        instance="trajectory",
        methods=[
            _ours("closed_form", operations, duration, (None,)),
            _ours("rosenbrock", operations, duration, tolerances),
            _ours("implicit", operations, duration, tolerances),
            _ours("explicit", operations, duration, tolerances),
            _ours("closed_form", operations, duration, (None,), dtype=jnp.float32),
            _ours("rosenbrock", operations, duration, (1e-3, 1e-5), dtype=jnp.float32),
            *([_ours("rosenbrock", operations, duration, _WIDTHS, True)] if count == 1 else []),
            _rival("SciPy LSODA", some, duration, "LSODA", tolerances),
            _rival("SciPy Radau", some[:1], duration, "Radau", tolerances),
        ],
        reference=reference,
        reference_note=(
            f"SciPy DOP853 at rtol {_TIGHT:g} on an independent right-hand side, {compared} "
            "trajectories; ratios are scaled by their final value"
        ),
        baseline="SciPy LSODA",
    )


def _extreme(quick: bool) -> Problem:
    """0.01 rad/s for 10 s: the carriers settle within about 1e-7 s, a stiffness of 1e8."""
    mechanism = load(_MECHANISM)
    speed, force, duration = 0.01, 7000.0, 10.0
    chain = Chain(mechanism, speed, force)
    tolerances = (1e-3, 1e-6) if quick else (1e-3, 1e-4, 1e-6, 1e-8, 1e-10)

    def reference():
        # At the first sample after the start the transient is over by 1e7 time constants.
        steady = chain.steady_ratios()
        ratios = np.zeros((len(steady), _SAMPLES))
        ratios[:, 1:] = np.array(steady)[:, None]
        efficiencies = [chain.efficiency(state) for state in ratios.T.tolist()]
        return {
            _RATIO: Reference(ratios[None], scale=np.array(steady)[None, :, None]),
            _EFFICIENCY: Reference(np.array([efficiencies])),
        }

    return Problem(
        name="extreme",
        title="Two stages at 0.01 rad/s for 10 s (1e8 time constants)",
        instance="trajectory",
        methods=[
            _ours("closed_form", [(speed, force)], duration, (None,)),
            _ours("rosenbrock", [(speed, force)], duration, tolerances),
            _ours("implicit", [(speed, force)], duration, tolerances),
            _rival("SciPy LSODA", [chain], duration, "LSODA", tolerances),
            _rival("SciPy Radau", [chain], duration, "Radau", tolerances),
        ],
        reference=reference,
        reference_note="closed form: the start, and the steady state at every later sample",
        baseline="SciPy Radau",
    )


def case(quick: bool) -> Case:
    """The case of this module."""
    return Case(
        "transient",
        "Carriers settling: methods by tolerance, regularised friction by width, against SciPy",
        [_settle(quick, 1), *([] if quick else [_settle(quick, 100)]), _extreme(quick)],
    )
