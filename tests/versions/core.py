"""Tests of the core paths: reading, contact, modes, motion, derivatives, design, sweep, report."""

TESTS = (
    "tests/file/test_file_examples.py",
    "tests/file/test_file_units.py",
    "tests/file/test_file_edit.py",
    "tests/analytic/test_analytic_hertz.py",
    "tests/analytic/test_analytic_meshing.py",
    "tests/analytic/test_analytic_modes.py",
    "tests/analytic/test_analytic_steady.py",
    "tests/analytic/test_analytic_settling.py",
    "tests/optimise/test_optimise_analytic.py",
    "tests/sensitivity/test_sensitivity_values.py",
    "tests/sweep/test_sweep.py",
    "tests/sweep/test_sweep_stores.py",
    "tests/report/test_report_write.py",
    "tests/cli/test_cli_targets.py",
    "tests/threads/test_threads_fork.py",
)
