"""Pictures of design studies can be printed: many limits, many axes, long words."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from report_checks import assert_printable

import prsm_jax as prsm
from prsm_jax.mechanism import Constraint, DesignProblem, Objective, Tolerance, Variable
from prsm_jax.optimisation import FrontPoint, ParetoFront
from prsm_jax.report import parallel_chart, sweep_figure, tornado_chart
from prsm_jax.uncertainty import Estimate, MethodResult, ToleranceAnalysis, ZoneEnds

#: The limits of the shipped actuator: quantities, units, and values at the ends of both axes.
QUANTITIES = {
    "max_pressure_shared": ("Pa", 1.8e9, 2.7e9),
    "first_axial_frequency": ("Hz", 8e3, 5.8e3),
    "nut_axial_stiffness_secant": ("N/m", 8.8e8, 5.1e8),
    "nut_outer_diameter": ("m", 0.06, 0.06),
    "roller_clearance": ("m", 0.0005, 0.0013),
    "drive_torque": ("N·m", 11.0, 33.0),
    "efficiency": ("1", 0.82, 0.87),
}


@pytest.fixture(scope="module")
def limits() -> tuple[Constraint, ...]:
    problem = prsm.load("actuator").design_problem
    assert problem is not None
    return problem.constraints


def _sweep(*axes: str):
    import xarray

    values = {
        "lead": (np.linspace(5e-3, 15e-3, 7), "m"),
        "contact_angle": (np.linspace(0.6, 1.0, 6), "rad"),
        "roller_radius": (np.linspace(3e-3, 5e-3, 6), "m"),
    }
    shape = [len(values[name][0]) for name in axes]
    along: Any = sum(np.meshgrid(*(np.linspace(0, 1, n) for n in shape), indexing="ij")) / len(axes)
    variables: dict[str, Any] = {
        name: (axes, low + along * (high - low), {"units": unit})
        for name, (unit, low, high) in QUANTITIES.items()
    }
    variables["code"] = (axes, (along == 1).astype(np.int8))
    variables["error"] = (axes, (along == 0).astype(np.int8))
    coords = {name: (name, values[name][0], {"units": values[name][1]}) for name in axes}
    return xarray.Dataset(variables, coords)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_sweeps_with_six_limits(limits, count):
    data = _sweep(*("lead", "contact_angle", "roller_radius")[:count])
    assert_printable(sweep_figure(data, "efficiency", constraints=limits))


def test_parallel_coordinates_of_ten_numbers():
    names = ["lead", "contact_angle", "roller_radius", "roller_profile_radius"]
    names += ["nut.support.torsional_stiffness", "screw_addendum", "thread.coefficient"]
    quantities = ("efficiency", "first_axial_frequency", "nut_axial_stiffness_secant")

    def point(index: int, status: str) -> FrontPoint:
        variables = dict.fromkeys(names, 0.012 + 0.001 * index)
        values = {name: QUANTITIES[name][1] * (1 + 0.02 * index) for name in quantities}
        return FrontPoint(variables, values, {}, {}, {}, (), 0.0, 0.0, status)

    front = ParetoFront(
        mechanism=prsm.load("actuator"),
        problem=DesignProblem(
            tuple(Variable(name, 0.0, 1.0) for name in names),
            tuple(Objective(name, "maximise") for name in quantities),
        ),
        points=tuple(point(index, "optimal") for index in range(1, 7)),
        start=point(0, "present design"),
        dropped=(),
        hypervolume=0.5,
        reference={},
        ideal={},
        tolerance=1e-6,
        message="",
        evaluations=1,
        derivative_evaluations=1,
        variable_units=dict.fromkeys(names, "m"),
        objective_units={name: QUANTITIES[name][0] for name in quantities},
    )
    assert_printable(parallel_chart(front))


@pytest.mark.parametrize("method", ["first_order", "second_order", "monte_carlo"])
def test_a_tornado(method):
    names = ("lead", "nut.support.torsional_stiffness", "thread.coefficient")
    estimate = Estimate(2.1e9, 1e7, (2.1e9,) * 5, None, (0.5, 0.4, 0.1))
    ends = ZoneEnds(2.1e9, np.array([2.0e9, 2.11e9, 2.1e9]), np.array([2.2e9, 2.104e9, np.nan]))
    analysis = ToleranceAnalysis(
        quantities=("max_pressure",),
        units=("Pa",),
        limits=((0.0, 2.21e9),),
        tolerances=tuple(Tolerance(name, -3e-5, 1e-5) for name in names),
        tolerance_units=("m", "N/m", "1"),
        methods={method: MethodResult({"max_pressure": estimate}, None, None)},
    )
    one = dataclasses.replace(analysis.best, ends={"max_pressure": ends})
    analysis = dataclasses.replace(analysis, methods={method: one})
    assert_printable(tornado_chart(analysis, "max_pressure"))
