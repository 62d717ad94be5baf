"""What to choose when, by case: words for an engineer; the numbers beside them are measured."""

#: Order of the page, heading, and what to choose.
CASES: dict[str, tuple[str, str]] = {
    "hertz": (
        "Hertz contact",
        "Use `exact`, the default: a closed-form approximation saves almost no time, and the user "
        "has to know its range. `antoine` is as accurate as single precision for contacts of "
        "roller screws. Evaluate many contacts in one call: a single contact is mostly overhead of "
        "Python and JAX.",
    ),
    "meshing": (
        "Meshing",
        "Use `prsm.mesh`. The closed forms are for starting values only. If only the position is "
        "used, the compiler omits normals and curvatures automatically.",
    ),
    "frequencies": (
        "Natural frequencies",
        "Use `prsm.modal`: it uses symmetry if the mechanism is symmetric. Map over a few thousand "
        "designs at once, and over more in chunks (`jax.lax.map` with `batch_size`). Without "
        "symmetry the default (Jacobi) keeps the digits of small frequencies and is safe in "
        "several threads; if the last three digits do not matter, values by LAPACK "
        "through NumPy are faster.",
    ),
    "many_designs": (
        "Natural frequencies of very many designs",
        "Use `distinct_frequencies` if each frequency is needed once, in chunks of one to four "
        "thousand designs, and with two devices on two cores.",
    ),
    "load_sharing": (
        "Load distribution among threads and rollers",
        "Use the default. A loose tolerance saves some of the Newton steps, but loses digits that "
        "a derivative needs. Run batches in `jax.lax.map` with a `batch_size` of a few hundred.",
    ),
    "roller_bending": (
        "Rollers that lean and bend",
        "Eight shapes, the default, have an error below a thousandth of a thread's mean load; more "
        "approach the beam slowly, because threads press at points. One shape is a rigid roller "
        "that leans. Beams of finite elements are exact, but take longer.",
    ),
    "rough_contact": (
        "Contact of true surfaces (half-spaces)",
        "The grid, not the tolerance, determines the error of values: twice as many cells along a "
        "side reduce it to a quarter. 32 × 32 cells give the pressure to 0.1 %; `flank_contact` "
        "has 128 × 128. A tolerance of 1e-4 is enough for values.",
    ),
    "truncated_contact": (
        "Ellipses cut by the crests of the threads",
        "Use the closed-form laws (laminae, rounded edge) for sweeps and optimisation; confirm the "
        "final design by `flank_contact`.",
    ),
    "slip_and_spin": (
        "Slip and spin in one ellipse",
        "The rule with 32 points is the default and valid for any ellipse; 16 points suffice up to "
        "a/b = 5.",
    ),
    "transient": (
        "Transients of one design",
        'At constant speed and load `method="auto"` uses the closed form. Where it does not '
        "apply, use RODASP (`rosenbrock`) at any tolerance; use an explicit solver only for scenes "
        "that are not stiff. Regularised friction approximates the law, not the solution: its "
        "width determines the error.",
    ),
    "many_transients": (
        "Transients of many designs",
        "Map the closed form or the quasi-steady balance where they apply: pass "
        "`method=prsm.dynamics.choose_method(…).method`, because inside `vmap` the numbers are "
        "unknown and RODASP is used. Integrate only where it is necessary. A batch takes as many "
        "steps as its slowest member: use chunks of about a hundred designs with explicit methods, "
        "and all designs at once with RODASP. For batches of a few hundred missions, one thread "
        "per core, each with its own designs, halves the time on two cores.",
    ),
    "torque_runs": (
        "Runs under a prescribed torque",
        "Use integrated carriers (the default) where the carriers matter, and quasi-steady ones "
        "where their own error estimate is small enough.",
    ),
    "gradients": (
        "Derivatives",
        "Use exact derivatives: forward mode for several quantities by a few parameters, reverse "
        "mode for one quantity by many parameters; `prsm.sensitivity` chooses. In a batch, central "
        "differences cost as much or more; they give at most seven to nine digits, and only with "
        "a suitable step. A single call of them can be faster.",
    ),
    "precision": (
        "Single or double precision",
        "Use double precision, the default. In a batch on a processor single precision takes from "
        "a third of the time to the same time, and loses eight digits; for maps of millions of "
        "designs the remaining digits may suffice.",
    ),
}

#: Why a default is what it is although something else is faster on a chart, by case and method.
REASONS: dict[tuple[str, str], str] = {
    ("many_designs", "distinct"): "Two devices must be requested before JAX starts.",
    ("rough_contact", "prsm_jax, tolerance 1e-8"): (
        "The remaining error is that of the grid, which single precision and a loose tolerance do "
        "not change; on a finer grid they do."
    ),
    (
        "slip_and_spin",
        "rule",
    ): "The default must be valid for long ellipses too: see the next charts.",
    ("many_transients", "RODASP"): (
        "Inside `vmap` the numbers are unknown, so RODASP is used; pass the result of "
        "`prsm.dynamics.choose_method` from outside."
    ),
    (
        "many_transients",
        "RODASP, at once",
    ): "The user has to choose the chunks of a batch.",
}
