"""Sensitivities and the optimisation as sections of a report."""

import numpy as np

from .._display_units import display_unit, in_unit, number, show
from ._cross_section import cross_section
from ._data import ReportData
from ._optimisation import Change, Limit, Optimisation, relative_change, signed_change
from ._optimisation_chart import optimisation_chart
from ._section import Picture, Section, Table
from ._sensitivity_bars import sensitivity_bars
from ._style import readable


def _elasticity(table) -> np.ndarray:
    values = np.asarray(table.elasticity, dtype=float)
    defined = getattr(table, "elasticity_defined", None)
    if defined is None:
        return values
    return np.where(np.asarray(defined)[:, None], values, np.nan)


def sensitivity_section(data: ReportData) -> Section | None:
    """What a millimetre or a degree does, and what a per cent does."""
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
    rows, relative = [], []
    for i, (name, unit) in enumerate(zip(table.quantities, table.quantity_units, strict=True)):
        shown = display_unit(unit, float(table.values[i]), name)
        label = readable(name) + (f" in {shown.label}" if shown.label else "")
        cells = [number(shown(g) / s.per_si, 3) for g, s in zip(gradient[i], steps, strict=True)]
        rows.append((label, number(shown(float(table.values[i]))), *cells))
        relative.append((readable(name), *(_signed(e) for e in elasticity[i])))
    tables = (
        Table("Change of each quantity, one parameter moved alone", head, tuple(rows)),
        Table(
            "Elasticity: per cent of the quantity for one per cent of the parameter",
            ("quantity", *(readable(p) for p in table.parameters)),
            tuple(relative),
        ),
    )
    picture = Picture(
        "sensitivities",
        "Elasticities by quantity.",
        lambda: sensitivity_bars(table.quantities, table.parameters, elasticity),
    )
    words = ("Exact derivatives at the operating point, by automatic differentiation.",)
    if not bool(getattr(table, "valid", True)):
        words += ("These numbers are not to be used: the analysis behind them is not valid.",)
    return Section("sensitivity", "Sensitivities", words, tables, (picture,))


def _signed(value: float) -> str:
    if not np.isfinite(value):
        return "not defined"
    return f"{value:+.4f}".replace("-", "\N{MINUS SIGN}")


def optimisation_section(data: ReportData) -> Section | None:
    """Before and after, limits and their use, and how well the optimum is known."""
    found = data.optimisation
    if found is None:
        return None
    active = ", ".join(found.active) or "none: the optimum lies inside the permitted range"
    words = [found.in_a_sentence(), f"Active: {active}."]
    if found.kkt_residual is not None:
        words.append(
            f"First-order optimality (KKT residual): {number(found.kkt_residual, 2)}; 0 is an "
            f"exact optimum. The search {'converged' if found.converged else 'did not converge'}"
            f"{': ' + found.message if found.message else ''}."
        )
    pictures = [
        Picture(
            "optimisation",
            "Objective by iteration, and the use of each limit at the optimum.",
            lambda: optimisation_chart(
                found.history,
                found.limits,
                objective=found.objective,
                unit=found.objective_unit,
                violations=found.violations,
            ),
        )
    ]
    if data.improved is not None:
        improved = data.improved.mechanism
        for i in range(1, len(data.mechanism.stages) + 1):
            many = len(data.mechanism.stages) > 1
            pictures.append(
                Picture(
                    f"before_after_stage_{i}" if many else "before_after",
                    "Before and after, to one scale" + (f", stage {i}." if many else "."),
                    lambda i=i: cross_section(
                        {"Before": data.mechanism, "After": improved}, stage=i
                    ),
                )
            )
    return Section(
        "optimisation", "Optimisation", tuple(words), _tables(found, data), tuple(pictures)
    )


def _worth(found: Optimisation, limit: Limit) -> str:
    """Change of the best objective when the limit is raised by one per cent of itself."""
    if not limit.active or limit.worth == 0:
        return ""
    gain = 0.01 * abs(limit.limit) * limit.worth
    return signed_change(found.objective, found.objective_unit, gain)


def _further(data: ReportData) -> list[Change]:
    """Quantities of the contact and the steady state beside those that the optimiser looked at."""
    after = data.improved
    if after is None:
        return []
    changes = []
    if data.contacts is not None and after.contacts is not None:
        before, after_it = (
            max(float(getattr(c, s).hertz.max_pressure) for c in part for s in ("screw", "nut"))
            for part in (data.contacts, after.contacts)
        )
        changes.append(Change("max_pressure", "Pa", before, after_it))
    if data.steady is not None and after.steady is not None:
        states = (data.steady, after.steady)
        for name, unit in (("efficiency", "1"), ("drive_torque", "N·m"), ("output_power", "W")):
            before, after_it = (float(getattr(state, name)) for state in states)
            changes.append(Change(name, unit, before, after_it))
        before, after_it = (float(sum(state.losses.values(), 0.0)) for state in states)
        changes.append(Change("loss_power", "W", before, after_it))
    return changes


def _tables(found: Optimisation, data: ReportData) -> tuple[Table, ...]:
    variables = []
    for v in found.variables:
        shown = display_unit(v.unit, [v.before, v.after, v.lower or 0.0, v.upper or 0.0])
        bounds = ""
        if v.lower is not None and v.upper is not None:
            bounds = f"{in_unit(v.lower, shown)} to {in_unit(v.upper, shown)}"
        note = f"at the {v.at_bound} bound" if v.at_bound else ""
        before, after = in_unit(v.before, shown, 5), in_unit(v.after, shown, 5)
        variables.append((readable(v.name), before, after, bounds, note))
    known = {q.name for q in found.quantities}
    compared = [*found.quantities, *(q for q in _further(data) if q.name not in known)]
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
    for c in found.limits:
        shown = display_unit(c.unit, [c.value, c.limit], c.quantity)
        use = f"{100 * c.use:.1f} %" if np.isfinite(c.use) else ""
        limits.append(
            (
                readable(c.quantity),
                in_unit(c.value, shown),
                f"{signs[c.sense]} {in_unit(c.limit, shown)}",
                use,
                "active" if c.active else "not active",
                _worth(found, c),
            )
        )
    tables = [
        Table("Design variables", ("variable", "before", "after", "range", ""), tuple(variables)),
        Table("Quantities", ("quantity", "before", "after", "change"), tuple(quantities)),
    ]
    if limits:
        head = ("quantity", "at the optimum", "limit", "use of the limit", "", "objective for +1 %")
        if not any(row[-1] for row in limits):
            # No limit is active, so none is worth anything.
            head, limits = head[:-1], [row[:-1] for row in limits]
        tables.append(Table("Constraints", head, tuple(limits)))
    return tuple(tables)
