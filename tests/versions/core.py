"""Tests of the core paths: reading, contact, modes, motion, derivatives, design, sweep, report.

Files, or single tests of a file where the rest takes long and uses no other package.
"""

TESTS = (
    "tests/file/test_file_examples.py",
    "tests/file/test_file_units.py",
    "tests/file/test_file_edit.py",
    "tests/contact/test_analytic_hertz.py",
    "tests/vibration/test_analytic_modes.py::test_both_paths_agree",
    "tests/vibration/test_analytic_modes.py::test_rollers_that_differ",
    "tests/dynamics/steady/test_analytic_steady.py::test_exact_efficiency",
    "tests/dynamics/steady/test_analytic_steady.py::test_power_balance_of_random_mechanisms",
    "tests/dynamics/speed_drive/test_analytic_settling.py::test_closed_form_against_scipy",
    "tests/dynamics/speed_drive/test_analytic_settling.py::test_closed_form_and_integration_agree",
    "tests/dynamics/solvers/test_gradients_windows.py::test_a_drive_that_jumps_has_its_left_value_at_the_end_of_a_step",
    "tests/numerics/test_numerics_transposed.py",
    "tests/optimisation/test_optimise_analytic.py::test_minimum_at_a_bound",
    "tests/optimisation/test_optimise_analytic.py::test_constrained_bowl_and_its_price",
    "tests/sensitivities/test_sensitivity_values.py::test_gradients_against_central_differences",
    "tests/sweeps/test_sweep_values.py",
    "tests/sweeps/test_sweep_stores.py",
    "tests/report/document/test_report_write.py",
    "tests/cli/test_cli_targets.py",
    "tests/programs/test_threads_fork.py",
)
