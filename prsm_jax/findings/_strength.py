"""Findings on strength and life: dents, fatigue, buckling, whirling, false brinelling, play."""

import functools
from collections.abc import Callable, Iterator

import equinox as eqx
import jax.numpy as jnp

from .. import strength
from .._errors import MissingDataError
from ..geometry import Finding
from ..mechanism import Mechanism, Stage
from ..quantities import (
    Analysis,
    dynamic_capacity_of,
    minimum_amplitude_of,
    static_safety_of,
)
from ._agreement import agreement_findings

#: What catalogues of ball screws ask for against buckling.
_BUCKLING_SAFETY = 2.0


def _life(analysis: Analysis, index: int, stage: Stage):
    capacity = dynamic_capacity_of(analysis, index, stage)
    life = strength.rating_life(stage, capacity, analysis.spectrum).time
    factor = strength.life_factor(stage)
    return life if factor is None else life * factor


def _buckling_safety(analysis: Analysis, _: int, stage: Stage):
    return strength.static_safety(strength.buckling_load(stage), analysis.demand[1])


def _speeds(analysis: Analysis, _: int, stage: Stage):
    limits = strength.permissible_speed(stage), strength.critical_speed(stage)
    return jnp.stack([analysis.demand[0], *limits])


def _backlash(analysis: Analysis, index: int, stage: Stage):
    return strength.backlash(stage, analysis.kinematics[index].meshing)


def _asked_for(stage: Stage) -> dict[str, Callable]:
    """The numbers that findings look at, as far as the file says what to compare them with."""
    data = stage.strength
    asked: dict[str, Callable] = {}
    if data is None:
        return asked
    if data.permissible_pressure is not None or data.static_capacity is not None:
        asked["static_safety"] = static_safety_of
    if data.required_life is not None:
        asked["life"] = _life
    if data.oscillation_amplitude is not None:
        asked["oscillation"] = minimum_amplitude_of
    if data.shaft is not None:
        asked |= {"buckling": _buckling_safety, "speed": _speeds}
    if strength.needs_meshing_for_backlash(stage):
        asked["backlash"] = _backlash
    return asked


@functools.cache
def _compiled():
    @eqx.filter_jit
    def numbers(mechanism: Mechanism):
        analysis, found = Analysis(mechanism), []
        for index, stage in enumerate(mechanism.stages):
            known = {}
            for name, function in _asked_for(stage).items():
                try:
                    known[name] = function(analysis, index, stage)
                except MissingDataError:
                    continue
            found.append(known)
        return found

    return numbers


def _check(stage: Stage, known: dict, number: int) -> Iterator[Finding]:
    safety = float(known.get("static_safety", jnp.inf))
    if safety < 1:
        yield Finding(
            "static_safety",
            "error",
            number,
            safety,
            1.0,
            f"the largest load is {1 / safety:.3g} times the static capacity: it leaves dents in "
            "the threads that roughen the motion; add engaged threads or rollers, or lower the "
            "load",
        )
    safety = float(known.get("buckling", jnp.inf))
    if safety < _BUCKLING_SAFETY:
        yield Finding(
            "buckling",
            "error" if safety < 1 else "warning",
            number,
            safety,
            _BUCKLING_SAFETY,
            f"the buckling load of the screw is {safety:.3g} times the largest load, and should be "
            f"{_BUCKLING_SAFETY:.3g} times: shorten the loaded length, fix the ends, or take a "
            "larger screw",
        )
    if "speed" in known:
        speed, permissible, critical = (float(value) for value in known["speed"])
        yield from _check_speed(speed, permissible, critical, number)
    if "life" in known and stage.strength is not None:
        asked = float(stage.strength.required_life)  # pyright: ignore[reportArgumentType]
        life = float(known["life"])
        if life < asked:
            yield Finding(
                "rating_life",
                "warning",
                number,
                life,
                asked,
                f"the rating life is {life / 3600:.4g} h, and {asked / 3600:.4g} h are asked for: "
                f"a dynamic capacity {(asked / life) ** (1 / 3):.3g} times as high would do (rests "
                "on the practice of ball screws and bearings)",
            )
    if "oscillation" in known and stage.strength is not None:
        amplitude = float(stage.strength.oscillation_amplitude)  # pyright: ignore[reportArgumentType]
        smallest = float(known["oscillation"])
        if amplitude < smallest:
            yield Finding(
                "false_brinelling",
                "warning",
                number,
                amplitude,
                smallest,
                f"the screw swings by {jnp.degrees(amplitude):.3g} deg to either side, and its "
                f"contacts leave their own ellipse only from {jnp.degrees(smallest):.3g} deg on: "
                "they wear in place, which no rating life covers; turn it further from time to "
                "time",
            )
    if "backlash" in known and float(known["backlash"]) < 0:
        play = float(known["backlash"])
        yield Finding(
            "backlash",
            "error",
            number,
            play,
            0.0,
            f"the teeth of screw, rollers and nut interfere by {-play * 1e3:.4g} mm together: thin "
            "them further, or give the preload that this is meant to make",
        )


def _check_speed(
    speed: float, permissible: float, critical: float, number: int
) -> Iterator[Finding]:
    if speed <= permissible:
        return
    past = speed > critical
    what = "its critical speed" if past else "the permissible speed"
    yield Finding(
        "screw_speed",
        "error" if past else "warning",
        number,
        speed,
        permissible,
        f"the screw turns at {speed * 30 / jnp.pi:.5g} rpm, above {what} of "
        f"{(critical if past else permissible) * 30 / jnp.pi:.5g} rpm: shorten the unsupported "
        "length, fix the ends, or take a larger lead",
    )


def strength_findings(mechanism: Mechanism) -> tuple[Finding, ...]:
    """Loads, speeds and lives that the strength data do not bear.

    `static_safety`: threads are dented. `rating_life`: shorter than asked for. `buckling`,
    `screw_speed`: the screw as a column and as a shaft. `false_brinelling`: it swings too little.
    `backlash`: there is less than none. `preload`, `engaged_threads`, `axial_backlash`: strength
    and load sharing have two numbers for one thing. Of what lacks data nothing is found.

    **Arguments:**

    - `mechanism`: the mechanism, with concrete numbers.
    """
    asked = any(_asked_for(stage) for stage in mechanism.stages)
    numbers = _compiled()(mechanism) if asked else [{} for _ in mechanism.stages]
    found = []
    for number, (stage, known) in enumerate(zip(mechanism.stages, numbers, strict=True), start=1):
        found += _check(stage, known, number)
        found += agreement_findings(stage, number, known.get("backlash"))
    return tuple(found)
