"""A study of three drivers of which no two numbers are alike; nothing is solved."""

import numpy as np
import scenes

from prsm_jax.mechanism import Constraint, DesignProblem, Objective, Variable
from prsm_jax.optimisation import FrontPoint, ParetoFront
from prsm_jax.studies import (
    Conflict,
    Driver,
    DriverMap,
    DriverStudy,
    FrontGradient,
    StudyProblem,
    Variant,
)

UNITS = {"efficiency": "1", "nut_outer_diameter": "m", "mass": "kg", "max_pressure": "Pa"}
SENSES = {"efficiency": "maximise", "nut_outer_diameter": "minimise", "mass": "minimise"}
SIZES = {"efficiency": 0.8, "nut_outer_diameter": 0.06, "mass": 1.5, "max_pressure": 1.4e9}
DRIVERS = (
    Driver("lead", "m", 5e-3, 15e-3, 9.7e-3, "lead: moves with it: pitch; stays: starts"),
    Driver("contact_angle", "rad", 0.6, 1.0, 0.77),
    Driver("roller_radius", "m", 3e-3, 6e-3, 4.1e-3),
)
_RANDOM = np.random.default_rng(7)


def _odd(*shape):
    return _RANDOM.uniform(1.0, 1.3, shape)


def _signs(*shape):
    return _RANDOM.uniform(0.1, 0.9, shape) * _RANDOM.choice([-1, 1], shape)


def _problem(objectives):
    return StudyProblem(
        drivers=DRIVERS,
        senses=dict(SENSES),  # type: ignore[arg-type]
        objectives=objectives,
        limits=(Constraint("max_pressure", upper=1.6e9),),
        limited={"max_pressure": "minimise"},
        units=UNITS,
    )


def _map(coordinates, shape):
    values = {name: size * _odd(*shape) for name, size in SIZES.items()}
    usable = np.ones(shape, bool)
    usable[(0,) * len(shape)] = len(shape) == 1
    for value in values.values():
        value[~usable] = np.nan
    over = (values["max_pressure"] - 1.6e9) / 1.6e9
    return DriverMap(
        coordinates=coordinates,
        values=values,
        elasticities={name: _signs(*shape, 3) for name in SIZES},
        usable=usable,
        error=np.zeros(shape, bool),
        violations={"max_pressure": np.where(usable, np.maximum(over, 0), np.nan)},
        reasons={} if usable.all() else {"overlapping_rollers": 1},
    )


def _front(objectives, designs, first, status):
    names = [one.name for one in DRIVERS]

    def point(index, place, status):
        return FrontPoint(
            variables={name: float(designs.coordinates[name][place]) for name in names},
            objectives={name: float(designs.values[name][place]) for name in objectives},
            constraints={"max_pressure": float(designs.values["max_pressure"][place])},
            margins={"backlash (stage 1)": 1e-6 * (index + 3)},
            weights=dict(zip(objectives, (0.1 * index, 0.7, 0.2), strict=False)),
            active=("max_pressure", "upper bound of lead")[:index],
            kkt_residual=1.1e-9 * index,
            violation=1e-9 * index,
            status=status,
            message=f"message {index}",
        )

    return ParetoFront(
        mechanism=scenes.example("wu2022"),
        problem=DesignProblem(
            tuple(Variable(one.name, one.lower, one.upper) for one in DRIVERS),
            tuple(Objective(name, SENSES[name]) for name in objectives),  # type: ignore[arg-type]
        ),
        points=tuple(point(i + 1, first + i, status) for i in range(3)),
        start=point(0, 0, "present design"),
        dropped=(),
        hypervolume=0.617,
        reference=dict.fromkeys(objectives, 0.7),
        ideal=dict.fromkeys(objectives, 0.9),
        tolerance=1e-6,
        message="every point is",
        evaluations=41,
        derivative_evaluations=37,
        variable_units={one.name: one.unit for one in DRIVERS},
        objective_units={name: UNITS[name] for name in objectives},
    )


def _designs(count):
    """The present design and others, as a list."""
    coordinates = {one.name: np.array([one.present, *(one.lower * _odd(count))]) for one in DRIVERS}
    return _map(coordinates, (count + 1,))


def _conflict(first, second, shape):
    cosine = np.round(_RANDOM.uniform(-0.99, 0.99, shape), 6)
    cosine[0, 0, 0] = np.nan
    share = {one.name: float(value) for one, value in zip(DRIVERS, _odd(3) - 1, strict=True)}
    most, least = (
        {one.name: one.lower * float(factor) for one, factor in zip(DRIVERS, _odd(3), strict=True)}
        for _ in range(2)
    )
    present, whole, part = (float(v) - 1 for v in _odd(3))
    sense = "minimise" if second == "max_pressure" else SENSES[second]
    return Conflict(
        first=first,
        second=second,
        senses=(SENSES[first], sense),  # type: ignore[arg-type]
        limit=second == "max_pressure",
        cosine=cosine,
        present=present,
        share=whole,
        share_allowed=part,
        by_driver=share,
        most=most,
        least=least,
    )


def made(*objectives):
    """The study, with these objectives of its front."""
    shape = (3, 4, 5)
    axes = {
        one.name: np.linspace(one.lower, one.upper, count)
        for one, count in zip(DRIVERS, shape, strict=True)
    }
    designs = _designs(3)
    pairs = [
        ("efficiency", "nut_outer_diameter"),
        ("efficiency", "mass"),
        ("nut_outer_diameter", "mass"),
        *((name, "max_pressure") for name in SENSES),
    ]
    gradients = tuple(
        FrontGradient(
            {
                name: dict(zip(axes, map(float, designs.elasticities[name][index]), strict=True))
                for name in SIZES
            },
            float(_odd()),
            f"The sentence of point {index}.",
        )
        for index in (1, 2, 3)
    )
    there = _designs(3)
    spin = Variant(
        name="spin",
        parts=("stage.1.friction.spin",),
        misses="losses by spin",
        values={name: size * _odd(4) for name, size in SIZES.items()},
        changes={name: _odd(4) - 1.1 for name in SIZES},
        turned=(("efficiency", "lead", 2),),
        without_data=("max_pressure",),
        front=_front(objectives, there, 1, "optimal"),
        complete={name: size * _odd(3) for name, size in SIZES.items()},
        allowed=np.array([True, False, True]),
        violations={"max_pressure": 0.123},
        volume=0.9345,
    )
    failed = Variant("load_sharing", ("stage.1.load_sharing",), "sharing", error="it has no mass")
    return DriverStudy(
        title="A study",
        problem=_problem(objectives),
        map=_map(axes, shape),
        conflicts=tuple(_conflict(first, second, shape) for first, second in pairs),
        front=_front(objectives, designs, 1, "optimal"),
        designs=designs,
        gradients=gradients,
        variants=(spin, failed),
        assumptions=("it rests on this", "and on that"),
    )
