"""Global sensitivities over whole ranges: Sobol indices, Morris' effects, active subspaces."""

import dataclasses
import math
from collections.abc import Iterable, Mapping
from typing import Any

import jax.numpy as jnp
import numpy as np

from .._errors import missing_extra
from ..fields import Scalar, as_optional_scalar
from ..mechanism import Mechanism, Tolerance, find_parameters, of_one_known_design
from ..quantities import named_quantities, quantity_of
from ..results import Shown
from ..text import TextTable
from ._inputs import Inputs, inputs_of
from ._programs import gradients_of_designs
from ._sampling import CHUNK, by_component, evaluate_points, points


@dataclasses.dataclass(frozen=True, repr=False)
class GlobalSensitivity(Shown):
    """Measures of the influence of parameters (columns) on quantities (rows).

    - `quantities`, `units`: single numbers and their SI units.
    - `parameters`: names of the numbers that were varied.
    - `measures`: arrays of quantities × parameters by name, with half widths of their 95 %
      intervals under `…_interval`. Sobol: `first_order`, `total_order` (shares of the variance).
      Morris: `mean`, `mean_absolute`, `standard_deviation` of the change of the quantity over the
      whole range of a parameter [SI]. Active subspace: `activity`.
    - `eigenvalues`, `directions`: of an active subspace, quantities × eigenvalues (largest first)
      and quantities × parameters × eigenvalues, in standard deviations of the parameters.
    """

    quantities: tuple[str, ...]
    units: tuple[str, ...]
    parameters: tuple[str, ...]
    measures: dict[str, np.ndarray]
    eigenvalues: np.ndarray | None = None
    directions: np.ndarray | None = None

    def of(self, measure: str, quantity: str) -> dict[str, float]:
        """One measure of a quantity by parameter.

        **Raises:** `KeyError` for an unknown measure or quantity.
        """
        if quantity not in self.quantities:
            raise KeyError(f"{quantity}; there are {', '.join(self.quantities)}")
        row = self.measures[measure][self.quantities.index(quantity)]
        return dict(zip(self.parameters, row.tolist(), strict=True))

    def to_dict(self) -> dict[str, Any]:
        """Plain lists [SI] for JSON; `None` where a number is not finite."""
        result: dict[str, Any] = {
            "quantities": list(self.quantities),
            "units": list(self.units),
            "parameters": list(self.parameters),
        }
        arrays = dict(self.measures)
        if self.eigenvalues is not None and self.directions is not None:
            arrays |= {"eigenvalues": self.eigenvalues, "directions": self.directions}
        return result | {name: _plain(array) for name, array in arrays.items()}

    def __str__(self) -> str:
        return self.text()

    def text(self, width: int | None = None) -> str:
        """The measures as a table, a row for each quantity and parameter."""
        rows = [
            (
                f"{name} [{unit}]" if unit != "1" else name,
                parameter,
                *(float(values[i, j]) for values in self.measures.values()),
            )
            for i, (name, unit) in enumerate(zip(self.quantities, self.units, strict=True))
            for j, parameter in enumerate(self.parameters)
        ]
        columns = ("quantity", "parameter", *(name.replace("_", " ") for name in self.measures))
        return TextTable("", columns, rows).text(width)


def _plain(array):
    if np.ndim(array):
        return [_plain(row) for row in array]
    return float(array) if math.isfinite(array) else None


def _inputs(mechanism: Mechanism, ranges: Mapping[str, Any] | None) -> Inputs:
    """Uniform distributions over ranges [SI], or the mechanism's own tolerances."""
    if ranges is None:
        return inputs_of(mechanism, None)
    rows = []
    for name, pair in ranges.items():
        try:
            lower, upper = map(float, pair)
        except (TypeError, ValueError):
            message = f"range of {name!r} is {pair!r}; give (lower, upper)"
            raise ValueError(message) from None
        nominal = _common_value(mechanism, name)
        rows.append(Tolerance(name, lower - nominal, upper - nominal, "uniform"))
    return inputs_of(mechanism, rows)


def _common_value(mechanism: Mechanism, name: str) -> float:
    """Present value of a number that all stages share: one range holds in each of them."""
    parameters = find_parameters(mechanism, name)
    present = [float(np.asarray(one.get(mechanism))) for one in parameters]
    if not np.allclose(present, present[0], rtol=1e-12, atol=0.0, equal_nan=True):
        raise ValueError(
            f"range of {name!r}: its present value differs between the stages "
            f"({', '.join(f'{value:g}' for value in present)}); name the stage: "
            f"{' or '.join(one.path for one in parameters)}"
        )
    return present[0]


def _evaluated(inputs: Inputs, deviations, selected, speed, load) -> dict[str, np.ndarray]:
    at = as_optional_scalar(speed), as_optional_scalar(load)
    values, codes, _ = evaluate_points(inputs, deviations, selected, *at, None)
    _refuse_failed(codes)
    return values


def _refuse_failed(codes: np.ndarray) -> None:
    if codes.any():
        raise ValueError(
            f"{int((codes != 0).sum())} of {codes.size} designs fail, and the method needs all of "
            "them; narrow the ranges"
        )


def _salib(inputs: Inputs):
    try:
        import SALib.analyze.morris
        import SALib.analyze.sobol
        import SALib.sample.morris
        import SALib.sample.sobol
    except ImportError as error:
        raise missing_extra("uncertainty", "a global sensitivity", error) from error
    count = len(inputs.tolerances)
    return SALib, {"num_vars": count, "names": list(inputs.names), "bounds": [[0.0, 1.0]] * count}


def _result(inputs: Inputs, rows: dict[str, dict[str, np.ndarray]], **more) -> GlobalSensitivity:
    measures = next(iter(rows.values()))
    return GlobalSensitivity(
        tuple(rows),
        tuple(quantity_of(label).unit for label in rows),
        inputs.names,
        {name: np.stack([row[name] for row in rows.values()]) for name in measures},
        **more,
    )


@of_one_known_design
def sobol_indices(
    mechanism: Mechanism,
    quantities: Iterable[str],
    ranges: Mapping[str, Any] | None = None,
    *,
    samples: int = 1024,
    seed: int = 0,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
) -> GlobalSensitivity:
    """First-order and total Sobol indices (SALib): shares of the variance over whole ranges.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `quantities`: names from the catalogue.
    - `ranges`: (lower, upper) [SI] by the name of a parameter, uniform; default the tolerances of
      the mechanism with their distributions.
    - `samples`: base samples, rounded up to a power of 2; there are (parameters + 2) times as many
      designs.
    - `seed`: of the samples.
    - `speed`, `load`: operating point [rad/s, N]; default that of the mechanism.

    **Returns:** a `GlobalSensitivity`.

    **Raises:** as `tolerance`; `ValueError` if a design fails, or for a range of a number that
    differs between the stages; `MissingExtraError` without SALib.
    """
    inputs, selected = _inputs(mechanism, ranges), named_quantities(quantities)
    salib, problem = _salib(inputs)
    base = 2 ** max(math.ceil(math.log2(samples)), 1)
    cube = salib.sample.sobol.sample(problem, base, calc_second_order=False, seed=seed)
    values = _evaluated(inputs, inputs.standardised(cube), selected, speed, load)
    rows = {}
    for label, array in values.items():
        spread = np.std(array)
        scaled = (array - np.mean(array)) / (spread if spread > 0 else 1.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            indices = salib.analyze.sobol.analyze(
                problem, scaled, calc_second_order=False, seed=seed
            )
        rows[label] = {
            "first_order": np.asarray(indices["S1"]),
            "total_order": np.asarray(indices["ST"]),
            "first_order_interval": np.asarray(indices["S1_conf"]),
            "total_order_interval": np.asarray(indices["ST_conf"]),
        }
    return _result(inputs, rows)


@of_one_known_design
def morris(
    mechanism: Mechanism,
    quantities: Iterable[str],
    ranges: Mapping[str, Any] | None = None,
    *,
    trajectories: int = 32,
    levels: int = 4,
    seed: int = 0,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
) -> GlobalSensitivity:
    """Elementary effects of Morris (SALib): a screening with few designs.

    An effect is the change of the quantity over a step of levels/(2 (levels − 1)) of the range of a
    parameter, over this share; for a linear quantity it is the change over the whole range (Morris
    1991). The distribution of the parameter has no influence.

    **Arguments:**

    - `mechanism`, `quantities`, `ranges`, `seed`, `speed`, `load`: as for `sobol_indices`.
    - `trajectories`: number of trajectories, each of (parameters + 1) designs.
    - `levels`: grid levels of a range, an even number.

    **Returns:** a `GlobalSensitivity`.

    **Raises:** as `sobol_indices`; `ValueError` for an odd number of levels.
    """
    if levels < 2 or levels % 2:
        raise ValueError(f"levels is {levels}; it must be an even number of at least 2")
    inputs, selected = _inputs(mechanism, ranges), named_quantities(quantities)
    salib, problem = _salib(inputs)
    cube = salib.sample.morris.sample(problem, trajectories, num_levels=levels, seed=seed)
    reach = [one.half_width / one.standard_deviation for one in inputs.tolerances]
    values = _evaluated(inputs, (2 * cube - 1) * np.array(reach), selected, speed, load)
    rows = {}
    for label, array in values.items():
        effects = salib.analyze.morris.analyze(problem, cube, array, num_levels=levels, seed=seed)
        rows[label] = {
            "mean": np.asarray(effects["mu"]),
            "mean_absolute": np.asarray(effects["mu_star"]),
            "standard_deviation": np.asarray(effects["sigma"]),
            "mean_absolute_interval": np.asarray(effects["mu_star_conf"]),
        }
    return _result(inputs, rows)


@of_one_known_design
def active_subspace(
    mechanism: Mechanism,
    quantities: Iterable[str],
    ranges: Mapping[str, Any] | None = None,
    *,
    samples: int = 256,
    seed: int = 0,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
) -> GlobalSensitivity:
    r"""Directions in the space of the parameters along which a quantity changes most.

    Eigenvectors of $C = E[\nabla q\,\nabla q^T]$ from exact gradients by the standardised
    parameters. The activity of parameter $i$ is $C_{ii}$, the mean square of its derivative.

    **Arguments:** as for `sobol_indices`; `samples` is the number of gradients, rounded up.

    **Returns:** a `GlobalSensitivity` with `eigenvalues` and `directions`.

    **Raises:** as `tolerance`; `ValueError` as `sobol_indices`.
    """
    inputs, selected = _inputs(mechanism, ranges), named_quantities(quantities)
    deviations = points(inputs, samples, seed).reshape(-1, len(inputs.tolerances))
    values, at = inputs.values(deviations), (as_optional_scalar(speed), as_optional_scalar(load))
    size = min(CHUNK, len(values))  # both are powers of 2
    parts: dict[str, list[np.ndarray]] = {one.name: [] for one in selected}
    for start in range(0, len(values), size):
        gradients, codes = gradients_of_designs(
            inputs.mechanism,
            inputs.paths,
            jnp.asarray(values[start : start + size]),
            jnp.asarray(inputs.directions),
            selected,
            *at,
        )
        _refuse_failed(np.asarray(codes))
        for name, arrays in parts.items():
            arrays.append(np.asarray(gradients[name]))
    gradients = by_component({name: np.concatenate(arrays) for name, arrays in parts.items()}, 2)
    rows, eigenvalues, directions = {}, [], []
    for label, slopes in gradients.items():
        matrix = slopes.T @ slopes / len(slopes)
        sizes, vectors = np.linalg.eigh(matrix)
        eigenvalues.append(sizes[::-1])
        directions.append(vectors[:, ::-1])
        rows[label] = {"activity": np.diag(matrix)}
    return _result(inputs, rows, eigenvalues=np.stack(eigenvalues), directions=np.stack(directions))
