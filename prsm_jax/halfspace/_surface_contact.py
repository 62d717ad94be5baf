"""Contact of two elastic bodies with any gap, as half-spaces."""

import dataclasses
from typing import Annotated

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..fields import In, Scalar, old_name
from ..programs import physics
from ..results import Result, lines_of, outcome
from ..text import Line
from ._displacement import normal_displacement
from ._equilibrium import equilibrium
from ._grid import Grid
from ._peak import peak_pressure

#: Result codes of a surface contact: meaning, and what to do.
RESULTS = {
    0: "contact found",
    1: "not converged: raise max_iterations or tolerance, and check that all numbers are finite",
    2: "the contact reaches the edge of the grid: make the grid larger",
    3: "no contact: no load, or an approach smaller than the gap",
    4: "not a half-space: under this load the Hertz pressure is above a tenth of the contact "
    "modulus, and the contact is no longer small compared with the bodies; lower the load",
    5: "no such flanks: they do not mesh, or a number of the stage is out of its range "
    "(prsm_jax.check names it)",
}
#: Pressure over contact modulus up to which strains and slopes are small. Hardened steel yields at
#: less than half of it.
_LARGEST_STRAIN = 0.1


class SurfaceContact(Result):
    """Contact of two surfaces under pressure; fields are arrays over the grid's cells."""

    grid: Grid
    #: Contact pressure, uniform on every cell [Pa].
    pressure: Float[Array, "nx ny"]
    #: Cells in contact.
    contact: Bool[Array, "nx ny"]
    #: Sum of both bodies' normal displacements [m].
    displacement: Float[Array, "nx ny"]
    #: Gap between the deformed surfaces [m].
    separation: Float[Array, "nx ny"]
    #: Approach of the two bodies δ [m].
    approach: Annotated[Scalar, In("m")]
    #: Normal force F [N].
    load: Annotated[Scalar, In("N")]
    #: Largest pressure, between the cells' centres [Pa].
    max_pressure: Annotated[Scalar, In("Pa")]
    #: Area in contact [m²].
    area: Annotated[Scalar, In("m²")]
    #: Total number of steps on all grids.
    iterations: Annotated[Int[Array, ""], In("1")]
    #: Largest violation of the contact conditions over the largest displacement.
    residual: Annotated[Scalar, In("1")]
    #: One of `RESULTS`; 0 is success.
    code: Int[Array, ""]

    def lines(self) -> list[Line]:
        """What `print` shows."""
        names = [meaning.partition(":")[0] for meaning in RESULTS.values()]
        return [outcome(self.code, names), *lines_of(self)]

    @property
    def found(self) -> Bool[Array, ""]:
        """Old name of `converged`."""
        return old_name(self, "found", "converged")

    @property
    def converged(self) -> Bool[Array, ""]:
        """Whether a contact within the grid was found."""
        return self.code == 0


def within_small_strains(
    surface: SurfaceContact, hertz_pressure: Scalar, modulus: Scalar
) -> SurfaceContact:
    """The contact, with result code 4 where its load is too large for the half-space model.

    **Arguments:**

    - `surface`: a solved contact.
    - `hertz_pressure`: pressure by closed form, without the edges of the surfaces [Pa].
    - `modulus`: contact modulus E* [Pa].
    """
    small = hertz_pressure <= _LARGEST_STRAIN * modulus
    finite = jnp.isfinite(hertz_pressure) & jnp.isfinite(modulus)
    return dataclasses.replace(surface, code=jnp.where(small | ~finite, surface.code, 4))


def _rim(field: Bool[Array, "nx ny"]) -> Bool[Array, ""]:
    return jnp.any(field[0] | field[-1]) | jnp.any(field[:, 0] | field[:, -1])


@physics("halfspace_contact")
def solve_contact(
    grid: Grid,
    gap: Float[Array, "nx ny"],
    modulus: Scalar,
    *,
    load: Scalar | float | None = None,
    approach: Scalar | float | None = None,
    material: Bool[Array, "nx ny"] | None = None,
    tolerance: Scalar | float = 1e-8,
    max_iterations: int = 1000,
) -> SurfaceContact:
    """Contact of two elastic half-spaces with a gap, frictionless, without adhesion.

    Pressures p ≥ 0 with K p + gap − δ ≥ 0 and one of the two zero everywhere; K is the displacement
    due to uniformly loaded rectangles (Love 1929). Constrained conjugate gradients with FFT
    convolution (Polonsky and Keer 1999), started on coarser grids. Derivatives, in forward and
    reverse mode, are those of the solution with the set of cells in contact fixed, not of the
    iterations: with respect to gap, load or approach, modulus and spacings, but not to the mask
    `material`.

    **Arguments:**

    - `grid`: the grid.
    - `gap`: distance of the undeformed surfaces along the common normal, up to a constant [m].
    - `modulus`: contact modulus E* [Pa].
    - `load`: normal force [N]; or
    - `approach`: approach of the bodies δ, measured from gap = 0 [m].
    - `material`: cells with material on both sides; elsewhere there is no pressure. Default: all
      cells.
    - `tolerance`: largest violation of the contact conditions over the largest displacement.
    - `max_iterations`: steps allowed on every grid.

    **Returns:** a `SurfaceContact`; `code` is one of `RESULTS`.

    **Raises:** `ValueError` unless exactly one of `load` and `approach` is given, and where gap or
    material do not fit the grid.
    """
    if (load is None) == (approach is None):
        raise ValueError(
            f"load is {load!r} and approach is {approach!r}; give exactly one of the two"
        )
    for name, field in (("gap", gap), ("material", material)):
        if field is not None and field.shape != grid.shape:
            raise ValueError(
                f"{name} has the shape {field.shape}, the grid {grid.shape}; they must be equal"
            )
    if material is None:
        material = jnp.ones(grid.shape, bool)
    control = "load" if approach is None else "approach"
    target = jnp.asarray(load if approach is None else approach, gap.dtype)
    modulus = jnp.asarray(modulus, gap.dtype)
    pressures = equilibrium(
        control,
        max_iterations,
        grid,
        gap,
        jnp.maximum(target, 0.0) if control == "load" else target,
        modulus,
        material,
        jnp.asarray(tolerance, gap.dtype),
    )
    contact = pressures.pressure > 0
    touching = jnp.any(contact)
    nearest = jnp.min(jnp.where(material, gap, jnp.inf))
    final = (
        jnp.where(touching, pressures.approach, nearest)
        if control == "load"
        else pressures.approach
    )
    displacement = normal_displacement(grid, pressures.pressure, modulus)
    # With numbers that are not finite no cell is in contact and no condition is violated.
    finite = jnp.isfinite(jnp.sum(pressures.pressure) + modulus + nearest + target)
    converged = (pressures.residual <= tolerance) & finite
    code = jnp.where(converged, jnp.where(touching, jnp.where(_rim(contact), 2, 0), 3), 1)
    return SurfaceContact(
        grid=grid,
        pressure=pressures.pressure,
        contact=contact,
        displacement=displacement,
        separation=displacement + gap - final,
        approach=final,
        load=jnp.sum(pressures.pressure) * grid.cell_area,
        max_pressure=peak_pressure(pressures.pressure, material),
        area=jnp.sum(contact.astype(gap.dtype)) * grid.cell_area,
        iterations=pressures.iterations,
        residual=pressures.residual,
        code=code,
    )
