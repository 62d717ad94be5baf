"""The core rooms, and which quick tests look at each."""

from pathlib import Path

_FOLDER = Path(__file__).parents[1]

#: By the start of a file's path inside of the package, the more particular first: files of tests,
#: `analytic/hertz` for `test_analytic_hertz.py`, wherever it is. Slow tests are left out.
_TESTS: tuple[tuple[str, str], ...] = (
    ("numerics", "numerics/jacobi numerics/solves response/elimination"),
    ("geometry/_flank_ends", "analytic/truncation analytic/single_faults"),
    ("geometry/_ring", "analytic/line_contact"),
    ("geometry/_curvature", "analytic/meshing analytic/truncation analytic/halfspace_flanks"),
    (
        "geometry/_checks",
        "analytic/construction analytic/single_faults analytic/findings_numbers analytic/findings",
    ),
    ("geometry", "analytic/meshing literature/meshing analytic/steady golden/examples"),
    ("contact/_line_c", "analytic/line_contact analytic/subsurface"),
    ("contact/stress/_line_s", "analytic/subsurface"),
    ("contact/stress/_stress", "analytic/subsurface analytic/strength"),
    (
        "contact/stress/_subsurface",
        "analytic/subsurface analytic/strength analytic/halfspace_flanks",
    ),
    ("contact/stress/_axis_stress", "analytic/subsurface"),
    ("contact/special_functions/_carlson", "analytic/subsurface"),
    ("contact/special_functions/_incomplete", "analytic/subsurface gradients/every_number"),
    ("contact/_truncation", "analytic/truncation gradients/truncation"),
    ("contact/_edge_pressure", "analytic/edge_pressure"),
    ("contact/_slip_and_spin", "analytic/slip_and_spin analytic/spin_losses analytic/steady"),
    ("contact/hertz/_methods", "approximations/outside analytic/hertz"),
    ("contact", "analytic/hertz literature/contact analytic/subsurface gradients/limits"),
    ("halfspace/_peak", "analytic/halfspace_peak analytic/halfspace"),
    ("halfspace/_equilibrium", "gradients/halfspace analytic/halfspace extreme/halfspace"),
    (
        "halfspace",
        "analytic/ends_of_laws analytic/halfspace analytic/halfspace_flanks extreme/halfspace "
        "analytic/line_contact analytic/subsurface analytic/single_faults gradients/halfspace",
    ),
    ("load_sharing/_flank_law", "analytic/ends_of_laws analytic/load_sharing"),
    ("load_sharing/_large", "analytic/load_sharing extreme/load_sharing"),
    (
        "load_sharing",
        "analytic/load_sharing analytic/single_faults analytic/axial_stiffness "
        "extreme/load_sharing gradients/load_sharing golden/examples",
    ),
    (
        "stiffness",
        "literature/vibration analytic/load_sharing analytic/axial_stiffness analytic/vibration "
        "analytic/unequal_rollers analytic/modes",
    ),
    ("strength/_reliability", "analytic/rating_life analytic/strength"),
    ("strength/_edges", "analytic/edge_pressure analytic/truncation"),
    (
        "strength/_truncation",
        "analytic/truncation_in_use analytic/truncation gradients/truncation",
    ),
    ("strength/_subsurface", "analytic/strength analytic/subsurface"),
    (
        "strength",
        "analytic/ends_of_laws analytic/strength analytic/rating_life analytic/single_faults "
        "analytic/truncation gradients/strength",
    ),
    (
        "vibration/_frequency_loci",
        "report/modes analytic/distinct_frequencies",
    ),
    ("vibration/arrowhead/_quartic", "analytic/secular analytic/vibration"),
    (
        "vibration/arrowhead/_arrowhead",
        "gradients/modes analytic/vibration analytic/distinct_frequencies",
    ),
    (
        "vibration/arrowhead/_secular",
        "analytic/secular analytic/vibration analytic/distinct_frequencies",
    ),
    (
        "vibration/model/_system",
        "analytic/vibration_system analytic/vibration analytic/unequal_rollers",
    ),
    (
        "vibration",
        "analytic/vibration analytic/modes analytic/distinct_frequencies analytic/unequal_rollers "
        "analytic/single_faults literature/planetary_gear gradients/modes",
    ),
    (
        "friction",
        "analytic/spin_losses analytic/lugre analytic/screw_friction analytic/regularised "
        "friction/laws_outside",
    ),
    ("dynamics/speed_drive/_closed_form", "analytic/settling"),
    ("dynamics/forces/_chain", "analytic/settling analytic/steady analytic/newton"),
    ("dynamics/forces/_reduced", "analytic/settling analytic/steady"),
    ("dynamics/solvers/rodasp/_solver", "analytic/rosenbrock"),
    ("dynamics/steady/_root_search", "analytic/small_newton analytic/rosenbrock analytic/steady"),
    ("dynamics/speed_drive/_quasi", "analytic/quasi_steady"),
    ("dynamics/torque_drive/_neglected", "analytic/torque_carriers analytic/quasi_steady"),
    ("dynamics/friction/_bristle", "analytic/lugre"),
    ("dynamics/speed_drive/_bristle", "analytic/lugre"),
    (
        "dynamics/friction/_rubbing",
        "analytic/spin_losses analytic/steady analytic/lugre analytic/regularised analytic/newton "
        "analytic/flanks",
    ),
    (
        "dynamics/friction/_thread_friction",
        "analytic/spin_losses analytic/steady analytic/newton analytic/regularised analytic/flanks",
    ),
    ("dynamics/newton_euler/_equations", "analytic/newton"),
    ("dynamics/newton_euler/_body_forces", "analytic/newton analytic/screw_friction"),
    ("dynamics/newton_euler/_free_bodies", "analytic/newton analytic/screw_friction"),
    ("dynamics/forces/_roller_balance", "analytic/newton analytic/single_faults"),
    ("dynamics/solvers/_driven", "analytic/driven_rate analytic/rosenbrock"),
    (
        "dynamics/torque_drive/_driven",
        "analytic/torque_carriers analytic/torque_drive analytic/torque_spin",
    ),
    ("dynamics/steady/_locking", "analytic/locking"),
    (
        "dynamics/friction/_screw_friction",
        "analytic/screw_friction analytic/steady analytic/newton",
    ),
    ("dynamics/torque_drive/_stick_slip", "analytic/torque_carriers analytic/torque_drive"),
    (
        "dynamics/torque_drive/_torque",
        "analytic/torque_drive analytic/torque_carriers analytic/transient_codes",
    ),
    ("dynamics/torque_drive/_smooth_torque", "analytic/torque_drive analytic/torque_carriers"),
    ("dynamics/torque_drive/_phases", "analytic/torque_carriers analytic/torque_drive"),
    (
        "dynamics/histories/_transient_q",
        "analytic/transient_quantities analytic/single_faults analytic/torque_carriers",
    ),
    (
        "dynamics",
        "analytic/steady analytic/screw_friction analytic/single_faults literature/dynamics "
        "analytic/newton analytic/transient_codes analytic/transient analytic/settling "
        "analytic/lugre analytic/quasi_steady",
    ),
    (
        "response",
        "response/counted_orders response/elimination response/receptance response/excitation",
    ),
    ("quantities/_assumptions", "analytic/assumptions"),
    ("quantities/entries/_truncation", "analytic/truncation"),
    ("quantities/entries/_axial", "analytic/axial_stiffness analytic/assumptions"),
    ("quantities/entries/_locking", "analytic/locking"),
    (
        "quantities",
        "analytic/strength analytic/rating_life analytic/single_faults literature/contact "
        "analytic/transient_quantities analytic/vibration gradients/strength golden/examples",
    ),
    (
        "findings/_truncation",
        "analytic/truncation analytic/truncation_remedy analytic/thread_extent "
        "analytic/findings_numbers analytic/findings",
    ),
    (
        "findings/_margin",
        "sweep/values analytic/findings_numbers analytic/construction analytic/findings",
    ),
    ("findings/_sharing", "analytic/assumptions analytic/findings analytic/findings_numbers"),
    ("findings/_locking", "analytic/locking analytic/findings analytic/findings_numbers"),
    (
        "findings",
        "analytic/findings_numbers analytic/construction analytic/single_faults "
        "analytic/strength analytic/findings",
    ),
    ("sensitivities", "sensitivity/values"),
    (
        "optimisation",
        "optimise/box analytic/search_methods optimise/analytic analytic/single_faults "
        "optimise/findings optimise/mechanism",
    ),
    ("calibration", "calibrate/analytic calibrate/recovery calibrate/files"),
    ("sweeps", "sweep/values analytic/single_faults"),
    ("scenario/_profiles", "analytic/profiles"),
    ("scenario/_sequences", "analytic/profiles"),
    ("scenario", "analytic/profiles file/scenarios"),
    ("mechanism/parameters/_follows", "sensitivity/values"),
    (
        "mechanism/parameters/_parameters",
        "analytic/construction sweep/values sensitivity/values optimise/analytic",
    ),
    (
        "mechanism",
        "analytic/construction analytic/ends_of_laws analytic/masses analytic/profiles "
        "analytic/steady "
        "analytic/unequal_rollers file/examples file/scenarios file/unequal_rollers "
        "analytic/findings_numbers file/errors",
    ),
)


#: Every file of tests by its name, which no two of them share.
_FILES = {path.name: path for path in _FOLDER.rglob("test_*.py")}


def _file(name: str) -> str:
    kind, _, topic = name.partition("/")
    return _FILES[f"test_{kind}_{topic}.py"].relative_to(_FOLDER).as_posix()


TESTS = tuple((start, tuple(_file(name) for name in names.split())) for start, names in _TESTS)
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
        for path in (package / room).rglob("*.py")
        if path.name != "__init__.py"
    )
