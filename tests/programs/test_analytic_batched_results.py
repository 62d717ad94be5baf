"""Every property and helper of every result of a batch is that of its designs, one by one.

Classes, properties and methods are found by looking: a new one is tested without being named here,
and a method that wants arguments fails until it has some in `ARGUMENTS`.
"""

import dataclasses
import functools
import inspect
from collections.abc import Iterator
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import prsm_jax as prsm
from prsm_jax.mechanism import get_parameter, set_parameters
from prsm_jax.programs._batches import AbstractResult

SCALES = (0.99, 1.0, 1.02)
#: What methods are called with that want something, by class and method; more than once if several.
ARGUMENTS: dict[tuple[str, str], list[dict[str, Any]]] = {
    ("Modes", "group"): [{"family": "torsional"}, {"family": "nothing"}],
    ("SpatialModes", "group"): [{"family": "axial_torsional"}, {"family": "nothing"}],
    ("LoadDistribution", "worst_thread"): [{"side": "screw"}, {"side": "nut"}],
    ("LoadDistribution", "by_roller"): [],  # takes values of the batch: a test of its own
    ("Campbell", "excited_family"): [],  # takes an order of the batch: a test of its own
    ("Campbell", "crossings"): [{}, {"max_speed": 500.0, "excited_only": True}],
    ("MeshResponse", "amplitude"): [{"coordinate": "screw u"}],
    ("MeshResponse", "force"): [{"spring": "ring_roller"}, {"spring": "ring_roller 3"}],
}
#: Results that are no batch's: they look at values, and refuse one.
OF_ONE_DESIGN = {"Optimum", "Sensitivity"}
_NO_RESULTS = (
    "prsm_jax.mechanism",
    "prsm_jax.friction",
    "prsm_jax.scenario",
    "prsm_jax.dynamics.forces._loads",
    "prsm_jax.dynamics.solvers",
)
_RPM = np.array([50.0, 100.0])


def _torque(mechanism):
    return prsm.dynamics.body_forces(mechanism, prsm.steady_state(mechanism))


def _forces_over_time(mechanism):
    return prsm.dynamics.body_forces(mechanism, prsm.simulate(mechanism, throw=False))


def _stress(mechanism):
    from prsm_jax.halfspace import Grid, subsurface_stress_field

    lead = get_parameter(mechanism, "lead")
    grid = Grid((4, 4), lead / 100, lead / 100)
    pressure = jnp.ones((4, 4)) * lead * 1e9
    return subsurface_stress_field(grid, pressure, jnp.asarray([1e-5, 2e-5, 4e-5]), lead * 30)


#: How to come to each result: an example, a function of it, and the results inside that.
MADE = {
    "modal": ("wu2022", lambda m: prsm.modal(m, shapes=True), "Modes"),
    "spatial_modal": ("wu2022", prsm.spatial_modal, "SpatialModes"),
    "steady_state": ("li2020_two_stage", prsm.steady_state, "SteadyState"),
    "simulate": (
        "li2020_two_stage",
        lambda m: prsm.simulate(m, throw=False),
        "Transient SolverReport",
    ),
    "load_distribution": (
        "actuator_load_sharing",
        prsm.load_sharing.load_distribution,
        "LoadDistribution SideLoads",
    ),
    "force_deflection": (
        "actuator_load_sharing",
        lambda m: prsm.load_sharing.force_deflection(m, jnp.asarray([1e3, 9e3])),
        "ForceDeflection",
    ),
    "body_forces": ("li2020_two_stage", _torque, "BodyForces"),
    "body_forces over time": ("li2020_two_stage", _forces_over_time, "BodyForces"),
    "campbell": ("wu2022", prsm.campbell, "Campbell Modes"),
    "frequency_response": (
        "wu2022",
        lambda m: prsm.frequency_response(m, "screw u", "nut u", jnp.asarray([10.0, 20.0])),
        "FrequencyResponse",
    ),
    "axis_compliance": (
        "actuator_axis",
        lambda m: prsm.response.axis_compliance(m, jnp.asarray([10.0, 20.0])),
        "AxisCompliance",
    ),
    "spatial_damping": (
        "actuator_axis",
        prsm.response.spatial_damping,
        "SpatialDamping SpatialModes",
    ),
    "mesh_response": (
        "wu2022",
        lambda m: prsm.response.mesh_response(m, jnp.asarray(_RPM)),
        "MeshResponse",
    ),
    "frequency_loci": (
        "wu2022",
        lambda m: prsm.vibration.frequency_loci(m, "screw.mass", [0.2, 0.3, 0.4]),
        "FrequencyLoci",
    ),
    "subsurface_stress": ("wu2022", _stress, "SubsurfaceStress"),
}


def _batch(name: str):
    mechanism = prsm.load(name)
    value = get_parameter(mechanism, "lead")
    designs = [set_parameters(mechanism, {"lead": value * scale}) for scale in SCALES]
    return jax.tree.map(lambda *leaves: jnp.stack(leaves), *designs)


@functools.cache
def _made(name: str):
    """The result of a batch, and that of its middle design by itself."""
    example, function, _ = MADE[name]
    batch = _batch(example)
    one = jax.tree.map(lambda leaf: leaf[1], batch)
    # A program each: many are compiled op by op otherwise.
    return eqx.filter_jit(jax.vmap(function))(batch), eqx.filter_jit(function)(one)


def _results(value) -> Iterator[AbstractResult]:
    """A result and those inside it."""
    if isinstance(value, AbstractResult):
        yield value
    if isinstance(value, eqx.Module):
        value = [getattr(value, field.name) for field in dataclasses.fields(value)]
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list | tuple):
        for one in value:
            yield from _results(one)


def _read(result) -> dict[str, Any]:
    """Every public property, and what every public method gives."""
    found, kind = {}, type(result)
    for name in dir(kind):
        # What is printed and drawn has tests of its own (tests/reading, tests/report).
        if name.startswith("_") or name in ("batch_shape", "lines", "plot"):
            continue
        member = inspect.getattr_static(kind, name)
        if isinstance(member, property):
            found[name] = _found(functools.partial(getattr, result, name))
        elif inspect.isfunction(inspect.unwrap(member)) or callable(member):
            method = getattr(result, name)
            needed = [
                p
                for p in list(inspect.signature(method).parameters.values())
                if p.default is p.empty
            ]
            given = ARGUMENTS.get((kind.__name__, name), None if needed else [{}])
            assert given is not None, f"give {kind.__name__}.{name} some ARGUMENTS"
            for index, arguments in enumerate(given):
                found[f"{name} {index}"] = _found(functools.partial(method, **arguments))
    return found


def _found(call):
    try:
        return call()
    except (ValueError, DeprecationWarning) as error:  # mode shapes not requested; old names
        return str(error).split("\n")[0]


def _same_for_all(kind: str, name: str) -> bool:
    """What is a matter of structure, not of a design."""
    return (kind, name) in {("Modes", "coordinates"), ("FrequencyResponse", "unit")}


def _agree(whole, each: list, where: str) -> None:
    """A batch's value against those of its designs; objects, words and numbers."""
    if isinstance(whole, str):
        assert each == [whole] * len(each), where
        return
    if isinstance(whole, np.ndarray) and whole.dtype == object:
        assert whole.shape == (len(each),), where
        assert list(whole) == each, where
        return
    if isinstance(each[0], tuple | list) and all(isinstance(v, str | int) for v in each[0]):
        each = [np.asarray(one) for one in each]
    leaves, rows = jax.tree.leaves(whole), [jax.tree.leaves(one) for one in each]
    assert len(leaves) == len(rows[0]), where
    for place, leaf in enumerate(leaves):
        expected = np.stack([np.asarray(row[place]) for row in rows])
        assert np.shape(leaf) == expected.shape, where
        if expected.dtype.kind in "USb":
            assert (np.asarray(leaf) == expected).all(), where
        else:
            least = 1e-13 * np.abs(expected[np.isfinite(expected)]).max(initial=0.0)
            np.testing.assert_allclose(leaf, expected, rtol=1e-12, atol=least, err_msg=where)


def _at(result, index: int):
    numbers, rest = eqx.partition(result, eqx.is_array)
    return eqx.combine(jax.tree.map(lambda leaf: leaf[index], numbers), rest)


@pytest.mark.parametrize("name", MADE)
def test_properties_and_helpers_of_a_batch_are_those_of_its_designs(name):
    whole, alone = _made(name)
    designs = [_at(whole, index) for index in range(len(SCALES))]
    fields, expected = (eqx.filter(one, eqx.is_array) for one in (designs[1], alone))
    _close(fields, expected, name)
    nodes = [list(_results(one)) for one in (whole, alone, *designs)]
    assert len({len(found) for found in nodes}) == 1
    assert {type(one).__name__ for one in nodes[0]} == set(MADE[name][2].split())
    for one, single, *each in zip(*nodes, strict=True):
        kind = type(one).__name__
        assert one.batch_shape == (len(SCALES),), kind
        assert single.batch_shape == (), kind
        values, alone_values = _read(one), _read(single)
        by_design = [_read(design) for design in each]
        for member, value in values.items():
            rows = [row[member] for row in by_design]
            if _same_for_all(kind, member):
                assert all(row == value for row in rows)
                continue
            _agree(value, rows, f"{kind}.{member}")
            # And the design that was never part of a batch.
            if not isinstance(alone_values[member], str | tuple | type(None)):
                _close(rows[1], alone_values[member], f"{kind}.{member} alone")
            else:
                assert repr(rows[1])[:40] == repr(alone_values[member])[:40]


def _close(found, expected, where: str) -> None:
    pairs = zip(jax.tree_util.tree_leaves_with_path(found), jax.tree.leaves(expected), strict=True)
    for (path, one), other in pairs:
        name = jax.tree_util.keystr(path)
        if "residual" in name or name.endswith("equilibrium.error"):  # nothing but rounding
            continue
        if isinstance(other, np.ndarray | jax.Array) and np.asarray(other).dtype.kind in "fc":
            least = 1e-9 * np.abs(other).max(initial=0.0)
            np.testing.assert_allclose(one, other, rtol=1e-7, atol=least, err_msg=where)


def _final(base):
    """The classes derived from one that have no further ones of their own."""
    derived = base.__subclasses__()
    return set().union(*map(_final, derived)) if derived else {base}


def test_every_class_of_results_is_among_them():
    public = {
        one
        for one in vars(prsm).values()
        if inspect.isclass(one)
        and issubclass(one, eqx.Module)
        and not one.__module__.startswith(_NO_RESULTS)
        and one.__name__ not in OF_ONE_DESIGN
    }
    # All of AbstractResult that are defined anywhere, and all that a user can name.
    assert {one for one in public if not issubclass(one, AbstractResult)} == set()
    tested = {name for _, _, classes in MADE.values() for name in classes.split()}
    assert {one.__name__ for one in public | _final(AbstractResult)} == tested


def test_helpers_that_take_arrays_of_the_batch():
    whole, _ = _made("load_distribution")
    numbers, rows = whole.by_roller(whole.nut.roller_load)
    for index in range(len(SCALES)):
        one = _at(whole, index)
        expected = one.by_roller(one.nut.roller_load)
        assert numbers == expected[0]
        np.testing.assert_array_equal(rows[index], expected[1])
    diagram, _ = _made("campbell")
    for place, order in enumerate(diagram.orders):
        families = diagram.excited_family(order, 1)
        one_by_one = [_at(diagram, index) for index in range(len(SCALES))]
        assert list(families) == [one.excited_family(one.orders[place], 1) for one in one_by_one]


#: Functions that describe a mechanism and take any, batches too.
_TAKE_ANY = {"all_parameters", "assumptions", "get_parameter", "set_parameter"}
_LATER = {"run": None, "scenario": None, "parameter": "lead", "values": [1.0], "quantities": ["x"]}
_LATER |= {"excitation": "screw u", "response": "screw u", "frequency": [1.0], "speed": [1.0]}
_LATER |= {"axes": {}, "path": "never.toml", "side": "screw", "capacity": 1.0, "spectrum": None}


def _doors() -> list[str]:
    found = []
    for name, one in vars(prsm).items():
        if inspect.isfunction(one) and name not in _TAKE_ANY:
            first = next(iter(inspect.signature(one).parameters), "")
            if first in ("mechanism", "stage", "thread"):
                found.append(name)
    return found


@pytest.mark.parametrize("name", _doors())
def test_a_batch_is_refused_at_every_door(name, unchecked, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    batch = _batch("wu2022")
    function = getattr(prsm, name)
    parameters = inspect.signature(function).parameters
    parts = {"mechanism": batch, "stage": batch.stages[0], "thread": batch.stages[0].thread}
    first = parts[next(iter(parameters))]
    more = {k: _LATER[k] for k, p in parameters.items() if p.default is p.empty and k in _LATER}
    with pytest.raises((ValueError, prsm.FileError), match=r"shape \(3,\).*batch") as refusal:
        function(first, **more)
    assert "\n" not in str(refusal.value)
    if name not in ("dump", "dumps"):
        assert str(refusal.value).startswith(f"{name}: ")
        one_by_one = name in (
            *("check", "strength_checks", "optimise", "pareto", "sweep", "calibrate", "tolerance"),
            "explain",
        )
        assert ("jax.vmap" in str(refusal.value)) != one_by_one
    assert list(tmp_path.iterdir()) == []
