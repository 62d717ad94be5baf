"""Li et al. 2020: single stage with viscous friction, and statements of the text on the curves."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ...dynamics import free_carrier_ratio, ideal_carrier_ratio
from ...mechanism import get_parameter
from .._difference import differs
from .._examples import (
    kinematics,
    knees,
    scene,
    steady,
    steady_example,
    time_to_settle,
    transient,
    two_stages,
)
from .._newtons_equations import newtons_equations
from .._registry import rows_of
from .._row import Row, number, trend
from ._li_radii import radius_rows

_NAME, _VISCOUS = "li2020_two_stage", "li2020_single_stage_viscous"
_SPLINE, _BEARING = "spline.coefficient", "thrust_bearing.coefficient"
_SPLINES, _BEARINGS = (0.10, 0.15, 0.20), (0.005, 0.055, 0.105)


@rows_of("li2020")
def viscous_friction() -> Iterator[Row]:
    """Section 3.1, figure 8: Newton's law against the Lagrange model of Jones et al. 2016."""
    mechanism, run = scene(_VISCOUS)
    stage, geometry = mechanism.stages[0], kinematics(_VISCOUS)[0]
    solution = newtons_equations(_VISCOUS, 0)
    error = np.abs(solution.carrier_acceleration - run.carrier_acceleration[0])
    error = float(error.max() / np.abs(solution.carrier_acceleration).max())
    yield trend(
        "section 3.1: Newton's and Lagrange's forms give the same carrier speed",
        "nearly the same",
        f"accelerations differ by {error:.0e}",
        error < 1e-12,
        "equations 17, 18 and 28 (with the ring gear in 17, and the sign of Newton's law) solved "
        "for acceleration and forces along the solution of Lagrange's equation; relative to the "
        "largest",
    )
    carrier, coefficient, mass, spin = (
        float(get_parameter(mechanism, name))
        for name in ("carrier.inertia", "thread.coefficient", "roller.mass", "roller.inertia")
    )
    count, starts = stage.present_roller_count, float(stage.thread.starts)
    inertia = count * (spin * (starts - 1) ** 2 + mass * float(stage.thread.centre_distance) ** 2)
    inertia += 2 * carrier
    drive = np.asarray(geometry.drive)
    constant = inertia / (count * coefficient * drive @ drive)
    free = float(free_carrier_ratio(geometry))
    curve = np.asarray(run.carrier_ratio[0])
    deviation = float(np.max(np.abs(curve - free * -np.expm1(-run.time / constant))))
    yield trend(
        "figure 8: carrier ratio in time, one stage with viscous friction",
        "rises and settles",
        f"ζ∞ (1 − exp(−t/τ)) with τ = {1e3 * constant:.4f} ms, within {deviation:.0e}",
        deviation < 1e-5 and bool(np.all(np.diff(curve) > -1e-9)),
        "the equation is linear, so its solution is known; the rest is interpolation between the "
        "steps",
    )
    ratio = float(steady_example(_VISCOUS).carrier_ratio[0])
    ideal = float(ideal_carrier_ratio(stage.thread))
    coulomb = float(steady(_NAME).carrier_ratio[0])
    yield trend(
        "figure 8: the carrier settles slightly below the ratio of rolling without slip",
        "slightly below",
        f"{ratio:.6f} < {ideal:.6f}",
        0.99 * ideal < ratio < ideal,
        "no number is printed; viscous and Coulomb friction end at the same ratio, within "
        f"{abs(ratio / coulomb - 1):.0e}, because geometry alone decides it",
    )


@rows_of("li2020")
def radii() -> Iterator[Row]:
    """Sections 3.1 and 3.2: radii that follow from the roller's and the number of starts."""
    yield from radius_rows(_NAME, "section 3", (("9.75", "16.25"), ("16.50", "27.50")))


@rows_of("li2020")
def steps_of_efficiency() -> Iterator[Row]:
    """Section 3.2, figure 9b."""
    run = transient(_NAME)
    efficiency = np.asarray(run.efficiency)
    knee_times = knees(np.asarray(run.time), efficiency)
    yield number(
        "figure 9b: number of steps of the efficiency", "2", float(len(knee_times)), tolerance=0.0
    )
    for stage, knee in enumerate(knee_times[:2]):
        loose, tight = (time_to_settle(run, stage, within) for within in (0.1, 0.01))
        share = float(np.interp(knee, run.time, run.carrier_ratio[stage]))
        share /= float(run.carrier_ratio[stage, -1])
        near = time_to_settle(run, stage, 0.05)
        yield trend(
            f"figure 9b: step {stage + 1} begins when carrier {stage + 1} becomes steady",
            "at the same time",
            f"bends over at {1e3 * knee:.4f} ms, carrier at {100 * share:.1f} %",
            loose < knee < tight,
            f"{1e6 * abs(knee - near):.1f} µs from where the carrier comes within 5 % of its "
            f"steady ratio, {1e6 * (tight - knee):.0f} µs before it is within 1 %",
        )
    yield trend(
        "section 3.2: efficiency is lowest at the start",
        "lowest at 0 ms",
        f"{efficiency[0]:.4f} at 0 ms, {efficiency[-1]:.4f} in the end",
        bool(efficiency[0] < 1.001 * efficiency.min()),
        "within the resolution of a figure: until "
        f"{1e3 * float(run.time[efficiency.argmin()]):.2f} ms it "
        f"falls by {100 * (1 - efficiency.min() / efficiency[0]):.2f} %, then it rises",
    )
    tangential = np.stack([newtons_equations(_NAME, k).friction for k in (0, 1)])
    tangential = tangential[:, :, 1]
    yield trend(
        "section 3.2: tangential friction opposes the screw most at the start, then falls",
        "largest at the start, falls",
        "; ".join(f"{one[0]:.1f} N, then {one[-1]:.1f} N" for one in tangential),
        bool(np.all(tangential > 0))
        and bool(np.all(tangential[:, -1] < 0.2 * tangential[:, 0]))
        and bool(np.all(tangential.max(axis=1) < 1.01 * tangential[:, 0])),
        "on one roller of stage 1 and of stage 2, all threads together",
    )


@rows_of("li2020")
def ring_gear_and_carrier() -> Iterator[Row]:
    """Section 3.2, figures 9c and 9d."""
    run = transient(_NAME)
    for stage in (0, 1):
        solution = newtons_equations(_NAME, stage)
        sign = np.sign(solution.ring_gear)
        changes = np.flatnonzero(np.diff(sign))
        angle = get_parameter(two_stages(_NAME), f"stage.{stage + 1}.gear.pressure_angle")
        magnitude = np.abs(solution.ring_gear) / np.cos(float(angle))
        same = float(np.max(np.abs(magnitude - run.ring_gear_force[stage])) / magnitude.max())
        when = float(run.time[changes[0]]) if len(changes) else 0.0
        yield trend(
            f"section 3.2: ring gear and roller {stage + 1} change the tooth flank once",
            "change flanks",
            f"from {solution.ring_gear[0]:.2f} N to {solution.ring_gear[-1]:.2f} N, through 0 at "
            f"{1e3 * when:.3f} ms",
            len(changes) == 1 and same < 1e-9,
            f"tangential force; from equations 17, 18 and 28, within {same:.0e} of figure 9c's "
            "curve",
        )
        radial = solution.friction[:, 0]
        pin = np.asarray(run.carrier_force[stage])
        later = run.time > float(run.time[np.argmax(np.diff(pin) > 0)])
        match = float(np.corrcoef(radial[later], pin[later])[0, 1])
        yield trend(
            f"section 3.2: carrier force {stage + 1} balances the radial friction",
            "rises with it",
            f"radial friction {radial[0]:.1f} to {radial[-1]:.1f} N, carrier {pin[0]:.1f} to "
            f"{pin[-1]:.1f} N",
            match > 0.99,
            f"correlation {match:.4f} once the carrier force rises; the normal forces of "
            "both threads have radial parts, too, and two pins hold a roller",
        )
    exact, printed = newtons_equations(_NAME, 0), newtons_equations(_NAME, 0, printed=True)
    yield differs(
        "equation 17 as printed: carrier 1 at the start",
        "speeds up forwards",
        float(printed.carrier_acceleration[0]),
        "rad/s²",
        between=(-6.35e5, -6.23e5),
        evidence=float(exact.carrier_acceleration[0]),
        evidence_between=(4.15e5, 4.23e5),
        because="equation 17 lacks the force of the ring gear, and its tangential inertia has the "
        "wrong sign; with 2 F_RG and Newton's sign it gives the evidence and agrees with "
        "Lagrange's equation, and the carriers turn with the screw as in figure 9a",
    )


def _spread(curves: Sequence[Any]) -> float:
    """Largest difference between curves, relative to the largest value of the first."""
    return float(np.max(np.ptp(np.stack(curves), axis=0)) / np.max(np.abs(curves[0])))


@rows_of("li2020")
def influence_over_time() -> Iterator[Row]:
    """Section 3.2, figures 9 and 10: each coefficient of friction over the whole transient."""
    changes = {}
    for figure, name, path, values in (
        (9, "spline", _SPLINE, _SPLINES),
        (10, "thrust bearing", _BEARING, _BEARINGS),
    ):
        runs = [transient(_NAME, (path, value)) for value in values]
        carriers = _spread([run.carrier_ratio for run in runs])
        yield trend(
            f"figure {figure}a: {name} friction and the carrier ratios in time",
            "hardly any influence",
            f"largest change {100 * carriers:.2g} %",
            carriers < 0.02,
            "of stage 1, whose rollers are pressed a little harder and speed up a little sooner",
        )
        for letter, words, attribute in (
            ("c", "ring gear", "ring_gear_force"),
            ("d", "carrier", "carrier_force"),
        ):
            first, second = (_spread([getattr(run, attribute)[k] for run in runs]) for k in (0, 1))
            end = np.array([getattr(run, attribute)[0, -1] for run in runs])
            yield trend(
                f"figure {figure}{letter}: {name} friction and the {words} forces",
                "very small, stage 2 none",
                f"stage 1 {100 * float(np.ptp(end) / end[0]):.2g} % in the end, "
                f"stage 2 {100 * second:.0e} %",
                second < 1e-4 and float(np.ptp(end) / end[0]) < 0.03 and first < 0.1,
                f"during the transient stage 1 changes by up to {100 * first:.2g} % of its largest "
                "force, because it settles a little sooner; stage 2 by the tolerance of the "
                "integration",
            )
        ends = [steady(_NAME, (path, value)) for value in values]
        changes[name] = float(ends[-1].nut_load[0] - ends[0].nut_load[0])
    yield trend(
        "section 3.2: thrust bearing friction changes the load of nut 1 as spline friction does",
        "similar",
        f"{changes['thrust bearing']:.0f} N and {changes['spline']:.0f} N for 0.1 more",
        0.5 < changes["thrust bearing"] / changes["spline"] < 2,
        "both by the torque of screw 2 that the spline carries",
    )
    radius = float(get_parameter(two_stages(_NAME), "thrust_bearing.radius"))
    ends = [steady(_NAME, (_BEARING, value)) for value in _BEARINGS]
    bearing = [
        radius * value * float(end.nut_load[0]) for value, end in zip(_BEARINGS, ends, strict=True)
    ]
    runs = [transient(_NAME, (_BEARING, value)) for value in _BEARINGS]
    more = float(runs[-1].stage_torque[1, -1] - runs[0].stage_torque[1, -1])
    expected = bearing[-1] - bearing[0]
    yield trend(
        "section 3.2: bearing friction adds to the torque of screw 2 directly",
        "directly",
        f"{more:.2f} N·m more, of which bearing {expected:.2f} N·m",
        abs(more / expected - 1) < 1e-4,
        "equation 22; coefficient 0.005 to 0.105",
    )
