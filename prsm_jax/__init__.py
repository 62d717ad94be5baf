"""prsm_jax: differentiable modelling of planetary roller screw mechanisms in JAX.

Data flows one way, and the folders are named after it: file → mechanism → geometry → contact →
halfspace, load_sharing → strength, stiffness → vibration, dynamics → response → quantities →
findings, sensitivities, optimisation, calibration, sweeps, uncertainty → report. A mechanism holds
laws of `friction` and a `scenario`. `validation` compares with published numbers, `explanation`
lists the parts of a mechanism, `cli` is the command line. The lowest layer is `fields` (numbers
with units and limits), `numerics` (methods), `programs` (how JAX compiles them), `text` and
`process` (signals, files).
"""

from . import process as process  # isort: skip # before JAX
from . import programs as programs  # isort: skip # it enables float64

from typing import TYPE_CHECKING

from . import (
    calibration as calibration,
    contact as contact,
    dynamics as dynamics,
    explanation as explanation,
    fields as fields,
    file as file,
    findings as findings,
    friction as friction,
    geometry as geometry,
    halfspace as halfspace,
    load_sharing as load_sharing,
    mechanism as mechanism,
    optimisation as optimisation,
    quantities as quantities,
    response as response,
    scenario as scenario,
    sensitivities as sensitivities,
    stiffness as stiffness,
    strength as strength,
    sweeps as sweeps,
    uncertainty as uncertainty,
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
from .calibration import calibrate as calibrate
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
from .explanation import explain as explain
from .file import (
    dump as dump,
    dumps as dumps,
    example_names as example_names,
    load as load,
    loads as loads,
)
from .findings import check as check
from .friction import FrictionLaw as FrictionLaw, friction_law as friction_law
from .geometry import mesh as mesh
from .load_sharing import (
    LoadDistribution as LoadDistribution,
    force_deflection as force_deflection,
    load_distribution as load_distribution,
)
from .mechanism import (
    Mechanism as Mechanism,
    Stage as Stage,
    all_parameters as all_parameters,
    get_parameter as get_parameter,
    set_parameter as set_parameter,
)
from .optimisation import (
    Optimum as Optimum,
    ParetoFront as ParetoFront,
    optimise as optimise,
    pareto as pareto,
)
from .quantities import (
    assumptions as assumptions,
    catalogue as catalogue,
    compute as compute,
    quantity as quantity,
)
from .response import (
    campbell as campbell,
    frequency_response as frequency_response,
)
from .scenario import Scenario as Scenario, TorqueScenario as TorqueScenario
from .sensitivities import Sensitivity as Sensitivity, sensitivity as sensitivity
from .sweeps import sweep as sweep
from .uncertainty import tolerance as tolerance
from .vibration import (
    Modes as Modes,
    modal as modal,
)

if not TYPE_CHECKING:
    #: Names that were at the top in the first release, by the room where they are now.
    _MOVED = {
        "contact": "hertz_contact",
        "dynamics": (
            "BodyForces body_forces choose_method energy integral mean_efficiency peak "
            "settling_time"
        ),
        "explanation": "Explanation",
        "file": "example_text",
        "findings": "Finding",
        "halfspace": "flank_contact solve_contact",
        "load_sharing": "ForceDeflection",
        "mechanism": "Constraint DesignProblem Objective OperatingPoint Thread Variable",
        "process": "end_on_signals",
        "programs": "to_precision traced_physics",
        "quantities": "Quantity available_quantities",
        "response": "Campbell FrequencyResponse MeshResponse mesh_response",
        "scenario": (
            "AerodynamicLoad ConstantProfile FrictionLoad HingeLoad PositionTableLoad "
            "SCurveMoveProfile SequenceProfile SineProfile SumLoad TableProfile "
            "TrapezoidalMoveProfile TrapezoidalProfile"
        ),
        "strength": "equivalent_load load_spectrum rating_life",
        "vibration": "FrequencyLoci frequency_loci",
    }

    def __getattr__(name: str):
        import warnings

        for room, names in _MOVED.items():
            if name in names.split():
                place = f"{__name__}.{room}.{name}"
                warnings.warn(f"{__name__}.{name} is now {place}", DeprecationWarning, stacklevel=2)
                return getattr(globals()[room], name)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
