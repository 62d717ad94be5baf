"""prsm_jax: differentiable modelling of planetary roller screw mechanisms in JAX.

Data flows one way, and the folders are named after it: file → mechanism → geometry → contact →
halfspace, load_sharing → strength, stiffness → vibration, dynamics → response → quantities →
findings, sensitivities, optimisation, calibration, sweeps, uncertainty → studies → report. A
mechanism holds laws of `friction` and a `scenario`. `validation` compares with published numbers,
`explanation` lists the parts of a mechanism, `catalogue_sizes` builds mechanisms from a maker's
table, `dimensioning` chooses one of them, `exchange` writes files of other programs, `cli` is the
command line. The lowest layer is `fields` (numbers with units and limits), `numerics` (methods),
`programs` (how JAX compiles them), `text`, `process` (signals, files) and `results` (how results
are printed and kept).
"""

from . import process as process  # isort: skip # before JAX
from . import programs as programs  # isort: skip # it enables float64

from typing import TYPE_CHECKING

from . import (
    contact as contact,
    dynamics as dynamics,
    fields as fields,
    file as file,
    findings as findings,
    friction as friction,
    geometry as geometry,
    load_sharing as load_sharing,
    mechanism as mechanism,
    quantities as quantities,
    response as response,
    results as results,
    scenario as scenario,
    stiffness as stiffness,
    strength as strength,
    vibration as vibration,
)
from ._errors import (
    FileError as FileError,
    MissingDataError as MissingDataError,
    MissingExtraError as MissingExtraError,
    PrsmError as PrsmError,
    UnknownNameError as UnknownNameError,
)
from ._version import __version__ as __version__
from .contact import thread_contacts as thread_contacts
from .dynamics import (
    ClosedForm as ClosedForm,
    Diffrax as Diffrax,
    Explicit as Explicit,
    Implicit as Implicit,
    QuasiSteady as QuasiSteady,
    Rodasp as Rodasp,
    SteadyState as SteadyState,
    Transient as Transient,
    simulate as simulate,
    steady_state as steady_state,
)
from .file import (
    dump as dump,
    dumps as dumps,
    load as load,
    loads as loads,
)
from .findings import check as check, strength_checks as strength_checks
from .friction import FrictionLaw as FrictionLaw, friction_law as friction_law
from .geometry import mesh as mesh
from .mechanism import (
    Mechanism as Mechanism,
    Stage as Stage,
    get_parameter as get_parameter,
    set_parameter as set_parameter,
)
from .quantities import (
    assumptions as assumptions,
    compute as compute,
    quantity as quantity,
)
from .response import (
    campbell as campbell,
    frequency_response as frequency_response,
)
from .results import load_result as load_result, save_result as save_result
from .scenario import Scenario as Scenario, TorqueScenario as TorqueScenario
from .vibration import (
    Modes as Modes,
    modal as modal,
    spatial_modal as spatial_modal,
)

if TYPE_CHECKING:
    from . import (
        calibration as calibration,
        catalogue_sizes as catalogue_sizes,
        dimensioning as dimensioning,
        exchange as exchange,
        explanation as explanation,
        halfspace as halfspace,
        optimisation as optimisation,
        sensitivities as sensitivities,
        studies as studies,
        sweeps as sweeps,
        uncertainty as uncertainty,
    )
    from .calibration import calibrate as calibrate
    from .catalogue_sizes import catalogue_mechanism as catalogue_mechanism
    from .explanation import explain as explain
    from .optimisation import (
        Optimum as Optimum,
        ParetoFront as ParetoFront,
        optimise as optimise,
        pareto as pareto,
    )
    from .sensitivities import Sensitivity as Sensitivity, sensitivity as sensitivity
    from .studies import study as study
    from .sweeps import sweep as sweep
    from .uncertainty import tolerance as tolerance
else:
    #: Rooms that an analysis of one design does not use, and their names at the top: imported at
    #: first use, because they are a tenth of the time of an import.
    _AT_FIRST_USE = {
        "calibration": "calibrate",
        "catalogue_sizes": "catalogue_mechanism",
        "dimensioning": "",
        "exchange": "",
        "explanation": "explain",
        "halfspace": "",
        "optimisation": "Optimum ParetoFront optimise pareto",
        "sensitivities": "Sensitivity sensitivity",
        "studies": "study",
        "sweeps": "sweep",
        "uncertainty": "tolerance",
    }
    #: Names that were at the top in earlier releases, by the room where they are now.
    _MOVED = {
        "contact": "hertz_contact",
        "dynamics": (
            "BodyForces body_forces choose_method energy integral mean_efficiency peak "
            "settling_time"
        ),
        "explanation": "Explanation",
        "file": "example_names example_text",
        "findings": "Finding",
        "halfspace": "flank_contact solve_contact",
        "load_sharing": "ForceDeflection LoadDistribution force_deflection load_distribution",
        "mechanism": (
            "Constraint DesignProblem Objective OperatingPoint Thread Variable all_parameters"
        ),
        "process": "end_on_signals",
        "programs": "to_precision traced_physics",
        "quantities": "Quantity available_quantities catalogue",
        "response": "Campbell FrequencyResponse MeshResponse mesh_response",
        "scenario": (
            "AerodynamicLoad ConstantProfile FrictionLoad HingeLoad PositionTableLoad "
            "SCurveMoveProfile SequenceProfile SineProfile SumLoad TableProfile "
            "TrapezoidalMoveProfile TrapezoidalProfile"
        ),
        "strength": "equivalent_load load_spectrum rating_life",
        "vibration": "FrequencyLoci frequency_loci",
    }

    def __dir__():
        later = (f"{room} {names}".split() for room, names in _AT_FIRST_USE.items())
        return sorted({*globals(), *(name for names in later for name in names)})

    def __getattr__(name: str):
        import importlib
        import warnings

        for room, names in _AT_FIRST_USE.items():
            if name == room or name in names.split():
                module = importlib.import_module(f".{room}", __name__)
                for one in names.split():
                    globals()[one] = getattr(module, one)
                return globals()[name]
        for room, names in _MOVED.items():
            if name in names.split():
                place = f"{__name__}.{room}.{name}"
                warnings.warn(f"{__name__}.{name} is now {place}", DeprecationWarning, stacklevel=2)
                return getattr(importlib.import_module(f".{room}", __name__), name)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


process.collect_as_before()
