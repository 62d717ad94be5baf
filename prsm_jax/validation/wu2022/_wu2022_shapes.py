"""Wu et al. 2022: mode shapes, Table 6."""

import itertools
from collections.abc import Iterator

import numpy as np

from ...mechanism import Stage
from .._data import read_table
from .._difference import fault
from .._examples import example
from .._registry import rows_of
from .._row import Row, half_unit, misprint, number
from ._wu2022_matrix import PublishedMode, eigen, published_modes, stable_matrices

_COUNT = 7
#: Two decimals throughout; a printed "−2" or "0" stands for −2.00 and 0.00.
_COARSEST = 0.005
#: Angles tried around the least squares angle when a double root leaves the orientation open [rad].
_ANGLES = np.linspace(-0.02, 0.02, 1601)
_NAMES = {"f": "torsional mode", "t": "transverse mode", "r": "roller mode"}
_OPEN = {
    1: "up to sign",
    2: "up to the orientation that a double root leaves open",
    4: "up to the combination that a fourfold root leaves open",
}


def _aligned(shapes: np.ndarray, mass: np.ndarray, target: np.ndarray, allowed: np.ndarray):
    """The mass-normalised member of an eigenspace that is closest to a printed shape.

    For a double root the least squares orientation is turned until the largest difference, in
    units of the difference that the printed digits allow, is smallest.
    """
    weights = shapes.T @ (mass * target)
    weights /= np.linalg.norm(weights)
    if shapes.shape[1] != 2:
        return shapes @ weights
    turned = np.cos(_ANGLES) * weights[:, None]
    turned += np.sin(_ANGLES) * np.array([[-weights[1]], [weights[0]]])
    candidates = shapes @ turned
    worst = np.max(np.abs(candidates - target[:, None]) / allowed[:, None], axis=0)
    return candidates[:, np.argmin(worst)]


def assurance(shapes: np.ndarray, mass: np.ndarray, wanted: np.ndarray) -> float:
    """Modal assurance criterion of a shape with an eigenspace of mass-normalised shapes, 0 to 1."""
    weights = shapes.T @ (mass * wanted)
    return float(weights @ weights / (wanted @ (mass * wanted)))


def _most_similar(stage: Stage, target: np.ndarray) -> tuple[float, float, np.ndarray]:
    """The stable model's mode most like a shape: frequency [Hz], assurance criterion, shapes."""
    matrix, mass = stable_matrices(stage, _COUNT)
    values, vectors = eigen(matrix, mass)
    near = 1e-9 * float(values[-1])
    starts = [0, *(np.nonzero(np.diff(values) > near)[0] + 1).tolist(), len(values)]
    groups = list(itertools.pairwise(starts))
    alike = [assurance(vectors[:, start:stop], mass, target) for start, stop in groups]
    start, stop = groups[int(np.argmax(alike))]
    return float(np.sqrt(values[start])) / (2 * np.pi), max(alike), vectors[:, start:stop]


def _note(mode: PublishedMode, frequency: float, likeness: float, largest: float) -> str:
    note = f"mass-normalised, {_OPEN[mode.shapes.shape[1]]}; largest difference {largest:.2g}; "
    if likeness > 1 - 1e-6:
        return note + f"the stable model has the same shape, at {frequency:.1f} Hz"
    sign = "ω² < 0: no vibration; " if mode.negative else ""
    return note + (
        f"{sign}the stable model's most similar mode has {frequency:.1f} Hz and an assurance "
        f"criterion of {likeness:.2f}"
    )


@rows_of("wu2022")
def table_6() -> Iterator[Row]:
    """All ten mode shapes of Table 6: how many of the 17 entries come out as printed."""
    stage = example("wu2022").stages[0]
    modes = published_modes(stage, _COUNT)
    _, mass = stable_matrices(stage, _COUNT)
    lines = read_table("wu2022_table6")
    names = [line["coordinate"] for line in lines]
    corrections = {
        (line["coordinate"], line["mode"]): line["correct"]
        for line in read_table("wu2022_table6_misprints")
    }
    for mode in list(lines[0])[1:]:
        published = modes[mode]
        printed = [line[mode] for line in lines]
        corrected = [
            corrections.get((name, mode), line[mode])
            for name, line in zip(names, lines, strict=True)
        ]
        target = np.array([float(text) for text in corrected])
        allowed = np.array([min(half_unit(text), _COARSEST) for text in corrected])
        shape = _aligned(published.shapes, mass, target, allowed)
        difference = np.abs(shape - target)
        family = "carrier mode" if mode == "f1" else _NAMES[mode[0]]
        frequency, likeness, stable = _most_similar(stage, shape)
        note = _note(published, frequency, likeness, float(difference.max()))
        wrong = [index for index, text in enumerate(printed) if text != corrected[index]]
        if wrong:
            note += f"; {len(wrong)} of the entries with corrected digits, see below"
        item = f"Table 6: {mode}, {family}, entries of the shape to the printed digit"
        count = float(np.sum(difference <= allowed * (1 + 1e-9)))
        ours = np.abs(_aligned(stable, mass, target, allowed) - target)
        own = float(np.sum(ours <= allowed * (1 + 1e-9)))
        if own == len(printed):
            yield number(item, str(len(printed)), count, tolerance=0.0, note=note)
        else:
            yield fault(item, str(len(printed)), count, own=own, note=note)
        for index in wrong:
            yield misprint(
                f"Table 6: {mode}, entry {names[index]}",
                printed[index],
                float(shape[index]),
                correct=corrected[index],
                note="the other 15 entries of the mode, all reproduced, leave no freedom; a zero "
                "after the decimal point is missing",
            )
