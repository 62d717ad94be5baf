"""True surfaces: half-space contact on a grid, against tamaas and against exact Hertz theory."""

import importlib
import importlib.util
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax.halfspace import grid_over, solve_contact

from ..harness import Case, Method, Prepared, Problem, Reference
from ..references.hertz import DIGITS, hertz

_MODULUS = 1.15e11
#: Half the grid over the semi-axes of the ellipse.
_EXTENT = 1.3
_LABELS = ("largest pressure p₀", "approach δ")


def _contacts(count: int) -> np.ndarray:
    """Rows of load [N], A and B [1/m] like those of roller screws."""
    random = np.random.default_rng(20_141_201)
    smaller = random.uniform(50.0, 100.0, count)
    return np.stack(
        [
            random.uniform(20.0, 200.0, count),
            smaller,
            smaller * random.uniform(1.15, 1.6, count),
        ],
        axis=1,
    )


def _semi_axes(contacts: np.ndarray) -> np.ndarray:
    """Semi-axes along x and y, near enough to size a grid: κ = (A/B)^{2/3} [m]."""
    from scipy.special import ellipe

    load, smaller, larger = contacts.T
    ratio = (smaller / larger) ** (2 / 3)
    second = ellipe(1 - ratio**2)
    major = np.cbrt(3 * load * second / (2 * np.pi * _MODULUS * ratio**2 * (smaller + larger)))
    return np.stack([major, ratio * major], axis=1)


def _named(pressure, approach) -> dict[str, Any]:
    return dict(zip(_LABELS, (np.atleast_1d(pressure), np.atleast_1d(approach)), strict=True))


def _ours(
    contacts: np.ndarray,
    name: str,
    tolerance: float,
    cells,
    together=False,
    dtype: Any = jnp.float64,
) -> Method:
    axes = jnp.asarray(_semi_axes(contacts), dtype)
    rows = jnp.asarray(contacts, dtype)

    def prepare(count):
        def solve(row, half):
            grid = grid_over((count, count), _EXTENT * half[0], _EXTENT * half[1])
            x, y = grid.points
            gap = row[1] * x**2 + row[2] * y**2
            found = solve_contact(
                grid, gap, jnp.asarray(_MODULUS, dtype), load=row[0], tolerance=tolerance
            )
            return found.max_pressure, found.approach, found.iterations

        def each(rows, axes):
            if together:
                return jax.vmap(solve)(rows, axes)
            return jax.lax.map(lambda one: solve(*one), (rows, axes))

        solver = jax.jit(each)
        return Prepared(
            lambda: solver(rows, axes),
            len(contacts),
            lambda out: _named(*out[:2]),
            lambda out: f"{int(np.max(out[2]))} steps of all grids",
        )

    return Method(name, prepare, cells, "cells along a side")


def _vertex(pressure: np.ndarray) -> float:
    """Largest pressure between the centres, as the package takes it: the rival gets it as well."""
    from prsm_jax.halfspace import peak_pressure

    return float(peak_pressure(jnp.asarray(pressure)))


def _tamaas(contacts: np.ndarray, tolerance: float, cells) -> Method:
    """Polonsky and Keer's algorithm in compiled code, not periodic as ours."""
    axes = _semi_axes(contacts)

    def prepare(count):
        tamaas: Any = importlib.import_module("tamaas")
        tamaas.set_log_level(tamaas.LogLevel.error)
        solvers = []
        for (load, smaller, larger), half in zip(contacts, axes, strict=True):
            lengths = [2 * _EXTENT * float(h) for h in half]
            model = tamaas.ModelFactory.createModel(
                tamaas.model_type.basic_2d, lengths, [count, count]
            )
            model.E, model.nu = _MODULUS, 0.0
            tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")
            x, y = ((np.arange(count) - (count - 1) / 2) * length / count for length in lengths)
            surface = -(smaller * x[:, None] ** 2 + larger * y[None, :] ** 2)
            kind = tamaas.PolonskyKeerRey.pressure
            solver = tamaas.PolonskyKeerRey(model, surface, tolerance, kind, kind)
            solver.setIntegralOperator("dcfft")
            solver.max_iter = 5000
            solvers.append((solver, model, surface, load / (lengths[0] * lengths[1])))

        def call():
            for solver, model, _, mean in solvers:
                model.traction[...] = 0
                solver.solve(mean)
            return solvers

        def read(_):
            found = []
            for _, model, surface, _ in solvers:
                pressure = np.array(model.traction)
                displacement = np.zeros_like(pressure)
                model.operators["dcfft"](pressure, displacement)
                contact = pressure > 0
                found.append((_vertex(pressure), (displacement - surface)[contact].mean()))
            return _named(*np.array(found).T)

        return Prepared(call, len(contacts), read)

    return Method(
        f"tamaas, tolerance {tolerance:.0e}".replace("e-0", "e-"),
        prepare,
        cells,
        "cells along a side",
        "rival",
    )


def _problem(name: str, title: str, count: int, rivals: int, cells, target: float) -> Problem:
    contacts = _contacts(count)
    methods = [
        _ours(contacts, "prsm_jax, tolerance 1e-4", 1e-4, cells),
        _ours(contacts, "prsm_jax, tolerance 1e-8", 1e-8, cells),
    ]
    methods.append(
        _ours(contacts, "prsm_jax, tolerance 1e-4, float32", 1e-4, cells, dtype=jnp.float32)
    )
    if count > 1:
        methods.append(_ours(contacts, "prsm_jax, tolerance 1e-4, in lock step", 1e-4, cells, True))
    baseline, left_out = methods[1].name, {"tamaas": "the package tamaas is not installed"}
    if importlib.util.find_spec("tamaas") is not None:
        methods += [_tamaas(contacts[:rivals], tolerance, cells) for tolerance in (1e-4, 1e-6)]
        baseline, left_out = methods[-1].name, {}

    def reference():
        rows = np.array([hertz(f, a, b, _MODULUS) for f, a, b in contacts[:rivals]])
        return {label: Reference(rows[:, i]) for i, label in enumerate(_LABELS)}

    return Problem(
        name=name,
        title=title,
        instance="contact",
        methods=methods,
        reference=reference,
        reference_note=f"exact Hertz theory, mpmath at {DIGITS} digits; "
        f"{min(rivals, count)} contact(s)",
        baseline=baseline,
        target=target,
        left_out=left_out,
    )


def case(quick: bool) -> Case:
    """The case of this module."""
    one = (32, 64) if quick else (16, 32, 64, 128, 256)
    many = (32,) if quick else (16, 32, 64)
    return Case(
        "rough_contact",
        "Contact of true surfaces on a grid: error against exact Hertz, against tamaas",
        [
            _problem("single", "One elliptical contact on a grid", 1, 1, one, 1e-4),
            _problem(
                "batch",
                "64 elliptical contacts on grids, in one call",
                8 if quick else 64,
                2 if quick else 8,
                many,
                1e-4,
            ),
        ],
    )
