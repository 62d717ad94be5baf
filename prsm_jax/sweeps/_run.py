"""Computation of the blocks of a sweep, by threads of this process or an executor's workers."""

import functools
import math
import operator
import os
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from .._errors import MissingDataError
from ..findings import sources
from ..mechanism import Mechanism, stages_of_count
from ._labels import Variable, arrays_of, variables_of
from ._plan import Blocks, Plan, fixed_counts, with_static
from ._program import (
    BlockResults,
    Question,
    block_shapes,
    evaluate_block,
)
from ._sizes import equal_parts
from ._store import opened

#: Blocks that an executor has at once: enough for many workers, few enough to stay in memory.
_IN_FLIGHT = 256
#: Blocks that a thread has at once, including the one that it computes.
_IN_FLIGHT_OF_THREAD = 2
#: Smallest number of designs in a call where a block is divided by whole numbers. In smaller calls
#: the call itself takes longer than the computation.
_LEAST = 64


class _Settings(NamedTuple):
    """What is computed for every design, in a form that can be sent to another process."""

    quantities: tuple[str, ...]
    gradients: tuple[str, ...]
    #: Names of the axes in their order, and whether a derivative by one keeps the others.
    axes: tuple[str, ...]
    hold_axes: bool
    findings: bool
    #: Number of designs in a call.
    size: int
    #: `speed` and `load` [rad/s, N], or `None`.
    point: dict[str, float | None]
    #: Axes of whole numbers that the program takes as numbers, from `FEWEST_TRACED`.
    traced: tuple[str, ...]

    @property
    def question(self) -> Question:
        margins = sources() if self.findings else None
        return Question(
            self.quantities, self.gradients, self.axes, self.hold_axes, margins, self.size
        )

    @property
    def arguments(self) -> dict[str, Any]:
        """The operating point as arrays, so that another speed does not compile again."""
        dtype = jnp.result_type(float)
        return {
            name: None if value is None else jnp.asarray(value, dtype)
            for name, value in self.point.items()
        }


class BlockTask(NamedTuple):
    """One block: its inputs, and the store that it is written to."""

    number: int
    mechanism: Mechanism
    settings: _Settings
    #: Values [SI] of parameters, and whole numbers; they broadcast to the shape of the block.
    values: dict[str, np.ndarray]
    static: dict[str, np.ndarray]
    #: Its place in the arrays of the sweep.
    where: tuple[slice, ...]
    #: Where it is written, or `None`.
    store: Path | None


class BlockDone(NamedTuple):
    """A block that was computed."""

    number: int
    designs: int
    #: Designs that failed, and designs in which `check` finds an error.
    counts: tuple[int, int]
    #: Its arrays, or `None` if they were written to the store.
    arrays: dict[str, np.ndarray] | None


@dataclass(frozen=True)
class Job:
    """A sweep, block by block."""

    mechanism: Mechanism
    plan: Plan
    blocks: Blocks
    quantities: tuple[str, ...]
    gradients: tuple[str, ...]
    #: `speed` and `load` [rad/s, N], or `None`.
    point: dict[str, float | None]
    findings: bool
    #: The most designs in a call.
    call: int
    #: Where blocks are written, or `None`.
    store: Path | None = None
    #: Whether a derivative by an axis keeps the values of the other axes.
    hold_axes: bool = False

    @functools.cached_property
    def _settings(self) -> _Settings:
        """Settings that need as few programs as possible."""
        counts = tuple(
            axis.name
            for axis in self.plan.axes
            if axis.static and stages_of_count(self.mechanism, axis.name)
        )
        choices = self.plan.static_choices(counts)
        # The combination with the most numbers that are not part of the program.
        most = min(choices, key=lambda choice: sum(value > 0 for value in choice.values()))
        if not all(most.values()):
            settings = self._settings_with(counts)
            try:
                self._traced(settings, most)
            except (TypeError, ValueError):
                # A result whose shape depends on the number needs a program for each.
                pass
            else:
                return settings
        return self._settings_with(())

    def _settings_with(self, traced: tuple[str, ...]) -> _Settings:
        # Only designs with equal whole numbers that are part of the program share a call.
        static = {
            axis.name
            for axis in self.plan.axes
            if axis.static and fixed_counts(axis.values, axis.name in traced).any()
        }
        size = self.blocks.size
        if self.plan.kind == "grid":
            lengths = zip(self.plan.dimensions, self.blocks.block, strict=True)
            size = math.prod(length for name, length in lengths if name not in static)
        else:
            share = -(-size // len(self.plan.static_choices(traced)))
            size = min(size, max(share, _LEAST))
        size = equal_parts(size, self.call)
        return _Settings(
            self.quantities,
            self.gradients,
            tuple(axis.name for axis in self.plan.axes),
            self.hold_axes,
            self.findings,
            size,
            self.point,
            traced,
        )

    def _traced(self, settings: _Settings, choice: dict[str, int]) -> BlockResults:
        """Shapes of the results of the program of a choice."""
        columns = {
            axis.name: jnp.zeros(settings.size, jnp.result_type(float))
            for axis in self.plan.axes
            if not choice.get(axis.name)
        }
        chosen = with_static(self.mechanism, choice)
        return block_shapes(chosen, columns, settings.arguments, settings.question)

    def task(self, number: int) -> BlockTask:
        """Inputs of one block."""
        where = self.blocks.slices(number)
        values = self.plan.values(where)
        static = {axis.name: values.pop(axis.name) for axis in self.plan.axes if axis.static}
        return BlockTask(number, self.mechanism, self._settings, values, static, where, self.store)

    def variables(self) -> tuple[Variable, ...]:
        """All arrays of the sweep; raises as `shapes` does."""
        return variables_of(
            self.mechanism, self.plan, self.quantities, self.gradients, self.shapes()
        )

    def result_bytes(self) -> int:
        """Memory that results of one design take [B]; raises as `shapes` does."""
        leaves = jax.tree.leaves(self.shapes())
        return sum(leaf.size * leaf.dtype.itemsize for leaf in leaves) // self._settings.size

    def shapes(self) -> BlockResults:
        """Shapes of the results of a call.

        **Raises:** `MissingDataError` where the mechanism lacks data; `ValueError` if whole numbers
        change the number of components of a quantity.
        """
        settings, first, where_first = self._settings, None, ""
        for choice in self.plan.static_choices(settings.traced):
            fixed = {name: value for name, value in choice.items() if value}
            words = ", ".join(f"{name} = {value}" for name, value in fixed.items())
            try:
                shapes = self._traced(settings, choice)
            except MissingDataError as error:
                raise (MissingDataError(f"at {words}: {error}") if words else error) from error
            if first is None:
                first, where_first = shapes, words
            for name, value in shapes.values.items():
                if value.shape != first.values[name].shape:
                    raise ValueError(
                        f"quantity {name!r} has {value.shape[1:]} components at {words} and "
                        f"{first.values[name].shape[1:]} at {where_first}; sweep them separately"
                    )
        assert first is not None  # a plan has at least one choice
        return first


def compute_block(task: BlockTask) -> BlockDone:
    """Compute one block, and write it if there is a store."""
    size = task.settings.size
    shape = tuple(part.stop - part.start for part in task.where)
    designs = math.prod(shape)
    # In the order of the designs.
    values, static = (
        {name: np.broadcast_to(array, shape).ravel() for name, array in given.items()}
        for given in (task.values, task.static)
    )
    parts, places = [], []
    for fixed, members in _groups(static, task.settings.traced, designs):
        chosen = with_static(task.mechanism, fixed)
        given = values | {n: v for n, v in static.items() if not fixed[n]}
        for start in range(0, len(members), size):
            place = members[start : start + size]
            # Every call has the same size; copies of the last design fill the last call.
            filled = place[np.minimum(np.arange(size), len(place) - 1)]
            columns = {
                name: jnp.asarray(column[filled], jnp.result_type(float))
                for name, column in given.items()
            }
            results = jax.tree.map(np.asarray, _evaluated(chosen, columns, task.settings))
            parts.append(jax.tree.map(operator.itemgetter(slice(len(place))), results))
            places.append(place)
    joined = jax.tree.map(lambda *leaves: np.concatenate(leaves), *parts)
    if static:
        order = np.argsort(np.concatenate(places))
        joined = jax.tree.map(operator.itemgetter(order), joined)
    arrays = arrays_of(shape, joined)
    counts = int(arrays["failed"].sum()), int((arrays["error"] != 0).sum())
    if task.store is None:
        return BlockDone(task.number, designs, counts, arrays)
    opened(task.store).write(task.number, task.where, arrays, counts)
    return BlockDone(task.number, designs, counts, None)


def _groups(
    static: dict[str, np.ndarray], traced: tuple[str, ...], designs: int
) -> Iterator[tuple[dict[str, int], np.ndarray]]:
    """Whole numbers that are part of a program, and the places of the designs that have them."""
    if not static:
        yield {}, np.arange(designs)
        return
    choices = np.array([fixed_counts(values, name in traced) for name, values in static.items()])
    distinct, group = np.unique(choices.astype(int), axis=1, return_inverse=True)
    for index, choice in enumerate(distinct.T.tolist()):
        yield dict(zip(static, choice, strict=True)), np.flatnonzero(group.ravel() == index)


#: Programs that were compiled; a thread that needs another one compiles it while others wait.
_compiled: set[Any] = set()
_compiling = threading.Lock()


def _evaluated(mechanism: Mechanism, columns: dict[str, Any], settings: _Settings) -> BlockResults:
    question, point = settings.question, settings.arguments
    # Each device has a program of its own.
    device = jax.config.jax_default_device  # pyright: ignore[reportAttributeAccessIssue]
    program = (question, jax.tree.structure((mechanism, columns, point)), device)
    if program in _compiled:
        return evaluate_block(mechanism, columns, point, question)
    with _compiling:
        results = evaluate_block(mechanism, columns, point, question)
        jax.block_until_ready(results)
        _compiled.add(program)
    return results


def run_blocks(job: Job, numbers: Iterable[int], executor: Executor | None) -> Iterator[BlockDone]:
    """Compute blocks in any order.

    **Arguments:**

    - `job`: the sweep.
    - `numbers`: which blocks.
    - `executor`: its workers compute; `None`: threads of this process, one for each core, or for
      each device if there are several.
    """
    tasks = map(job.task, numbers)
    if executor is not None:
        yield from _by(executor, compute_block, tasks, _IN_FLIGHT)
        return
    devices = jax.local_devices()
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    lanes = len(devices) if len(devices) > 1 or devices[0].platform != "cpu" else cores or 1
    with ThreadPoolExecutor(lanes, "sweep") as threads:
        work = functools.partial(_on_device, devices)
        yield from _by(threads, work, tasks, lanes * _IN_FLIGHT_OF_THREAD)


def _on_device(devices: list[Any], task: BlockTask) -> BlockDone:
    """Compute a block; consecutive blocks use the devices one after the other."""
    with jax.default_device(devices[task.number % len(devices)] if len(devices) > 1 else None):
        return compute_block(task)


def _by(
    executor: Executor,
    function: Callable[[BlockTask], BlockDone],
    tasks: Iterator[BlockTask],
    at_once: int,
) -> Iterator[BlockDone]:
    """Results of an executor as they are completed, with a bounded number of blocks at once."""
    waiting: set[Future[BlockDone]] = set()
    try:
        while True:
            for task in tasks:
                waiting.add(executor.submit(function, task))
                if len(waiting) >= at_once:
                    break
            if not waiting:
                return
            done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
            for future in done:
                yield future.result()
    finally:
        for future in waiting:
            future.cancel()
