"""The matrix behind Tables 5 and 6 of Wu et al. 2022, which is no stiffness matrix.

Kept apart from the toolkit's model on purpose: it exists to reproduce and explain those tables.
"""

import dataclasses

import numpy as np

from ..mechanism import Stage

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
    roller_sign: int
    torsion_sign: int
    corner_sign: int


def _bodies(stage: Stage) -> tuple[_Body, ...]:
    thread, given = stage.thread, stage.stiffness
    assert given is not None
    projection = float(np.cos(float(thread.roller_helix_angle)) ** 2)
    assert given.screw_roller is not None
    assert given.nut_roller is not None
    assert given.ring_roller is not None
    meshes = {
        "screw": float(given.screw_roller) * projection,
        "ring_gear": float(given.ring_roller),
        "nut": float(given.nut_roller) * projection,
    }
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
                roller_sign=sign,
                torsion_sign=sign,
                corner_sign=-sign,
            )
        )
    return tuple(bodies)


def published_matrices(stage: Stage, roller_count: int) -> tuple[np.ndarray, np.ndarray]:
    """Matrix and mass diagonal whose eigenvalue magnitudes are the frequencies of Table 5.

    The couplings are those of the springs `δ = gᵀq`, but on the diagonal the springs count
    negative for all translations, for the torsion of ring gear and nut, and for the rollers as
    held by the screw. A spring that is stretched then gives energy back, so the matrix is
    indefinite: −K, +K and the couplings belong to no common energy.

    **Arguments:**

    - `stage`: the stage with the numbers of Table 4.
    - `roller_count`: N.
    """
    bodies = _bodies(stage)
    angles = 2 * np.pi * np.arange(roller_count) / roller_count
    size = 9 + roller_count + 1
    matrix, mass = np.zeros((size, size)), np.zeros(size)
    for index, body in enumerate(bodies):
        place = slice(3 * index, 3 * index + 3)
        signs = np.array([-1.0, -1.0, body.torsion_sign])
        mass[place] = body.mass, body.mass, body.equivalent_mass
        matrix[place, place] += np.diag([body.radial, body.radial, body.torsional])
        for roller, position in enumerate(angles):
            angle = -body.roller_sign * position
            row = np.array([-np.sin(angle), np.cos(angle), 1.0])
            other = 9 + roller
            matrix[place, place] += body.mesh * np.diag(signs * row**2)
            matrix[other, other] += body.corner_sign * body.mesh
            matrix[place, other] += body.mesh * body.roller_sign * row
            matrix[other, place] += body.mesh * body.roller_sign * row
    mass[9:-1] = ROLLER_MASS
    carrier = stage.carrier
    assert carrier is not None
    assert carrier.inertia is not None
    assert carrier.support is not None
    assert carrier.support.torsional_stiffness is not None
    radius = float(stage.thread.centre_distance)
    mass[-1] = carrier.count * float(carrier.inertia) / radius**2 + roller_count * ROLLER_MASS
    matrix[-1, -1] = float(carrier.support.torsional_stiffness)
    return matrix, mass


def published_modes(stage: Stage, roller_count: int) -> dict[str, tuple[float, bool]]:
    """Frequency √|ω²|/2π [Hz] of every column of Table 5, and whether ω² is negative.

    The columns are told apart by multiplicity: simple roots (the carrier's first), double roots,
    and the (N − 3)-fold one.
    """
    matrix, mass = published_matrices(stage, roller_count)
    weight = 1 / np.sqrt(mass)
    values = np.linalg.eigvalsh(matrix * np.outer(weight, weight))
    clusters: list[list[float]] = []
    scale = float(np.abs(values).max())
    for value in values.tolist():
        if clusters and abs(value - clusters[-1][-1]) < 1e-9 * scale:
            clusters[-1].append(value)
        else:
            clusters.append([value])
    carrier = matrix[-1, -1] / mass[-1]
    corner = sum(b.corner_sign * b.mesh for b in _bodies(stage)) / ROLLER_MASS
    found: dict[str, tuple[float, bool]] = {}
    simple, double = [], []
    for cluster in clusters:
        value = cluster[0]
        entry = (float(np.sqrt(abs(value)) / (2 * np.pi)), value < 0)
        if abs(value - corner) < 1e-9 * scale:
            found["r"] = entry
        elif abs(value - carrier) < 1e-9 * scale:
            found["f1"] = entry
        elif len(cluster) == 1:
            simple.append(entry)
        else:
            double.append(entry)
    found |= {f"f{2 + index}": entry for index, entry in enumerate(sorted(simple))}
    found |= {f"t{1 + index}": entry for index, entry in enumerate(sorted(double))}
    return found
