"""The compiled programs of a search: quantities and margins of a design, and their derivatives."""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ...fields import Scalar
from ...findings import evaluate_margins, margins_of, shared_loads
from ...mechanism import Mechanism, find_parameters, set_parameters, tolerance_zones
from ...numerics import apart
from ...programs import repeated_program
from ...quantities import Analysis, find_quantity
from ._margin_rows import Respected


def screw_speed(
    mechanism: Mechanism, speed: Scalar | None, load: Scalar | None, nut_speed: Scalar | None
) -> Scalar | None:
    """Screw speed of a design [rad/s]: given, or from the speed of the nut [m/s]."""
    if nut_speed is None:
        return speed
    one = Analysis(mechanism, jnp.ones_like(nut_speed), load)
    return nut_speed / find_quantity("nut_speed").function(one)


class Scatter(eqx.Module):
    """Tolerances of a mechanism, as deviations from the numbers of each design.

    - `paths`: names of the numbers.
    - `offsets`: from the numbers to the middle of their zones [SI].
    - `directions`: change of the numbers for one standard deviation of each tolerance [SI].
    - `sigmas`: number of standard deviations by which a value is worsened.
    """

    paths: tuple[str, ...] = eqx.field(static=True)
    offsets: Float[Array, " numbers"]
    directions: Float[Array, "tolerances numbers"]
    sigmas: Scalar

    def made(
        self, design: Mechanism, deviations: Float[Array, " tolerances"] | None = None
    ) -> Mechanism:
        """A mechanism with deviations from a design; by default in the middle of all zones.

        **Arguments:**

        - `design`: the mechanism with its nominal numbers.
        - `deviations`: standardised, of each tolerance.
        """
        moves = self.offsets
        if deviations is not None:
            moves = moves + deviations @ self.directions
        values = {
            path: find_parameters(design, path)[0].get(design) + moves[index]
            for index, path in enumerate(self.paths)
        }
        return set_parameters(design, values, checked=False)


def scatter_of(mechanism: Mechanism, sigmas: float | None) -> Scatter | None:
    """The tolerances of a mechanism for values worsened by standard deviations; `None` without.

    **Raises:** `ValueError` where the mechanism has no tolerances, or impossible ones.
    """
    if sigmas is None:
        return None
    if not mechanism.tolerances:
        raise ValueError(
            f"tolerance_sigmas is {sigmas:g}, and the mechanism has no tolerances; give a "
            "[tolerances] table in its file, or leave it out"
        )
    zones = tolerance_zones(mechanism)
    numbers = zones.offsets, zones.directions, np.asarray(sigmas, float)
    return Scatter(zones.paths, *map(jnp.asarray, numbers))


def outputs_at(inputs: tuple[Any, ...], position: Float[Array, " variables"]):
    """Quantities and margins of a design as separate arrays, and whether the design is usable.

    With tolerances the arrays are all means, then all means plus `sigmas` standard deviations, then
    all means minus these. Margins are those in the middle of the tolerances.
    """
    mechanism, names, quantities, margins, lower, width, speed, load, nut_speed, scatter = inputs
    values = lower + width * position
    moved = set_parameters(mechanism, {name: values[i] for i, name in enumerate(names)})

    def at_point(speed, load):
        if scatter is None:
            at = screw_speed(moved, speed, load, nut_speed)
            return _analysed(moved, quantities, margins, at, load)
        return _worsened(moved, quantities, margins, speed, load, nut_speed, scatter)

    if load is None or jnp.ndim(load) == 0:
        return at_point(speed, load)
    # Several operating points: every quantity at each point, and the least value of every margin.
    outputs, valid = jax.vmap(at_point)(speed, load)
    split = len(quantities) * (1 if scatter is None else 3)
    return (
        [jnp.ravel(numbers) for numbers in outputs[:split]]
        + [jnp.min(numbers, axis=0) for numbers in outputs[split:]],
        jnp.all(valid),
    )


def _worsened(
    design: Mechanism,
    quantities: tuple[str, ...],
    margins: Respected | None,
    speed: Any,
    load: Any,
    nut_speed: Any,
    scatter: Scatter,
) -> tuple[list[Array], Any]:
    """Means, means plus and minus standard deviations, and margins at one operating point.

    The first-order standard deviation is the root of the sum of squared slopes along the
    tolerances. A derivative of this function differentiates the slopes a second time.
    """

    def at(deviations, margins):
        made = scatter.made(design, deviations)
        at = screw_speed(made, speed, load, nut_speed)
        return _analysed(made, quantities, margins, at, load)

    count = scatter.directions.shape[0]
    middle = jnp.zeros(count, scatter.offsets.dtype)
    outputs, valid = at(middle, margins)
    # One tolerance after the other: side by side they take far longer to compile.
    slopes = jax.lax.map(
        lambda along: jax.jvp(lambda one: at(one, None)[0], (middle,), (along,))[1],
        jnp.eye(count, dtype=middle.dtype),
    )
    means, rest = outputs[: len(quantities)], outputs[len(quantities) :]
    spreads = [scatter.sigmas * _norm(one) for one in slopes]
    pairs = list(zip(means, spreads, strict=True))
    return [*means, *(m + s for m, s in pairs), *(m - s for m, s in pairs), *rest], valid


def _norm(slopes: Float[Array, "tolerances components"]) -> Float[Array, " components"]:
    """Root of the sum of squares over the tolerances; 0 with derivative 0 where all are 0."""
    total = jnp.sum(slopes**2, axis=0)
    some = total > 0
    return jnp.where(some, jnp.sqrt(jnp.where(some, total, 1.0)), 0.0)


def _analysed(
    moved: Mechanism, quantities: tuple[str, ...], margins: Respected | None, speed: Any, load: Any
) -> tuple[list[Array], Any]:
    """Quantities and margins at one operating point, and whether they can be used."""
    analysis = Analysis(moved, speed, load)
    # A design whose threads do not mesh is unusable, whatever the requested quantities.
    for stage in analysis.kinematics:
        analysis.require(stage.meshing.converged)
    analysis.expect(case for name in quantities for case in find_quantity(name).shares)
    if margins is not None:
        analysis.expect(shared_loads(margins_of(moved), margins.keeps))
    # Not concatenated: XLA would recompute the operands for each element.
    outputs = [jnp.ravel(find_quantity(name).function(analysis)) for name in quantities]
    if margins is not None:
        for numbers in evaluate_margins(analysis, margins.keeps, details=False):
            if numbers is not None:
                outputs.append(jnp.ravel(numbers["value"]))
    # Overlapping rollers violate only a margin, which a search may do on its way.
    return outputs, analysis.computed


def _concatenated(arrays: list[Array]) -> Array:
    return jnp.concatenate(arrays)


#: XLA would recompute what it concatenates for each element; one array is sooner copied than many.
_as_one = apart(_concatenated, whole=True)


@repeated_program
def compiled_values(inputs: tuple[Any, ...], position: Float[Array, " variables"]):
    """All numbers of `outputs_at` as one array, compiled, and whether the design is usable."""
    arrays, valid = outputs_at(inputs, position)
    return _as_one(arrays), valid


@repeated_program
def compiled_derivatives(inputs: tuple[Any, ...], position: Float[Array, " variables"]):
    """`compiled_values`, and the derivatives of the numbers by the position, variables last.

    With tolerances only the derivatives, and `None` in place of the values.
    """

    def outputs(point):
        arrays, valid = outputs_at(inputs, point)
        return arrays, (arrays, valid)

    if inputs[-1] is not None:
        # Second derivatives: variables one after the other, as the tolerances.
        def column(along):
            return jax.jvp(outputs, (position,), (along,), has_aux=True)[1]

        columns = jax.lax.map(column, jnp.eye(position.shape[0], dtype=position.dtype))
        return None, _as_one([jnp.moveaxis(one, 0, -1) for one in columns])
    # Forward mode, for there are few variables; a linearisation takes longer to trace and compile.
    slopes, (arrays, valid) = jax.jacfwd(outputs, has_aux=True)(position)
    return (_as_one(arrays), valid), _as_one(slopes)
