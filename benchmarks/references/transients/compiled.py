"""Carrier dynamics of two stages for compiled rivals: numbalsoda's LSODA, CasADi's CVODES and IDAS.

One vector of numbers describes a trajectory, the same for all rivals: how the screw is driven, and
of every stage what its right-hand side needs. Coulomb friction, exact or regularised, in threads,
spline and thrust bearing; screw driving or driven, the load always on the same flanks.
"""

import importlib.util
import math
import os
from importlib import import_module
from types import SimpleNamespace

import numpy as np

STAGES = 2
#: Of the drive: amplitude of the speed Ω₀, angular frequency (unless constant), load, width ε of
#: the friction law (0: exact), initial carrier ratio.
DRIVE = 5
#: Of a stage: number of rollers, L/2π, screw's velocity per radian x y, drive x y, normal x y z,
#: inertia of the carrier, μ, μ_SS/r_SS, μ_NS r_NS, mass that moves with the nut, mass and inertia
#: of the screw, travel of the nut and of the screw per radian.
STAGE = 18
NUMBERS = DRIVE + STAGES * STAGE


def missing_rivals() -> list[str]:
    """Packages of the compiled rivals that are not installed."""
    names = ("numba", "numbalsoda", "casadi")
    return [name for name in names if importlib.util.find_spec(name) is None]


def right_hand_side(operations, moving: bool):
    """d(ω/Ω₀)/dt of every stage, written for numba and for CasADi's symbols alike.

    `operations` has sqrt, sin, cos and sign; `moving` makes the speed a sine.
    """
    sqrt, sin, cos, sign = operations.sqrt, operations.sin, operations.cos, operations.sign

    def rates(time, ratio, p, out):
        amplitude, frequency, load, width = p[0], p[1], p[2], p[3]
        speed, acceleration = amplitude, 0.0
        if moving:
            speed = amplitude * sin(frequency * time)
            acceleration = amplitude * frequency * cos(frequency * time)
        sense = sign(speed)
        nut_load, torque = load, 0.0
        for index in range(2):
            k = 1 - index
            at = 5 + 18 * k
            carrier = amplitude * ratio[k]
            slip_x = p[at + 2] * speed - p[at + 4] * carrier
            slip_y = p[at + 3] * speed - p[at + 5] * carrier
            slip_z = p[at + 1] * speed
            size = sqrt(slip_x * slip_x + slip_y * slip_y + slip_z * slip_z + width * width)
            share = p[at + 10] / (size + 1e-300)
            axial = nut_load + p[at + 13] * acceleration * p[at + 16]
            # N (F |n_z| − f_z) = F_n − m z̈
            force = axial / p[at] / (-p[at + 8] - share * slip_z)
            friction_x = share * force * slip_x
            friction_y = share * force * slip_y
            drive = friction_x * p[at + 4] + friction_y * p[at + 5]
            out[k] = p[at] * drive / (p[at + 9] * amplitude)
            if index == 0:
                # The roller pushes the screw back; the drive has to balance its moment.
                moment = p[at + 2] * (force * p[at + 6] + friction_x)
                moment += p[at + 3] * (force * p[at + 7] + friction_y)
                torque = p[at] * moment + p[at + 15] * acceleration
                axial = axial + p[at + 14] * acceleration * p[at + 17]
                # M = M₀ + μ_NS r_NS |F| and F = F_n + μ_SS/r_SS |M|; the load keeps its sign.
                bearing, spline = p[at + 12] * sense, p[at + 11] * sense
                spline = spline * sign(torque + bearing * axial)
                torque = (torque + bearing * axial) / (1 - bearing * spline)
                nut_load = axial + spline * torque
        return out

    return rates


def python_rates(moving: bool, numbers: np.ndarray):
    """The right-hand side for SciPy, of one trajectory, in Python floats."""

    def sign(value):
        return float(value > 0) - float(value < 0)

    operations = SimpleNamespace(sqrt=math.sqrt, sin=math.sin, cos=math.cos, sign=sign)
    rates, given = right_hand_side(operations, moving), numbers.tolist()
    return lambda time, ratio: rates(time, ratio.tolist(), given, [0.0, 0.0])


def followed(rates, size: int, times: np.ndarray, solver: str, rtol: float, atol: float):
    """A trajectory from zero by SciPy at given times (size × time); NaN where it fails."""
    from scipy.integrate import solve_ivp

    span = (0.0, float(times[-1]))
    found = solve_ivp(
        rates, span, np.zeros(size), method=solver, t_eval=times, rtol=rtol, atol=atol
    )
    complete = found.status == 0 and found.y.shape[1] == len(times)
    return found.y if complete else np.full((size, len(times)), np.nan)


class Lsoda:
    """numbalsoda's LSODA over many trajectories, compiled, on all cores."""

    def __init__(self, moving: bool):
        numba, numbalsoda = import_module("numba"), import_module("numbalsoda")
        operations = SimpleNamespace(sqrt=np.sqrt, sin=np.sin, cos=np.cos, sign=np.sign)
        # As in C: at standstill nothing slips, and 0/0 is not an exception.
        rates = numba.njit(right_hand_side(operations, moving), error_model="numpy")
        numbers = NUMBERS

        @numba.cfunc(numbalsoda.lsoda_sig, error_model="numpy")
        def function(time, state, rate, data):
            given = numba.carray(data, (numbers,))
            rates(time, numba.carray(state, (2,)), given, numba.carray(rate, (2,)))

        # The address, not the object: what the compiled loop can take.
        address, lsoda = function.address, numbalsoda.lsoda
        self._function = function

        @numba.njit(parallel=True)
        def solve(numbers, times, rtol, atol):
            found = np.empty((numbers.shape[0], 2, times.shape[0]))
            for row in numba.prange(numbers.shape[0]):
                start = np.full(2, numbers[row, 4])
                values, success = lsoda(
                    address, start, times, data=numbers[row], rtol=rtol, atol=atol, mxstep=1000000
                )
                if success:
                    found[row] = values.T
                else:
                    found[row] = np.nan
            return found

        self.solve = solve


def mapped(function, count: int):
    """A function of CasADi over many rows of numbers at once, on all cores by its own threads.

    **Arguments:**

    - `function`: of one vector of numbers.
    - `count`: number of rows.

    **Returns:** a function of the rows; results of all of them side by side, as columns.
    """
    over_all = function.map(count, "thread", len(os.sched_getaffinity(0)))
    return lambda rows: np.array(over_all(np.asarray(rows).T))


def casadi_integrators(moving: bool, solver: str, times: np.ndarray, rtol: float, atol: float):
    """CasADi's integrator of both carriers over the sample times, and its forward sensitivities.

    `solver` is "cvodes", or "idas" for the same equations with the rates as algebraic unknowns.

    **Returns:** functions of one vector of numbers: the ratios (stage × time), and their
    derivatives by the speed, the load and the first friction coefficient (stage × time × 3).
    """
    casadi = import_module("casadi")
    rates = right_hand_side(casadi, moving)
    state, numbers, time = casadi.SX.sym("x", 2), casadi.SX.sym("p", NUMBERS), casadi.SX.sym("t")
    found = casadi.vertcat(*rates(time, state, numbers, [0, 0]))
    at_start = casadi.Function("rates", [time, state, numbers], [found])
    problem = {"x": state, "p": numbers, "t": time, "ode": found}
    if solver == "idas":
        unknown = casadi.SX.sym("z", 2)
        problem = {**problem, "ode": unknown, "z": unknown, "alg": unknown - found}
    options = {"reltol": rtol, "abstol": atol, "max_num_steps": 1000000}
    integrator = casadi.integrator("carriers", solver, problem, times[0], times[1:], options)
    given, seeds = casadi.MX.sym("p", NUMBERS), np.zeros((NUMBERS, 3))
    for column, row in enumerate((0, 2, DRIVE + 10)):
        seeds[row, column] = 1.0
    begin = casadi.repmat(given[4], 2, 1)
    # IDAS fails to find consistent rates from anything else than the right ones.
    guess = {"z0": at_start(times[0], begin, given)} if solver == "idas" else {}
    ends = casadi.horzcat(begin, integrator(x0=begin, p=given, **guess)["xf"])
    values = casadi.Function("values", [given], [ends])
    tangents = casadi.jtimes(casadi.vec(ends), given, casadi.DM(seeds))
    slopes = casadi.Function("slopes", [given], [tangents])
    return values, slopes
