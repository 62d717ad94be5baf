"""The glossary has every number and every quantity, with the unit that the package declares."""

import re

import pytest

import prsm_jax as prsm
from prsm_jax.mechanism import DESIGN_VARIABLES
from tests.docs.glossary import PAGE, package_quantities, page


def test_the_tables_are_those_of_the_declarations():
    """Written by `python -m tests.docs.glossary`."""
    assert PAGE.read_text(encoding="utf-8") == page()


def _units_by_name(text):
    """Units of each name in the tables, read from the page alone."""
    units: dict[str, set[str]] = {}
    for table in re.findall(r"(?:^\|.*\|\n)+", text, flags=re.M):
        head, _, *rows = [re.split(r"(?<!\\)\|", line)[1:-1] for line in table.splitlines()]
        columns = [cell.strip() for cell in head]
        for row in rows:
            name, unit = (row[columns.index(one)].strip() for one in ("name", "unit"))
            # "N·s/m; N·m·s in `stage.friction.thrust_bearing`".
            several = [one.partition(" in ")[0] for one in unit.split("; ")]
            units.setdefault(name.strip("`"), set()).update(several)
    return units


@pytest.mark.parametrize("example", prsm.file.example_names())
def test_every_number_of_an_example_is_in_it(example):
    units = _units_by_name(PAGE.read_text(encoding="utf-8"))
    derived = {one.name for one in DESIGN_VARIABLES}
    for one in prsm.mechanism.all_parameters(prsm.load(example)):
        name = one.path.rpartition(".")[2]
        if name not in derived:
            assert {one.unit, "that of the value"} & units[name], (one.path, one.unit)


def test_every_quantity_is_in_it():
    text = PAGE.read_text(encoding="utf-8")
    units = _units_by_name(text[text.index("## Quantities") :])
    assert units == {q.name: {q.unit} for q in package_quantities()}


def test_symbols_have_the_unit_of_their_name():
    text = PAGE.read_text(encoding="utf-8")
    symbols, _, tables = text.partition("## Numbers of a mechanism")
    declared = _units_by_name(tables)
    for one in DESIGN_VARIABLES:
        declared.setdefault(one.name, set()).add(one.unit)
    found = _units_by_name(symbols)
    assert len(found) > 20
    for name, units in found.items():
        assert units <= declared[name], name
