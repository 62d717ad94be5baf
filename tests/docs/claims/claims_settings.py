"""Claims on settings and constants: limits of findings, defaults, points of a rule, exit status."""

import functools
import inspect

import jax
import jax.numpy as jnp
import mpmath
import numpy as np

from prsm_jax.cli.verbs import _modal
from prsm_jax.contact import EllipseShape, _edge_pressure, slip_and_spin
from prsm_jax.contact.special_functions import _elliptic
from prsm_jax.dynamics.friction import _rubbing
from prsm_jax.findings import _locking, _masses, _preferred, _stiffness
from prsm_jax.optimisation.results._rounding import rounded_variables
from prsm_jax.scenario import Scenario, TorqueScenario, _sequences
from tests.docs.claims import Claim

COMMANDS, FILES, FINDINGS = "docs/command_line.md", "docs/files.md", "docs/findings.md"
FRICTION, MODEL, STRENGTH = "docs/friction.md", "docs/model.md", "docs/strength.md"


def _default(function, name: str):
    return lambda: [inspect.signature(function).parameters[name].default]


@functools.cache
def _law(order: int):
    def law(ratio, angle, spin):
        one = jnp.ones_like(ratio)
        shape = EllipseShape(ratio**2, one, 0.0 * one, ratio)
        force, moment = slip_and_spin(shape, (jnp.cos(angle), jnp.sin(angle)), spin, order)
        return jnp.stack([*force, moment / ratio])

    return jax.jit(jax.vmap(law))


def _rule(order: int, longest: float) -> float:
    """Largest relative change of force and moment if there are four times as many points.

    The point without slip lies inside the ellipse, next to its edge, or outside.
    """
    count, random = 6000, np.random.default_rng(20)
    ratio = longest ** random.uniform(0, 1, count)
    ratio[::10] = longest
    angle = random.uniform(0, 2 * np.pi, count)
    third = count // 3
    edge = 1 + random.choice([-1, 1], third) * 10 ** random.uniform(-6, -1, third)
    away = np.concatenate([random.uniform(0, 1, third), edge, 10 ** random.uniform(0, 3, third)])
    random.shuffle(away)
    spin = np.hypot(np.cos(angle), np.sin(angle) / ratio) / away
    cases = [jnp.asarray(one) for one in (ratio, angle, spin)]
    few, many = (np.asarray(_law(points)(*cases)) for points in (order, 4 * order))
    force = np.hypot(*(few - many)[:, :2].T) / np.hypot(*many[:, :2].T)
    return float(max(np.max(force), np.max(np.abs(few / many - 1)[:, 2])))


def _elliptic_error() -> list[float]:
    """Largest relative error of B and D over 0 < m₁ ≤ 1, in exact arithmetic."""

    def value(coefficients, x):
        return sum(mpmath.mpf(one) * x**power for power, one in enumerate(coefficients))

    worst = 0.0
    with mpmath.workdps(40):
        for point in range(1, 201):
            x = (mpmath.mpf(point) / 200) ** 3
            first, second = mpmath.ellipk(1 - x), mpmath.ellipe(1 - x)
            d = (first - second) / (1 - x) if x < 1 else mpmath.pi / 4
            for exact, factor, regular, logarithmic in (
                (first - d, x, _elliptic._B_REGULAR, _elliptic._B_LOGARITHMIC),
                (d, 1, _elliptic._D_REGULAR, _elliptic._D_LOGARITHMIC),
            ):
                found = value(regular, x) - factor * mpmath.log(x) * value(logarithmic, x)
                worst = max(worst, abs(float(found / exact - 1)))
    return [worst]


CLAIMS = [
    Claim(FINDINGS, "differs by {} % or more from every lead", lambda: [100 * _preferred._SAME]),
    Claim(FINDINGS, "({} kg/m³ if no density is given)", lambda: [_masses._STEEL_DENSITY]),
    Claim(FINDINGS, "({} diameters if none is given)", lambda: [_stiffness._LONGEST]),
    Claim(FINDINGS, "by a factor of {} or more for every length", lambda: [_stiffness._SLACK]),
    Claim(FINDINGS, "or is within {} % of it (warning)", lambda: [100 * _locking._SCATTER]),
    Claim(FILES, "number of times in the result ({})", lambda: [Scenario.samples]),
    Claim(FILES, "stick and slip phases ({})", lambda: [TorqueScenario.most_phases]),
    Claim(FILES, "nested, at most {} deep", lambda: [_sequences._DEEPEST]),
    Claim(COMMANDS, "spans a factor of {} or more", lambda: [_modal._WIDE]),
    Claim(COMMANDS, "constraint below {}.", _default(rounded_variables, "tolerance")),
    Claim(STRENGTH, "\\Bigl(1 - {}\\,\\frac{\\sqrt{g/s}}", lambda: [_edge_pressure._DEPTH]),
    Claim(STRENGTH, "\\,(1 + {}/\\Lambda", lambda: [_edge_pressure._BLUNT]),
    Claim(STRENGTH, "\\Bigl(1 + {}\\,(g'/s)^2", lambda: [_edge_pressure._OPPOSITE]),
    Claim(FRICTION, "The dynamics use {} points", lambda: [_rubbing._ORDER]),
    Claim(FRICTION, "own default of {} points", _default(slip_and_spin, "order")),
    Claim(
        FRICTION,
        "accurate to {} up to $a/b = 5$ and to {} up to 10",
        lambda: [_rule(_rubbing._ORDER, 5.0), _rule(_rubbing._ORDER, 10.0)],
        rounded=False,
    ),
    Claim(
        FRICTION, "points is accurate to {} up to 50", lambda: [_rule(32, 50.0)],
        rounded=False,
    ),
    Claim(MODEL, "errors up to {})", _elliptic_error, rounded=False, least=0.5),
]  # fmt: skip
