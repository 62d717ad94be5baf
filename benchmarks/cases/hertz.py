"""Hertz contact: exact theory and closed-form approximations against root searches in SciPy."""

import functools
import math
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax.contact import APPROXIMATIONS, hertz_contact

from ..harness import Case, Method, Prepared, Problem, Reference, rival
from ..references.hertz import DIGITS, hertz

_MODULUS = 1.15e11
_LABELS = ("largest pressure p₀", "approach δ", "major semi-axis a", "minor semi-axis b")


class _Contacts(NamedTuple):
    force: np.ndarray
    #: A and B [1/m].
    smaller: np.ndarray
    larger: np.ndarray


def _contacts(count: int, ratios: tuple[float, float]) -> _Contacts:
    random = np.random.default_rng(20_220_427)
    # The first contacts, which the reference covers, are spread evenly and include the ends.
    low, high = np.log(ratios)
    ratio = np.exp(random.uniform(low, high, count))
    ratio[:2] = ratios
    smaller = random.uniform(50.0, 300.0, count)
    return _Contacts(random.uniform(1.0, 200.0, count), smaller, smaller * ratio)


def _named(*found) -> dict[str, Any]:
    return dict(zip(_LABELS, found, strict=True))


@functools.cache
def _jitted(method):
    def solve(force, total, difference_squared, modulus):
        result = hertz_contact(force, total, difference_squared, modulus, method)
        return result.max_pressure, result.approach, result.semi_major, result.semi_minor

    return jax.jit(jax.vmap(solve, in_axes=(0, 0, 0, None)))


def _ours(contacts: _Contacts, method: str, dtype, one: bool = False) -> Method:
    if one:
        contacts = _Contacts(*(column[:1] for column in contacts))

    def prepare(_):
        total = contacts.larger + contacts.smaller
        difference = contacts.larger - contacts.smaller
        inputs = [jnp.asarray(x, dtype) for x in (contacts.force, total, difference**2, _MODULUS)]
        return Prepared(
            lambda: _jitted(method)(*inputs), len(contacts.force), lambda out: _named(*out)
        )

    name = method if dtype == jnp.float64 else f"{method}, float32"
    name += ", one contact" if one else ""
    return Method(name, prepare, kind="method" if method == "exact" else "approximation")


def _finish(contacts, axis_ratio, k, e):
    force, smaller, larger = contacts
    major = np.cbrt(3 * force * e / (2 * np.pi * _MODULUS * axis_ratio**2 * (smaller + larger)))
    pressure = 3 * force / (2 * np.pi * axis_ratio * major**2)
    approach = pressure * axis_ratio * major * k / _MODULUS
    return pressure, approach, major, axis_ratio * major


def _residual(log_axis_ratio, target, library=np):
    from scipy.special import ellipe, ellipkm1

    square = library.exp(2 * log_axis_ratio)
    k, e = ellipkm1(square), ellipe(1 - square)
    return library.log((k - e) / (e / square - k)) - target


def _brentq(contacts: _Contacts, count: int) -> Method:
    """One root search per contact, as most published codes do it."""
    from scipy.optimize import brentq
    from scipy.special import ellipe, ellipkm1

    some = [column[:count].tolist() for column in contacts]

    def call():
        rows = []
        for force, smaller, larger in zip(*some, strict=True):
            target = math.log(smaller / larger)
            root = brentq(_residual, 1.2 * target, 0.4 * target, args=(target, math), xtol=1e-14)
            axis_ratio = math.exp(root)  # pyright: ignore[reportArgumentType]
            k, e = ellipkm1(axis_ratio**2), ellipe(1 - axis_ratio**2)
            rows.append(_finish(_Contacts(force, smaller, larger), axis_ratio, k, e))
        return np.array(rows).T

    return rival("SciPy brentq", call, count, lambda out: _named(*out))


def _elementwise(contacts: _Contacts) -> Method:
    """SciPy's vectorised bracketing search over the whole batch."""
    from scipy.optimize.elementwise import find_root
    from scipy.special import ellipe, ellipkm1

    def call():
        target = np.log(contacts.smaller / contacts.larger)
        found = find_root(_residual, (1.2 * target, 0.4 * target), args=(target,))
        axis_ratio = np.exp(found.x)
        k, e = ellipkm1(axis_ratio**2), ellipe(1 - axis_ratio**2)
        return _finish(contacts, axis_ratio, k, e)

    count = len(contacts.force)
    return rival("SciPy elementwise.find_root", call, count, lambda out: _named(*out))


def _problem(name: str, title: str, ratios: tuple[float, float], quick: bool) -> Problem:
    contacts = _contacts(20_000 if quick else 100_000, ratios)
    compared = 40 if quick else 200

    def reference():
        some = zip(*(column[:compared] for column in contacts), strict=True)
        rows = np.array([hertz(force, a, b, _MODULUS) for force, a, b in some])
        return {label: Reference(rows[:, i]) for i, label in enumerate(_LABELS)}

    return Problem(
        name=name,
        title=title,
        instance="contact",
        methods=[
            *(_ours(contacts, method, jnp.float64) for method in ("exact", *APPROXIMATIONS)),
            _ours(contacts, "exact", jnp.float32),
            _ours(contacts, "antoine", jnp.float32),
            _ours(contacts, "exact", jnp.float64, one=True),
            _brentq(contacts, 200 if quick else 500),
            _elementwise(contacts),
        ],
        reference=reference,
        reference_note=f"mpmath at {DIGITS} digits, {compared} contacts",
        baseline="SciPy brentq",
    )


def case(quick: bool) -> Case:
    """The case of this module."""
    return Case(
        "hertz",
        "Elliptical contacts, their pressure, approach and axes: exact, approximations, SciPy",
        [
            _problem("range", "Hertz contact, B/A 1.15 to 1.6 (roller screws)", (1.15, 1.6), quick),
            _problem("wide", "Hertz contact, B/A 1 to 1e4", (1.0 + 1e-6, 1e4), quick),
        ],
    )
