"""Sensitivities of any quantities to any numbers of a mechanism."""

from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Float

from .._errors import MissingDataError
from ..fields import Scalar, as_optional_scalar, listed_names
from ..mechanism import Mechanism, Parameter, find_parameters, of_one_design, what_follows
from ..programs import one_program_where_possible, prepare_program, runs_one_verb
from ..quantities import (
    QuantityLike,
    available_quantities,
    by_friction,
    component_names,
    find_quantity,
    quantity_names,
)
from ._derivatives import Mode, jacobian
from ._kinks import one_sided
from ._second import hessian
from ._table import Sensitivity

#: Main results for an engineer; those without data in the mechanism are omitted.
DEFAULT_QUANTITIES = (
    "efficiency",
    "drive_torque",
    "max_pressure",
    "axial_stiffness",
    "lowest_torsional_frequency",
    "lowest_mesh_torsional_frequency",
    "lowest_transverse_frequency",
    "lowest_mesh_transverse_frequency",
)
DEFAULT_PARAMETERS = ("lead", "contact_angle", "roller_radius")
#: A longer list of quantities is compiled as two programs by a process that runs one verb.
_ONE_PROGRAM = 4
_MODES = ("auto", "forward", "reverse")
#: The arrays of a `Sensitivity` by their names, and the values of the quantities by theirs.
Numbers: TypeAlias = dict[str, Any]


@of_one_design
def sensitivity(
    mechanism: Mechanism,
    quantities: Iterable[QuantityLike] | None = None,
    parameters: Iterable[str] | None = None,
    *,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
    mode: Mode = "auto",
    kinks: bool = True,
    second: bool = False,
) -> Sensitivity:
    r"""Exact derivatives of quantities with respect to parameters, by automatic differentiation.

    Each parameter changes alone, together with the dimensions that follow from it (see `Thread`).
    A name that applies to several stages changes all of them by equal amounts: its derivative is
    the sum over the stages $\sum_k g_k$. Its elasticity is $\sum_k g_k p_k / q$, the response to
    an increase by one per cent in every stage. Compiled once per structure of the mechanism; can
    itself be used under `jax.jit`, `jax.vmap` and `jax.grad`.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `quantities`: names from the catalogue, or functions of a mechanism that return one number;
      an array gives one row per component. Default: those of `DEFAULT_QUANTITIES` that the
      mechanism has the data for.
    - `parameters`: names of numbers of the mechanism. Default: lead, contact angle, roller radius.
    - `speed`, `load`: operating point [rad/s, N]; default that of the mechanism.
    - `mode`: `"forward"`, `"reverse"`, or `"auto"`: forward where there are no more parameters
      than quantities.
    - `kinks`: whether to look for kinks, such as a tie of the operating load with one of the duty
      cycle: there the derivatives below and above differ, and the table has both. Costs two more
      evaluations for each parameter; inside a trace there is no search for kinks.
    - `second`: whether to compute second derivatives, too: `hessian` of the table. A program of its
      own, which takes several times as long to compile. At a kink there is no second derivative.

    **Returns:** a `Sensitivity`.

    **Raises:** `UnknownNameError` for an unknown name; `ValueError` for a static parameter, an
    empty list or an unknown mode; `MissingDataError` where the mechanism lacks data.
    """
    if mode not in _MODES:
        raise ValueError(f"mode is {mode!r}; choose one of {', '.join(_MODES)}")
    names = _quantity_names(mechanism, quantities, speed, load)
    parameters = _parameter_names(parameters)
    # A Python number would be a constant of the program: another speed would compile again.
    speed, load = as_optional_scalar(speed), as_optional_scalar(load)

    table = _table(mechanism, names, parameters, speed, load, mode, kinks)
    if not second:
        return table
    return eqx.tree_at(
        lambda t: t.hessian,
        table,
        _compiled_hessian(mechanism, names, parameters, speed, load),
        is_leaf=lambda leaf: leaf is None,
    )


def _table(
    mechanism: Mechanism,
    names: tuple[str, ...],
    parameters: tuple[str, ...],
    speed: Scalar | None,
    load: Scalar | None,
    mode: Mode,
    kinks: bool,
) -> Sensitivity:
    groups = _single_numbers(mechanism, parameters)
    shift = jnp.zeros(sum(map(len, groups)), jnp.result_type(float))
    parts = _parts(names)
    if len(parts) > 1:
        if mode == "auto" and len(shift) <= len(names):
            # As for all quantities together.
            mode = "forward"
        for part in parts:
            prepare_program(
                _compiled_numbers, mechanism, part, parameters, speed, load, mode, shift
            )

    def moved_by(shift: Float[Array, " numbers"]) -> Numbers:
        return _joined(
            names,
            [
                _compiled_numbers(mechanism, part, parameters, speed, load, mode, shift)
                for part in parts
            ],
        )

    numbers = moved_by(shift)
    table = _with_names(mechanism, names, parameters, groups, numbers)
    if not kinks or any(isinstance(leaf, Tracer) for leaf in jax.tree.leaves((mechanism, table))):
        return table

    def at(shifts: np.ndarray) -> np.ndarray:
        return np.asarray(moved_by(jnp.asarray(shifts, shift.dtype))["gradient"])

    left, right = one_sided(at, [np.asarray(values) for values in table.parameter_values])
    return eqx.tree_at(
        lambda t: (t.left, t.right),
        table,
        (jnp.asarray(left), jnp.asarray(right)),
        is_leaf=lambda leaf: leaf is None,
    )


def _quantity_names(mechanism: Mechanism, quantities, speed, load) -> tuple[str, ...]:
    if quantities is None:
        names = available_quantities(mechanism, DEFAULT_QUANTITIES, speed=speed, load=load)
        if not names:
            raise MissingDataError(
                f"the mechanism has data for none of the default quantities "
                f"({', '.join(DEFAULT_QUANTITIES)}); name the quantities"
            )
        return names
    names = quantity_names(listed_names(quantities, "quantities"))
    if not names:
        raise ValueError("quantities is empty; name at least one")
    for name in names:
        find_quantity(name)
    return names


def _parameter_names(parameters: Iterable[str] | None) -> tuple[str, ...]:
    names = tuple(DEFAULT_PARAMETERS if parameters is None else parameters)
    if not names:
        raise ValueError("parameters is empty; name at least one")
    return names


def _single_numbers(mechanism: Mechanism, names: Sequence[str]) -> list[tuple[Parameter, ...]]:
    """The numbers behind each name, one per stage that has it."""
    groups = []
    for name in names:
        parameters = find_parameters(mechanism, name)
        for parameter in parameters:
            if parameter.static:
                raise ValueError(
                    f"parameter {name!r} is a whole number and has no derivative; sweep over it "
                    "instead"
                )
        groups.append(parameters)
    return groups


def _parts(names: tuple[str, ...]) -> tuple[tuple[str, ...], ...]:
    """Quantities by program: while the compiler is at work on one, the next is traced."""
    if len(names) <= _ONE_PROGRAM or not runs_one_verb():
        return (names,)
    friction, rest = by_friction(names)
    if friction and rest:
        return rest, friction
    half = (len(names) + 1) // 2
    return names[:half], names[half:]


def _joined(names: tuple[str, ...], parts: Sequence[Numbers]) -> Numbers:
    """Numbers of all quantities in the order of their names."""
    if len(parts) == 1:
        return parts[0]
    by_name: Numbers = {}
    for part in parts:
        by_name |= part["by_name"]
    rows: dict[str, np.ndarray] = {}
    first = 0
    for name in (name for part in _parts(names) for name in part):
        rows[name] = first + np.arange(by_name[name].size)
        first += by_name[name].size
    order = np.concatenate([rows[name] for name in names])
    joined = {
        # By NumPy: each operation of JAX outside of a program is compiled, too.
        key: jnp.asarray(np.concatenate([part[key] for part in parts])[order])
        for key in ("values", "gradient", "elasticity", "elasticity_defined")
    }
    valid = jnp.asarray(np.all([part["valid"] for part in parts]))
    return parts[0] | joined | {"by_name": by_name, "valid": valid}


def _numbers(
    mechanism: Mechanism,
    quantities: tuple[str, ...],
    parameters: tuple[str, ...],
    speed: Scalar | None,
    load: Scalar | None,
    mode: Mode,
    shift: Float[Array, " numbers"],
) -> Numbers:
    groups = _single_numbers(mechanism, parameters)
    numbers = [number for group in groups for number in group]
    by_name, derivatives, valid = jacobian(mechanism, quantities, numbers, speed, load, mode, shift)
    values = jnp.concatenate([jnp.ravel(by_name[name]) for name in quantities])
    points = jnp.stack([number.get(mechanism) for number in numbers])
    known = jnp.isfinite(values) & (values != 0)
    relative = derivatives * points[None, :] / jnp.where(known, values, 1.0)[:, None]
    relative = jnp.where(known[:, None], relative, 0.0)
    gradient, elasticity, current = [], [], []
    first = 0
    for group in groups:
        columns = slice(first, first + len(group))
        gradient.append(jnp.sum(derivatives[:, columns], axis=1))
        elasticity.append(jnp.sum(relative[:, columns], axis=1))
        current.append(points[columns])
        first += len(group)
    return {
        "by_name": by_name,
        "values": values,
        "gradient": jnp.stack(gradient, axis=1),
        "elasticity": jnp.stack(elasticity, axis=1),
        "elasticity_defined": known,
        "parameter_values": current,
        "valid": valid,
    }


_compiled_numbers = one_program_where_possible(_numbers)


@one_program_where_possible
def _compiled_hessian(
    mechanism: Mechanism,
    quantities: tuple[str, ...],
    parameters: tuple[str, ...],
    speed: Scalar | None,
    load: Scalar | None,
) -> Float[Array, "quantities parameters parameters"]:
    return hessian(mechanism, quantities, _single_numbers(mechanism, parameters), speed, load)


def _with_names(
    mechanism: Mechanism,
    quantities: tuple[str, ...],
    parameters: tuple[str, ...],
    groups: Sequence[tuple[Parameter, ...]],
    numbers: Numbers,
) -> Sensitivity:
    components = [component_names(name, numbers["by_name"][name].shape) for name in quantities]
    labels = tuple(label for labels in components for label in labels)
    units = tuple(
        find_quantity(name).unit
        for name, labels in zip(quantities, components, strict=True)
        for _ in labels
    )
    return Sensitivity(
        values=numbers["values"],
        gradient=numbers["gradient"],
        elasticity=numbers["elasticity"],
        elasticity_defined=numbers["elasticity_defined"],
        parameter_values=tuple(numbers["parameter_values"]),
        valid=numbers["valid"],
        quantities=labels,
        parameters=parameters,
        quantity_units=units,
        parameter_units=tuple(group[0].unit for group in groups),
        dependents=tuple(what_follows(mechanism, name) for name in parameters),
    )
