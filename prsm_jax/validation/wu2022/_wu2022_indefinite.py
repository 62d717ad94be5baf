"""Wu et al. 2022: why Tables 5 and 6 are not those of a stable structure."""

from collections.abc import Iterator

import numpy as np

from .._difference import differs
from .._examples import example
from .._registry import rows_of
from .._row import Row
from ._wu2022_matrix import eigen, published_matrices, published_modes, stable_matrices

_COUNT = 7
_DISPLACEMENT = 1e-6
#: Displacements of one body, all others at rest: its index in q, and the directions.
_ALONE = (
    ("screw moved sideways", 0, "in x and in y"),
    ("nut moved sideways", 6, "in x and in y"),
    ("ring gear turned", 5, ""),
    ("nut turned", 8, ""),
)
#: Expected energies of the published matrix, and of springs and supports [µJ].
_ENERGIES = {
    "screw moved sideways": (-361.2, 361.5),
    "nut moved sideways": (-270.8, 493.6),
    "ring gear turned": (-860.7, 864.1),
    "nut turned": (-759.8, 769.1),
}


def static_energies() -> dict[str, tuple[float, float]]:
    """Energy ½ qᵀK q [J] of single displacements by 1 µm: published matrix, stable model."""
    stage = example("wu2022").stages[0]
    published, _ = published_matrices(stage, _COUNT)
    stable, _ = stable_matrices(stage, _COUNT)
    half = 0.5 * _DISPLACEMENT**2
    return {
        name: (float(half * published[place, place]), float(half * stable[place, place]))
        for name, place, _ in _ALONE
    }


@rows_of("wu2022")
def indefinite() -> Iterator[Row]:
    """The negative eigenvalues, and displacements that would release energy."""
    stage = example("wu2022").stages[0]
    values, _ = eigen(*published_matrices(stage, _COUNT))
    lowest, _ = eigen(*stable_matrices(stage, _COUNT))
    unstable = {name: mode for name, mode in published_modes(stage, _COUNT).items() if mode[1]}
    which = ", ".join(
        f"{name} {mode.frequency:.0f} Hz" + (" twice" if mode.shapes.shape[1] == 2 else "")
        for name, mode in unstable.items()
    )
    time = 1e6 / (2 * np.pi * min(mode.frequency for mode in unstable.values()))
    yield differs(
        "Tables 5 and 6, N = 7: eigenvalues below zero",
        "0",
        float((values < 0).sum()),
        between=(6.0, 6.0),
        evidence=float((lowest < 0).sum()),
        evidence_between=(0.0, 0.0),
        because="springs and supports can only store energy, so ½ qᵀK q is a sum of squares and "
        "every ω² ≥ 0. But for misprints, all 60 frequencies and all ten shapes follow, to the "
        "printed digit, from a matrix whose mesh springs enter the diagonal with the wrong sign: − "
        "for translations, for the torsion of ring gear and nut, and for the rollers at the "
        f"screw. Six ω² are then negative ({which}), and the tables print √|ω²|. They are not "
        "frequencies: displaced by one of these shapes the mechanism would not vibrate; the "
        "displacement would grow by a "
        f"factor e within {time:.0f} µs at most. The stable model has the same springs with the "
        "correct sign; its number of eigenvalues below zero is the evidence, and its "
        f"lowest ω² is that of {np.sqrt(lowest[0]) / (2 * np.pi):.1f} Hz",
    )
    energies = static_energies()
    for name, _, directions in _ALONE:
        released, stored = (1e6 * energy for energy in energies[name])
        loss, gain = _ENERGIES[name]
        yield differs(
            f"Tables 5 and 6, N = 7: energy with the {name} by 1 µm, all else at rest",
            "more than 0",
            released,
            "µJ",
            between=(loss - 0.1, loss + 0.1),
            evidence=stored,
            evidence_between=(gain - 0.1, gain + 0.1),
            because="½ K u² with the diagonal entry of the matrix"
            + (f", {directions}" if directions else "")
            + f"; springs and support store {stored:+.4g} µJ (the evidence)",
        )
