"""What is computed for many designs: each task builds a function and its inputs of any size."""

import dataclasses
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

import prsm_jax as prsm
from prsm_jax.contact import hertz_contact
from prsm_jax.geometry import mesh
from prsm_jax.mechanism import get_parameter, set_parameters
from prsm_jax.vibration import distinct_frequencies

from ..method_options import taken
from ..references.designs import random_designs, threads
from ..references.stages import random_systems, unflattened
from ..references.transients.designs_of_two_stages import (
    base as two_stages,
    design,
    kinematics_of,
    random_designs as random_two_stages,
)

_ROLLERS = 10
_VARIABLES = ("lead", "contact_angle", "roller_radius")
_QUANTITIES = ("efficiency", "max_pressure", "natural_frequencies")


@dataclasses.dataclass(frozen=True)
class Task:
    """Something that is computed for each of many designs.

    - `build`: number of designs to (function of one design, inputs of all, design axis first).
    - `sizes`: numbers of designs; the quick form takes the first.
    - `single`: whether it is computed in float32 too.
    """

    title: str
    build: Callable[[int], tuple[Callable[[Any], Any], Any]]
    sizes: tuple[int, ...]
    single: bool = True


def _repeated(inputs: Any, count: int) -> Any:
    """Inputs of a thousand designs, again and again."""
    return jax.tree.map(lambda x: np.resize(np.asarray(x), (count, *np.shape(x)[1:])), inputs)


def _hertz(count: int):
    random = np.random.default_rng(1882)
    total = random.uniform(50.0, 500.0, 1000)
    ratio = random.uniform(0.01, 0.99, 1000)

    def one(given):
        found = hertz_contact(*given)
        return found.max_pressure, found.approach

    inputs = (random.uniform(1.0, 1e4, 1000), total, (ratio * total) ** 2, np.full(1000, 1.1e11))
    return one, _repeated(inputs, count)


def _meshing(count: int):
    def one(thread):
        found = mesh(thread)
        return found.screw.contact_radius, found.nut.contact_radius, found.screw.normal

    return one, _repeated(threads(random_designs(1000)), count)


def _frequencies(count: int):
    systems = unflattened(_ROLLERS)
    columns = tuple(random_systems(_ROLLERS, 1000, 0.3).T)

    def one(columns):
        found = distinct_frequencies(systems(columns))
        return found.carrier, *found.torsional, *found.transverse, found.roller

    return one, _repeated(columns, count)


def _chain(differentiated: bool):
    def build(count: int):
        actuator = prsm.load("actuator")
        base = np.array([float(get_parameter(actuator, name)) for name in _VARIABLES])
        factors = np.random.default_rng(45).uniform(0.97, 1.03, (1000, len(base)))

        def values(given):
            moved = set_parameters(actuator, dict(zip(_VARIABLES, given, strict=True)))
            return prsm.compute(moved, _QUANTITIES)

        return (jax.jacfwd(values) if differentiated else values), _repeated(base * factors, count)

    return build


def _settling(method: Any):
    def build(count: int):
        mechanism = two_stages(0.0)
        designs = random_two_stages(1000)
        inputs = (designs.factors, kinematics_of(mechanism, designs), designs.speed, designs.load)

        def one(given):
            factors, kinematics, speed, load = given
            scene = prsm.Scenario(speed, load, jnp.asarray(1e-3), samples=21)
            run = prsm.simulate(
                design(mechanism, factors),
                scene,
                method=method,
                gradient="forward",
                **taken(method, rtol=1e-6, atol=1e-8),
                throw=False,
                kinematics=kinematics,
            )
            return run.carrier_ratio

        return one, _repeated(inputs, count)

    return build


TASKS = {
    "hertz": Task("exact Hertz contact", _hertz, (100_000, 1_000_000, 10_000_000, 100_000_000)),
    "meshing": Task("meshing of both sides", _meshing, (100_000, 1_000_000, 10_000_000)),
    "frequencies": Task(
        "distinct natural frequencies of a stage, 10 rollers",
        _frequencies,
        (100_000, 1_000_000, 10_000_000),
    ),
    "chain": Task(
        "efficiency, pressure and frequencies from geometry",
        _chain(differentiated=False),
        (10_000, 100_000, 1_000_000),
        single=False,
    ),
    "chain_jacobian": Task(
        "their Jacobian by lead, contact angle and roller radius",
        _chain(differentiated=True),
        (10_000, 100_000, 1_000_000),
        single=False,
    ),
    "closed_form": Task(
        "two stages settling in 1 ms, closed form, 21 samples",
        _settling("closed_form"),
        (10_000, 100_000, 1_000_000),
        single=False,
    ),
    "rodasp": Task(
        "two stages settling in 1 ms, RODASP at 1e-6, in lock step",
        _settling("rosenbrock"),
        (10_000, 100_000, 1_000_000),
        single=False,
    ),
}
