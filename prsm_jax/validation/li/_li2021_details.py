"""Li et al. 2021: statements of the text on the curves, in addition to the numbers."""

from collections.abc import Iterator

import numpy as np

from ...mechanism import get_parameter
from .._difference import differs
from .._examples import kinematics, knees, steady, time_to_settle, transient, two_stages
from .._newtons_equations import newtons_equations
from .._registry import rows_of
from .._row import Row, trend
from ._li_radii import radius_rows

_NAME = "li2021_two_stage"
_THREAD, _SPLINE = "thread.coefficient", "spline.coefficient"
_LEADS = ((0.005, 0.015), (0.010, 0.010), (0.015, 0.005))


def _pitches(first: float, second: float) -> tuple[tuple[str, float], ...]:
    return ("stage.1.lead", first), ("stage.2.lead", second)


@rows_of("li2021")
def radii() -> Iterator[Row]:
    """Section 3.1: radii that follow from the roller's and the number of starts."""
    yield from radius_rows(_NAME, "section 3.1", (("9.75", "16.25"), ("16.5", "27.5")))


@rows_of("li2021")
def base_case_over_time() -> Iterator[Row]:
    """Section 3.1, figure 3."""
    run = transient(_NAME)
    time, torque = np.asarray(run.time), np.asarray(run.stage_torque[1])
    at = int(np.searchsorted(time, 0.14e-3))
    leaves = int(np.flatnonzero(torque[at:] < 0.99 * torque[at])[0]) + at
    yield trend(
        "section 3.1: after 0.14 ms the torque on screw 2 stays for a short time, then falls",
        "stays, then falls",
        f"within 1 % until {1e3 * float(time[leaves]):.3f} ms, from {torque[at]:.2f} to "
        f"{torque[-1]:.2f} N·m",
        float(time[leaves]) > 0.15e-3 and torque[-1] < 0.6 * torque[at],
    )
    for stage, knee in enumerate(knees(time, np.asarray(run.efficiency))[:2]):
        loose, tight = (time_to_settle(run, stage, within) for within in (0.1, 0.01))
        yield trend(
            f"figure 3d: efficiency bends over where carrier {stage + 1} becomes steady",
            "at the same time",
            f"at {1e3 * knee:.4f} ms, carrier within 5 % at "
            f"{1e3 * time_to_settle(run, stage, 0.05):.4f} ms",
            loose < knee < tight,
            "the text gives 0.14 and 0.46 ms for the carriers; see their rows",
        )
    slip = [newtons_equations(_NAME, k).friction for k in (0, 1)]
    yield trend(
        "section 3.1: axial friction rises as the carriers speed up",
        "rises",
        "; ".join(f"{one[0, 2]:.1f} to {one[-1, 2]:.1f} N" for one in slip),
        all(one[-1, 2] > 3 * one[0, 2] for one in slip),
        "on one roller of stage 1 and of stage 2",
    )
    second = np.asarray(run.screw_roller_axial_force[1])
    yield trend(
        "figure 3c: contact force of stage 2 rises to its steady value",
        "rises",
        f"{second[0]:.0f} to {second[-1]:.0f} N",
        bool(np.all(np.diff(second) > -1e-6 * second[0])),
        "only its own axial friction changes it",
    )
    friction = np.asarray(run.spline_friction[1])
    ratio = friction / torque
    coefficient, radius = (
        float(get_parameter(two_stages(_NAME), name)) for name in (_SPLINE, "spline.radius")
    )
    yield trend(
        "figure 3d: spline friction changes as the torque on screw 2",
        "similar",
        f"f/M = {ratio[0]:.4f} 1/m all the time",
        float(np.max(np.abs(ratio * radius / coefficient - 1))) < 1e-9,
        f"equation 12; from {friction[0]:.1f} to {friction[-1]:.1f} N",
    )


@rows_of("li2021")
def equation_23() -> Iterator[Row]:
    """Section 2.2: torques as printed, from friction alone and of one roller."""
    mechanism = two_stages(_NAME)
    torque, travel = 0.0, 0.0
    for index, (stage, geometry) in enumerate(
        zip(mechanism.stages, kinematics(_NAME), strict=True)
    ):
        side = geometry.meshing.screw
        radius, angle = float(side.contact_radius), float(side.contact_angle_position)
        x, y, _ = newtons_equations(_NAME, index).friction[-1]
        torque += radius * (y * np.cos(angle) - x * np.sin(angle))
        travel += float(stage.thread.lead) / (2 * np.pi)
    literal = float(get_parameter(mechanism, "operating_point.load")) * travel / abs(torque)
    yield differs(
        "equation 23 as printed: steady efficiency",
        "0.80",
        literal,
        between=(62.3, 62.8),
        evidence=float(steady(_NAME).efficiency),
        evidence_between=(0.79, 0.81),
        because="equation 23 has the friction of one roller and no torque of the normal force; "
        f"with the friction of all rollers it gives {literal / stage.present_roller_count:.1f}, "
        "with that torque added, the evidence, as figure 3d shows",
    )


@rows_of("li2021")
def friction_over_time() -> Iterator[Row]:
    """Section 3.2, figure 4."""
    base = transient(_NAME)
    threads, spline = transient(_NAME, (_THREAD, 0.2)), transient(_NAME, (_SPLINE, 0.3))
    deviation = float(np.max(np.abs(spline.carrier_ratio - base.carrier_ratio)))
    deviation /= float(base.carrier_ratio.max())
    yield trend(
        "figure 4a: spline friction 0.3 instead of 0.2 and the carrier ratios in time",
        "slight influence",
        f"largest change {100 * deviation:.2g} %",
        deviation < 0.02,
        "of carrier 1; the ratio of carrier 2 does not change",
    )
    late = int(np.searchsorted(base.time, 0.75e-3 * (1 - 1e-9)))
    growth = [
        np.abs(run.screw_roller_axial_force[:, late] - run.screw_roller_axial_force[:, 0])
        for run in (base, threads)
    ]
    yield trend(
        "figure 4b: contact forces at 0.75 ms and at 0 differ more with thread friction 0.2",
        "more",
        "; ".join(f"{b:.0f} instead of {a:.0f} N" for a, b in zip(*growth, strict=True)),
        bool(np.all(growth[1] > growth[0])),
    )
    first = float(
        steady(_NAME, (_SPLINE, 0.3)).screw_roller_axial_force[0]
        / steady(_NAME).screw_roller_axial_force[0]
        - 1
    )
    yield trend(
        "figure 4b: spline friction raises the contact force of stage 1 only a little",
        "small increase",
        f"{100 * first:.2f} %",
        0 < first < 0.03,
    )
    force = [run.spline_friction[1] for run in (base, threads, spline)]
    load = float(get_parameter(two_stages(_NAME), "operating_point.load"))
    lower = np.asarray(force[1] < force[0])
    yield trend(
        "figure 4d: spline friction rises with both coefficients",
        "rises",
        "; ".join(f"{one[0]:.1f} to {one[-1]:.1f} N" for one in force),
        all(bool(one[k] > force[0][k]) for one in force[1:] for k in (0, -1)),
        "thread 0.1 and spline 0.2; thread 0.2; spline 0.3. At the start and in the end; between "
        f"{1e3 * float(base.time[lower].min()):.2f} and {1e3 * float(base.time[lower].max()):.2f} "
        "ms thread friction 0.2 has the smaller force, because carrier 2 settles sooner",
    )
    yield trend(
        "section 3.2: spline friction is much smaller than the load",
        "much smaller",
        f"{float(force[0][-1]):.1f} N, {100 * float(force[0][-1]) / load:.1f} % of {load:.0f} N",
        float(force[0][-1]) < 0.05 * load,
    )


@rows_of("li2021")
def leads_over_time() -> Iterator[Row]:
    """Section 3.3, figure 5."""
    note = "pitches 1 and 3, 2 and 2, 3 and 1 mm on five starts"
    runs = [transient(_NAME, *_pitches(*pair)) for pair in _LEADS]
    ends = [steady(_NAME, *_pitches(*pair)) for pair in _LEADS]
    second = [float(end.carrier_ratio[1]) for end in ends]
    times = [1e3 * time_to_settle(run, 1, 1e-3) for run in runs]
    yield trend(
        "figure 5a: carrier 2 likewise with the lead of screw 2",
        "sooner, higher ratio",
        f"{times[0]:.3f}, {times[1]:.3f}, {times[2]:.3f} ms; {second[0]:.4f}, {second[1]:.4f}, "
        f"{second[2]:.4f}",
        times[0] > times[1] > times[2] and second[0] < second[1] < second[2],
        note,
    )
    spline = [float(end.spline_friction[1]) for end in ends]
    contact = [float(end.screw_roller_axial_force[1]) for end in ends]
    by_spline, by_contact = (max(v) / min(v) - 1 for v in (spline, contact))
    yield trend(
        "figure 5b, 5d: pitch of screw 2 changes the spline force far more than its contact force",
        "much greater",
        f"{100 * by_spline:.0f} % against {100 * by_contact:.2f} %",
        by_spline > 50 * by_contact,
        note,
    )
    first = [float(end.screw_roller_axial_force[0]) for end in ends]
    yield trend(
        "section 3.3: the smallest contact force of stage 1 has the largest pitch of screw 1",
        "3 mm",
        f"{1e3 * _LEADS[int(np.argmin(first))][0] / 5:g} mm",
        int(np.argmin(first)) == 2,
        "the spline force goes with the lead of screw 2 and adds to the load of stage 1",
    )
