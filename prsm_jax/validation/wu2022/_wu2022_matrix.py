"""The matrix behind Tables 5 and 6 of Wu et al. 2022, which is not a stiffness matrix.

It is separate from the toolkit's model on purpose: it exists to reproduce and explain those tables.
"""

import dataclasses
import itertools
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...mechanism import Stage
from .._examples import given

#: Roller mass that the table was computed with, where Table 4 prints 0.0326 [kg].
ROLLER_MASS = 0.033


@dataclasses.dataclass(frozen=True)
class _Body:
    """Signs with which a body's mesh springs enter the diagonal blocks, and its numbers."""

    mass: float
    equivalent_mass: float
    radial: float
    torsional: float
    mesh: float
    phase: float
    roller_sign: int
    torsion_sign: int
    corner_sign: int


def _bodies(stage: Stage) -> tuple[_Body, ...]:
    thread, stiffness = stage.thread, given(stage.stiffness)
    projection = float(np.cos(float(thread.roller_helix_angle)) ** 2)
    meshes = {
        "screw": float(given(stiffness.screw_roller)) * projection,
        "ring_gear": float(given(stiffness.ring_roller)),
        "nut": float(given(stiffness.nut_roller)) * projection,
    }
    # α_s, α_r and α_n of equations 7 to 13, for which the paper prints no values: these give
    # the directions of the transverse modes of Table 6.
    thread_phase = float(thread.contact_angle)
    gear_phase = float(given(stage.gear).pressure_angle)
    bodies = []
    for name, mesh in meshes.items():
        part = getattr(stage, name)
        sign = 1 if name == "screw" else -1
        bodies.append(
            _Body(
                mass=float(part.mass),
                # J/r² with J = m r²: the rounding of the printed inertias shows in four entries.
                equivalent_mass=float(part.mass),
                radial=float(part.support.radial_stiffness),
                torsional=float(part.support.torsional_stiffness),
                mesh=mesh,
                phase=gear_phase if name == "ring_gear" else thread_phase,
                roller_sign=sign,
                torsion_sign=sign,
                corner_sign=-sign,
            )
        )
    return tuple(bodies)


def _mass_diagonal(stage: Stage, roller_count: int) -> np.ndarray:
    carrier = given(stage.carrier)
    radius = float(stage.thread.centre_distance)
    rollers = roller_count * ROLLER_MASS
    bodies = [(body.mass, body.mass, body.equivalent_mass) for body in _bodies(stage)]
    inertia = carrier.count * float(given(carrier.inertia)) / radius**2
    return np.array([*np.ravel(bodies), *[ROLLER_MASS] * roller_count, inertia + rollers])


def _supports(stage: Stage, roller_count: int) -> np.ndarray:
    carrier = given(stage.carrier)
    bodies = [(body.radial, body.radial, body.torsional) for body in _bodies(stage)]
    torsional = float(given(given(carrier.support).torsional_stiffness))
    return np.array([*np.ravel(bodies), *[0.0] * roller_count, torsional])


def _springs(stage: Stage, roller_count: int) -> Iterator[tuple[_Body, slice, int, np.ndarray]]:
    """Every mesh spring: its body, the places of body and roller in q, and g on the body."""
    angles = 2 * np.pi * np.arange(roller_count) / roller_count
    for index, body in enumerate(_bodies(stage)):
        for roller, position in enumerate(angles):
            angle = body.phase - body.roller_sign * position
            row = np.array([-np.sin(angle), np.cos(angle), 1.0])
            yield body, slice(3 * index, 3 * index + 3), 9 + roller, row


def stable_matrices(stage: Stage, roller_count: int) -> tuple[np.ndarray, np.ndarray]:
    """The toolkit's model, `Σ k g gᵀ` and supports, with data and phases of `published_matrices`.

    **Arguments and returns:** as `published_matrices`.
    """
    matrix = np.diag(_supports(stage, roller_count))
    for body, place, other, row in _springs(stage, roller_count):
        spring = np.zeros(len(matrix))
        spring[place], spring[other] = row, body.roller_sign
        matrix += body.mesh * np.outer(spring, spring)
    return matrix, _mass_diagonal(stage, roller_count)


def published_matrices(stage: Stage, roller_count: int) -> tuple[np.ndarray, np.ndarray]:
    """Matrix and mass diagonal that Tables 5 and 6 follow from, in the paper's coordinates.

    The springs stretch by `δ = gᵀq`, so a stiffness matrix has `+k g²` on the diagonal and
    `±k g` in the couplings of body and roller. In this one the springs enter the diagonal
    with a negative sign for all translations, for the torsion of ring gear and nut, and for the
    rollers at the screw, and every coupling has the opposite sign. Frequencies determine the signs
    on the diagonal; mode shapes, those of the couplings and the phases of the contacts. A stretched
    spring then releases energy: the matrix is indefinite, not that of an elastic structure.

    **Arguments:**

    - `stage`: the stage with the numbers of Table 4.
    - `roller_count`: N.

    **Returns:** the matrix [N/m] and the mass diagonal [kg], in
    q = [x, y, u of screw, ring gear, nut; u of each roller; u of the carrier].
    """
    matrix = np.diag(_supports(stage, roller_count))
    for body, place, other, row in _springs(stage, roller_count):
        signs = np.array([-1.0, -1.0, body.torsion_sign])
        matrix[place, place] += body.mesh * np.diag(signs * row**2)
        matrix[other, other] += body.corner_sign * body.mesh
        matrix[place, other] -= body.mesh * body.roller_sign * row
        matrix[other, place] -= body.mesh * body.roller_sign * row
    return matrix, _mass_diagonal(stage, roller_count)


def eigen(matrix: np.ndarray, mass: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues ω², ascending, and mass-normalised eigenvectors in columns."""
    weight = 1 / np.sqrt(mass)
    values, vectors = np.linalg.eigh(matrix * np.outer(weight, weight))
    return values, vectors * weight[:, None]


class PublishedMode(NamedTuple):
    """One column of Tables 5 and 6: `√|ω²|/2π` [Hz], whether ω² < 0, mass-normalised shapes."""

    frequency: float
    negative: bool
    shapes: np.ndarray


def published_modes(stage: Stage, roller_count: int) -> dict[str, PublishedMode]:
    """The columns of Table 5, distinguished by multiplicity.

    Simple roots are `f2` to `f5` (the carrier's `f1`), double ones `t1` to `t4`, the (N − 3)-fold
    one `r`. A column has as many shapes as the multiplicity of its root.

    **Arguments:** as `published_matrices`.
    """
    matrix, mass = published_matrices(stage, roller_count)
    values, vectors = eigen(matrix, mass)
    near = 1e-9 * float(np.abs(values).max())
    starts = [0, *(np.nonzero(np.diff(values) > near)[0] + 1).tolist(), len(values)]
    carrier = matrix[-1, -1] / mass[-1]
    corner = sum(b.corner_sign * b.mesh for b in _bodies(stage)) / ROLLER_MASS
    columns: dict[str, PublishedMode] = {}
    simple: list[PublishedMode] = []
    double: list[PublishedMode] = []
    for start, stop in itertools.pairwise(starts):
        value = float(values[start])
        frequency = float(np.sqrt(abs(value)) / (2 * np.pi))
        mode = PublishedMode(frequency, value < 0, vectors[:, start:stop])
        if abs(value - corner) < near:
            columns["r"] = mode
        elif abs(value - carrier) < near:
            columns["f1"] = mode
        elif stop - start == 1:
            simple.append(mode)
        else:
            double.append(mode)
    for letter, first, modes in (("f", 2, simple), ("t", 1, double)):
        ordered = sorted(modes, key=lambda mode: mode.frequency)
        columns |= {f"{letter}{first + index}": mode for index, mode in enumerate(ordered)}
    return columns
