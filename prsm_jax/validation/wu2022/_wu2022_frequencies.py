"""Wu et al. 2022: natural frequencies, Tables 5 and 6 and equation 89."""

import dataclasses
import functools
from collections.abc import Iterator

import numpy as np

from ...mechanism import Stage
from ...stiffness import thread_stiffness
from ...vibration import (
    carrier_mode,
    roller_modes,
    torsional_block,
    transverse_block,
    vibration_system,
)
from .._data import read_table
from .._difference import differs, fault
from .._examples import example, given
from .._registry import rows_of
from .._row import Row, misprint, number
from ._wu2022_matrix import ROLLER_MASS, published_modes

_COUNTS = tuple(range(7, 13))


def _no_contact():
    raise AssertionError("Table 4 gives the contact stiffnesses")


def _system(stage: Stage, roller_count: int, roller_mass: float | None = None):
    stage = dataclasses.replace(stage, roller_count=roller_count)
    if roller_mass is not None:
        radius = float(stage.thread.roller_radius)
        roller = dataclasses.replace(
            stage.roller, mass=roller_mass, inertia=roller_mass * radius**2
        )
        stage = dataclasses.replace(stage, roller=roller)
    return vibration_system(stage, thread_stiffness(stage, _no_contact))


def _block_frequencies(stiffness, mass) -> list[float]:
    """Frequencies of one small matrix [Hz], in NumPy: a compiled solver would take longer."""
    weight = 1 / np.sqrt(np.asarray(mass))
    values = np.linalg.eigvalsh(np.asarray(stiffness) * np.outer(weight, weight))
    return (np.sqrt(np.maximum(values, 0.0)) / (2 * np.pi)).tolist()


@functools.cache
def stable_frequencies() -> dict[int, dict[str, float]]:
    """The toolkit's frequencies for Table 4 as printed, by number of rollers and column [Hz]."""
    stage = example("wu2022").stages[0]
    frequencies: dict[int, dict[str, float]] = {}
    for count in _COUNTS:
        system = _system(stage, count)
        carrier, rollers = given(carrier_mode(system)), given(roller_modes(system))
        frequencies[count] = {
            "f1": float(carrier.frequencies[0]),
            **{
                f"f{2 + k}": float(value)
                for k, value in enumerate(_block_frequencies(*torsional_block(system)))
            },
            **{
                f"t{1 + k}": float(value)
                for k, value in enumerate(_block_frequencies(*transverse_block(system)))
            },
            "r": float(rollers.frequencies[0]),
        }
    return frequencies


_FAMILY = {"f": "torsional mode", "t": "transverse mode", "r": "roller mode"}


@rows_of("wu2022")
def table_5() -> Iterator[Row]:
    """All 60 frequencies of Table 5."""
    stage = example("wu2022").stages[0]
    corrections = {
        (int(line["n_rollers"]), line["mode"]): line["correct"]
        for line in read_table("wu2022_table5_misprints")
    }
    for line in read_table("wu2022_table5"):
        count = int(line.pop("n_rollers"))
        modes = published_modes(stage, count)
        for mode, printed in line.items():
            computed, negative = modes[mode].frequency, modes[mode].negative
            correct = corrections.get((count, mode), printed)
            family = "carrier mode" if mode == "f1" else _FAMILY[mode[0]]
            note = f"stable model: {stable_frequencies()[count][mode]:.1f} Hz; "
            if mode == "f1":
                note += f"the roller mass is {ROLLER_MASS} kg here, printed 0.0326 kg"
            else:
                note += f"√|ω²| of an indefinite matrix, here ω² {'<' if negative else '>'} 0"
            if correct != printed:
                note += (
                    f"; digits transposed or wrong in print, {correct} appears elsewhere"
                    if (mode == "r")
                    else f"; printed instead of {correct}"
                )
            item = f"Table 5, N = {count}: {mode}, {family}"
            own = stable_frequencies()[count][mode]
            if correct != printed:
                row = misprint(item, printed, computed, "Hz", correct=correct, note=note)
                yield dataclasses.replace(row, own=own)
            else:
                yield fault(item, printed, computed, "Hz", own=own, note=note)


@rows_of("wu2022")
def closed_forms() -> Iterator[Row]:
    """Table 6, the carrier's closed form, and equation 89."""
    stage = example("wu2022").stages[0]
    corrected = _system(stage, 7, ROLLER_MASS)
    carrier, rollers = given(carrier_mode(corrected)), given(roller_modes(corrected))
    stable = stable_frequencies()[7]
    yield number(
        "carrier mode in closed form, N = 7, roller mass 0.033 kg",
        "834",
        float(carrier.frequencies[0]),
        "Hz",
        note=f"with the printed 0.0326 kg it is {stable['f1']:.1f} Hz",
    )
    yield differs(
        "equation 89: roller mode",
        "14081",
        float(rollers.frequencies[0]),
        "Hz",
        between=(22699.5, 22700.5),
        evidence=published_modes(stage, 7)["r"].frequency,
        evidence_between=(14080.5, 14081.5),
        because="the equation correctly adds all three stiffnesses; the tabulated frequency "
        "follows if the screw's is subtracted (the evidence)",
    )
    yield misprint(
        "Table 6: multiplicity of the roller mode, N = 7",
        "6",
        float(rollers.multiplicity),
        correct="4",
        note="the heading says m = N − 1; the text and the number of roots say N − 3",
    )
