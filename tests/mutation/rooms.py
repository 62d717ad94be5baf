"""The core rooms, and which quick tests look at each."""

from pathlib import Path

#: By the start of a file's path inside of the package, the more particular first: tests in the
#: order in which they are tried. Slow tests are left out.
TESTS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("geometry/_flanks", ("analytic/test_analytic_flanks.py", "analytic/test_analytic_meshing.py")),
    ("geometry/_ring", ("analytic/test_analytic_line_contact.py",)),
    (
        "geometry/_checks",
        ("analytic/test_analytic_single_faults.py", "analytic/test_analytic_findings.py"),
    ),
    ("geometry", ("analytic/test_analytic_meshing.py", "literature/test_literature_meshing.py")),
    (
        "contact/_line",
        ("analytic/test_analytic_line_contact.py", "analytic/test_analytic_subsurface.py"),
    ),
    ("contact/_stress", ("analytic/test_analytic_subsurface.py",)),
    ("contact/_subsurface", ("analytic/test_analytic_subsurface.py",)),
    ("contact/_axis_stress", ("analytic/test_analytic_subsurface.py",)),
    (
        "contact",
        (
            "analytic/test_analytic_hertz.py",
            "literature/test_literature_contact.py",
            "analytic/test_analytic_subsurface.py",
        ),
    ),
    (
        "halfspace",
        (
            "analytic/test_analytic_halfspace.py",
            "analytic/test_analytic_halfspace_flanks.py",
            "extreme/test_extreme_halfspace.py",
        ),
    ),
    (
        "load_sharing",
        (
            "analytic/test_analytic_load_sharing.py",
            "analytic/test_analytic_single_faults.py",
            "extreme/test_extreme_load_sharing.py",
        ),
    ),
    ("stiffness", ("analytic/test_analytic_load_sharing.py", "analytic/test_analytic_modes.py")),
    (
        "strength/_rel",
        ("analytic/test_analytic_rating_life.py", "analytic/test_analytic_strength.py"),
    ),
    (
        "strength",
        (
            "analytic/test_analytic_strength.py",
            "analytic/test_analytic_rating_life.py",
            "analytic/test_analytic_single_faults.py",
        ),
    ),
    (
        "modal",
        (
            "analytic/test_analytic_modes.py",
            "analytic/test_analytic_distinct_frequencies.py",
            "analytic/test_analytic_unequal_rollers.py",
            "analytic/test_analytic_single_faults.py",
            "literature/test_literature_planetary_gear.py",
            "report/test_report_modes.py",
        ),
    ),
    ("dynamics/_settling", ("analytic/test_analytic_settling.py",)),
    ("dynamics/_rosenbrock", ("analytic/test_analytic_rosenbrock.py",)),
    ("dynamics/_quasi", ("analytic/test_analytic_quasi_steady.py",)),
    ("dynamics/_bristle", ("analytic/test_analytic_lugre.py",)),
    ("dynamics/_locking", ("analytic/test_analytic_locking.py",)),
    ("dynamics/_screw_friction", ("analytic/test_analytic_screw_friction.py",)),
    ("dynamics/_torque", ("analytic/test_analytic_torque_drive.py",)),
    ("dynamics/_smooth_torque", ("analytic/test_analytic_torque_drive.py",)),
    ("dynamics/_transient_q", ("analytic/test_analytic_transient_quantities.py",)),
    (
        "dynamics",
        (
            "analytic/test_analytic_steady.py",
            "analytic/test_analytic_single_faults.py",
            "analytic/test_analytic_newton.py",
            "analytic/test_analytic_transient.py",
            "analytic/test_analytic_settling.py",
            "analytic/test_analytic_torque_drive.py",
        ),
    ),
    (
        "response",
        (
            "response/test_response_receptance.py",
            "response/test_response_excitation.py",
            "response/test_response_counted_orders.py",
            "response/test_response_elimination.py",
        ),
    ),
    (
        "quantities",
        (
            "analytic/test_analytic_strength.py",
            "analytic/test_analytic_rating_life.py",
            "analytic/test_analytic_transient_quantities.py",
            "analytic/test_analytic_vibration.py",
            "golden/test_golden_examples.py",
        ),
    ),
    (
        "findings",
        (
            "analytic/test_analytic_findings_numbers.py",
            "analytic/test_analytic_findings.py",
            "analytic/test_analytic_single_faults.py",
            "analytic/test_analytic_strength.py",
        ),
    ),
    ("sensitivity", ("sensitivity/test_sensitivity_values.py",)),
    (
        "optimise",
        (
            "optimise/test_optimise_analytic.py",
            "analytic/test_analytic_single_faults.py",
            "optimise/test_optimise_mechanism.py",
        ),
    ),
    ("sweep", ("sweep/test_sweep.py", "analytic/test_analytic_single_faults.py")),
    ("mechanism/_profiles", ("analytic/test_analytic_profiles.py",)),
    ("mechanism/_sequences", ("analytic/test_analytic_profiles.py",)),
    (
        "mechanism",
        (
            "analytic/test_analytic_masses.py",
            "analytic/test_analytic_steady.py",
            "analytic/test_analytic_profiles.py",
            "file/test_file_examples.py",
        ),
    ),
)
#: Rooms that are drawn from.
ROOMS = tuple(dict.fromkeys(start.partition("/")[0] for start, _ in TESTS))


def quick_tests(path: str) -> tuple[str, ...]:
    """Tests of a file of the package, given as `geometry/_meshing.py`."""
    return next(tests for start, tests in TESTS if path.startswith(start))


def core_files(package: Path) -> list[Path]:
    """Files of the core, in order."""
    return sorted(
        path
        for room in ROOMS
        for path in (package / room).glob("*.py")
        if path.name != "__init__.py"
    )
