"""Friction of a Hertz ellipse that slides and spins, by direct integration over the ellipse.

In the plane in which the ellipse is a unit disc the local slip vanishes at one point and grows in
proportion to the distance from it along each ray. So the integral is taken in polar coordinates
about that point, ray by ray, with the pressure as it is.
"""

import itertools

import numpy as np


def slip_and_spin(
    semi_major: float, semi_minor: float, slip, spin: float, points: int = 1500
) -> tuple[float, float, float]:
    """Force per μ F along and across the major axis, and moment per μ F [m].

    `∫ p u/|u| dA / F` and `∫ p (r × u)/|u| dA / F` with `u = v + ω n × r` and Hertz's pressure,
    `p ∝ √(1 − x²/a² − y²/b²)`.

    **Arguments:**

    - `semi_major`, `semi_minor`: a and b [m].
    - `slip`: slip velocity along the major and the minor axis [m/s].
    - `spin`: angular velocity about the normal [rad/s].
    - `points`: of Gauss's rule over the rays, in each of eight parts, and fewer along them.
    """
    along, across = (float(part) for part in slip)
    if spin == 0:
        speed = np.hypot(along, across)
        return (along / speed, across / speed, 0.0)
    # u = ω (−b (η − η₀), a (ξ − ξ₀)).
    centre = np.array([-across / (spin * semi_major), along / (spin * semi_minor)])
    distance = np.hypot(*centre)
    nodes, weights = np.polynomial.legendre.leggauss(points // 8)
    inside = distance < 1
    limits = np.linspace(-np.pi, np.pi, 9) if inside else np.linspace(-np.pi / 2, np.pi / 2, 9)
    start = np.arctan2(-centre[1], -centre[0])
    turn = np.concatenate(
        [(b - a) / 2 * nodes + (a + b) / 2 for a, b in itertools.pairwise(limits)]
    )
    weight = np.concatenate([(b - a) / 2 * weights for a, b in itertools.pairwise(limits)])
    if not inside:
        # Rays that meet the disc, dense at the tangents, where chords end like a root.
        weight = weight * np.cos(turn) / np.sqrt(distance**2 - np.sin(turn) ** 2)
        angle = start + np.arcsin(np.sin(turn) / distance)
    else:
        angle, weight = _dense(turn, weight, semi_minor / semi_major)
    cosine, sine = np.cos(angle), np.sin(angle)
    closest = -(centre[0] * cosine + centre[1] * sine)
    chord = np.sqrt(np.maximum(1 - distance**2 + closest**2, 0.0))
    # The pressure ends like a root at the edge of the disc: at one end of a ray, or at both.
    radial, radial_weights = np.polynomial.legendre.leggauss(80)
    if inside:
        s, far = (radial + 1) / 2, closest + chord
        radius = far[:, None] * (1 - s**2)
        length = far[:, None] * s * radial_weights
    else:
        t = np.pi / 2 * radial
        radius = closest[:, None] + chord[:, None] * np.sin(t)
        length = chord[:, None] * np.cos(t) * np.pi / 2 * radial_weights
    first = centre[0] + radius * cosine[:, None]
    second = centre[1] + radius * sine[:, None]
    pressure = 3 / (2 * np.pi) * np.sqrt(np.maximum(1 - first**2 - second**2, 0.0))
    mass = pressure * radius * length * weight[:, None]
    # The direction of the slip is the same along a ray.
    u = np.sign(spin) * np.array([-semi_minor * sine, semi_major * cosine])
    u = u / np.hypot(*u)
    arm = semi_major * first * u[1][:, None] - semi_minor * second * u[0][:, None]
    return (
        float(np.sum(mass * u[0][:, None])),
        float(np.sum(mass * u[1][:, None])),
        float(np.sum(mass * arm)),
    )


def _dense(turn, weight, ratio):
    """Rays and weights, dense along the minor axis of a long ellipse, where the slip turns fast."""
    scale = 1 / np.sqrt(ratio)
    angle = np.arctan2(scale * np.sin(turn), np.cos(turn))
    return angle, weight * scale / (np.cos(turn) ** 2 + scale**2 * np.sin(turn) ** 2)
