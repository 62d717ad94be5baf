"""Mode shapes of the whole stage from the small shapes of each harmonic."""

import jax.numpy as jnp
from jaxtyping import Array, Float, Inexact

from ._assembly import coordinates
from ._spring_network import Coordinate
from ._system import VibrationSystem


def harmonic_shapes(
    system: VibrationSystem,
    harmonic: int,
    amplitudes: dict[Coordinate, Inexact[Array, " modes"]],
) -> Float[Array, "coordinates modes multiplicity"]:
    """Displacements of all degrees of freedom of a symmetric system; see `expanded_shapes`."""
    return expanded_shapes(coordinates(system), system.roller_positions, harmonic, amplitudes)


def expanded_shapes(
    degrees: tuple[Coordinate, ...],
    position: Float[Array, " rollers"],
    harmonic: int,
    amplitudes: dict[Coordinate, Inexact[Array, " modes"]],
) -> Float[Array, "coordinates modes multiplicity"]:
    """Displacements of all degrees of freedom for amplitudes of one harmonic.

    The inverse of the transformation of `harmonic_network`. From harmonic 1 on every complex
    shape gives two real ones, at one instant and a quarter period later, which are M-orthogonal.
    From 2 on each harmonic up to N/2 has such a pair (the one at N/2 is single).

    **Arguments:**

    - `degrees`: all degrees of freedom.
    - `position`: angle of each roller around the screw [rad].
    - `harmonic`: 0, 1, or 2 for all higher ones.
    - `amplitudes`: by the coordinates of the harmonic network.
    """
    count = len(position)
    modes = next(iter(amplitudes.values())).shape[-1]
    dtype = position.dtype

    def patterns() -> Float[Array, "rollers multiplicity"]:
        if harmonic == 0:
            return jnp.full((count, 1), count**-0.5, dtype)
        columns = []
        for order in range(2, count // 2 + 1):
            if 2 * order == count:
                columns.append(jnp.cos(order * position) / count**0.5)
            else:
                columns += [
                    wave(order * position) * (2 / count) ** 0.5 for wave in (jnp.cos, jnp.sin)
                ]
        return jnp.stack(columns, axis=1)

    def pair(amplitude) -> list[tuple[Array, Array]]:
        """Real and imaginary part, now and a quarter period later (times i)."""
        real, imaginary = jnp.real(amplitude), jnp.imag(amplitude)
        return [(real, imaginary), (-imaginary, real)]

    def of_roller(amplitude) -> Float[Array, "rollers modes multiplicity"]:
        if harmonic == 1:
            size = (2 / count) ** 0.5
            cosine, sine = size * jnp.cos(position)[:, None], size * jnp.sin(position)[:, None]
            parts = [cosine * a[None, :] - sine * b[None, :] for a, b in pair(amplitude)]
            return jnp.stack(parts, axis=-1)
        return jnp.real(amplitude)[None, :, None] * patterns()[:, None, :]

    def of_body(body: str, direction: str) -> Float[Array, "modes multiplicity"] | None:
        if harmonic == 0 and Coordinate(body, direction) in amplitudes:
            return jnp.real(amplitudes[Coordinate(body, direction)])[:, None]
        kind, at = direction[:-1], direction[-1]
        whole = Coordinate(body, f"{kind}w")
        if harmonic == 1 and at in ("x", "y") and whole in amplitudes:
            # w = i (x − i y), so x is the imaginary part of w and y the real one.
            which = int(at == "x")
            parts = [parts[which] for parts in pair(amplitudes[whole])]
            return jnp.stack(parts, axis=-1)
        return None

    rows: list[Array] = []
    rollers = {}
    multiplicity = count - 3 if harmonic == 2 else harmonic + 1
    for coordinate in degrees:
        if coordinate.body.startswith("roller "):
            direction = coordinate.direction
            if direction not in rollers:
                rollers[direction] = iter(of_roller(amplitudes[Coordinate("roller", direction)]))
            rows.append(next(rollers[direction]))
            continue
        row = of_body(coordinate.body, coordinate.direction)
        rows.append(jnp.zeros((modes, multiplicity), dtype) if row is None else row)
    return jnp.stack(rows)


def carrier_shape(system: VibrationSystem) -> Float[Array, "coordinates 1 1"]:
    """The carrier alone."""
    carrier = system.carrier
    assert carrier is not None
    zeros = jnp.zeros((len(coordinates(system)) - 1,), carrier.equivalent_mass.dtype)
    return jnp.append(zeros, carrier.equivalent_mass**-0.5)[:, None, None]
