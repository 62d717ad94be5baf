"""The mechanisms and grids of the benchmark, and their blocks as the kernel alone gets them."""

import dataclasses
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

import prsm_jax as prsm
from prsm_jax.mechanism import Mechanism, get_parameter
from prsm_jax.sweeps._plan import Blocks, Plan, blocks_of, plan_of
from prsm_jax.sweeps._program import evaluate_block
from prsm_jax.sweeps._run import Job
from prsm_jax.sweeps._sizes import block_size, call_size

QUANTITIES = ("natural_frequencies", "efficiency", "max_pressure")
VARIABLES = ("lead", "contact_angle", "roller_radius")
_POINT = {"speed": None, "load": None}


def _without_root_searches() -> Mechanism:
    """The actuator as the rival has it: equal threads, neither spin nor rolling losses."""
    mechanism = prsm.load("actuator")
    (stage,) = mechanism.stages
    assert stage.friction is not None
    friction = dataclasses.replace(stage.friction, spin=None, rolling_hysteresis=None)
    stage = dataclasses.replace(stage, friction=friction, load_sharing=None)
    return dataclasses.replace(mechanism, stages=(stage,))


#: By name: what a sweep varies.
SCENES: dict[str, Callable[[], Mechanism]] = {
    "actuator": lambda: prsm.load("actuator"),
    "actuator as the rival has it": _without_root_searches,
}


class Study(NamedTuple):
    """One sweep of a scene."""

    mechanism: Mechanism
    axes: dict[str, np.ndarray]
    job: Job

    @property
    def points(self) -> int:
        """Number of designs."""
        return self.job.plan.points


def study(scene: str, side: int, findings: bool) -> Study:
    """A grid of `side`³ designs within 10 % of a scene, laid out as `prsm_jax.sweep` does."""
    mechanism = SCENES[scene]()
    axes = {
        name: float(get_parameter(mechanism, name)) * np.linspace(0.9, 1.1, side)
        for name in VARIABLES
    }
    plan = plan_of(mechanism, axes, _POINT, "grid", None, 0)
    blocks = blocks_of(plan.shape, block_size(plan.points))
    job = Job(mechanism, plan, blocks, QUANTITIES, (), dict(_POINT), findings, call_size())
    return Study(mechanism, axes, job)


def calls(of: Study) -> list[dict[str, jax.Array]]:
    """The arguments of every call of the compiled program, in the order of the sweep."""
    plan, blocks, size = of.job.plan, of.job.blocks, of.job.task(0).settings.size
    found = []
    for number in range(len(blocks)):
        columns = _columns(plan, blocks, number)
        designs = len(next(iter(columns.values())))
        for start in range(0, designs, size):
            places = np.minimum(np.arange(start, start + size), designs - 1)
            found.append({name: jnp.asarray(column[places]) for name, column in columns.items()})
    return found


def _columns(plan: Plan, blocks: Blocks, number: int) -> dict[str, np.ndarray]:
    shape = blocks.lengths(number)
    values = plan.values(blocks.slices(number))
    return {name: np.broadcast_to(array, shape).ravel() for name, array in values.items()}


def kernel(of: Study, given: list[dict[str, jax.Array]], threads: int) -> None:
    """Run the compiled program on all calls and wait; nothing is copied, kept or written."""
    settings = of.job.task(0).settings
    question, point = settings.question, settings.arguments

    def one(columns: dict[str, Any]) -> None:
        jax.block_until_ready(evaluate_block(of.mechanism, columns, point, question))

    with ThreadPoolExecutor(threads) as pool:
        for _ in pool.map(one, given):
            pass
