"""Public functions and what verbs compute, each as a function of a few numbers of an example.

Of the package, only names are used that stay from release to release, so the programs of an older
one can be measured too.
"""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp

import prsm_jax as prsm

EXAMPLES = ("actuator", "wu2022", "li2020_two_stage")
KINDS = ("value", "gradient", "hessian")
#: Designs in one call.
BATCHES = (1, 100)
VARIABLES = ("stage.1.lead", "stage.1.contact_angle", "stage.1.roller_radius")
_FREQUENCIES = (500.0, 1000.0, 2000.0)


def _check(mechanism):
    # A name of this release: the other functions do not depend on it.
    from prsm_jax.findings import check_numbers

    return check_numbers(mechanism)


def _all(mechanism):
    return prsm.compute(mechanism, prsm.quantities.available_quantities(mechanism))


def _quantity(name: str):
    return lambda mechanism: prsm.compute(mechanism, [name])[name]


def _response(mechanism):
    return prsm.frequency_response(mechanism, "screw u", "nut u", jnp.array(_FREQUENCIES)).value


#: Function of a mechanism, and the scalar of its result whose Hessian is asked for, if one is.
FUNCTIONS: dict[str, tuple[Callable[[Any], Any], Callable[[Any], Any] | None]] = {
    "steady_state": (prsm.steady_state, lambda found: found.efficiency),
    "modal": (prsm.modal, lambda found: found.frequencies[-1]),
    "simulate": (lambda m: prsm.simulate(m, throw=False), lambda found: found.efficiency[-1]),
    "frequency_response": (_response, lambda found: jnp.abs(found[0])),
    "campbell": (lambda m: prsm.campbell(m).critical_speeds, None),
    "check": (_check, None),
    "compute_all": (_all, None),
    "max_pressure": (_quantity("max_pressure"), lambda found: found),
    "max_pressure_shared": (_quantity("max_pressure_shared"), lambda found: found),
    "rating_life": (_quantity("rating_life"), jnp.sum),
    "static_safety": (_quantity("static_safety"), jnp.sum),
}


def _numbers(results: Any) -> list[jax.Array]:
    leaves = jax.tree.leaves(results)
    return [x for x in leaves if eqx.is_array(x) and jnp.issubdtype(x.dtype, jnp.floating)]


def program(example: str, name: str, kind: str, batch: int):
    """A program and its argument.

    **Arguments:**

    - `example`: whose designs.
    - `name`: of `FUNCTIONS`.
    - `kind`: of `KINDS`. The gradient of a scalar is taken in reverse mode, that of a function
      without one is the Jacobian of all its numbers in forward mode.
    - `batch`: designs at once; 1 is a program without `jax.vmap`.

    **Raises:** `ValueError` for the Hessian of a function without a scalar.
    """
    mechanism = prsm.load(example)
    function, scalar = FUNCTIONS[name]
    centre = jnp.stack([jnp.asarray(prsm.get_parameter(mechanism, one)) for one in VARIABLES])

    def found(numbers):
        moved = mechanism
        for variable, number in zip(VARIABLES, numbers, strict=True):
            moved = prsm.set_parameter(moved, variable, number)
        return function(moved)

    def one(numbers):
        assert scalar is not None
        return scalar(found(numbers))

    if kind == "value":
        run = lambda numbers: _numbers(found(numbers))  # noqa: E731
    elif kind == "gradient":
        run = jax.grad(one) if scalar else jax.jacfwd(lambda numbers: _numbers(found(numbers)))
    elif scalar is None:
        raise ValueError(f"{name} has no scalar result")
    else:
        run = jax.hessian(one)
    if batch == 1:
        return run, centre
    factors = 1 + 1e-3 * jnp.linspace(-1, 1, batch)
    return jax.vmap(run), factors[:, None] * centre[None, :]
