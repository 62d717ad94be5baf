"""The way of two numbers through the rooms: functions in the order in which they return.

`python -m tests.layers.walks` traces the derivatives, and fails if a walk is another one.
"""

import sys
from types import FrameType
from typing import Any, NamedTuple

import jax

import prsm_jax as prsm
from prsm_jax.fields import Scalar


class Walk(NamedTuple):
    """The way of one number of a mechanism to one quantity.

    - `example`: the mechanism.
    - `parameter`, `quantity`: by name.
    - `functions`: module below `prsm_jax` and function, in the order in which they return.
    """

    example: str
    parameter: str
    quantity: str
    functions: tuple[tuple[str, str], ...]

    def traced(self) -> None:
        """Trace the derivative of the quantity by the parameter, as `prsm.sensitivity` does."""

        def evaluate(value: Scalar):
            moved = prsm.set_parameter(prsm.load(self.example), self.parameter, value)
            return prsm.compute(moved, [self.quantity])[self.quantity]

        value = prsm.get_parameter(prsm.load(self.example), self.parameter)
        jax.make_jaxpr(jax.jacfwd(evaluate))(value)


WALKS = (
    Walk(
        "li2020_two_stage",
        "lead",
        "efficiency",
        (
            ("file._read", "load"),
            ("mechanism.parameters._parameters", "set_parameter"),
            ("geometry._meshing", "contact_point"),
            ("geometry._meshing", "mesh"),
            ("dynamics._kinematics", "stage_kinematics"),
            ("dynamics.steady._carrier_balance", "balanced_carrier_ratio"),
            ("dynamics.friction._thread_friction", "slip_direction"),
            ("dynamics.steady._carrier_balance", "steady_motion"),
            ("dynamics.friction._thread_friction", "thread_friction"),
            ("dynamics.forces._stage_forces", "stage_forces"),
            ("dynamics.forces._chain", "chain_forces"),
            ("dynamics.steady._steady", "steady_state"),
            ("quantities.entries._operation", "efficiency"),
            ("quantities._compute", "compute"),
        ),
    ),
    Walk(
        "actuator_load_sharing",
        "contact_angle",
        "max_pressure_shared",
        (
            ("file._read", "load"),
            ("mechanism.parameters._parameters", "set_parameter"),
            ("geometry._meshing", "mesh"),
            ("contact._conventions", "contact_frames"),
            ("contact.hertz._hertz", "hertz_contact"),
            ("contact._thread_contact", "contact_side"),
            ("load_sharing._stage_chains", "stage_chains"),
            ("load_sharing._chains", "forces_and_slopes"),
            ("load_sharing._equilibrium", "equilibrium"),
            ("load_sharing._side_loads", "side_loads"),
            ("load_sharing._distribution", "stage_load_distributions"),
            ("quantities.entries._load_sharing", "max_pressure_shared"),
            ("quantities._compute", "compute"),
        ),
    ),
)


def in_words(walk: Walk) -> str:
    """A numbered list of the functions, with their rooms."""
    lines = [
        f"{number}. `{module.split('.')[0]}`: `{name}` (`{module}`)"
        for number, (module, name) in enumerate(walk.functions, start=1)
    ]
    return (
        f"The way of `{walk.parameter}` of `{walk.example}` to `{walk.quantity}` and to its "
        "derivative:\n\n" + "\n".join(lines) + "\n"
    )


def taken(walk: Walk) -> tuple[tuple[str, str], ...]:
    """The functions of a walk in the order in which they first return."""
    order: list[tuple[str, str]] = []

    def note(frame: FrameType, event: str, _: Any) -> None:
        if event != "return":
            return
        module = str(frame.f_globals.get("__name__", "")).removeprefix(f"{prsm.__name__}.")
        function = module, frame.f_code.co_name
        if function in walk.functions and function not in order:
            order.append(function)

    # What has been traced before would not be called again.
    jax.clear_caches()
    sys.setprofile(note)
    try:
        walk.traced()
    finally:
        sys.setprofile(None)
    return tuple(order)


def main() -> int:
    """Compare; 1 if a walk is another one."""
    walks = {walk.parameter: (walk.functions, taken(walk)) for walk in WALKS}
    wrong = [(name, real) for name, (written, real) in walks.items() if real != written]
    print(*wrong, sep="\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
