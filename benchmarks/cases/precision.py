"""Float32 against float64: what the cheaper numbers cost and what they save."""

import dataclasses
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax import compute
from prsm_jax.contact import contact_modulus
from prsm_jax.file import load
from prsm_jax.friction import CoulombFriction
from prsm_jax.geometry import mesh
from prsm_jax.mechanism import Mechanism, material_of, set_parameters
from prsm_jax.programs import to_precision
from prsm_jax.stiffness import thread_stiffness
from prsm_jax.vibration import modal, vibration_system

from ..harness import Case, Method, Prepared, Problem, Reference
from ..references import vibration
from ..references.contact import forward_efficiency, largest_pressure
from ..references.meshing import DIGITS, Design

_FIELDS = ("lead", "contact_angle", "roller_radius")


def _mechanism() -> Mechanism:
    """Wu et al. 2022 with the exact flank curvatures."""
    mechanism = load("wu2022")
    stage = dataclasses.replace(mechanism.stages[0], curvature="exact")
    return dataclasses.replace(mechanism, stages=(stage,))


def _designs(count: int) -> np.ndarray:
    """Lead, contact angle, roller radius of random designs."""
    random = np.random.default_rng(32)
    return np.column_stack(
        [
            random.uniform(5e-3, 15e-3, count),
            np.radians(random.uniform(40.0, 50.0, count)),
            random.uniform(3e-3, 5e-3, count),
        ]
    )


def _moved(mechanism: Mechanism, design) -> Mechanism:
    return set_parameters(mechanism, dict(zip(_FIELDS, design, strict=True)))


def _problem(
    name: str,
    title: str,
    quantity: str,
    solve: Callable[[Mechanism], jax.Array],
    expected: Callable[[np.ndarray], object],
    reference_note: str,
    designs: np.ndarray,
    compared: int,
) -> Problem:
    mechanism = _mechanism()

    def method(label: str, dtype, batched: bool) -> Method:
        def prepare(_):
            base, inputs = to_precision(mechanism, dtype), jnp.asarray(designs, dtype)

            def one(design):
                return solve(_moved(base, design))

            jitted = jax.jit(jax.vmap(one) if batched else one)
            given = inputs if batched else inputs[0]

            def read(out):
                return {quantity: out if batched else np.asarray(out)[None]}

            return Prepared(lambda: jitted(given), len(designs) if batched else 1, read)

        return Method(f"{label}, {'a batch' if batched else 'one design'}", prepare)

    return Problem(
        name=name,
        title=f"{title}, float32 against float64",
        instance="design",
        methods=[
            method(label, dtype, batched)
            for batched in (True, False)
            for label, dtype in (("float64", jnp.float64), ("float32", jnp.float32))
        ],
        reference=lambda: {
            quantity: Reference(np.array([expected(design) for design in designs[:compared]]))
        },
        reference_note=f"{reference_note}, {compared} designs",
        baseline="float64, a batch",
    )


def case(quick: bool) -> Case:
    """The case of this module."""
    designs = _designs(2_000 if quick else 20_000)
    compared = 10 if quick else 50
    mechanism = _mechanism()
    stage = mechanism.stages[0]
    assert mechanism.operating_point is not None
    assert stage.engaged_threads is not None
    assert stage.friction is not None
    assert isinstance(stage.friction.thread, CoulombFriction)
    friction = float(stage.friction.thread.coefficient)
    axial_force = float(mechanism.operating_point.load)
    axial_force /= stage.roller_count * float(stage.engaged_threads)
    modulus = float(contact_modulus(material_of(stage, "roller"), material_of(stage, "screw")))
    starts = float(stage.thread.starts)

    def design_of(row: np.ndarray) -> Design:
        lead, angle, radius = row.tolist()
        return Design(lead, starts, radius, angle, float(radius / np.cos(angle)))

    def frequencies(row: np.ndarray) -> np.ndarray:
        moved = _moved(mechanism, row).stages[0]
        system = vibration_system(moved, thread_stiffness(moved, lambda: None))  # pyright: ignore
        numbers = [float(leaf) for leaf in jax.tree.leaves(system)]
        return vibration.frequencies(numbers, stage.roller_count)[0]

    def contact_radius(row: np.ndarray) -> float:
        import mpmath

        from ..references.meshing import mesh_point

        with mpmath.workdps(DIGITS):
            return float(mesh_point(design_of(row)).screw_radius)

    exact = f"mpmath at {DIGITS} digits"
    return Case(
        "precision",
        "Float32 against float64: efficiency, contact pressure, frequencies, meshing",
        [
            _problem(
                "efficiency",
                "Efficiency",
                "efficiency η",
                lambda m: compute(m, ["efficiency"])["efficiency"],
                lambda row: forward_efficiency(design_of(row), friction),
                f"closed form in {exact}",
                designs,
                compared,
            ),
            _problem(
                "pressure",
                "Largest contact pressure",
                "largest pressure p₀",
                lambda m: compute(m, ["max_pressure"])["max_pressure"],
                lambda row: largest_pressure(design_of(row), axial_force, modulus),
                f"meshing, curvatures and Hertz theory in {exact}",
                designs,
                compared,
            ),
            _problem(
                "frequencies",
                "Natural frequencies",
                "all frequencies",
                lambda m: modal(m).frequencies,
                frequencies,
                f"full matrix in mpmath at {vibration.DIGITS} digits, its masses and springs "
                "from float64",
                designs,
                max(2, compared // 5),
            ),
            _problem(
                "meshing",
                "Contact radius on the screw",
                "contact radius on the screw",
                lambda m: mesh(m.stages[0].thread).screw.contact_radius,
                contact_radius,
                exact,
                designs,
                compared,
            ),
        ],
    )
