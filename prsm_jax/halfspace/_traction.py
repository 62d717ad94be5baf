"""Tangential traction by Coulomb's law: full sliding, and partial slip."""

from typing import Annotated

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..fields import In, Scalar
from ..programs import physics
from ..results import Result
from ._surface_contact import SurfaceContact, solve_contact


def sliding_traction(contact: SurfaceContact, coefficient: Scalar | float) -> Float[Array, "nx ny"]:
    """Traction of a contact that slides, q = μ p, along the slip [Pa].

    **Arguments:**

    - `contact`: the normal contact.
    - `coefficient`: friction coefficient μ.
    """
    return coefficient * contact.pressure


class PartialSlip(Result):
    """Tangential traction in one direction, with a stick zone inside a slip zone."""

    #: Traction in the direction of the force [Pa].
    traction: Float[Array, "nx ny"]
    #: Cells that stick.
    stick: Bool[Array, "nx ny"]
    #: Cells in contact that slip.
    slip: Bool[Array, "nx ny"]
    #: Tangential force, at most μ F [N].
    force: Annotated[Scalar, In("N")]
    #: Whether the whole contact slides: the given force is μ F or more.
    sliding: Annotated[Bool[Array, ""], In("1")]
    #: Approach minus that under the load F* of the stick zone, δ(F) − δ(F*) [m].
    approach_difference: Annotated[Scalar, In("m")]
    #: Result code of the second contact, one of `RESULTS`; 3 if no cell sticks.
    code: Array

    def displacement(self, coefficient: Scalar | float, poisson_ratio: Scalar | float) -> Scalar:
        """Tangential displacement of the bodies, both of one material [m].

        μ (2 − ν)/(2 (1 − ν)) (δ(F) − δ(F*)), the ratio of tangential to normal compliance without
        the coupling of directions by Poisson's ratio; exact for circles by Mindlin 1949.

        **Arguments:**

        - `coefficient`: friction coefficient μ.
        - `poisson_ratio`: of both bodies.
        """
        ratio = (2 - poisson_ratio) / (2 * (1 - poisson_ratio))
        return coefficient * ratio * self.approach_difference


@physics("partial_slip")
def partial_slip(
    contact: SurfaceContact,
    gap: Float[Array, "nx ny"],
    modulus: Scalar,
    coefficient: Scalar | float,
    force: Scalar | float,
    *,
    material: Bool[Array, "nx ny"] | None = None,
    tolerance: Scalar | float = 1e-8,
    max_iterations: int = 1000,
) -> PartialSlip:
    """Traction under a tangential force that grows from 0 at constant normal force.

    q = μ (p(F) − p(F*)) with F* = F − Q/μ: the stick zone is the contact under the smaller load
    (Ciavarella 1998, Jäger 1998; Cattaneo and Mindlin for spheres). Exact for elastically similar
    bodies when Poisson's ratio does not couple the two tangential directions (plane problems, or ν
    = 0); otherwise the slip is not exactly along the force and the error is some per cent.

    **Arguments:**

    - `contact`: the normal contact under the load F.
    - `gap`, `modulus`, `material`: as used for that contact.
    - `coefficient`: friction coefficient μ; without friction (0) no cell sticks.
    - `force`: tangential force Q ≥ 0 [N]; at μ F and above the contact slides.
    - `tolerance`, `max_iterations`: as in `solve_contact`.
    """
    mu = jnp.asarray(coefficient, gap.dtype)
    asked = jnp.asarray(force, gap.dtype)
    # At a tie `maximum` has half of the derivative: at Q = 0 half of the compliance.
    tangential = jnp.where(asked < 0, 0.0, asked)
    limit = mu * contact.load
    sliding = tangential >= limit
    remaining = jnp.where(sliding, 0.0, contact.load - tangential / jnp.where(sliding, 1.0, mu))
    inner = solve_contact(
        contact.grid,
        gap,
        modulus,
        load=remaining,
        material=material,
        tolerance=tolerance,
        max_iterations=max_iterations,
    )
    return PartialSlip(
        traction=mu * (contact.pressure - inner.pressure),
        stick=inner.contact,
        slip=contact.contact & ~inner.contact,
        force=jnp.where(sliding, limit, tangential),
        sliding=sliding,
        approach_difference=contact.approach - inner.approach,
        code=inner.code,
    )
