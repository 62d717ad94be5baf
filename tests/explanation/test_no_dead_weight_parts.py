"""Every optional part of a mechanism is described, and leaves nothing behind when it is taken away.

Which parts there are is found here a second time, apart from `prsm_jax.explain`.
"""

import dataclasses
import importlib
import typing

import equinox as eqx
import jax
import numpy as np
import pytest
import tomlkit
from scenes import example

import prsm_jax as prsm
from prsm_jax.explanation import places, without
from prsm_jax.friction import friction_laws
from prsm_jax.mechanism import Mechanism, Stage

#: Its name in the package is that of the function.
room = importlib.import_module("prsm_jax.explanation._explain")
EXAMPLES = prsm.file.example_names()


def _modules_in(hint):
    """Classes of the mechanism anywhere in a type hint."""
    if isinstance(hint, type) and issubclass(hint, eqx.Module):
        return {hint}
    return set().union(*(_modules_in(one) for one in typing.get_args(hint)))


def _classes():
    """All classes that a mechanism may consist of."""
    found, new = set(), {Mechanism}
    while new:
        cls = new.pop()
        found.add(cls)
        for hint in typing.get_type_hints(cls).values():
            new |= _modules_in(hint) - found
    return found


def undescribed(cls):
    """Optional fields of a class that do not say what is missed without them."""
    hints = typing.get_type_hints(cls)
    return [
        f"{cls.__name__}.{field.name}"
        for field in dataclasses.fields(cls)
        if type(None) in typing.get_args(hints[field.name])
        and not field.metadata.get("without" if "unit" not in field.metadata else "description")
    ]


def test_every_optional_field_says_what_is_missed_without_it():
    classes = _classes() | set(friction_laws().values())
    assert {
        Stage,
        prsm.mechanism.Thread,
        prsm.friction.LuGreFriction,
        prsm.mechanism.SplitNut,
    } <= classes
    assert not [name for cls in classes for name in undescribed(cls)]


def test_a_new_field_without_a_word_on_it_is_found():
    class Oiled(Stage):
        oil: prsm.friction.Drag | None = None

    assert undescribed(Oiled) == ["Oiled.oil"]


def _optional(module, name):
    """Names of all optional fields of a module and of what is in it, and whether they are there."""
    hints = typing.get_type_hints(type(module))
    for field in dataclasses.fields(module):
        value, own = getattr(module, field.name), f"{name}.{field.name}".removeprefix(".")
        if field.metadata.get("same_table"):
            # The numbers of a law stand in the table of the spline or bearing that it is of.
            yield from _optional(value, name)
            continue
        # The radius of those is there or not as the law needs it.
        needed = field.metadata.get("law_decides")
        if type(None) in typing.get_args(hints[field.name]) and not needed:
            yield own, value is not None
        if field.name == "unequal_roller":
            yield own, len(value) > 0
        for index, one in enumerate(value if isinstance(value, tuple) else [value]):
            if isinstance(one, eqx.Module):
                inner = f"{own}.{index + 1}" if isinstance(value, tuple) else own
                yield from _optional(one, inner)


@pytest.mark.parametrize("name", EXAMPLES)
def test_no_optional_field_of_an_example_is_left_out(name):
    one = example(name)
    found = {p.name: p.present for p in places(one)}
    # A stage more or less is a part as well, though no field.
    count = len(one.stages)
    assert found.pop("stage.2") == (count == 2)
    expected = {key.replace("stages.", "stage."): there for key, there in _optional(one, "")}
    assert found == expected


def _tables(name, place):
    """An example's own text with a part taken out of it; `None` where it is not a part of that."""
    document = tomlkit.parse(prsm.file.example_text(name))
    # What is to be optimised takes long to read.
    document.pop("optimise", None)
    path: list = [
        {"stages": "stage", "design_problem": "optimise"}.get(key, key) for key in place.path
    ]
    inner: typing.Any = document
    for key in path[:-1]:
        inner = inner[key]
    if path[-1] not in inner and not isinstance(path[-1], int):
        return None
    del inner[path[-1]]
    return tomlkit.dumps(document)


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_part_taken_away_is_a_part_that_was_never_there(name):
    """The same pytree: no program can tell one from the other, so none has a trace of the part."""
    one, compared = dataclasses.replace(example(name), design_problem=None), 0
    for place in places(one):
        if not place.present:
            continue
        text = _tables(name, place)
        if text is None:
            continue
        try:
            never = prsm.loads(text)
        except prsm.PrsmError:
            # Another part needs it, or the file does.
            continue
        taken = without(one, place)
        if place.name.endswith(".friction.thread"):
            # The last law may leave a table without a key, which a file does not have.
            continue
        assert jax.tree.structure(never) == jax.tree.structure(taken), place.name
        jax.tree.map(np.testing.assert_array_equal, never, taken)
        compared += 1
    assert compared >= 8


@pytest.fixture(scope="module", params=["wu2022", "li2020_two_stage", "actuator_mission"])
def counted(request):
    return request.param, prsm.explain(example(request.param))


#: Parts whose absence is a number as well, such as a spring of stiffness 0.
_NOTHING_SAVED = ("support",)


def test_what_is_read_costs_equations(counted):
    """More with the part than without, in every program that reads its numbers."""
    name, found = counted
    programs = {p.name for p in found.programs if p.account is not None}
    assert "steady_state" in programs
    costly = set()
    for part in found.carried:
        for program, cost in part.costs.items():
            assert program in programs
            if cost.needed is not None:
                assert cost.absent is None
                continue
            kind = part.name.rpartition(".")[2]
            assert cost.equations is not None
            if cost.absent is not cost.present and kind not in _NOTHING_SAVED:
                costly.add(kind)
                assert cost.equations > 0 or _replaces(part), (part.name, program)
    expected = {
        "wu2022": {"gear", "carrier", "ring_gear"},
        "li2020_two_stage": {"friction", "spline", "thrust_bearing", "stage", "gear"},
        "actuator_mission": {"drag", "thrust_bearing", "load_sharing", "tooth", "gear"},
    }[name]
    assert expected - {"stage"} <= costly | {"2"}


def _replaces(part):
    """Whether a part stands in the place of something that is computed without it.

    Without drag all forces of `actuator_mission` are proportional to the load, and the steady state
    is computed for a unit load where there is none.
    """
    return part.name.endswith((".stiffness", ".friction.thread", ".friction.drag"))


def test_numbers_that_no_program_reads_cost_nothing(monkeypatch):
    """What is not traced anew, since its numbers are not read, has the same program without it."""
    one = example("li2020_two_stage")
    quick = prsm.explain(one, programs=["steady_state"], numbers=True)
    count = room._Counted._count

    def everything(self, mechanism, same):
        account, _ = count(self, mechanism, same)
        return account, frozenset(room.number_paths(one))

    monkeypatch.setattr(room._Counted, "_count", everything)
    slow = prsm.explain(one, programs=["steady_state"], numbers=True)
    for part in slow.carried:
        assert (
            part.costs["steady_state"].equations
            == quick.part(part.name).costs["steady_state"].equations
        ), part.name
