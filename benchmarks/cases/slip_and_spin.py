"""Friction of ellipses that slide and spin: rules of several orders, closed forms, the old sum."""

import functools
import math
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax.contact import EllipseShape, complete_elliptic_integrals, slip_and_spin

from ..harness import Case, Kind, Method, Prepared, Problem, Reference, rival
from ..references.slip_and_spin import slip_and_spin as integrated

_LABELS = ("power lost", "force along the slip", "moment about the normal")


class _Motions(NamedTuple):
    """Ellipses with their motions, in the axes of each ellipse."""

    major: Any
    minor: Any
    along: Any
    across: Any
    spin: Any


def _motions(count: int, ratios: tuple[float, float], spins: tuple[float, float]) -> _Motions:
    """Axis ratios, and ω a/v, spread evenly in their logarithms; the slip has any direction."""
    random = np.random.default_rng(20_220_428)
    minor = random.uniform(1e-4, 4e-4, count)
    major = minor * np.exp(random.uniform(math.log(ratios[0]), math.log(ratios[1]), count))
    angle, speed = random.uniform(0, 2 * np.pi, count), random.uniform(0.01, 1.0, count)
    spin = np.exp(random.uniform(math.log(spins[0]), math.log(spins[1]), count)) * speed / major
    return _Motions(major, minor, speed * np.cos(angle), speed * np.sin(angle), spin)


def _named(found) -> dict[str, Any]:
    return dict(zip(_LABELS, found, strict=True))


def _numbers(motions: _Motions, force, moment):
    """Power and force along the slip per speed, and moment; all per μ F."""
    along, across, spin = motions.along, motions.across, motions.spin
    speed = (along**2 + across**2) ** 0.5
    pulled = (force[0] * along + force[1] * across) / speed
    return pulled + moment * spin / speed, pulled, moment


@functools.cache
def _rule(order: int):
    def one(motion):
        shape = EllipseShape(
            motion.major**2, motion.minor**2, 0 * motion.major, motion.major * motion.minor
        )
        slip = (motion.along, motion.across)
        return _numbers(motion, *slip_and_spin(shape, slip, motion.spin, order))

    return jax.jit(jax.vmap(one))


def _two_terms(motion: _Motions):
    """v + ω² ⟨x'²⟩/2v, which slow spin adds (its gradient, with the direction of slip)."""
    square = motion.along**2 + motion.across**2
    speed, first, second = jnp.sqrt(square), motion.major**2 / 5, motion.minor**2 / 5
    moments = first * motion.along**2 + second * motion.across**2
    scale = motion.spin**2 / (2 * square**2 * speed)
    force = (
        motion.along / speed + scale * motion.along * (2 * first * square - 3 * moments),
        motion.across / speed + scale * motion.across * (2 * second * square - 3 * moments),
    )
    return _numbers(motion, force, motion.spin * moments / (square * speed))


def _sum(motion: _Motions):
    """Full sliding and the full moment of pure spin, as in the first release."""
    speed = jnp.sqrt(motion.along**2 + motion.across**2)
    _, second = complete_elliptic_integrals(jnp.asarray(motion.minor / motion.major))
    force = motion.along / speed, motion.across / speed
    return _numbers(motion, force, 3 / 8 * motion.major * second)


def _ours(
    name: str, motions: _Motions, function, settings=(None,), kind: Kind = "method"
) -> Method:
    inputs = _Motions(*(jnp.asarray(column) for column in motions))

    def prepare(setting):
        call = function if setting is None else function(setting)
        return Prepared(lambda: call(inputs), len(motions.major), _named)

    return Method(name, prepare, settings, "points" if settings != (None,) else "", kind)


def _direct(motions: _Motions, count: int):
    """The reference's own integration over the ellipse, motion by motion."""
    some = _Motions(*(column[:count] for column in motions))
    rows = [
        integrated(major, minor, (along, across), spin)
        for major, minor, along, across, spin in zip(*some, strict=True)
    ]
    first, second, moment = np.array(rows).T
    return _numbers(some, (first, second), moment)


def _problem(name: str, title: str, ratios, spins, quick: bool) -> Problem:
    motions = _motions(2_000 if quick else 50_000, ratios, spins)
    compared = 30 if quick else 200

    def reference():
        return {label: Reference(x) for label, x in _named(_direct(motions, compared)).items()}

    direct = rival("direct integration (NumPy)", lambda: _direct(motions, 10), 10, _named)
    return Problem(
        name=name,
        title=title,
        instance="contact",
        methods=[
            _ours("rule", motions, _rule, (8, 12, 16, 24, 32)),
            _ours("two terms", motions, jax.jit(jax.vmap(_two_terms)), kind="approximation"),
            _ours("sum of both", motions, jax.jit(jax.vmap(_sum)), kind="approximation"),
            direct,
        ],
        reference=reference,
        reference_note=f"direct integration, 1500 × 80 points, {compared} contacts",
        baseline=direct.name,
        target=1e-6,
    )


def case(quick: bool) -> Case:
    """The case of this module."""
    return Case(
        "slip_and_spin",
        "Friction of ellipses that slide and spin at once: quadrature, closed forms, the old sum",
        [
            _problem(name, f"Slip and spin, {words}", ratios, spins, quick)
            for name, words, ratios, spins in (
                ("screws", "a/b 1 to 1.5, ω a/v 0.05 to 0.5 (screw side)", (1.0, 1.5), (0.05, 0.5)),
                ("flanks", "a/b 1 to 5, ω a/v 0.01 to 100", (1.0, 5.0), (0.01, 100.0)),
                ("wide", "a/b 1 to 50, ω a/v 0.01 to 100", (1.0, 50.0), (0.01, 100.0)),
            )
        ],
    )
