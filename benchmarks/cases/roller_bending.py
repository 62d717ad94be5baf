"""Rollers that lean and bend: number of shapes, against beams of finite elements in NumPy."""

import dataclasses
import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

import prsm_jax as prsm
from prsm_jax.load_sharing import stage_load_distribution
from prsm_jax.mechanism import RollerBending

from ..harness import Case, Method, Prepared, Problem, Reference
from ..references.roller_bending import balance, bent_rollers

_LABEL = "thread loads"
_SHAPES = (1, 2, 3, 5, 8, 12, 16)
_CHUNK = 100


@functools.cache
def _stage(support: float | None, shapes: int):
    """A stage of equal rollers whose nut is in one piece, without play and errors."""
    (stage,) = prsm.load("actuator_load_sharing").stages
    held = None if support is None else jnp.asarray(support)
    assert stage.load_sharing is not None
    sharing = dataclasses.replace(
        stage.load_sharing,
        backlash=None,
        split_nut=None,
        screw_pitch_error=None,
        roller_bending=RollerBending(held, shapes),
    )
    return dataclasses.replace(stage, load_sharing=sharing)


@eqx.filter_jit
def _distribution(stage, load):
    return stage_load_distribution(stage, load)


@functools.cache
def _numbers(support: float | None):
    stage = _stage(support, 1)
    chains = _distribution(stage, jnp.asarray(5e3)).chains
    return bent_rollers(stage, chains, support)


@functools.cache
def _program(batch: int | None):
    def one(stage, load):
        return stage_load_distribution(stage, load).screw.forward[0]

    if batch is None:
        return eqx.filter_jit(lambda stage, loads: one(stage, loads[0])[None])
    return eqx.filter_jit(
        lambda stage, loads: jax.lax.map(lambda load: one(stage, load), loads, batch_size=batch)
    )


def _ours(support: float | None, loads: np.ndarray, batch: int | None, settings) -> Method:
    def prepare(shapes) -> Prepared:
        stage, some = _stage(support, shapes), jnp.asarray(loads if batch else loads[:1])
        return Prepared(lambda: _program(batch)(stage, some), len(some), lambda out: {_LABEL: out})

    return Method("a batch" if batch else "one at a time", prepare, settings, "shapes")


def _elements(support: float | None, loads: np.ndarray) -> Method:
    def prepare(tolerance) -> Prepared:
        numbers = _numbers(support)

        def call():
            return np.stack([balance(numbers, load, tolerance).screw for load in loads])

        return Prepared(call, len(loads), lambda out: {_LABEL: out})

    return Method("finite elements (NumPy)", prepare, (1e-3, 1e-6, 1e-12), "tolerance", "rival")


def _problem(name: str, title: str, support: float | None, quick: bool) -> Problem:
    compared = 10 if quick else 50
    loads = np.random.default_rng(20_261_125).uniform(2e3, 2e4, 200 if quick else 2000)

    def reference():
        exact = [balance(_numbers(support), load) for load in loads[:compared]]
        if max(one.error for one in exact) > 1e-9:
            raise RuntimeError(f"roller bending, {name}: the finite elements are not in balance")
        values = np.stack([one.screw for one in exact])
        return {_LABEL: Reference(values, np.mean(values, axis=1, keepdims=True))}

    settings = (1, 8) if quick else _SHAPES
    return Problem(
        name=name,
        title=title,
        instance="nut",
        methods=[
            _ours(support, loads, _CHUNK, settings),
            _ours(support, loads, None, (8,)),
            _elements(support, loads[:compared]),
        ],
        reference=reference,
        reference_note=(
            f"beams of cubic finite elements, {compared} nuts; errors over the mean load of a "
            "thread"
        ),
        baseline="finite elements (NumPy)",
        target=1e-3,
    )


def case(quick: bool) -> Case:
    """The case of this module."""
    return Case(
        "roller_bending",
        "Load on the threads of rollers that lean and bend: shapes, finite elements",
        [
            _problem("free", "Load on the threads of free rollers that bend", None, quick),
            _problem(
                "supported",
                "Load on the threads of rollers that bend, 20 kN·m/rad against leaning",
                2e4,
                quick,
            ),
        ],
    )
