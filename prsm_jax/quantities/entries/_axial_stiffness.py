"""Axial stiffnesses, named by their elastic parts and by secant or tangent.

A secant is F/x, the load over the travel that it causes; a tangent is dF/dx, for a small additional
load. Contacts stiffen with load, so without preload the tangent is larger: 3/2 of the secant for
Hertz point contacts. Each group includes more elastic parts than the one before: contacts, nut,
axis.
"""

import functools
from collections.abc import Callable

from ... import strength
from ...fields import Scalar
from ...load_sharing import secant_or_tangent
from ...mechanism import Stage
from ...stiffness import ThreadStiffness, axial_stiffness as stage_axial_stiffness, in_series
from .._analysis import Analysis, SharedLoad
from .._catalogue import quantity
from .._nut_travel import elastic_of, nut_tangent_of

_CONTACTS = (
    "of the thread contacts, and of their teeth where [stage.load_sharing.tooth] is given; shafts "
    "rigid, all stages in series; with [stage.load_sharing] each thread at its own load, else all "
    "threads at the same load"
)
_NUT = (
    "of the nut: contacts, teeth, and the segments of screw, rollers and nut between the threads, "
    "all stages in series"
)
_AXIS = (
    "of the whole axis: the nut, the screw's shaft over its loaded length, and the supports of "
    "screw and nut whose axial_stiffness is given, all stages in series"
)


def _of_contacts(analysis: Analysis, threads: tuple[ThreadStiffness, ...]) -> Scalar:
    pairs = zip(analysis.mechanism.stages, threads, strict=True)
    stages = [stage_axial_stiffness(stage, one) for stage, one in pairs]
    return functools.reduce(in_series, stages)


def _contact_secant(analysis: Analysis):
    return _of_contacts(analysis, analysis.threads)


def _contact_tangent(analysis: Analysis):
    return _of_contacts(analysis, analysis.tangent_threads)


def _nut_secant(analysis: Analysis, index: int) -> Scalar:
    elastic = elastic_of(analysis, index)
    sharing = analysis.mechanism.stages[index].load_sharing
    if sharing is None or not sharing.has_reverse_flanks:
        return elastic.secant_stiffness
    travel = analysis.distribution(index).deflection
    return secant_or_tangent(elastic, travel, nut_tangent_of(analysis, index))


def _nut_secants(analysis: Analysis) -> list[Scalar]:
    return [_nut_secant(analysis, index) for index in range(len(analysis.mechanism.stages))]


def _nut_tangents(analysis: Analysis) -> list[Scalar]:
    return [nut_tangent_of(analysis, i) for i in range(len(analysis.mechanism.stages))]


def _with_shaft(stage: Stage, nut: Scalar) -> Scalar:
    parts = [nut, strength.shaft_axial_stiffness(stage)]
    for body in (stage.screw, stage.nut):
        if body.support is not None and body.support.axial_stiffness is not None:
            parts.append(body.support.axial_stiffness)
    return functools.reduce(in_series, parts)


def _of_nut(nuts: Callable[[Analysis], list[Scalar]]) -> Callable[[Analysis], Scalar]:
    return lambda analysis: functools.reduce(in_series, nuts(analysis))


def _of_axis(nuts: Callable[[Analysis], list[Scalar]]) -> Callable[[Analysis], Scalar]:
    def axis(analysis: Analysis) -> Scalar:
        pairs = zip(analysis.mechanism.stages, nuts(analysis), strict=True)
        return functools.reduce(in_series, [_with_shaft(stage, nut) for stage, nut in pairs])

    return axis


_LOADED: tuple[SharedLoad, ...] = ("operating_point",)
#: The secant of a nut is measured from the position of the unloaded nut.
_FROM_REST: tuple[SharedLoad, ...] = ("operating_point", "none")


def _declare(
    name: str,
    symbol: str,
    description: str,
    function,
    assumes: tuple[str, ...] = (),
    shares: tuple[SharedLoad, ...] = _LOADED,
) -> None:
    quantity(name, symbol, "N/m", description, assumes=assumes, shares=shares)(function)


_EQUAL = ("equal_stiffness", "stiffness_without_preload")
_SECANT = (*_EQUAL, "secant_of_both_flanks")
_SHARED = ("shared_without_preload",)
_declare(
    "contact_axial_stiffness_secant", "K_c", f"secant F/x {_CONTACTS}", _contact_secant, _SECANT
)
_declare(
    "contact_axial_stiffness_tangent",
    "K_c,t",
    f"tangent dF/dx {_CONTACTS}",
    _contact_tangent,
    _EQUAL,
)
for _name, _symbol, _what, _stiffness in (
    ("nut", "K_n", _NUT, _of_nut),
    ("axis", "K_x", _AXIS, _of_axis),
):
    _declare(
        f"{_name}_axial_stiffness_secant",
        _symbol,
        f"secant F/x {_what}; x from the position of the unloaded nut",
        _stiffness(_nut_secants),
        _SHARED,
        _FROM_REST,
    )
    _declare(
        f"{_name}_axial_stiffness_tangent",
        f"{_symbol},t",
        f"tangent dF/dx {_what}",
        _stiffness(_nut_tangents),
        _SHARED,
    )

# Former names.
_declare(
    "axial_stiffness",
    "K_a",
    f"another name of contact_axial_stiffness_secant: secant F/x {_CONTACTS}",
    _contact_secant,
    _SECANT,
)
_declare(
    "axial_stiffness_shared",
    "K_ax",
    f"another name of nut_axial_stiffness_tangent: tangent dF/dx {_NUT}",
    _of_nut(_nut_tangents),
    _SHARED,
)
