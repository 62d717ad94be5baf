"""What to choose when, by case: words for an engineer; the numbers beside them are measured."""

#: Order of the page, heading, and what to choose.
CASES: dict[str, tuple[str, str]] = {
    "hertz": (
        "Hertz contact",
        "Take `exact`, the default: a closed-form approximation saves next to nothing, and an "
        "engineer has to know its range. `antoine` is as good as single precision for contacts "
        "of roller screws. Call it for many contacts at once: a single call is mostly overhead of "
        "Python and JAX.",
    ),
    "meshing": (
        "Meshing",
        "Take `prsm.mesh`. The closed forms are for starting values only. Where the position alone "
        "is used, the compiler leaves normals and curvatures out by itself.",
    ),
    "frequencies": (
        "Natural frequencies",
        "Take `prsm.modal`: it uses symmetry where the mechanism has it. Map over some thousands "
        "of designs at once, in chunks (`jax.lax.map` with `batch_size`) beyond that. Without "
        "symmetry the default (Jacobi) keeps the digits of small frequencies and is safe in "
        "several threads; where the last three digits do not matter, values by LAPACK "
        "through NumPy are faster.",
    ),
    "many_designs": (
        "Natural frequencies of very many designs",
        "Take `distinct_frequencies` where each frequency is needed once, in chunks of one to four "
        "thousand designs, and two devices where there are two cores.",
    ),
    "load_sharing": (
        "Load distribution among threads and rollers",
        "Take the default. A loose tolerance saves a few Newton steps of several, and costs "
        "digits that a derivative needs. Batches in `jax.lax.map` with a `batch_size` of some "
        "hundreds.",
    ),
    "rough_contact": (
        "Contact of true surfaces (half-spaces)",
        "The grid, not the tolerance, is the error of values: twice as many cells along a side cut "
        "it to a quarter. 32 × 32 cells give a design its pressure to a per mille; `flank_contact` "
        "has 128 × 128. A tolerance of 1e-4 is enough for values.",
    ),
    "truncated_contact": (
        "Ellipses cut by the crests of the threads",
        "The closed laws (laminae, rounded edge) are for sweeps and optimisation; confirm the "
        "final design by `flank_contact`.",
    ),
    "slip_and_spin": (
        "Slip and spin in one ellipse",
        "The rule with 32 points is the default and holds for any ellipse; 16 suffice up to "
        "a/b = 5.",
    ),
    "transient": (
        "Transients of one design",
        'At constant speed and load `method="auto"` takes the closed form. Where it does not '
        "apply, take RODASP (`rosenbrock`) at any tolerance; an explicit solver only for scenes "
        "that are not stiff. Regularised friction is an approximation of the law, not of the "
        "solution: its width sets the error.",
    ),
    "many_transients": (
        "Transients of many designs",
        "Map the closed form or the quasi-steady balance where they apply: pass "
        "`method=prsm.dynamics.choose_method(…).method`, because inside `vmap` no number is known "
        "and RODASP is taken. Integrate only what has to be integrated, in chunks of some hundred "
        "designs, for a batch takes as many steps as its slowest member; as many threads as there "
        "are cores, each with chunks of its own, halve the time on two.",
    ),
    "torque_runs": (
        "Runs under a prescribed torque",
        "Integrated carriers (the default) where the carriers matter; quasi-steady ones where "
        "the error that they estimate themselves is small enough.",
    ),
    "gradients": (
        "Derivatives",
        "Take exact derivatives. Forward mode for a few parameters of several quantities, reverse "
        "mode for one quantity of many parameters; `prsm.sensitivity` chooses. In a batch central "
        "differences cost as much or more; they never give more than seven to nine digits, at a "
        "step that has to be found. A single call of them can be faster.",
    ),
    "precision": (
        "Single or double precision",
        "Take double precision, the default. In a batch on a processor single precision takes "
        "between a third and all of its time, and eight digits are lost; for maps of millions of "
        "designs those that are left may do.",
    ),
}

#: Why a default is what it is although something else is faster on a chart, by case and method.
REASONS: dict[tuple[str, str], str] = {
    ("many_designs", "distinct"): "Two devices have to be asked for before JAX starts.",
    ("rough_contact", "prsm_jax, tolerance 1e-8"): (
        "The error left is that of the grid, which single precision and a loose tolerance do not "
        "change; on a finer grid they do."
    ),
    (
        "slip_and_spin",
        "rule",
    ): "The default has to hold for long ellipses too: see the next charts.",
    ("many_transients", "RODASP"): (
        "Inside `vmap` no number is known, so that RODASP is taken; pass what "
        "`prsm.dynamics.choose_method` gives outside."
    ),
    (
        "many_transients",
        "RODASP, at once",
    ): "How to cut a batch into chunks is for the user to say.",
}
