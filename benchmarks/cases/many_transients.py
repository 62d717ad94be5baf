"""Many designs' transients at equal achieved error: compiled rivals, derivatives, lock step."""

import concurrent.futures
import functools
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax import Scenario, simulate

from ..harness import Case, Method, Prepared, Problem, Reference
from ..method_options import taken
from ..references.transients.compiled import (
    Lsoda,
    casadi_integrators,
    followed,
    mapped,
    missing_rivals,
    python_rates,
)
from ..references.transients.designs_of_two_stages import (
    Designs,
    apart,
    base,
    design,
    kinematics_of,
    numbers_of,
    random_designs,
)

_RATIO = "carrier speeds over the largest screw speed"
_SLOPES = "derivatives by speed, load and friction coefficient"
_OF_MEAN = "derivatives of the mean speed of the first carrier"
#: Absolute tolerance over relative tolerance; all solvers have the same.
_ABSOLUTE = 1e-2
_FREQUENCY = 2 * np.pi * 5
#: Carrier speeds are measured by the steady value of the first design.
_SCALE = 0.37
_TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
_QUICK = (1e-4, 1e-6)
#: Rivals that take packages of their own.
_LSODA = "numbalsoda LSODA, all cores"
_THREADS = "{}, a thread for each core"
_BALANCE, _RODASP = "quasi-steady balance", "RODASP"
_CASADI = "CasADi {}, interpreted, mapped on all cores"


@dataclass(frozen=True)
class Size:
    """How many designs, over how much time, and how many of them are compared."""

    settling: int
    missions: int
    many_missions: int
    slopes: int
    in_step: int
    chunk: int
    compared: int
    mission_s: float
    tolerances: tuple[float, ...]
    mission_tolerances: tuple[float, ...]
    in_step_tolerances: tuple[float, ...]


_FULL = Size(
    10_000, 100, 10_000, 2000, 9984, 96, 50, 1.0, _TOLERANCES, _TOLERANCES[2:5], (1e-4, 1e-6, 1e-8)
)
_SMALL = Size(200, 50, 200, 100, 192, 24, 5, 1.0, _QUICK, (*_QUICK, 1e-8), (1e-6,))
#: Whether everything runs: one reversal, and as many designs as chunks need.
_LEAST = Size(8, 4, 8, 4, 8, 4, 1, 0.11, _QUICK, (*_QUICK, 1e-8), (1e-6,))
#: Designs in a chunk of a large batch: what a step works on stays in a core's cache.
_IN_CACHE = 250


class Scene:
    """Designs, how they are driven, and everything that is computed once for all methods."""

    def __init__(self, count, duration, samples, frequency=0.0, width=0.0):
        self.designs: Designs = random_designs(count)
        self.mechanism = base(width)
        self.duration, self.samples = duration, samples
        self.frequency, self.width = frequency, width
        self.times = np.linspace(0.0, duration, samples)
        self.kinematics = kinematics_of(self.mechanism, self.designs)
        self.numbers = numbers_of(self.mechanism, self.designs, self.kinematics, frequency, width)

    def scenario(self, speed, force) -> Scenario:
        """The scene of one design."""
        motion = speed
        if self.frequency:

            def motion(time):
                return speed * jnp.sin(self.frequency * time)

        return Scenario(motion, force, self.duration, samples=self.samples)

    @functools.cached_property
    def inputs(self) -> tuple[Any, ...]:
        """What the package's methods are given of all designs."""
        designs = self.designs
        given = designs.factors, self.kinematics, designs.speed, designs.load
        return jax.tree.map(jnp.asarray, given)

    def rows(self, count: int) -> np.ndarray:
        """Numbers of the first designs, meshed apart from the package."""
        return apart(base(0.0), self.designs, self.numbers, count)


def _tight(scene: Scene, rows: np.ndarray, solver: str, rtol: float) -> np.ndarray:
    """Carrier speeds over the screw's largest, by SciPy: row × stage × time."""
    moving, atol = bool(scene.frequency), rtol * _ABSOLUTE
    found = [
        followed(python_rates(moving, row), 2, scene.times, solver, rtol, atol) for row in rows
    ]
    return np.array(found)


def _reference(scene: Scene, count: int, solver: str, rtol: float) -> Callable[..., Any]:
    return lambda: {_RATIO: Reference(_tight(scene, scene.rows(count), solver, rtol), _SCALE)}


def _solver(scene: Scene, method: Any, meshes: bool = False, gradient: Any = "forward"):
    """Carrier speeds of one design, over the amplitude of its screw speed, and the steps."""

    def solve(factors, kinematics, speed, force, rtol):
        run = simulate(
            design(scene.mechanism, factors),
            scene.scenario(speed, force),
            method=method,
            gradient=gradient,
            **taken(method, rtol=rtol, atol=rtol * _ABSOLUTE, max_steps=100_000),
            throw=False,
            kinematics=None if meshes else kinematics,
        )
        found = jnp.where(run.solver.code != 0, jnp.nan, run.carrier_speed / speed)
        return found, run.solver.steps + run.solver.rejected

    return solve


def _steps(out):
    steps = np.asarray(out[1])
    if not steps.any():
        return ""
    return f"{steps.mean():.0f} steps on average, {steps.max()} in lock step"


def _ours(
    scene: Scene,
    name: str,
    method: Any,
    settings: Sequence[Any],
    chunk: int = 0,
    order=None,
    threads: int = 0,
    **options,
) -> Method:
    """A method of the package; with `chunk`, that many designs at once, in a certain order.

    With `threads`, chunks run in as many threads of Python, as the rivals' loops do.
    """
    batched: Any = jax.vmap(_solver(scene, method, **options), in_axes=(0, 0, 0, 0, None))
    rows = np.arange(len(scene.designs.speed)) if order is None else order
    inputs = jax.tree.map(lambda x: x[rows], scene.inputs)
    back = np.argsort(rows)
    jitted: Any
    if threads:
        jitted = jax.jit(batched)
        pool = concurrent.futures.ThreadPoolExecutor(threads)
        parts = [
            jax.tree.map(lambda x, k=k: x[k : k + chunk], inputs)
            for k in range(0, len(rows), chunk)
        ]

        def call(rtol):
            running = [pool.submit(jitted, *part, rtol) for part in parts]
            found = [jax.block_until_ready(one.result()) for one in running]
            return jax.tree.map(lambda *x: np.concatenate(x), *found)
    elif chunk:
        parts = jax.tree.map(lambda x: x.reshape(-1, chunk, *x.shape[1:]), inputs)
        jitted = jax.jit(
            lambda given, rtol: jax.tree.map(
                lambda x: x.reshape(-1, *x.shape[2:]),
                jax.lax.map(lambda part: batched(*part, rtol), given),
            )
        )

        def call(rtol):
            return jitted(parts, rtol)
    else:
        jitted = jax.jit(batched)

        def call(rtol):
            return jitted(*inputs, rtol)

    def prepare(rtol):
        given = jnp.asarray(1e-8 if rtol is None else rtol)

        def read(out):
            return {_RATIO: np.asarray(out[0])[back]}

        return Prepared(lambda: call(given), len(rows), read, _steps)

    return Method(name, prepare, settings, "rtol" if settings != (None,) else "")


def _in_threads(scene: Scene, name: str, method: str, settings: Sequence[Any]) -> Method:
    """A method in a thread for each core, as the rivals' loops; large batches in chunks."""
    count, cores = len(scene.designs.speed), len(os.sched_getaffinity(0))
    chunk = min(-(-count // cores), _IN_CACHE)
    threads = _THREADS.format(name)
    return _ours(scene, threads, method, settings, chunk, np.arange(count), cores)


def _lsoda(scene: Scene, settings, count: int) -> Method:
    solver = Lsoda(bool(scene.frequency))
    rows = np.ascontiguousarray(scene.numbers[:count])

    def prepare(rtol):
        def call():
            return solver.solve(rows, scene.times, rtol, rtol * _ABSOLUTE)

        return Prepared(call, len(rows), lambda out: {_RATIO: out})

    return Method(_LSODA, prepare, settings, "rtol", "rival")


def _casadi(scene: Scene, solver: str, settings, batch: int) -> Method:
    def prepare(rtol):
        values, _ = casadi_integrators(
            bool(scene.frequency), solver, scene.times, rtol, rtol * _ABSOLUTE
        )
        solve = mapped(values, batch)

        def read(out):
            return {_RATIO: np.array(np.split(out, batch, axis=1))}

        return Prepared(lambda: solve(scene.numbers[:batch]), batch, read)

    return Method(_CASADI.format(solver.upper()), prepare, settings, "rtol", "rival")


def _scipy(scene: Scene, solver: str, settings, count: int) -> Method:
    def prepare(rtol):
        def call():
            return _tight(scene, scene.numbers[:count], solver, rtol)

        return Prepared(call, count, lambda out: {_RATIO: out})

    return Method(f"SciPy {solver}", prepare, settings, "rtol", "rival")


def _rivals(scene: Scene, settings, batch: int, few: int) -> list[Method]:
    absent = missing_rivals()
    found = []
    if "numbalsoda" not in absent and "numba" not in absent:
        found.append(_lsoda(scene, settings, batch))
    if "casadi" not in absent:
        found.append(_casadi(scene, "cvodes", settings, batch))
        if not scene.frequency:
            # At standstill IDAS finds no consistent start.
            found.append(_casadi(scene, "idas", settings, batch))
    return [*found, *(_scipy(scene, solver, settings, few) for solver in ("LSODA", "Radau"))]


def _left_out(*rivals: str) -> dict[str, str]:
    """The rivals that need a package which is not installed, and which."""
    needs = {_LSODA: ("numba", "numbalsoda")}
    found = {}
    for name in rivals:
        absent = [one for one in needs.get(name, ("casadi",)) if one in missing_rivals()]
        if absent:
            found[name] = f"not installed: {', '.join(absent)}"
    return found


def _settle(size: Size) -> Problem:
    count, settings, compared = size.settling, size.tolerances, size.compared
    scene = Scene(count, 1e-3, 21)
    rivals = _rivals(scene, settings, count, min(compared, 10))
    return Problem(
        name="settle",
        title=f"Two-stage settle, 1 ms, batch of {count} designs",
        instance="trajectory",
        methods=[
            _ours(scene, "closed form", "closed_form", (None,)),
            _ours(scene, "closed form, meshing included", "closed_form", (None,), meshes=True),
            _ours(scene, "RODASP", "rosenbrock", settings),
            _in_threads(scene, _RODASP, "rosenbrock", settings),
            _ours(scene, "Tsit5", "explicit", settings),
            _ours(scene, "Kvaerno5 with Newton", "implicit", settings),
            *rivals,
        ],
        reference=_reference(scene, compared, "DOP853", 1e-12),
        reference_note=f"SciPy DOP853 at rtol 1e-12, {compared} designs, meshed in mpmath",
        baseline=rivals[0].name,
        left_out=_left_out(_LSODA, _CASADI.format("CVODES"), _CASADI.format("IDAS")),
        target=1e-6,
    )


def _mission_reference(scene: Scene, compared: int) -> Callable[..., Any]:
    def reference():
        rows = scene.rows(compared)
        # SciPy's solvers give up where the force jumps. Over a nanometre per second it does not,
        # and that moves the solution by 3e-11.
        rows[:, 3] = np.maximum(rows[:, 3], 1e-9)
        return {_RATIO: Reference(_tight(scene, rows, "Radau", 1e-10), _SCALE)}

    return reference


def _mission(size: Size, width: float) -> Problem:
    count, settings, compared = size.missions, size.mission_tolerances, min(size.compared, 2)
    scene = Scene(count, size.mission_s, round(200 * size.mission_s) + 1, _FREQUENCY, width)
    rivals = _rivals(scene, settings, count, 1)
    friction = "exact Coulomb friction"
    if width:
        friction = f"Coulomb friction regularised over {1e3 * width:g} mm/s"
    # In chunks, because the samples of a whole batch, rewritten at every step, outgrow the cache.
    chunk, order = size.missions // (5 if size is _SMALL else 2), np.arange(count)
    ours = [
        _ours(scene, _BALANCE, "quasi_steady", (None,)),
        _in_threads(scene, _BALANCE, "quasi_steady", (None,)),
        _ours(scene, _RODASP, "rosenbrock", settings, chunk, order),
        _in_threads(scene, _RODASP, "rosenbrock", settings),
    ]
    return Problem(
        name="mission_smooth" if width else "mission",
        title=f"{size.mission_s:g} s with reversals at 5 Hz, {friction}, batch of {count} designs",
        instance="trajectory",
        methods=[*ours, *rivals],
        reference=_mission_reference(scene, compared),
        reference_note=f"SciPy Radau at rtol 1e-10, {compared} designs, meshed in mpmath",
        baseline=rivals[0].name,
        left_out=_left_out(_LSODA, _CASADI.format("CVODES")),
        target=1e-5,
    )


def _many_missions(size: Size) -> Problem:
    """The same in a large batch, by the fastest rival alone."""
    count, compared = size.many_missions, min(size.compared, 2)
    scene = Scene(count, size.mission_s, round(200 * size.mission_s) + 1, _FREQUENCY)
    # Both tolerances, for at one alone errors differ.
    settings, chunk = (1e-6, 1e-7), size.missions if count % size.missions == 0 else count
    rivals = _rivals(scene, settings, count, 1)[:1]
    return Problem(
        name="many_missions",
        title=f"{size.mission_s:g} s with reversals at 5 Hz, exact Coulomb friction, "
        f"batch of {count} designs",
        instance="trajectory",
        methods=[
            _ours(scene, _BALANCE, "quasi_steady", (None,), chunk, np.arange(count)),
            _in_threads(scene, _BALANCE, "quasi_steady", (None,)),
            _in_threads(scene, _RODASP, "rosenbrock", settings),
            *rivals,
        ],
        reference=_mission_reference(scene, compared),
        reference_note=f"SciPy Radau at rtol 1e-10, {compared} designs, meshed in mpmath",
        baseline=rivals[0].name,
        left_out=_left_out(_LSODA),
        target=1e-5,
    )


def _sloped(scene: Scene, method: Any, gradient: Any = "forward"):
    """Carrier speeds as a function of factors on speed, load and friction of the first stage."""
    solve = _solver(scene, method, gradient=gradient)

    def values(given, factors, kinematics, speed, force, rtol):
        scaled = factors.at[0, 3].multiply(given[2])
        found, _ = solve(scaled, kinematics, speed * given[0], force * given[1], rtol)
        return found

    return values


def _differences(scene: Scene) -> np.ndarray:
    """Derivatives of two designs by speed, load and friction, by fourth-order differences."""
    rows, step, found = scene.rows(2), 1e-3, []
    for column in (0, 2, 15):
        ends = []
        for factor in (1 + step, 1 - step, 1 + 2 * step, 1 - 2 * step):
            moved = rows.copy()
            moved[:, column] *= factor
            # The state is counted in the speed's amplitude; the derivative is of that.
            ends.append(_tight(scene, moved, "DOP853", 1e-13))
        found.append((8 * (ends[0] - ends[1]) - (ends[2] - ends[3])) / (12 * step))
    return np.stack(found, axis=-1)


def _gradient_of_one(size: Size) -> Problem:
    """One result by three parameters: forward and reverse mode, and the value alone."""
    count, settings = size.slopes, size.tolerances
    scene = Scene(count, 1e-3, 21)

    def ours(name: str, method: Any, settings, gradient: str, slope: Any) -> Method:
        values = _sloped(scene, method, gradient)

        def mean(given, *rest):
            return jnp.mean(values(given, *rest)[0])

        one = functools.partial(slope(mean), jnp.ones(3))
        jitted = jax.jit(jax.vmap(one, in_axes=(0, 0, 0, 0, None)))

        def prepare(rtol):
            given = jnp.asarray(1e-8 if rtol is None else rtol)

            def read(out):
                # A value has no derivatives to show.
                return {_OF_MEAN: np.asarray(out) if np.ndim(out) > 1 else np.full((1, 3), np.nan)}

            return Prepared(lambda: jitted(*scene.inputs, given), count, read)

        return Method(name, prepare, settings, "rtol" if settings != (None,) else "")

    def reference():
        return {_OF_MEAN: Reference(_differences(scene)[:, 0].mean(axis=1), _SCALE)}

    return Problem(
        name="gradient_of_one",
        title=f"Settle with derivatives of one result by three parameters, {count} designs",
        instance="trajectory",
        methods=[
            ours("closed form, reverse", "closed_form", (None,), "forward", jax.grad),
            ours("RODASP, forward", "rosenbrock", settings, "forward", jax.jacfwd),
            ours("RODASP, reverse", "rosenbrock", settings, "reverse", jax.grad),
            ours("RODASP, values only", "rosenbrock", settings, "forward", lambda one: one),
        ],
        reference=reference,
        reference_note=(
            "fourth-order differences of SciPy DOP853 at rtol 1e-13, good to about 1e-9; "
            "two designs, meshed in mpmath"
        ),
        baseline="RODASP, values only",
        target=1e-6,
    )


def _gradients(size: Size) -> Problem:
    count, settings = size.slopes, size.tolerances
    scene = Scene(count, 1e-3, 21)

    def ours(name: str, method: Any, settings, slopes: bool) -> Method:
        values = _sloped(scene, method)
        differentiated = jax.jacfwd(values) if slopes else values
        jitted = jax.jit(
            jax.vmap(functools.partial(differentiated, jnp.ones(3)), in_axes=(0, 0, 0, 0, None))
        )

        def prepare(rtol):
            given = jnp.asarray(1e-8 if rtol is None else rtol)

            def read(out):
                return {_SLOPES: np.asarray(out) if slopes else unknown}

            return Prepared(lambda: jitted(*scene.inputs, given), count, read)

        return Method(name, prepare, settings, "rtol" if settings != (None,) else "")

    #: What a method without derivatives shows.
    unknown = np.full((1, 2, scene.samples, 3), np.nan)

    def casadi(solver: str, few: int, slopes: bool) -> Method:
        def prepare(rtol):
            built = casadi_integrators(False, solver, scene.times, rtol, rtol * _ABSOLUTE)
            rows, solve = scene.numbers[:few], mapped(built[slopes], few)
            # By the logarithms of speed, load and friction coefficient, as ours.
            scale = np.stack([rows[:, 0], rows[:, 2], rows[:, 15]], axis=1)

            def call():
                return solve(rows)

            def read(out):
                if not slopes:
                    return {_SLOPES: unknown}
                each = np.split(out, few, axis=1)
                shaped = [np.reshape(x, (scene.samples, 2, 3)).transpose(1, 0, 2) for x in each]
                return {_SLOPES: np.array(shaped) * scale[:, None, None, :]}

            return Prepared(call, few, read)

        name = _CASADI.format(solver.upper()) + ("" if slopes else ", values only")
        return Method(name, prepare, settings, "rtol", "rival")

    def reference():
        return {_SLOPES: Reference(_differences(scene), _SCALE)}

    methods = [
        ours("closed form", "closed_form", (None,), True),
        ours("closed form, values only", "closed_form", (None,), False),
        ours("RODASP", "rosenbrock", settings, True),
        ours("RODASP, values only", "rosenbrock", settings, False),
    ]
    if "casadi" not in missing_rivals():
        few = min(count, 200)
        methods += [casadi("cvodes", few, True), casadi("cvodes", few, False)]
    return Problem(
        name="gradients",
        title=f"Settle with derivatives by three parameters, batch of {count} designs",
        instance="trajectory",
        methods=methods,
        reference=reference,
        reference_note=(
            "fourth-order differences of SciPy DOP853 at rtol 1e-13, good to about 1e-9; "
            "two designs, meshed in mpmath"
        ),
        baseline="RODASP, values only",
        left_out=_left_out(_CASADI.format("CVODES")),
        target=1e-6,
    )


def _lock_step(size: Size) -> Problem:
    """All designs of a batch take as many steps as the slowest."""
    count, settings, compared = size.in_step, size.in_step_tolerances, min(size.compared, 5)
    scene = Scene(count, 1e-3, 21)
    # Stiffness: the force that settles a carrier over its inertia and slip.
    p = scene.numbers
    stiffness = p[:, 2] * p[:, 15] / (p[:, 14] * p[:, 0])
    order, chunk = np.argsort(stiffness), size.chunk
    shuffled = np.arange(count)
    return Problem(
        name="lock_step",
        title=f"Lock step: {count} designs at once, in chunks, and in chunks of like stiffness",
        instance="trajectory",
        methods=[
            _ours(scene, "Tsit5, at once", "explicit", settings),
            _ours(scene, "Tsit5, chunks", "explicit", settings, chunk, shuffled),
            _ours(scene, "Tsit5, chunks by stiffness", "explicit", settings, chunk, order),
            _ours(scene, "RODASP, at once", "rosenbrock", settings),
            _ours(scene, "RODASP, chunks", "rosenbrock", settings, chunk, shuffled),
            _ours(scene, "RODASP, chunks by stiffness", "rosenbrock", settings, chunk, order),
        ],
        reference=_reference(scene, compared, "DOP853", 1e-12),
        reference_note=f"SciPy DOP853 at rtol 1e-12, {compared} designs, meshed in mpmath",
        baseline="Tsit5, at once",
        target=1e-6,
    )


def case(quick: bool, smoke: bool = False) -> Case:
    """The case of this module; with `smoke` as small as still runs all of it."""
    size = _LEAST if smoke else _SMALL if quick else _FULL
    return Case(
        "many_transients",
        "Transients of many designs against compiled rivals, their derivatives, and lock step",
        [
            _settle(size),
            _mission(size, 0.0),
            _mission(size, 1e-3),
            _many_missions(size),
            _gradients(size),
            _gradient_of_one(size),
            _lock_step(size),
        ],
    )
