"""Any mechanism that a file can hold survives a round trip, bit for bit.

The strategies are made from the classes as the schema is, so a new field is tested at once.
"""

import dataclasses
import typing
from typing import Any

import equinox as eqx
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import prsm_jax.file as file
from prsm_jax.fields import ANY, STARTS, Declared, Limit, declared, limit_of
from prsm_jax.file import TableChoice, table_choices
from prsm_jax.mechanism import (
    DISTRIBUTIONS,
    AxialPlay,
    Constraint,
    DesignProblem,
    DutyCycle,
    FreeNut,
    LoadSharing,
    Mechanism,
    Objective,
    OperatingPoint,
    PartErrors,
    Roller,
    SplitNut,
    Stage,
    Support,
    Thread,
    Tolerance,
    UnequalRoller,
    Variable,
)
from tests.present import present

_NAMES = st.from_regex(r"[a-z][a-z_]{0,20}", fullmatch=True)
_LARGEST = 1e120
#: The lists of one number per thread.
_GAP_LISTS = tuple(one.name for one in declared(LoadSharing) if one.is_list)


def numbers(limit: Limit) -> st.SearchStrategy[float]:
    """Any double that a limit admits, up to 1e120."""
    return st.floats(max(limit.lower, -_LARGEST), min(limit.upper, _LARGEST)).filter(limit.admits)


def _limit(cls: type[eqx.Module], name: str) -> Limit:
    (field,) = [field for field in declared(cls) if field.name == name]
    return field.limit


def _field(field: Declared) -> st.SearchStrategy:
    if field.element is not None:
        return st.just(())  # filled when the number of rollers is known
    if field.classes:
        present = st.one_of([_choice(one) for one in table_choices(field.hint).values()])
    elif field.is_list:
        return st.none()  # filled when the number of threads is known
    elif field.unit is not None:
        present = numbers(field.limit)
    elif field.whole:
        present = st.integers(int(field.limit.lower), int(field.limit.upper))
    else:
        present = st.sampled_from(field.words) if field.words else st.booleans()
    return st.one_of(st.none(), present) if type(None) in typing.get_args(field.hint) else present


@st.composite
def _choice(draw, choice: TableChoice):
    """A module of a table, with a law where that stands in the same table."""
    if choice.law is None:
        return draw(modules(choice.cls))
    law = draw(modules(choice.law))
    kind: Any = choice.cls
    return kind(law, None if choice.law.load_independent else draw(numbers(limit_of("m"))))


@st.composite
def modules(draw, cls: type[eqx.Module]):
    """A module of a class with any of its optional parts."""
    values = {one.name: draw(_field(one)) for one in declared(cls)}
    if cls is Support and values["radial_stiffness"] is None:
        values["radial_stiffness_y"] = None
    if cls is Thread and values["radius_ratio"] is None:
        # Starts then determine the radii.
        values["starts"] = draw(numbers(STARTS))
    if cls is LoadSharing:
        values |= draw(sharing_lists(values["thread_count"], values["split_nut"]))
    if cls in (PartErrors, FreeNut):
        for name in [one for one in values if one.endswith("_angle")]:
            if values[name.removesuffix("_angle")] is None:
                values[name] = None
    if cls is PartErrors and values["nut_tilt"] is None:
        values["nut_eccentricity"] = draw(numbers(ANY))
    if cls is SplitNut and (values["preload"] is None) == (values["offset"] is None):
        values |= {"preload": None, "offset": draw(numbers(ANY))}
    if cls is Roller and values["support"] is not None:
        values["support"] = Support(values["support"].radial_stiffness)
    if cls is AxialPlay and values["preload_force"] is not None:
        values["axial_backlash"] = None
    if cls is Stage:
        values |= draw(_of_a_type(values["thread"], values))
        values["unequal_roller"] = draw(unequal_rollers(values["roller_count"]))
        values["load_sharing"] = draw(
            with_roller_errors(values["load_sharing"], values["roller_count"])
        )
        # Dimensions that must fit each other are scaled to do so.
        thread = values["thread"]
        radius = float(thread.roller_radius)
        bound = {"screw": _screw_ratio(values["type"], thread) * radius, "roller": radius}
        for body, outer in bound.items():
            part = values[body]
            bore = draw(st.one_of(st.none(), st.floats(0, 0.99))) if outer > 1e-300 else None
            values[body] = dataclasses.replace(
                part, bore_radius=None if bore is None else min(bore * outer, 50.0)
            )
        values["carrier"] = _narrowed(values["carrier"], bound["screw"] + radius)
        values["strength"] = _thick_enough(values["strength"], values["screw"].bore_radius)
        line = values["line_contact"]
        if line is not None:
            values["line_contact"] = dataclasses.replace(
                line,
                screw_minor_radius=1e-3,
                screw_major_radius=2e-3,
                roller_minor_radius=1e-3,
                roller_major_radius=2e-3,
            )
    return cls(**values)


@st.composite
def _of_a_type(draw, thread: Thread, values: dict[str, Any]):
    """A type that the numbers of a thread fit, without the parts that it cannot have."""
    kinds = ("standard", "inverted")
    if thread.radius_ratio is not None:
        kinds = ("recirculating", "differential")
        thread = dataclasses.replace(thread, starts=draw(st.floats(1, 2)))
    kind = draw(st.sampled_from(kinds))
    if kind == "standard":
        return {"type": kind}
    gear = values["gear"] if kind == "inverted" else None
    without = {"ring_gear": None, "curvature": "exact", "line_contact": None}
    return {"type": kind, "thread": thread, "gear": gear} | without


def _screw_ratio(kind: str, thread: Thread) -> float:
    """Screw radius over roller radius."""
    if thread.radius_ratio is not None:
        return float(thread.radius_ratio) - 2
    return float(thread.starts) - (2 if kind == "standard" else 0)


@st.composite
def sharing_lists(draw, thread_count: int, split_nut: SplitNut | None):
    """Lists of one number per thread, few threads, and a nut that is split before the last."""
    count = min(thread_count, 4)
    if split_nut is not None:
        count = max(count, 2)
        split_nut = dataclasses.replace(split_nut, after_thread=draw(st.integers(1, count - 1)))
    names = draw(st.sets(st.sampled_from(_GAP_LISTS)))
    lists = {
        name: draw(st.lists(numbers(_limit(LoadSharing, name)), min_size=count, max_size=count))
        for name in sorted(names)
    }
    return {"thread_count": count, "split_nut": split_nut} | lists


@st.composite
def with_roller_errors(draw, sharing: LoadSharing | None, roller_count: int):
    """Errors of parts with one number for each roller, where there are few."""
    if sharing is None or sharing.part_errors is None or roller_count > 8:
        return sharing
    deviations = draw(st.lists(numbers(ANY), min_size=roller_count, max_size=roller_count))
    errors = dataclasses.replace(sharing.part_errors, roller_diameter_deviation=deviations)
    return dataclasses.replace(sharing, part_errors=errors)


@st.composite
def unequal_rollers(draw, roller_count: int):
    """Some rollers of a stage that differ, at least one of them being there."""
    chosen = draw(st.lists(st.integers(1, roller_count), max_size=3, unique=True))
    rollers = []
    for index, number in enumerate(chosen):
        missing = index > 0 and draw(st.booleans())
        names = ("stiffness_factor", "mass_factor", "position_offset", "tooth_thinning")
        differing = () if missing else draw(st.sets(st.sampled_from(names), min_size=1))
        values = {name: draw(numbers(_limit(UnequalRoller, name))) for name in sorted(differing)}
        rollers.append(UnequalRoller(number, missing=missing, **values))
    return tuple(rollers)


def _narrowed(carrier, radius: float):
    if carrier is None or carrier.radial_width is None:
        return carrier
    width = min(float(carrier.radial_width), radius)
    return dataclasses.replace(carrier, radial_width=width)


def _thick_enough(strength, bore_radius):
    """With a root of the screw's thread outside the screw's bore."""
    shaft = None if strength is None else strength.shaft
    if shaft is None or shaft.root_radius is None or bore_radius is None:
        return strength
    root = max(float(shaft.root_radius), float(bore_radius) * 1.1 + 1e-3)
    shaft = dataclasses.replace(shaft, root_radius=root)
    return dataclasses.replace(present(strength), shaft=shaft)


@st.composite
def _variables(draw):
    chosen = draw(
        st.lists(
            st.sampled_from(["lead", "roller_radius", "contact_angle"]), min_size=1, unique=True
        )
    )
    variables = []
    for name in chosen:
        ends = numbers(_limit(Thread, name))
        pair = st.tuples(ends, ends).filter(lambda b: b[0] != b[1])
        variables.append(Variable(name, *sorted(draw(pair))))
    return tuple(variables)


@st.composite
def design_problems(draw):
    """A design problem with any number of objectives and constraints."""
    finite = st.floats(allow_nan=False, allow_infinity=False)
    objectives = st.builds(
        Objective,
        _NAMES,
        st.sampled_from(["maximise", "minimise"]),
        st.one_of(st.just(1.0), finite),
    )
    constraints = st.one_of(
        st.builds(Constraint, _NAMES, lower=finite),
        st.builds(Constraint, _NAMES, upper=finite),
        st.builds(Constraint, _NAMES, equal=finite),
    )
    return DesignProblem(
        draw(_variables()),
        tuple(draw(st.lists(objectives, min_size=1, max_size=3))),
        tuple(draw(st.lists(constraints, max_size=3))),
        draw(st.integers(1, 100)),
        draw(st.integers(0, 2**32 - 1)),
        draw(_NAMES),
    )


@st.composite
def tolerances(draw):
    """Tolerances of some numbers of the operating point, which every mechanism here may lack."""
    rows = []
    for name in draw(st.lists(st.sampled_from(["speed", "load"]), min_size=1, unique=True)):
        ends = st.floats(-1e6, 1e6, allow_subnormal=False)
        lower, upper = sorted(draw(st.tuples(ends, ends).filter(lambda b: b[0] != b[1])))
        if draw(st.booleans()):
            lower, upper = -max(abs(lower), abs(upper)), max(abs(lower), abs(upper))
        distribution = draw(st.sampled_from(DISTRIBUTIONS))
        positive = st.floats(1e-3, 1e3)
        sigmas = draw(st.one_of(st.just(3.0), positive)) if distribution == "normal" else 3.0
        cost = draw(st.one_of(st.just(1.0), positive))
        rows.append(Tolerance(name, lower, upper, distribution, sigmas, cost))
    return tuple(rows)


@st.composite
def duty_cycles(draw):
    """A duty cycle of one to five phases."""
    size = draw(st.integers(1, 5))
    columns = {
        field.name: np.array(
            draw(st.lists(numbers(_limit(DutyCycle, field.name)), min_size=size, max_size=size))
        )
        for field in dataclasses.fields(DutyCycle)
    }
    return DutyCycle(**columns)


def _without_first_spline(stages: list[Stage]) -> tuple[Stage, ...]:
    first = stages[0]
    if first.friction is not None:
        friction = dataclasses.replace(first.friction, spline=None)
        first = dataclasses.replace(first, friction=friction)
    return (first, *stages[1:])


@st.composite
def mechanisms(draw):
    """Any mechanism that a file can hold."""
    point = draw(st.one_of(st.none(), modules(OperatingPoint)))
    stages = draw(st.lists(modules(Stage), min_size=1, max_size=2))
    if any(stage.type != "standard" for stage in stages):
        stages = stages[:1]
    return Mechanism(
        _without_first_spline(stages),
        point,
        draw(st.one_of(st.none(), duty_cycles())),
        draw(st.text(st.characters(exclude_categories=["Cs"]), max_size=20)),
        draw(st.one_of(st.none(), design_problems())),
        tolerances=None if point is None else draw(st.one_of(st.none(), tolerances())),
    )


# The tests' shape checks sample long tuples at random, here of modules that a strategy builds.
@pytest.mark.filterwarnings("ignore:Do not use the `random` module inside strategies")
@settings(max_examples=20, deadline=None, suppress_health_check=tuple(HealthCheck))  # pyright: ignore[reportArgumentType]
@given(mechanisms())
def test_any_mechanism_survives_exactly(identical, mechanism):
    again = file.loads(file.dumps(mechanism))
    assert identical(mechanism, again)
    assert again.design_problem == mechanism.design_problem
    assert again.tolerances == mechanism.tolerances
    assert again.title == mechanism.title
