"""Excitation orders against screw speed: at which speeds do they meet natural frequencies?"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..fields import Scalar, plain
from ..mechanism import Mechanism, of_one_design, stage_at
from ..programs import each, mapped, one_program, physics
from ..results import DesignResult
from ..text import Line
from ..vibration import RIGID_SHARE, Modes, stage_modes, stage_system
from ._orders import ExcitationOrder, excitation_orders, find_order, phasing, working_carrier_ratio


@dataclass(frozen=True)
class Crossing:
    """A screw speed at which an order meets a natural frequency."""

    #: Screw speed [rad/s].
    speed: float
    order: str
    harmonic: int
    #: Natural frequency [Hz].
    frequency: float
    family: str
    multiplicity: int
    #: Whether the phases of the rollers let the order excite this family.
    excited: bool

    @property
    def speed_rpm(self) -> float:
        """Screw speed [rpm]."""
        return self.speed * 30 / np.pi


class Campbell(DesignResult):
    """Natural frequencies of one stage and the orders that may excite them.

    The frequencies do not change with the speed: rollers and screw turn too slowly for gyroscopic
    effects, and the contact stiffness is that of one load.
    """

    modes: Modes
    orders: tuple[ExcitationOrder, ...]
    #: Speed of the carriers over that of the body that turns, ζ.
    carrier_ratio: Scalar
    harmonics: int = eqx.field(static=True)
    roller_count: int = eqx.field(static=True)
    symmetric: bool = eqx.field(static=True)

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of a batch of diagrams; empty for a single design."""
        return self.carrier_ratio.shape

    def lines(self) -> list[Line]:
        """What `print` shows: orders per turn of the screw, and natural frequencies by family."""
        orders = [Line(f"order: {one.name.replace('_', ' ')}", one.order) for one in self.orders]
        modes = [replace(one, label=f"frequencies: {one.label}") for one in self.modes.lines()]
        return [
            Line("carrier ratio", self.carrier_ratio),
            Line("harmonics", self.harmonics),
            *orders,
            *modes,
        ]

    @property
    @mapped
    def critical_speeds(self) -> Float[Array, "orders harmonics degrees"]:
        """Screw speeds at which harmonics of orders meet the natural frequencies [rad/s].

        `2π f / (h · order)` for every order, harmonic from 1 and entry of `modes.frequencies`.
        Differentiable; 0 for a rigid motion.
        """
        order = jnp.stack([one.order for one in self.orders])
        harmonic = jnp.arange(1, self.harmonics + 1, dtype=order.dtype)
        rate = jnp.abs(order[:, None, None]) * harmonic[None, :, None]
        return 2 * jnp.pi * self.modes.frequencies[None, None, :] / rate

    def excited_family(self, order: ExcitationOrder, harmonic: int) -> Any:
        """The family that a harmonic of an order excites; `None` if the stage is not symmetric.

        Not available inside a trace. For a batch: an array of objects, one for each design.
        """
        lobes = np.asarray(order.lobes)
        if not lobes.shape:
            return self._excited(harmonic * float(lobes))
        results = np.empty(lobes.shape, object)
        for index in np.ndindex(*lobes.shape):
            results[index] = self._excited(harmonic * float(lobes[index]))
        return results

    def _excited(self, lobes: float) -> str | None:
        if not self.symmetric:
            return None
        try:
            return phasing(lobes, self.roller_count)
        except ValueError:
            # A design with 80.3 teeth cannot be built, but a search may pass through it.
            return None

    @each
    def crossings(
        self,
        max_speed: float | None = None,
        *,
        min_speed: float = 0.0,
        excited_only: bool = False,
    ) -> tuple[Crossing, ...]:
        """All crossings in ascending order of speed, repeated roots once.

        Not available inside a trace. For a batch: an array of such tuples, one for each design.

        **Arguments:**

        - `max_speed`, `min_speed`: range of the screw speed [rad/s].
        - `excited_only`: omit crossings whose excitation is cancelled by the phases of the rollers.
        """
        speeds = np.asarray(self.critical_speeds)
        frequencies = np.asarray(self.modes.frequencies)
        families, times = self.modes.families, self.modes.multiplicities
        results = []
        for row, order in zip(speeds, self.orders, strict=True):
            for harmonic, line in enumerate(row, start=1):
                family = self.excited_family(order, harmonic)
                for mode in self.modes.distinct:
                    # A rigid motion has no critical speed.
                    if frequencies[mode] <= RIGID_SHARE * frequencies[-1]:
                        continue
                    if line[mode] < min_speed or (max_speed is not None and line[mode] > max_speed):
                        continue
                    # The contacts do not excite the mode of the carrier alone.
                    excited = families[mode] != "carrier" and family in (None, families[mode])
                    if excited or not excited_only:
                        results.append(
                            Crossing(
                                float(line[mode]),
                                order.name,
                                harmonic,
                                float(frequencies[mode]),
                                families[mode],
                                times[mode],
                                excited,
                            )
                        )
        return tuple(sorted(results, key=lambda one: one.speed))


@of_one_design
@one_program
@physics("campbell")
def campbell(
    mechanism: Mechanism,
    *,
    stage: int = 1,
    harmonics: int = 3,
    load: float | Scalar | None = None,
    carrier_ratio: float | Scalar | None = None,
    orders: Sequence[str] | None = None,
) -> Campbell:
    """Natural frequencies and excitation orders of one stage, for a Campbell diagram.

    Jittable, and differentiable through `critical_speeds`.

    **Arguments:**

    - `mechanism`: the mechanism; as for `modal`.
    - `stage`: which stage, counted from 1.
    - `harmonics`: how many harmonics of each order.
    - `load`: axial load at which the contact stiffness is taken [N]; default that of the
      operating point.
    - `carrier_ratio`: ζ; default that of the steady state.
    - `orders`: names of the orders; default all.

    **Raises:** `ValueError` for a stage or an order that does not exist; `MissingDataError` if the
    mechanism lacks data.
    """
    if harmonics < 1:
        raise ValueError(f"harmonics is {harmonics}; give at least 1")
    chosen = stage_at(mechanism, stage)
    ratio = working_carrier_ratio(mechanism, stage) if carrier_ratio is None else carrier_ratio
    ratio = jnp.asarray(ratio, chosen.thread.lead.dtype)
    known = excitation_orders(chosen, ratio)
    if orders is not None:
        known = tuple(find_order(known, name) for name in orders)
    system = stage_system(mechanism, stage, load)
    return Campbell(
        # Without symmetry the family of a mode follows from its shape.
        stage_modes(system, shapes=not system.symmetric),
        known,
        ratio,
        harmonics,
        plain(system.roller_count),
        system.symmetric,
    )
