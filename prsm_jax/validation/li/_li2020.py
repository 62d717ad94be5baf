"""Li et al. 2020: two stages by Newton's law, and one stage with viscous friction."""

from collections.abc import Iterator

import numpy as np

from ...mechanism import get_parameter
from .._difference import differs, formula
from .._examples import steady, time_to_settle, transient, two_stages
from .._registry import rows_of
from .._row import Row, number, trend

_NAME = "li2020_two_stage"
_SPLINE, _BEARING = "spline.coefficient", "thrust_bearing.coefficient"
#: Bounds of the exact efficiencies that are compared with equation 35's second form.
_SECOND_FORM = {0.10: (0.99354, 0.99355), 0.20: (0.98717, 0.98718)}
_CITATION = (
    "X. Li, G. Liu, C. Song, X. Fu, S. Ma, Q. Wan, J. Northwestern Polytechnical Univ. 38 (2020) "
    "1001-1009"
)


@rows_of("li2020", _CITATION)
def efficiency() -> Iterator[Row]:
    """Section 3.2, figures 9a and 9b."""
    run, end = transient(_NAME), steady(_NAME)
    yield number(
        "section 3.2: efficiency at the start",
        "0.60",
        float(run.efficiency[0]),
        tolerance=0.01,
        note="given as approximate: one unit of its last digit is allowed",
    )
    yield number("section 3.2: steady efficiency", "0.87", float(end.efficiency))

    slope = np.gradient(run.efficiency, run.time)
    settled = [time_to_settle(run, stage, 1e-3) for stage in (0, 1)]
    shares = []
    start = 0.0
    for time in settled:
        inside = (run.time >= start) & (run.time <= time)
        shares.append(float(np.interp(time, run.time, slope) / slope[inside].max()))
        start = time
    yield trend(
        "figure 9b: efficiency rises in two steps, whose ends are the settling times of figure 9a",
        "two steps",
        f"settled at {1e3 * settled[0]:.3f} ms and {1e3 * settled[1]:.3f} ms",
        max(shares) < 0.15,
        "when a carrier is within 0.1 % of its steady ratio the efficiency rises at "
        f"{100 * shares[0]:.0f} % (stage 1) and {100 * shares[1]:.0f} % (stage 2) of the steepest "
        "slope of its step",
    )
    first, second = (float(ratio) for ratio in end.carrier_ratio)
    yield trend(
        "figure 9a: carrier 2 slightly faster in the end",
        "ratio 2 > ratio 1",
        f"{second:.6f} > {first:.6f}",
        first < second < 1.01 * first,
        "the helix angle of stage 2 is smaller, so its contact lies closer to the pitch point",
    )
    yield trend(
        "figure 9a: carrier 2 takes longer to settle",
        "later",
        f"{1e3 * settled[1]:.3f} ms > {1e3 * settled[0]:.3f} ms",
        settled[1] > settled[0],
        "time to within 0.1 % of the steady ratio",
    )


@rows_of("li2020")
def forces() -> Iterator[Row]:
    """Section 3.2, figures 9c and 9d, and the conclusions."""
    run = transient(_NAME)
    gear, pin, axial = run.ring_gear_force, run.carrier_force, run.screw_roller_axial_force
    for stage in (0, 1):
        force = np.asarray(gear[stage])
        low = int(np.argmin(force))
        yield trend(
            f"figure 9c: ring gear force of stage {stage + 1} falls to zero, then rises to less",
            "to zero, then less than at the start",
            f"{force[0]:.2f} N, {force[low]:.2f} N, {force[-1]:.2f} N",
            force[low] < 0.02 * force[0] and force[-1] < 0.5 * force[0] and low < len(force) - 1,
            "the other tooth flank takes over where the force passes zero",
        )
    steady_pin = np.asarray(pin[:, -1])
    quick = [float(run.time[np.argmax(pin[k] >= 0.95 * steady_pin[k])]) for k in (0, 1)]
    yield trend(
        "figure 9d: carrier forces rise quickly to their steady values",
        "quick rise",
        f"95 % at {1e3 * quick[0]:.3f} ms and {1e3 * quick[1]:.3f} ms",
        bool(np.all(pin[:, 0] < 0.5 * steady_pin))
        and all(q < time_to_settle(run, k, 1e-3) for k, q in enumerate(quick)),
        "before the carriers are within 0.1 % of their steady ratio",
    )
    for name, curve, when, index in (
        ("contact force", axial, "at the start", 0),
        ("contact force", axial, "in the end", -1),
        ("carrier force", pin, "at the start", 0),
        ("carrier force", pin, "in the end", -1),
        ("ring gear force", gear, "at the start", 0),
        ("ring gear force", gear, "in the end", -1),
    ):
        first, second = float(curve[0, index]), float(curve[1, index])
        note = "stage 1 carries the spline friction of stage 2 on top of the load"
        if name == "ring gear force" and index == 0:
            note = (
                "the abstract states this for the parts' forces in general, the text on figure 9c "
                "only for the end; here the moment balance of the roller, which both Newton's and "
                "Lagrange's forms fulfil, gives stage 2 the larger force at the start"
            )
        yield trend(
            f"abstract: {name} {when}, stage 1 above stage 2",
            "stage 1 > stage 2",
            f"{first:.5g} N, {second:.5g} N",
            first > second,
            note,
        )


@rows_of("li2020")
def friction_coefficients() -> Iterator[Row]:
    """Section 3.2, figures 9 and 10, equation 35, and the helix angles given with it."""
    spline = [steady(_NAME, (_SPLINE, value)) for value in (0.10, 0.15, 0.20)]
    bearing = [steady(_NAME, (_BEARING, value)) for value in (0.005, 0.055, 0.105)]
    weak, strong = ([float(s.efficiency) for s in runs] for runs in (spline, bearing))
    yield trend(
        "figure 9b: spline friction 0.10, 0.15, 0.20 lowers the efficiency only slightly",
        "slightly lower",
        ", ".join(f"{value:.4f}" for value in weak),
        weak[0] > weak[1] > weak[2] > 0.98 * weak[0],
    )
    yield trend(
        "figure 10b: thrust bearing friction 0.005, 0.055, 0.105 lowers it markedly",
        "markedly lower",
        ", ".join(f"{value:.4f}" for value in strong),
        strong[0] > strong[1] > strong[2] and strong[2] < 0.8 * strong[0],
    )
    for name, runs in (("spline", spline), ("thrust bearing", bearing)):
        ratio = np.ptp([s.carrier_ratio for s in runs], axis=0).max()
        second = np.ptp([s.contact_force[1] for s in runs])
        first = np.ptp([s.contact_force[0] for s in runs]) / runs[0].contact_force[0]
        yield trend(
            f"figures 9, 10: {name} friction and the rest of the mechanism",
            "hardly any influence",
            f"contact force 1 by {100 * first:.2g} %",
            ratio < 1e-12 and second < 1e-9 and first < 0.03,
            "carrier ratios and the contact force of stage 2 do not change at all",
        )
    stages = two_stages(_NAME).stages
    for stage, printed in zip(stages, ("9.27", "5.51"), strict=True):
        angle = np.degrees(float(stage.thread.screw_helix_angle))
        which = 1 if stage is stages[0] else 2
        yield number(f"section 3.2: helix angle of screw {which}", printed, angle, "°")

    first, second = (float(stage.thread.lead) for stage in stages)
    radius = float(get_parameter(two_stages(_NAME), "spline.radius"))
    slopes = [np.tan(float(stage.thread.screw_helix_angle)) for stage in stages]
    without = (("thread.coefficient", 0.0), (_BEARING, 0.0))
    for value in (0.10, 0.20):
        exact = float(steady(_NAME, (_SPLINE, value), *without).efficiency)
        mean_lead = first * second / (first + second)
        printed = 1 / (1 + value * mean_lead / (2 * np.pi * radius))
        yield formula(
            f"equation 35, first form: efficiency with spline friction {value:.2f} alone",
            f"{printed:.6f}",
            exact,
            note="the formula's value; without friction in threads and bearing it is exact",
        )
        approximate = 1 / (1 + value * slopes[0] * slopes[1] / sum(slopes))
        # 1/tan λ₁ + 1/tan λ₂ = 2π (r₁/L₁ + r₂/L₂) is 2π r (L₁ + L₂)/(L₁ L₂) for this radius r.
        screws = [float(stage.thread.screw_radius) for stage in stages]
        other = (screws[0] * second + screws[1] * first) / (first + second)
        moved = float(
            steady(_NAME, (_SPLINE, value), ("spline.radius", other), *without).efficiency
        )
        low, high = _SECOND_FORM[value]
        yield differs(
            f"equation 35, second form: efficiency with spline friction {value:.2f} alone",
            f"{approximate:.6f}",
            exact,
            between=(low, high),
            evidence=moved,
            evidence_between=(approximate - 5e-7, approximate + 5e-7),
            because=f"the second form replaces the radius of the spline, {1e3 * radius:.2f} mm, by "
            f"a mean of the screws' radii weighted by leads, {1e3 * other:.2f} mm: with a spline "
            "of that radius the model gives the formula's value, the evidence",
        )
