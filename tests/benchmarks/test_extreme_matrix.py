"""The matrix of extremes in a reduced form: no bad cell, and faults put in that it has to find."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from benchmarks.extremes import command, structures
from benchmarks.extremes.cells import Cell, Table, is_bad, joined
from benchmarks.extremes.differences import Slope
from benchmarks.extremes.judge import Programs, judge
from benchmarks.extremes.plan import reduced_rows, rows_of
from benchmarks.extremes.slopes import slope_cell
from benchmarks.extremes.structures import Ellipse, Structure, columns_of, structure
from prsm_jax.contact import hertz_contact

#: Structures without a bad cell in the full run, `python -m benchmarks extremes`.
REDUCED = ("hertz", "steady_1", "steady_2")


def run(one: Structure, rows) -> Table:
    """A table of these rows."""
    compiled, table = Programs(one), Table(one.name, columns_of(one))
    base, _ = compiled.values(compiled.leaves)
    for row in rows:
        cells, _ = judge(compiled, row, base, seed=14)
        table.rows.append(row.as_json())
        table.cells[row.name] = cells
    return table


@pytest.mark.parametrize("name", REDUCED)
def test_no_cell_is_bad(name):
    one = structure(name)
    table = run(one, reduced_rows(one))
    assert not table.bad()
    counts = table.counts()
    judged = sum(number for status, number in counts.items() if status != "absent")
    assert judged > 30
    # Refusing everything would be a way to be never wrong.
    assert counts["agrees"] > 0.1 * judged


def _with(change) -> Structure:
    """The bare contact with something done to its results."""
    one = structures.hertz()

    def outputs(ellipse: Ellipse):
        values = change(ellipse, one.outputs(ellipse)[0])
        # A flag that knows only what the values say.
        return values, {n: jnp.where(jnp.isfinite(v), 0, 1) for n, v in values.items()}

    return dataclasses.replace(one, outputs=outputs)


def _swallowed(ellipse, values):
    # What `where(force > 0, …, 0)` makes of NaN.
    loaded = ellipse.force > 0
    return {name: jnp.where(loaded, value, 0.0) for name, value in values.items()}


@jax.custom_jvp
def _same(value):
    return value


@_same.defjvp
def _same_jvp(primals, tangents):
    return primals[0], 1.01 * tangents[0]


def _wrong_slope(_, values):
    return values | {"approach": _same(values["approach"])}


@jax.custom_jvp
def _same_forward(value):
    return value


@_same_forward.defjvp
def _same_forward_jvp(primals, tangents):
    # Right as it stands, and a hundredth too large transposed.
    slope = jax.custom_derivatives.linear_call(lambda _, t: t, lambda _, c: 1.01 * c, (), *tangents)
    return primals[0], slope


def _wrong_reverse(_, values):
    return values | {"approach": _same_forward(values["approach"])}


def _wrong_value(_, values):
    return values | {"semi_major": values["semi_major"] * (1 + 1e-6)}


def _not_a_number(ellipse, values):
    # The gradient of a square root at 0.
    at_circle = jnp.sqrt(ellipse.difference_squared) * 0.0
    return values | {"stiffness": values["stiffness"] + at_circle}


@pytest.mark.parametrize(
    ("change", "status", "kind"),
    [
        (_swallowed, "accepted", "value"),
        (_wrong_slope, "wrong_gradient", "forward"),
        (_wrong_reverse, "wrong_gradient", "reverse"),
        (_wrong_value, "wrong_value", "value"),
        (_not_a_number, "not_finite", "forward"),
    ],
)
def test_a_fault_is_found(change, status, kind):
    one = _with(change)
    table = run(one, reduced_rows(one))
    assert (kind, status) in {(where, cell.status) for _, _, where, cell in table.bad()}


@pytest.mark.parametrize(("change", "place"), [(_wrong_slope, 1), (_wrong_reverse, 2)])
def test_a_wrong_derivative_is_found_in_every_row(change, place):
    """What rounding may do must not forgive a fault of a hundredth."""
    one = structures.hertz()
    rows = reduced_rows(one)
    sound, faulty = (run(which, rows).cells for which in (one, _with(change)))
    agreed = {name for name, cells in sound.items() if cells["approach"][place].status == "agrees"}
    found = {name for name in agreed if is_bad(faulty[name]["approach"][place].status)}
    assert len(found) >= 20
    # Without a force the slope is 0, and so is a hundredth of it; float32 is held to less.
    unseen = {"force × 0", "force: zero", "force: negative", "as it is, in float32"}
    assert agreed - found <= unseen


def test_rows_are_seeded_and_cover_every_number():
    one = structure("steady_2")
    rows = rows_of(one, count=20)
    assert rows == rows_of(one, count=20)
    assert rows != rows_of(one, count=20, seed=15)
    spoiled = {row.number for row in rows if row.group == "number"}
    leaves = [x for x in jax.tree.leaves(one.base) if np.issubdtype(x.dtype, np.inexact)]
    assert len(spoiled) == len(leaves)
    offered = [row.offered for row in rows if row.group == "number"]
    assert offered.count("NaN") == offered.count("zero") == len(leaves)


def test_statuses_that_are_faults():
    assert is_bad("not_finite")
    assert is_bad("hang")
    assert not is_bad("refused")
    assert not is_bad("open")


def test_the_bare_contact_is_hertz():
    """The matrix calls the package as users do."""
    ellipse = structures.hertz().base
    given = ellipse.force, ellipse.total, ellipse.difference_squared, ellipse.modulus
    found = hertz_contact(*given)
    values, codes = structures.hertz().outputs(ellipse)
    assert float(values["max_pressure"]) == float(found.max_pressure)
    assert int(codes["max_pressure"]) == 0


def test_parts_of_a_structure_make_one_table():
    """Rows and cells of both parts; other structures stay apart."""

    def part(structure, *names, status="agrees"):
        rows = [{"name": name, "group": "single", "changes": []} for name in names]
        cell = Cell(status, 0.0)
        return Table(structure, ("x",), rows, {name: {"x": (cell,) * 3} for name in names})

    first, other = joined([part("a", "one"), part("b", "two"), part("a", "three", "four")])
    assert [row["name"] for row in first.rows] == ["one", "three", "four"]
    assert first.counts()["agrees"] == 9
    # A row that was run again replaces the former one.
    (again,) = joined([part("a", "one", "two"), part("a", "one", status="refused")])
    assert [row["name"] for row in again.rows] == ["one", "two"]
    assert again.counts() == {"agrees": 3, "refused": 3}
    assert other.structure == "b"


def test_a_process_without_a_row_is_a_fault(monkeypatch, tmp_path, capsys):
    """It printed "0 cells, 0 bad" and the exit status was 0."""
    monkeypatch.setenv("XLA_FLAGS", "--no_such_flag_of_the_compiler=true")
    assert command.main(["hertz", "--rows", "1", "--out", str(tmp_path)]) == 1
    assert "before its first row" in capsys.readouterr().out


def test_a_value_that_jumps_has_no_derivative_and_hides_no_other():
    """As the force in a sample on a reversal: its differences have no limit, the rest have one."""
    value, slope = np.array([2.0, 3.0]), np.array([1.0, 0.5])
    measured = Slope(slope, np.array([1e-9, 40.0]), np.zeros(2))

    def verdict(given, histories=True):
        return slope_cell(value, np.array(given), measured, 1e-6, histories, False)

    assert verdict([1.0, 1e12]) == Cell("open", pytest.approx(0.0), "jump")  # pyright: ignore[reportArgumentType]
    assert verdict([1.1, 1e12]).status == "wrong_gradient"
    assert verdict([1.0, 1e12], histories=False).status == "wrong_gradient"
    # An error that is small beside the values is not that of a jump.
    measured = Slope(slope, np.array([1e-9, 1e-9]), np.zeros(2))
    assert verdict([1.0, 1e12]).status == "wrong_gradient"
    assert verdict([1.0, 0.5]).status == "agrees"
