"""What one subset of quantities costs, and one Hessian: rows of the tables."""

from typing import Any

import jax
import numpy as np

from .measured import (
    FOUR,
    VARIABLES,
    as_one,
    central_differences,
    designs_around,
    error_of,
    of_numbers,
    reference_jacobian,
    results_of_verbs,
    timed,
    with_value,
)


def joint(example: str, names: tuple[str, ...], count: int, seconds: float) -> dict[str, Any]:
    """Value, value and Jacobian, and differences of some quantities together, in one run.

    **Arguments:**

    - `example`, `names`: whose quantities, and which.
    - `count`: designs in a batch.
    - `seconds`: for how long the programs are sampled in turn.
    """
    evaluate, centre = of_numbers(example, names)
    together, designs = as_one(evaluate), designs_around(centre, count)
    found = timed(
        {
            "value": evaluate,
            "forward, as a dictionary": with_value(evaluate),
            "forward, concatenated": with_value(together),
            "central differences": central_differences(together, len(VARIABLES)),
        },
        designs,
        seconds,
    )
    expected = reference_jacobian(together, designs[0])
    value, dictionary, concatenated, differences = found.values()
    parts = [
        np.asarray(part[0]).reshape(-1, len(VARIABLES)) for part in dictionary.found[0].values()
    ]
    return {
        "quantities": list(names),
        "microseconds": {name: 1e6 * sample.seconds for name, sample in found.items()},
        "compile_s": {name: sample.compile_seconds for name, sample in found.items()},
        "processor_s": {name: s.compile_processor_seconds for name, s in found.items()},
        "instructions": {name: s.instructions for name, s in found.items()},
        "over_value": {
            "dictionary": dictionary.seconds / value.seconds,
            "concatenated": concatenated.seconds / value.seconds,
        },
        "differences_over_forward": differences.seconds / concatenated.seconds,
        "error_dictionary": error_of(np.concatenate(parts), expected),
        "error_forward": error_of(np.asarray(concatenated.found[0][0]), expected),
        "error_differences": error_of(np.asarray(differences.found[0]), expected),
    }


def hessian(example: str, name: str, count: int, seconds: float) -> dict[str, Any]:
    """Hessian of a scalar quantity by four numbers, and its derivative in reverse mode.

    **Arguments:** as `joint`, with the name of one scalar.
    """
    evaluate, centre = of_numbers(example, (name,), FOUR)

    def scalar(numbers):
        return evaluate(numbers)[name]

    designs = designs_around(centre, count)
    found = timed(
        {
            "value": scalar,
            "reverse": jax.grad(scalar),
            "forward over forward": jax.jacfwd(jax.jacfwd(scalar)),
        },
        designs,
        seconds,
    )
    value, reverse, second = found.values()
    expected = reference_jacobian(jax.jacfwd(scalar), designs[0])
    return {
        "quantity": name,
        "compile_s": {key: sample.compile_seconds for key, sample in found.items()},
        "processor_s": {key: s.compile_processor_seconds for key, s in found.items()},
        "instructions": {key: s.instructions for key, s in found.items()},
        "microseconds": {key: 1e6 * sample.seconds for key, sample in found.items()},
        "reverse_over_value": reverse.seconds / value.seconds,
        "hessian_over_value": second.seconds / value.seconds,
        "error": error_of(np.asarray(second.found[0]), expected),
    }


def joint_to_single(example: str, names: tuple[str, ...], count: int, seconds: float) -> float:
    """Time of one concatenated Jacobian over those of its parts one by one."""
    evaluate, centre = of_numbers(example, names)
    parts = {name: jax.jacfwd(as_one(of_numbers(example, (name,))[0])) for name in names}
    found = timed(
        {**parts, "together": jax.jacfwd(as_one(evaluate))}, designs_around(centre, count), seconds
    )
    return found["together"].seconds / sum(found[name].seconds for name in names)


def verbs_to_value(example: str, count: int, seconds: float) -> float:
    """Time of value and Jacobian of the results of three verbs, concatenated, over the value's."""
    evaluate, centre = results_of_verbs(example)
    value, both = timed(
        {"value": evaluate, "both": with_value(evaluate)}, designs_around(centre, count), seconds
    ).values()
    return both.seconds / value.seconds
