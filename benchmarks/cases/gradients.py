"""Derivatives from geometry: forward, reverse and differences, one design and a batch."""

import dataclasses
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax import modal, steady_state
from prsm_jax.file import load
from prsm_jax.friction import CoulombFriction
from prsm_jax.mechanism import Mechanism, get_parameter, set_parameters

from ..harness import Case, Kind, Method, Prepared, Problem, Reference
from ..references.contact import efficiency_slopes
from ..references.geometry_chain import frequency_slopes
from ..references.meshing import DIGITS

_NAMES = ("lead", "contact_angle", "roller_radius")
#: Families of `frequency_slopes`, in its order.
_FAMILIES = ("carrier", "torsional", "transverse", "roller")
_STEPS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8)


def _around(mechanism: Mechanism, count: int) -> np.ndarray:
    """Designs within 5 % of a mechanism."""
    base = np.array([float(get_parameter(mechanism, name)) for name in _NAMES])
    return base * np.random.default_rng(2022).uniform(0.95, 1.05, (count, len(base)))


def _moved(mechanism: Mechanism, design) -> Mechanism:
    return set_parameters(mechanism, dict(zip(_NAMES, design, strict=True)))


def _frequencies(mechanism: Mechanism):
    """The distinct frequencies, family by family."""

    def values(design):
        modes = modal(_moved(mechanism, design))
        groups = [modes.group(family) for family in _FAMILIES]
        return [group.frequencies for group in groups if group is not None]

    return values


def _efficiency(mechanism: Mechanism):
    return lambda design: [steady_state(_moved(mechanism, design)).efficiency[None]]


def _differences(values: Callable[..., Any]) -> Callable[..., Any]:
    """Central differences of second order, with a step relative to each parameter."""

    def slopes(design, step):
        moved = design * (1 + step * jnp.concatenate([jnp.eye(3), -jnp.eye(3)]))
        # Side by side, as a user who knows `vmap` would write it.
        ends = jax.vmap(values)(moved)
        return [((rows[:3] - rows[3:]) / (2 * step * design)[:, None]).T for rows in ends]

    return slopes


def _problem(
    name: str,
    title: str,
    label: str,
    values: Callable[..., Any],
    designs: np.ndarray,
    exact: Callable[[np.ndarray], np.ndarray],
    compared: int,
    least: bool = False,
) -> Problem:
    def method(
        label_of: str, differentiate: Callable[..., Any], kind: Kind = "method", settings=(None,)
    ):
        def one_or_many(batched: bool) -> Method:
            rows = jnp.asarray(designs if batched else designs[:1])
            given = rows if batched else rows[0]
            axes = (0,) if settings == (None,) else (0, None)
            # Not a batch of one: `vmap` turns branches into selections. Steps are traced: one
            # program for all.
            jitted = jax.jit(jax.vmap(differentiate, axes) if batched else differentiate)

            def prepare(setting):
                step = () if setting is None else (jnp.asarray(setting),)

                def read(out):
                    parts = [np.asarray(part) for part in out]
                    parts = parts if batched else [part[None] for part in parts]
                    return {label: np.concatenate(parts, axis=1)}

                return Prepared(lambda: jitted(given, *step), len(rows), read)

            where = "a batch" if batched else "one design"
            step = "" if settings == (None,) else "relative step"
            return Method(f"{label_of}, {where}", prepare, settings, step, kind)

        return [one_or_many(True), one_or_many(False)]

    def scipy() -> Method:
        from scipy.optimize._numdiff import approx_derivative  # what its optimisers call

        jitted = jax.jit(lambda design: jnp.concatenate(values(design)))

        def prepare(_):
            def call():
                return approx_derivative(
                    lambda design: np.asarray(jitted(design)), designs[0], method="3-point"
                )

            return Prepared(call, 1, lambda out: {label: np.atleast_2d(out)[None]})

        return Method("SciPy approx_derivative, 3-point, one design", prepare, kind="rival")

    def reference():
        rows = np.array([exact(design) for design in designs[:compared]])
        # A derivative that is small beside the others of the same parameter is judged by those.
        return {label: Reference(rows, scale=np.abs(rows).max(axis=1, keepdims=True))}

    methods = [*method("forward", jax.jacfwd(values))]
    if not least:
        methods += method("reverse", jax.jacrev(values))
        methods += method("differences", _differences(values), "approximation", _STEPS)
    return Problem(
        name=name,
        title=title,
        instance="design",
        methods=[*methods, scipy()],
        reference=reference,
        reference_note=f"equations written apart in mpmath at {DIGITS} digits and more, "
        f"{compared} designs",
        baseline="SciPy approx_derivative, 3-point, one design",
    )


def case(quick: bool, smoke: bool = False) -> Case:
    """The case of this module; with `smoke` only forward mode where programs are large."""
    count, compared = (200, 2) if quick else (2_000, 8)
    mechanism, bare = load("actuator"), load("wu2022")
    # The reference has equal contacts.
    alike = tuple(dataclasses.replace(one, load_sharing=None) for one in mechanism.stages)
    mechanism = dataclasses.replace(mechanism, stages=alike)
    around, aside = _around(mechanism, count), _around(bare, count)
    stage = bare.stages[0]
    assert stage.friction is not None
    assert isinstance(stage.friction.thread, CoulombFriction)
    friction, starts = float(stage.friction.thread.coefficient), float(stage.thread.starts)
    return Case(
        "gradients",
        "Derivatives by lead, contact angle and roller radius: forward, reverse, differences",
        [
            _problem(
                "frequencies",
                "Derivatives of the distinct frequencies by three parameters",
                "∂f/∂(lead, contact angle, roller radius)",
                _frequencies(mechanism),
                around,
                lambda row: frequency_slopes(*row),
                compared,
                least=smoke,
            ),
            _problem(
                "efficiency",
                "Derivatives of the efficiency by three parameters",
                "∂η/∂(lead, contact angle, roller radius)",
                _efficiency(bare),
                aside,
                lambda row: efficiency_slopes(row, starts, friction)[None],
                compared,
            ),
        ],
    )
