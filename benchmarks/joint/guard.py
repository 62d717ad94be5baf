"""What the guard of the joint derivatives compares, and its limits."""

from collections.abc import Mapping
from typing import Any

from ..guard import Numbers

_TOGETHER = "Jacobian together over one by one"
_VERBS = "Jacobian over value, results of verbs"
_COMPILING = "Hessian: processor time of compiling [s]"
_INSTRUCTIONS = "Hessian: instructions of the compiled program"

#: Far from noise. Where a concatenation was computed anew for each of its elements, its Jacobian
#: took 400 values and 58 times those of its parts (34 values for the results of verbs), and the
#: Hessian did not compile within 400 s. That time is the only number here that is not a ratio of
#: times of one run; with other work on the machine it was 43 to 104 s. The number of instructions,
#: 154,000 at first, has no noise.
LIMITS = {
    "Jacobian over value, dictionary": 5.0,
    "Jacobian over value, concatenated": 5.0,
    _TOGETHER: 4.0,
    _VERBS: 6.0,
    "differences over Jacobian": 1.5,
    "reverse over value": 6.0,
    "Hessian over value": 150.0,
    _COMPILING: 400.0,
    _INSTRUCTIONS: 250e3,
}


def numbers_of_joint(
    row: Mapping[str, Any], second: Mapping[str, Any], together: float, verbs: float
) -> Numbers:
    """The numbers of one subset, one Hessian, the subset against its parts, and verbs."""
    return Numbers(
        errors={
            "error of the Jacobian, dictionary": row["error_dictionary"],
            "error of the Jacobian, concatenated": row["error_forward"],
            "error of the Hessian": second["error"],
        },
        ratios={"differences over Jacobian": row["differences_over_forward"]},
        costs={
            "Jacobian over value, dictionary": row["over_value"]["dictionary"],
            "Jacobian over value, concatenated": row["over_value"]["concatenated"],
            _TOGETHER: together,
            _VERBS: verbs,
            "reverse over value": second["reverse_over_value"],
            "Hessian over value": second["hessian_over_value"],
            _COMPILING: second["processor_s"]["forward over forward"],
            _INSTRUCTIONS: second["instructions"]["forward over forward"],
        },
    )
