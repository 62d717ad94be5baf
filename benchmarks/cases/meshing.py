"""Meshing: where screw and roller touch, by several formulations, against SciPy's hybr."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import mpmath
import numpy as np

from prsm_jax.geometry import flanks_of, mesh
from prsm_jax.geometry._flanks import screw_side_gap
from prsm_jax.geometry._meshing import contact_point, starting_slope
from prsm_jax.mechanism import Thread

from ..harness import Case, Kind, Method, Prepared, Problem, Reference, rival
from ..references.designs import Designs, random_designs, rows, threads
from ..references.meshing import DIGITS, Design, mesh_point

_LABELS = ("contact radius on the screw", "angular position on the roller")
_Positions = tuple[jax.Array, jax.Array]


def _named(radius, angle) -> dict[str, Any]:
    return dict(zip(_LABELS, (radius, np.abs(angle)), strict=True))


def _batched(
    name: str, designs: Designs, solve: Callable[..., object], *,
    first: Callable[..., Any] = lambda out: out,
    settings=(None,), setting_name: str = "", kind: Kind = "method", dtype=jnp.float64,
    one: bool = False,
) -> Method:  # fmt: skip
    """A method that solves one thread, vmapped and jitted, with the setting traced."""
    jitted = jax.jit(lambda batch, *setting: jax.vmap(lambda t: solve(t, *setting))(batch))

    def prepare(setting):
        batch = threads(designs, dtype)
        if one:
            batch = jax.tree.map(lambda leaf: leaf[:1], batch)
        arguments = () if setting is None else (setting,)
        return Prepared(
            lambda: jitted(batch, *arguments),
            1 if one else len(designs.lead),
            lambda out: _named(*first(out)),
        )

    return Method(name, prepare, settings, setting_name, kind)


def _positions(contact) -> _Positions:
    return contact.contact_radius, contact.roller_angle_position


def _starting_angles(thread: Thread) -> _Positions:
    """Small-angle estimate of the contact positions on screw and roller (magnitudes) [rad].

    φ_s ≈ (tan λ_s + tan λ_R) / (tan α (1 + r_s/r_R)), φ_R = φ_s r_s/r_R; one to two per cent high.
    """
    flanks = flanks_of(thread)
    helix_slopes = flanks.reduced_lead * (1 / flanks.screw_radius + 1 / flanks.nut_radius)
    ratio = flanks.screw_radius / thread.roller_radius
    screw_angle = helix_slopes / (flanks.slope * (1 + ratio))
    return screw_angle, screw_angle * ratio


def _second_order(thread: Thread) -> _Positions:
    """The package's starting point: no root search."""
    flanks = flanks_of(thread)
    triangle, x, y = contact_point(flanks, starting_slope(flanks))
    return triangle.screw_radius, jnp.arctan2(y, flanks.centre_distance - x)


def _by_sine_rule(thread: Thread, screw_angle, roller_angle) -> _Positions:
    total = jnp.sin(screw_angle + roller_angle)
    return thread.centre_distance * jnp.sin(roller_angle) / total, roller_angle


def _newton(residual, start, steps):
    """Newton on two unknowns with a fixed number of steps, the 2×2 system by Cramer's rule."""

    def advance(_, unknown):
        value, ((a, b), (c, d)) = residual(unknown), jax.jacfwd(residual)(unknown)
        step = jnp.stack([d * value[0] - b * value[1], a * value[1] - c * value[0]])
        return unknown - step / (a * d - b * c)

    return jax.lax.fori_loop(0, steps, advance, start)


def _cartesian(thread: Thread, steps) -> _Positions:
    """Equal gradients in (x, y): two unknowns, a fixed number of steps."""
    flanks, centre = flanks_of(thread), thread.centre_distance
    angle, _ = _starting_angles(thread)
    start = thread.screw_radius * jnp.stack([jnp.cos(angle), -jnp.sin(angle)])
    gap = jax.grad(lambda p: screw_side_gap(flanks, p[0], p[1]))
    x, y = _newton(gap, start, steps)
    return jnp.hypot(x, y), jnp.arctan2(y, centre - x)


def _two_angles(thread: Thread, steps) -> _Positions:
    """The equivalent form in the two angular positions, as in the papers.

    `φ_s + φ_R = atan(tan λ_s/tan α) + atan(tan λ_R/tan α_R)` and
    `tan²α + tan²λ_s = tan²α_R + tan²λ_R`, with helix and flank angles at the contact radii.
    """
    slope = jnp.tan(thread.flank_angle)
    profile = thread.profile_radius

    def residual(angles):
        total = jnp.sin(angles[0] + angles[1])
        screw_radius = thread.centre_distance * jnp.sin(angles[1]) / total
        roller_radius = thread.centre_distance * jnp.sin(angles[0]) / total
        screw_helix = thread.lead / (2 * jnp.pi * screw_radius)
        roller_helix = thread.pitch / (2 * jnp.pi * roller_radius)
        offset = roller_radius - thread.roller_radius + profile * jnp.sin(thread.flank_angle)
        arc = offset / jnp.sqrt(profile**2 - offset**2)
        across = jnp.arctan(screw_helix / slope) + jnp.arctan(roller_helix / arc)
        return jnp.stack(
            [
                angles[0] + angles[1] - across,
                slope**2 + screw_helix**2 - arc**2 - roller_helix**2,
            ]
        )

    return _by_sine_rule(thread, *_newton(residual, jnp.stack(_starting_angles(thread)), steps))


def _hybr(designs: Designs, count: int) -> Method:
    """SciPy's Powell hybrid method in a loop over designs, the residual in plain Python."""
    from math import atan2, hypot

    from ..references.flanks import contact_point, flanks_of

    def solve(design: Design):
        flanks = flanks_of(
            design.lead,
            design.contact_angle,
            design.roller_radius,
            design.starts,
            design.profile_radius,
        )
        x, y = contact_point(flanks)
        return hypot(x, y), atan2(y, flanks.centre - x)

    some = rows(designs, count)

    def call():
        return np.array([solve(design) for design in some])

    return rival("SciPy root (hybr)", call, count, lambda out: _named(*out.T))


def case(quick: bool) -> Case:
    """The case of this module."""
    designs = random_designs(20_000 if quick else 100_000)
    compared = 40 if quick else 200

    def position(thread: Thread) -> _Positions:
        return _positions(mesh(thread).screw)

    alone = "mesh, position only"
    steps: dict[str, Any] = {"settings": (1, 2, 3, 4, 5), "setting_name": "Newton steps"}

    def reference():
        with mpmath.workdps(DIGITS):
            points = [mesh_point(design) for design in rows(designs, compared)]
        return {
            _LABELS[0]: Reference(np.array([float(p.screw_radius) for p in points])),
            _LABELS[1]: Reference(np.array([float(abs(p.roller_angle)) for p in points])),
        }

    problem = Problem(
        name="contact_point",
        title="Meshing of screw and roller, random designs",
        instance="design",
        methods=[
            _batched(
                "mesh, all of it (normals, curvatures)",
                designs,
                mesh,
                first=lambda out: _positions(out.screw),
            ),
            _batched(alone, designs, position),
            _batched(f"{alone}, float32", designs, position, dtype=jnp.float32),
            _batched(f"{alone}, one design", designs, position, one=True),
            _batched("(x, y) form", designs, _cartesian, **steps),
            _batched("two-angle form", designs, _two_angles, **steps),
            _batched(
                "small-angle closed form",
                designs,
                lambda t: _by_sine_rule(t, *_starting_angles(t)),
                kind="approximation",
            ),
            _batched("second-order closed form", designs, _second_order, kind="approximation"),
            _hybr(designs, 50 if quick else 200),
        ],
        reference=reference,
        reference_note=f"mpmath findroot at {DIGITS} digits, {compared} designs",
        baseline="SciPy root (hybr)",
    )
    return Case("meshing", "Contact points of screw and roller: formulations and SciPy", [problem])
