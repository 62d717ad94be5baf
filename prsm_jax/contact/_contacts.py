"""Thread contacts of a mechanism."""

import jax.numpy as jnp

from .._errors import MissingDataError
from ..fields import Scalar
from ..mechanism import Mechanism, of_one_design
from ..programs import one_program
from ._thread_contact import StageContact, stage_contact
from .hertz import HertzMethod


def load_of(mechanism: Mechanism, load: float | Scalar | None) -> Scalar:
    """The axial load `load`, or the load of the operating point if it is None [N].

    **Raises:** `MissingDataError` if both are missing; `ValueError` for an array with axes.
    """
    return _operating(mechanism, "load", load)


def speed_of(mechanism: Mechanism, speed: float | Scalar | None) -> Scalar:
    """The screw speed `speed`, or the speed of the operating point if it is None [rad/s].

    **Raises:** `MissingDataError` if both are missing; `ValueError` for an array with axes.
    """
    return _operating(mechanism, "speed", speed)


def _operating(mechanism: Mechanism, name: str, value: float | Scalar | None) -> Scalar:
    if value is None:
        if mechanism.operating_point is None:
            raise MissingDataError(
                f"no {name}: the mechanism has no operating point; pass {name}=… or give "
                f"[operating_point] {name}"
            )
        value = getattr(mechanism.operating_point, name)
    number = jnp.asarray(value, mechanism.stages[0].thread.lead.dtype)
    if number.ndim:
        raise ValueError(
            f"{name} has the shape {number.shape}, and an operating point has one {name}; map the "
            f"analysis over the batch: jax.vmap(lambda {name}: prsm.steady_state(mechanism, "
            f"{name}={name}))({name}s)"
        )
    return number


@of_one_design
@one_program
def thread_contacts(
    mechanism: Mechanism,
    load: float | Scalar | None = None,
    *,
    method: HertzMethod | None = None,
) -> tuple[StageContact, ...]:
    """Hertz contacts of screw and nut side of every stage, under a static load.

    The stages are in series, so each carries the full load; friction is not included.

    **Arguments:**

    - `mechanism`: the mechanism, with materials and engaged threads.
    - `load`: axial load [N]; default: load of the operating point. The sign is ignored.
    - `method`: Hertz method in place of that of each stage (`contact_method`).

    **Raises:** `MissingDataError` if load, materials or engaged threads are not given.
    """
    magnitude = jnp.abs(load_of(mechanism, load))
    return tuple(stage_contact(stage, magnitude, method=method) for stage in mechanism.stages)
