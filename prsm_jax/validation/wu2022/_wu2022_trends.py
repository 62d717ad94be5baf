"""Wu et al. 2022: trends of figures 10 to 12, from geometry to frequency."""

import dataclasses
import functools
from collections.abc import Iterator

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from ...contact import engaged_threads, stage_contact
from ...mechanism import Mechanism, set_parameter
from ...vibration import modal
from .._difference import differs
from .._examples import example
from .._registry import rows_of
from .._row import Row, trend

_THREAD_LOAD = 100.0
_RADII = np.linspace(2e-3, 10e-3, 9)
_ANGLES = np.radians(np.linspace(30.0, 60.0, 13))
#: Indices of Table 3's values in them: 4 mm and 45°.
_RADIUS, _ANGLE = 2, 6


def _load(mechanism: Mechanism):
    stage = mechanism.stages[0]
    return _THREAD_LOAD * stage.roller_count * engaged_threads(stage)


@eqx.filter_jit
def _curves(mechanism: Mechanism, radii, angles):
    def stiffness(radius, angle):
        moved = set_parameter(mechanism, "roller_radius", radius)
        moved = set_parameter(moved, "contact_angle", angle)
        contact = stage_contact(moved.stages[0], _load(moved))
        return jnp.stack([contact.screw.axial_stiffness, contact.nut.axial_stiffness])

    def frequencies(angle):
        moved = set_parameter(mechanism, "contact_angle", angle)
        modes = modal(moved, load=_load(moved))
        return {group.family: group.frequencies for group in modes.groups}

    by_angle = jax.vmap(stiffness, in_axes=(None, 0))
    return jax.vmap(by_angle, in_axes=(0, None))(radii, angles), jax.vmap(frequencies)(angles)


@functools.cache
def curves() -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Thread stiffness (roller radius × contact angle × side), and frequencies by contact angle.

    The contact stiffnesses of Table 4 are removed, so that they follow from Hertz contact.
    """
    mechanism = example("wu2022")
    stage = mechanism.stages[0]
    assert stage.stiffness is not None
    derived = dataclasses.replace(stage.stiffness, screw_roller=None, nut_roller=None)
    mechanism = dataclasses.replace(
        mechanism, stages=(dataclasses.replace(stage, stiffness=derived),)
    )
    results = _curves(mechanism, jnp.asarray(_RADII), jnp.asarray(_ANGLES))
    return jax.tree.map(np.asarray, results)


def rises(curve: np.ndarray) -> bool:
    """Whether every first difference is positive."""
    return bool(np.all(np.diff(curve) > 0))


def bends(curve: np.ndarray) -> int:
    """+1 if the curve grows ever faster, −1 if ever more slowly, 0 if neither throughout."""
    second = np.diff(curve, 2)
    return 1 if np.all(second > 0) else -1 if np.all(second < 0) else 0


def _ends(curve: np.ndarray, scale: float, unit: str) -> str:
    return f"{curve[0] * scale:.4g} to {curve[-1] * scale:.4g} {unit}"


@rows_of("wu2022")
def stiffness_trends() -> Iterator[Row]:
    """Figures 10 and 11."""
    stiffness, _ = curves()
    for index, side in enumerate(("screw", "nut")):
        curve = stiffness[:, _ANGLE, index]
        family = stiffness[:, :, index].T
        yield trend(
            f"figure 10: thread stiffness, {side} side, with the roller radius",
            "rises, ever more slowly",
            _ends(curve, 1e-6, "N/µm"),
            all(rises(one) and bends(one) == -1 for one in family),
            "roller radius 2 to 10 mm at fixed starts, 100 N on each thread; signs of the first "
            "and second differences, at 45° and at each of 13 contact angles from 30° to 60°",
        )
    for index, side in enumerate(("screw", "nut")):
        curve = stiffness[_RADIUS, :, index]
        family = stiffness[:, :, index]
        yield trend(
            f"figure 11: thread stiffness, {side} side, with the contact angle",
            "rises, ever faster",
            _ends(curve, 1e-6, "N/µm"),
            all(rises(one) and bends(one) == 1 for one in family),
            "contact angle 30° to 60°, measured from the transverse plane, 100 N on each thread; "
            "for the roller of 4 mm radius and each of nine radii from 2 to 10 mm",
        )


@rows_of("wu2022")
def frequency_trends() -> Iterator[Row]:
    """Figure 12: which frequencies rise with the contact angle, and how."""
    stiffness, frequencies = curves()
    note = "contact angle 30° to 60°; stiffness from geometry and Hertz contact, 7 × 16 threads"
    for name, curve in (
        ("roller mode", frequencies["roller"][:, 0]),
        ("highest torsional mode", frequencies["torsional"][:, -1]),
        ("highest transverse mode", frequencies["transverse"][:, -1]),
    ):
        yield trend(
            f"figure 12: {name} with the contact angle",
            "rises, ever faster",
            _ends(curve, 1.0, "Hz"),
            rises(curve) and bends(curve) == 1,
            note,
        )
    lowest = frequencies["torsional"][:, 1]
    second = np.diff(lowest, 2)
    turn = np.degrees(_ANGLES[1:-1][np.argmax(second > 0)])
    slower = rises(lowest) and bool(np.all(np.diff(np.sign(second)) >= 0)) and second[0] < 0
    squared = lowest**2
    yield differs(
        "figure 12: lowest torsional mode of the meshes, contact angle up to which it rises ever "
        "more slowly",
        "rises, ever faster",
        float(turn) if slower else 0.0,
        "°",
        # The angles are 2.5° apart.
        between=(55.0, 60.0),
        evidence=float(np.min(np.diff(squared, 2) / squared[1:-1])),
        evidence_between=(1e-3, 1e-2),
        because="the frequency is proportional to the square root of the stiffness, and the root "
        f"removes the upward bend of figure 11 ({_ends(lowest, 1.0, 'Hz')}). The square of the "
        "frequency bends upwards throughout (evidence: its least second difference over its "
        "value); frequencies of modes that strain the gear too, whose stiffness is constant, bend "
        "upwards themselves",
    )
    carrier = frequencies["carrier"][:, 0]
    yield differs(
        "figure 12: first natural frequency (the carrier's in Table 5) with the contact angle",
        "rises, ever faster",
        float(np.ptp(carrier)),
        "Hz",
        between=(0.0, 1e-6),
        evidence=float(stiffness[_RADIUS, -1, 0] / stiffness[_RADIUS, 0, 0]),
        evidence_between=(1.5, 5.0),
        because=f"constant, {_ends(carrier, 1.0, 'Hz')}; the computed number is its change. The "
        "contact stiffness grows by the factor in evidence; the carrier mode does not contain it "
        "(equation 58), so the figure must show another mode",
    )
