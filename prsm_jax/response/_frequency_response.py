"""Frequency response functions between two degrees of freedom of one stage."""

from collections.abc import Sequence
from typing import Annotated, Literal, TypeAlias

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float

from ..fields import In, Scalar, listed_numbers
from ..mechanism import DampingLaw, Mechanism, of_one_design, stage_at
from ..programs import one_program
from ..results import DesignResult, lines_of
from ..text import Line
from ..vibration import VibrationSystem, spring_network, stage_system
from ._dissipation import AnyDamping, AsGiven, checked_damping, stage_damping
from ._receptance import Solver, infinite, magnitude, receptance_matrix

#: Displacement, velocity or acceleration per force.
Kind: TypeAlias = Literal["receptance", "mobility", "accelerance"]
#: Power of iω that goes with each kind, and its unit.
KINDS: dict[Kind, tuple[int, str]] = {
    "receptance": (0, "m/N"),
    "mobility": (1, "m/(N·s)"),
    "accelerance": (2, "m/(N·s²)"),
}


class FrequencyResponse(DesignResult):
    """Complex amplitude at one degree of freedom per unit force at another.

    For a rotation the force is the torque over the nominal radius, and the displacement is
    `u = r θ`.
    """

    #: [Hz].
    frequency: Annotated[Float[Array, " frequencies"], In("Hz")]
    #: In the unit of `kind`; infinite at a pole, NaN at a frequency that is not a number. At an
    #: undamped natural frequency whose modes do not connect both places: the limit.
    value: Complex[Array, " frequencies"]
    #: Whether the response has a pole there: the mode takes part at both places, without damping,
    #: and no steady amplitude exists.
    at_pole: Bool[Array, " frequencies"]
    excitation: str = eqx.field(static=True)
    response: str = eqx.field(static=True)
    kind: Kind = eqx.field(static=True)

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of a batch of responses; empty for a single design."""
        return self.frequency.shape[:-1]

    @property
    def unit(self) -> str:
        """SI unit of `value`."""
        return KINDS[self.kind][1]

    def lines(self) -> list[Line]:
        """What `print` shows."""
        size = np.abs(np.asarray(self.value))
        lines = [
            Line("force at", self.excitation),
            Line(f"{self.kind} of", self.response),
            *lines_of(self),
            Line("magnitude", size, self.unit),
        ]
        if not self.batch_shape:
            peak = np.argmax(size)
            lines.append(Line("largest at", np.asarray(self.frequency)[peak], "Hz"))
        return [*lines, Line("driven at a pole", self.at_pole)]

    @property
    def magnitude(self) -> Float[Array, "*batch frequencies"]:
        """Absolute value; its derivative is 0 where the response is 0."""
        return magnitude(self.value)

    @property
    def decibel(self) -> Float[Array, "*batch frequencies"]:
        """20 lg of the magnitude over one SI unit [dB re 1 m/N, for a receptance]."""
        return 20 * jnp.log10(self.magnitude)

    @property
    def phase(self) -> Float[Array, "*batch frequencies"]:
        """Phase of the response against the force, from −π to π [rad]."""
        # An undamped response is in phase or in antiphase; the sign of a zero does not matter.
        turned = (self.value.imag != 0) & ~self.at_pole
        angle = jnp.angle(jnp.where(turned, self.value, jnp.ones_like(self.value)))
        against = (self.value.real < 0) & ~turned
        return jnp.where(against, jnp.pi, angle)


def apart_by_symmetry(system: VibrationSystem, first: str, second: str) -> bool:
    """Whether, from symmetry alone, a force at one coordinate cannot move another.

    In a symmetric stage rotations and translations of the bodies on the axis belong to different
    families of modes; and the carrier vibrates on its own if rollers only rotate.
    """
    if first == second:
        return False
    (one, along), (other, across) = first.rsplit(" ", 1), second.rsplit(" ", 1)
    if system.translation is None and "carrier" in (one, other):
        return True
    on_axis = not any(body.startswith("roller") for body in (one, other))
    if not (system.symmetric and on_axis):
        return False
    # Where rollers translate, oblique contacts turn a force along x into a motion along y.
    alike = along == across or (system.translation is not None and "u" not in (along, across))
    return not alike


@of_one_design
def frequency_response(
    mechanism: Mechanism,
    excitation: str,
    response: str,
    frequency: float | Float[Array | np.ndarray, " frequencies"] | Sequence[float],
    *,
    stage: int = 1,
    load: float | Scalar | None = None,
    damping: AnyDamping | AsGiven | None = "given",
    kind: Kind = "receptance",
    method: Solver = "direct",
) -> FrequencyResponse:
    """Response of one degree of freedom to a harmonic force at another.

    Jittable, differentiable with respect to the mechanism and the frequencies, and vmappable.

    **Arguments:**

    - `mechanism`: the mechanism; as for `modal`.
    - `excitation`, `response`: degrees of freedom, such as `"screw u"`, `"nut x"`, `"roller 3 u"`:
      x, y and `u = r θ` of screw, ring_gear and nut, u of each roller (also radial and tangential
      where rollers translate) and of the carrier.
    - `frequency`: frequencies of the force, or one frequency [Hz].
    - `stage`: which stage, counted from 1.
    - `load`: axial load at which the contact stiffness is taken [N]; default that of the
      operating point.
    - `damping`: default that of the mechanism (`stage.damping`; undamped without it); or a law, a
      viscous damping matrix, a `Dissipation`, or `None`.
    - `kind`: `"receptance"`, `"mobility"` or `"accelerance"`.
    - `method`: `"direct"` (any damping) or `"modal"` (a law of damping).

    **Raises:** `ValueError` for an unknown name, kind or method, a frequency that is not finite, or
    damping that does not fit; `MissingDataError` if the mechanism lacks data.
    """
    if kind not in KINDS:
        raise ValueError(f"kind is {kind!r}; choose one of {', '.join(KINDS)}")
    return _response(
        mechanism,
        excitation,
        response,
        listed_numbers("frequency", frequency, "frequencies", "Hz"),
        load,
        stage=stage,
        damping=checked_damping(damping),
        kind=kind,
        method=method,
    )


@one_program
def _response(
    mechanism: Mechanism,
    excitation: str,
    response: str,
    hertz: Float[Array, " frequencies"],
    load: float | Scalar | None,
    *,
    stage: int,
    damping: AnyDamping | AsGiven | None,
    kind: Kind,
    method: Solver,
) -> FrequencyResponse:
    system = stage_system(mechanism, stage, load)
    network = spring_network(system)
    hertz = hertz.astype(network.mass.dtype)
    omega = 2 * jnp.pi * hertz
    chosen = stage_damping(stage_at(mechanism, stage), damping)
    receptances, at_pole = receptance_matrix(
        network, omega, (response,), (excitation,), chosen, method
    )
    value = receptances[:, 0, 0]
    # A law of damping does not couple the families; any other matrix may.
    has_law = chosen is None or isinstance(chosen, DampingLaw)
    if has_law and apart_by_symmetry(system, excitation, response):
        # 0 at a number, NaN elsewhere.
        value, at_pole = (0 * hertz).astype(value.dtype), jnp.zeros_like(at_pole)
    power = KINDS[kind][0]
    if power:
        factor = jnp.asarray(1j**power, value.dtype) * (omega**power).astype(value.dtype)
        # Infinity is set last: i times infinity is not a number.
        value = infinite(factor * jnp.where(at_pole, jnp.ones_like(value), value), at_pole)
    return FrequencyResponse(hertz, value, at_pole, excitation, response, kind)
