"""Tolerances in README's table of validations stand in the tests that it speaks of."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
#: Beginning of a row, a number in its last column, and the test that asserts it. Those of
#: `meshing points`, `elliptical Hertz contact` and `natural frequencies` are the benchmarks'.
ASSERTED = [
    (
        "slip orthogonal",
        "1e-12",
        "geometry/test_analytic_meshing.py::test_slip_is_tangential_at_every_carrier_speed",
    ),
    (
        "slip and spin",
        "2e-7",
        "contact/test_analytic_slip_and_spin.py::test_long_ellipses_against_direct_integration",
    ),
    (
        "stress below",
        "1e-11",
        "contact/test_analytic_subsurface.py::"
        "test_axis_by_closed_form_by_quadrature_and_by_textbook",
    ),
    (
        "stress below",
        "1e-9",
        "contact/test_analytic_subsurface.py::test_against_direct_integration_of_point_forces",
    ),
    (
        "loads of threads",
        "1e-9",
        "load_sharing/test_analytic_load_sharing.py::test_rigid_roller_in_closed_form",
    ),
    (
        "loads of threads",
        "1e-6",
        "load_sharing/test_analytic_load_sharing.py::test_against_a_minimisation_of_the_energy",
    ),
    (
        "loads of threads",
        "1e-8",
        "load_sharing/test_analytic_load_sharing.py::test_work_is_stored_energy",
    ),
    (
        "natural frequencies",
        "1e-13",
        "vibration/test_analytic_vibration.py::test_symmetry_reduction_equals_the_full_problem",
    ),
    ("modes by symmetry", "1e-12", "vibration/test_analytic_modes.py::test_both_paths_agree"),
    ("derivatives at repeated", "1e-5", "vibration/test_gradients_modes.py::test_clusters"),
    (
        "power balance",
        "1e-12",
        "dynamics/steady/test_analytic_steady.py::test_power_balance_of_random_mechanisms",
    ),
    (
        "accelerations and shared",
        "1e-12",
        "dynamics/newton_euler/test_analytic_newton.py::test_newton_accelerates_the_carriers_as_lagrange",
    ),
    (
        "settling of carriers",
        "3e-11",
        "dynamics/speed_drive/test_analytic_settling.py::test_closed_form_and_integration_agree",
    ),
    (
        "settling of carriers",
        "5e-12",
        "dynamics/speed_drive/test_analytic_settling.py::test_closed_form_against_scipy",
    ),
    (
        "receptances",
        "40",
        "response/test_response_receptance.py::test_direct_solution_and_modal_sum_agree",
    ),
    (
        "receptances",
        "10",
        "response/test_response_receptance.py::test_the_power_of_the_force_is_what_damping_takes",
    ),
    (
        "quasi-steady transients",
        "3e-10",
        "dynamics/speed_drive/test_analytic_quasi_steady.py::test_error_is_below_the_estimate",
    ),
    ("extreme scenes", "1e-6", "dynamics/speed_drive/test_extreme_dynamics.py::BOUND"),
    ("extreme scenes", "2e-6", "dynamics/speed_drive/test_extreme_dynamics.py::BOUND"),
    (
        "stick and slip",
        "1e-7",
        "dynamics/torque_drive/test_analytic_torque_carriers.py::test_against_scipy",
    ),
    (
        "stick and slip",
        "2e-8",
        "dynamics/torque_drive/test_analytic_torque_carriers.py::test_against_scipy",
    ),
    (
        "excitation orders",
        "1e-5",
        "response/test_response_counted_orders.py::test_order_is_what_passes_per_turn",
    ),
    (
        "LuGre",
        "1e-14",
        "dynamics/speed_drive/test_analytic_lugre.py::test_steady_slip_is_stribecks_law",
    ),
    ("self-locking", "1e-14", "dynamics/steady/test_analytic_locking.py::test_limits_of_one_stage"),
    (
        "gradients, forward",
        "1e-7",
        "quantities/test_gradients_examples.py::test_forward_and_reverse_against_central_differences",
    ),
]


def _named(path: Path, name: str) -> ast.AST:
    """A function or a constant of a module."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        targets = [ast.unparse(t) for t in getattr(node, "targets", ())]
        if getattr(node, "name", None) == name or name in targets:
            return node
    raise AssertionError(f"{path.name} has no {name}")


@pytest.mark.parametrize(("row", "number", "place"), ASSERTED)
def test_a_tolerance_of_the_table_is_asserted(row, number, place):
    (line,) = [
        one
        for one in (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
        if one.startswith(f"| {row}")
    ]
    claimed = re.findall(r"\d+(?:\.\d+)?(?:e-\d+)?", line.split("|")[3])
    assert number in claimed
    file, name = place.split("::")
    node = _named(ROOT / "tests" / file, name)
    constants = {one.value for one in ast.walk(node) if isinstance(one, ast.Constant)}
    assert float(number) in constants, f"{place} does not speak of {number}"
