"""A derivative beside that by differences."""

import dataclasses

import numpy as np

from .cells import Cell
from .differences import Slope

#: Relative difference up to which a derivative agrees with one by differences.
_SLOPE_TOLERANCE = 1e-6
#: A derivative below this share of its value, per relative change of a number, cannot be measured.
_UNMEASURABLE = 1e-9
#: Frequencies nearer than this to each other cross within the steps of the differences.
_NEARLY_REPEATED = 1e-4
#: Nearer than this they are one root to the package, whose members share a derivative.
_REPEATED = 1e-11
#: A value jumps where the error of its derivative is as large as the derivative itself, and larger
#: than this share of the largest value.
_JUMP = 0.1
#: Steps are chosen by an absolute tolerance too, of 1e-10 on carrier ratios, and errors of several
#: steps add up.
STATE_TOLERANCE = 3e-10
#: Differences of a method that chooses its steps are those of the choice as well. Where the exact
#: derivative is known they miss it by up to 4e-4 of it, and derivatives at fixed steps by less.
_CHOICE = 5e-5


def with_choice_of_steps(slope: Slope | None) -> Slope | None:
    """Differences with what the choice of steps adds to their error."""
    if slope is None:
        return None
    own = _CHOICE * np.max(np.abs(slope.value), initial=0.0)
    return dataclasses.replace(slope, error=slope.error + own)


def first_of(values) -> str:
    """The first number that is not finite, or the first of all, as text."""
    flat = np.ravel(np.asarray(values, float))
    bad = flat[~np.isfinite(flat)]
    return f"{(bad if bad.size else flat)[0]:.6g}" if flat.size else "nothing"


def slope_cell(
    found: np.ndarray,
    given: np.ndarray,
    measured: Slope | None,
    tolerance: float,
    histories: bool,
    spectrum: bool,
    stepping: bool = False,
    least: float = 0.0,
) -> Cell:
    """Verdict on a forward derivative.

    **Arguments:**

    - `found`: the value.
    - `given`, `measured`: its derivative, and that by differences.
    - `tolerance`: relative, where it is wider than the ordinary one.
    - `histories`: whether errors are relative to the largest entry.
    - `spectrum`: whether it is a sorted list of frequencies.
    - `stepping`: whether a method that chooses its steps found it.
    - `least`: what is as good as nothing.
    """
    if not np.isfinite(given).all():
        return Cell("not_finite", None, first_of(given))
    if measured is None:
        return Cell("open", None, "no stretch without a refusal")
    tolerance = max(_SLOPE_TOLERANCE, tolerance)
    value = np.abs(found)
    unknown = measured.error + measured.jump
    # As in a sample on a reversal itself: differences grow as their steps get smaller.
    jumps = unknown >= np.maximum(np.abs(measured.value), _JUMP * np.max(value, initial=0.0))
    jumps &= histories & (np.max(value, initial=0.0) > 0)
    scale = np.where(jumps, 0.0, np.maximum(np.abs(given), np.abs(measured.value)))
    # Below that, and below what rounding does to the largest component, nothing is measured.
    share = 1.0 if histories else 1e-8
    floor = _UNMEASURABLE * np.maximum(value, share * np.max(value, initial=0.0)) + least
    if histories:
        scale = np.maximum(scale, np.max(scale, initial=0.0))
    if stepping:
        # Tolerances of steps are relative to values, and parts of a slope may cancel.
        scale = np.maximum(scale, np.max(value, initial=0.0))
    difference = np.where(jumps, 0.0, np.abs(given - measured.value))
    allowed = tolerance * scale + 10 * measured.error + 1.05 * measured.jump + floor
    error = float(np.max(difference / np.maximum(scale, floor + 1e-300), initial=0.0))
    if np.any(difference > allowed) and spectrum:
        cell = _of_roots(found, given, measured, allowed)
        if cell is not None:
            return cell
    if np.any(difference > allowed):
        worst = int(np.argmax(difference / allowed))
        seen = f"{np.ravel(given)[worst]:.10g} for {np.ravel(measured.value)[worst]:.10g}"
        return Cell("wrong_gradient", error, f"{seen} ± {np.ravel(measured.error)[worst]:.1g}")
    if np.any(jumps):
        return Cell("open", error, "jump")
    vague = unknown > np.maximum(1e-2 * scale, floor)
    if np.any(vague):
        return Cell("open", error, "kink" if np.any(measured.jump > 0) else "rounding")
    return Cell("agrees", error)


def _of_roots(values, given, measured: Slope, allowed) -> Cell | None:
    """Frequencies next to each other by the mean of their derivatives, which has no kink.

    A member of a repeated root has no derivative where the root parts, and a sorted list of
    members that cross within a step cannot measure one.
    """
    for closeness, status in ((_REPEATED, "agrees"), (_NEARLY_REPEATED, "open")):
        parted = np.diff(values) > closeness * values[1:]
        group = np.concatenate([[0], np.cumsum(parted)])
        if group[-1] + 1 == len(values):
            continue
        size = np.bincount(group)
        difference = abs(np.bincount(group, given) - np.bincount(group, measured.value))
        if np.all(difference <= np.bincount(group, allowed)):
            return Cell(status, float(np.max(difference / size)), "mean of a repeated root")
    return None
