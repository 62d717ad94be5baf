"""Sensitivities and the optimisation as sections of a report."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...text import (
    display_unit,
    fixed,
    in_unit,
    number,
    related,
    show,
    state_without_efficiency,
    with_label,
)
from .._parts import component_words
from .._style import readable
from ..design_charts import (
    Change,
    Limit,
    Optimisation,
    optimisation_chart,
    relative_change,
    sensitivity_bars,
    signed_change,
)
from ..drawings import cross_section
from ..interactive import elasticity_bars, objective_curve
from ..results import ReportData, largest_pressure
from ._section import Picture, Section, Table


def _elasticity(table) -> np.ndarray:
    values = np.asarray(table.elasticity, dtype=float)
    defined = getattr(table, "elasticity_defined", None)
    if defined is None:
        return values
    return np.where(np.asarray(defined)[:, None], values, np.nan)


def sensitivity_section(data: ReportData) -> Section | None:
    """Derivatives per millimetre or degree, and elasticities in per cent."""
    table = data.sensitivity
    if table is None:
        return None
    elasticity, gradient = _elasticity(table), np.asarray(table.gradient, dtype=float)
    steps = [
        display_unit(unit, np.abs(np.asarray(value, dtype=float)).ravel().tolist())
        for unit, value in zip(table.parameter_units, table.parameter_values, strict=True)
    ]
    head = ("quantity", "value")
    head += tuple(
        f"per {step.label} of {readable(name)}" if step.label else f"per 1 of {readable(name)}"
        for name, step in zip(table.parameters, steps, strict=True)
    )
    kinks = {(q, p): (below, above) for q, p, below, above in getattr(table, "kinks", ())}
    rows, relative = [], []
    for i, (name, unit) in enumerate(zip(table.quantities, table.quantity_units, strict=True)):
        value = float(table.values[i])
        shown = display_unit(unit, value, name)
        label = component_words(name) + (f" in {shown.label}" if shown.label else "")
        state = state_without_efficiency(name, value)
        if state:
            # Without an efficiency, its derivatives are not defined.
            undefined = ("not defined",) * len(steps)
            rows.append((label, state, *undefined))
            relative.append((component_words(name), *undefined))
            continue
        cells, signed = [], []
        for j, (parameter, step) in enumerate(zip(table.parameters, steps, strict=True)):
            if (name, parameter) in kinks:
                slopes = kinks[name, parameter]
                sides = [number(shown(slope) / step.per_si, 3) for slope in slopes]
                shares = [_signed(_share(table, j, value, slope)) for slope in slopes]
                cells.append(f"{sides[0]} below, {sides[1]} above")
                signed.append(f"{shares[0]} below, {shares[1]} above")
            else:
                cells.append(number(shown(gradient[i, j]) / step.per_si, 3))
                signed.append(_signed(elasticity[i, j]))
        rows.append((label, number(shown(value)), *cells))
        relative.append((component_words(name), *signed))
    tables = (
        Table("Change of each quantity, one parameter moved alone", head, tuple(rows)),
        Table(
            "Elasticity: per cent of the quantity for one per cent of the parameter",
            ("quantity", *(readable(p) for p in table.parameters)),
            tuple(relative),
        ),
    )
    dependent: Any = getattr(table, "dependents", ())
    dependents = tuple(
        (readable(name), _listed(follows), _listed(stays))
        for name, (follows, stays) in zip(table.parameters, dependent, strict=False)
        if follows or stays
    )
    if dependents:
        head = ("parameter", "what follows", "what stays")
        tables += (Table("What moves with each parameter", head, dependents),)
    picture = Picture(
        "sensitivities",
        "Elasticities by quantity.",
        lambda: sensitivity_bars(table.quantities, table.parameters, elasticity),
        lambda: elasticity_bars(table.quantities, table.parameters, elasticity),
    )
    words = ("Exact derivatives at the operating point, by automatic differentiation.",)
    if kinks:
        words += (
            "Kinks: where a cell has two numbers, the derivatives below and above the present "
            "value of the parameter differ, because a maximum or a limit changes there from one "
            "term to another.",
        )
    if not bool(getattr(table, "valid", True)):
        words += ("Do not use these numbers: the analysis behind them is not valid.",)
    return Section("sensitivity", "Sensitivities", words, tables, (picture,))


def _share(table, column: int, value: float, slope: float) -> float:
    """Elasticity of a slope; not defined (NaN) where stages differ in the parameter."""
    present = np.unique(np.asarray(table.parameter_values[column], dtype=float))
    return slope * float(present[0]) / value if value and present.size == 1 else np.nan


def _signed(value: float) -> str:
    return fixed(value, 4, "+") if np.isfinite(value) else "not defined"


def optimisation_section(data: ReportData) -> Section | None:
    """Designs before and after, use of the limits, and convergence of the search."""
    result = data.optimisation
    if result is None:
        return None
    words = [result.in_a_sentence()]
    if not result.converged and (result.feasible or result.active):
        active = ", ".join(result.active) or "none: the optimum lies inside the permitted range"
        words.append(f"Active: {active}.")
    if result.kkt_residual is not None:
        words.append(
            f"First-order optimality (KKT residual): {number(result.kkt_residual, 2)}; 0 is an "
            f"exact optimum. The search {'converged' if result.converged else 'did not converge'}"
            f"{_reason(result.message)}."
        )
    pictures = [
        Picture(
            "optimisation",
            "Objective by iteration, and the use of each limit at "
            f"{'the optimum' if result.feasible else 'the best design found'}.",
            lambda: optimisation_chart(
                result.history,
                result.limits,
                objective=result.objective,
                unit=result.objective_unit,
                violations=result.violations,
                feasible=result.feasible,
            ),
            lambda: objective_curve(result.history, result.objective, result.objective_unit),
        )
    ]
    if data.improved is not None:
        improved = data.improved.mechanism
        ends = tuple(name.capitalize() for name in data.ends)
        both = {ends[0]: data.mechanism, ends[1]: improved}
        for i in range(len(data.mechanism.stages)):
            suffix, of_stage = data.of_stage(i)
            pictures.append(
                Picture(
                    f"before_after{suffix}",
                    f"{ends[0]} and {ends[1].lower()}, to the same scale{of_stage}.",
                    lambda i=i: cross_section(both, stage=i + 1),
                )
            )
    return Section(
        "optimisation", "Optimisation", tuple(words), _tables(result, data), tuple(pictures)
    )


def _reason(message: str) -> str:
    """Why a search ended; empty if the message repeats the residual already stated."""
    return "" if not message or message.startswith("KKT residual") else f": {message}"


def _worth(result: Optimisation, limit: Limit) -> str:
    """Change of the best objective if the limit is raised by one per cent."""
    if not limit.active or limit.multiplier == 0:
        return ""
    gain = 0.01 * abs(limit.limit) * limit.multiplier
    return signed_change(result.objective, result.objective_unit, gain)


def _further(data: ReportData) -> list[Change]:
    """Quantities of contact and steady state, in addition to those of the optimiser."""
    after = data.improved
    if after is None:
        return []
    changes = []
    if data.contacts is not None and after.contacts is not None:
        changes.append(
            Change("max_pressure", "Pa", largest_pressure(data), largest_pressure(after))
        )
    if data.steady is not None and after.steady is not None:
        states = (data.steady, after.steady)
        for name, unit in (("efficiency", "1"), ("drive_torque", "N·m"), ("output_power", "W")):
            before, after_it = (float(getattr(state, name)) for state in states)
            changes.append(Change(name, unit, before, after_it))
        before, after_it = (float(sum(state.losses.values(), 0.0)) for state in states)
        changes.append(Change("loss_power", "W", before, after_it))
    return changes


def _listed(names: Sequence[str]) -> str:
    return ", ".join(map(readable, names)) or "nothing"


def _tables(result: Optimisation, data: ReportData) -> tuple[Table, ...]:
    variables = []
    for v in result.variables:
        shown = display_unit(v.unit, [v.before, v.after, v.lower or 0.0, v.upper or 0.0])
        bounds = ""
        if v.lower is not None and v.upper is not None:
            bounds = f"{in_unit(v.lower, shown)} to {in_unit(v.upper, shown)}"
        note = f"at the {v.at_bound} bound" if v.at_bound else ""
        before, after = in_unit(v.before, shown, 5), in_unit(v.after, shown, 5)
        dependents = (_listed(v.follows), _listed(v.stays))
        variables.append((readable(v.name), before, after, bounds, note, *dependents))
    known = {q.name for q in result.quantities}
    compared = [*result.quantities, *(q for q in _further(data) if q.name not in known)]
    quantities = [
        (
            readable(q.name),
            show(q.before, q.unit, q.name),
            show(q.after, q.unit, q.name),
            relative_change(q),
        )
        for q in compared
    ]
    signs = {"upper": "at most", "lower": "at least", "equal": "equal to"}
    limits = []
    for c in result.limits:
        shown = display_unit(c.unit, [c.value, c.limit], c.quantity)
        use = with_label(fixed(100 * c.use, 1), "%", " ") if np.isfinite(c.use) else ""
        limits.append(
            (
                readable(c.quantity),
                state_without_efficiency(c.quantity, c.value) or in_unit(c.value, shown),
                related(signs[c.sense], in_unit(c.limit, shown)),
                use,
                "active" if c.active else "not active",
                _worth(result, c),
            )
        )
    tables = [
        Table(
            "Design variables",
            ("variable", *data.ends, "range", "", "what follows", "what stays"),
            tuple(variables),
        ),
        Table("Quantities", ("quantity", *data.ends, "change"), tuple(quantities)),
    ]
    if limits:
        where = "at the optimum" if result.feasible else "best found"
        head = ("quantity", where, "limit", "use of the limit", "", "objective for +1 %")
        if not any(row[-1] for row in limits):
            # No limit is active, so none affects the objective.
            head, limits = head[:-1], [row[:-1] for row in limits]
        tables.append(Table("Constraints", head, tuple(limits)))
    return tuple(tables)
