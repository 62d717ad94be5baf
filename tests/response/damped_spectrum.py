"""All eigenvalues of a damped network by LAPACK, and whether damped modes are among them."""

import numpy as np


def quadratic_eigenvalues(network, damping):
    """Eigenvalues of λ² M + λ C + K that vibrate or are at rest."""
    weight = 1 / np.sqrt(np.asarray(network.mass))
    stiffness = weight[:, None] * np.asarray(network.stiffness_matrix()) * weight
    size = len(weight)
    zero, one = np.zeros((size, size)), np.eye(size)
    matrix = np.block([[zero, one], [-stiffness, -weight[:, None] * damping * weight]])
    return np.linalg.eigvals(matrix)


def assert_all_among(found, exact):
    """Each damped mode is an eigenvalue, as often as its group says; returns how many are."""
    compared = 0
    for group, ratios, frequencies in zip(
        found.modes.groups, found.ratios, found.damped_frequencies, strict=True
    ):
        for ratio, hertz in zip(np.asarray(ratios), np.asarray(frequencies), strict=True):
            if ratio == 0:
                continue
            size = 2 * np.pi * hertz
            value = size * complex(-ratio, np.sqrt(1 - ratio**2))
            # LAPACK's eigenvalues have the rounding of the largest one.
            near = np.abs(exact - value) < 1e-12 * np.abs(exact).max()
            assert near.sum() == group.multiplicity
            compared += 1
    return compared
