"""What a user of the package gets without asking: which rows of a benchmark are our defaults."""

from dataclasses import replace
from typing import Any

from .harness import Case, Method

#: Any setting: how many designs a user maps over, or in which chunks, is a choice of his.
ANY = object()

#: By case, and by problem where they differ: the methods and settings. `prsm.simulate` takes the
#: closed form at constant speed and load; a speed that varies is integrated by RODASP at 1e-8 where
#: numbers are traced, as in a batch, and balanced where they are known.
DEFAULTS: dict[str, dict[str, Any]] = {
    "hertz": {"exact": (None,), "exact, one contact": (None,)},
    "meshing": {"mesh, position only": (None,), "mesh, position only, one design": (None,)},
    "frequencies": {"reduced": ANY, "Jacobi": ANY},
    "many_designs": {
        "distinct": ANY,
        "distinct, forward": ANY,
    },
    "load_sharing": {
        "one at a time": (1e-12,),
        "a batch": (1e-12,),
    },
    "roller_bending": {
        "one at a time": (8,),
        "a batch": (8,),
    },
    "rough_contact": {"prsm_jax, tolerance 1e-8": (128, 64, 32)},
    "slip_and_spin": {"rule": (32,)},
    "torque_runs": {"integrated carriers, RODASP": (1e-8,)},
    "transient": {"closed_form": (None,)},
    "many_transients": {
        "closed form": (None,),
        "RODASP, at once": (1e-8,),
        "RODASP": (1e-8,),
    },
    "truncated_contact": {
        "prsm_jax, laminae": (None,),
        "prsm_jax, rounded edge": (None,),
    },
    "precision": {
        "float64, a batch": (None,),
        "float64, one design": (None,),
    },
    "gradients": {
        "forward, a batch": (None,),
        "forward, one design": (None,),
        "reverse, a batch": (None,),
        "reverse, one design": (None,),
    },
}

#: Problems in which a method of that name is not the default.
_NOT_IN = {
    ("many_transients", "settle", "RODASP"),
    ("many_transients", "gradients", "RODASP"),
    # Of one quantity by three numbers reverse mode is taken, of ten by three forward mode.
    *(("gradients", "efficiency", f"forward, {how}") for how in ("a batch", "one design")),
    *(("gradients", "frequencies", f"reverse, {how}") for how in ("a batch", "one design")),
}


def with_defaults(case: Case) -> Case:
    """The case with its defaults marked."""
    known = DEFAULTS.get(case.name, {})

    def marked(problem: str, method: Method) -> Method:
        settings = known.get(method.name, ())
        if method.kind == "rival" or (case.name, problem, method.name) in _NOT_IN:
            return method
        return replace(method, defaults=method.settings if settings is ANY else settings)

    problems = [
        replace(one, methods=[marked(one.name, method) for method in one.methods])
        for one in case.problems
    ]
    return replace(case, problems=problems)
