"""prsm_jax: differentiable modelling of planetary roller screw mechanisms in JAX.

Data flows one way, and the folders are named after it: file → mechanism → geometry → contact →
halfspace, load_sharing → strength, stiffness → vibration, dynamics → response → quantities →
findings, sensitivities, optimisation, sweeps → report. A mechanism holds laws of `friction` and
a `scenario`. `validation` compares with published numbers, `explanation` lists the parts of
a mechanism, `cli` is the command line. The lowest layer is `fields` (numbers with units
and limits), `numerics` (methods), `programs` (how JAX compiles them), `text` and `process`
(signals, files).
"""

from . import process as process  # isort: skip # before JAX
from .programs import to_precision as to_precision  # isort: skip # it enables float64

from ._errors import (
    FileError as FileError,
    MissingDataError as MissingDataError,
    MissingExtraError as MissingExtraError,
    PrsmError as PrsmError,
    UnknownNameError as UnknownNameError,
)
from ._version import __version__ as __version__
from .contact import hertz_contact as hertz_contact, thread_contacts as thread_contacts
from .dynamics import (
    BodyForces as BodyForces,
    ClosedForm as ClosedForm,
    Diffrax as Diffrax,
    HingeLoad as HingeLoad,
    Kvaerno as Kvaerno,
    QuasiSteady as QuasiSteady,
    Rodasp as Rodasp,
    Scenario as Scenario,
    SteadyState as SteadyState,
    TorqueScenario as TorqueScenario,
    Transient as Transient,
    Tsitouras as Tsitouras,
    body_forces as body_forces,
    choose_method as choose_method,
    energy as energy,
    integral as integral,
    mean_efficiency as mean_efficiency,
    peak as peak,
    settling_time as settling_time,
    simulate as simulate,
    steady_state as steady_state,
)
from .explanation import Explanation as Explanation, explain as explain
from .file import (
    dump as dump,
    dumps as dumps,
    example_names as example_names,
    example_text as example_text,
    load as load,
    loads as loads,
)
from .findings import check as check
from .friction import FrictionLaw as FrictionLaw, friction_law as friction_law
from .geometry import Finding as Finding, mesh as mesh
from .halfspace import flank_contact as flank_contact, solve_contact as solve_contact
from .load_sharing import (
    ForceDeflection as ForceDeflection,
    LoadDistribution as LoadDistribution,
    force_deflection as force_deflection,
    load_distribution as load_distribution,
)
from .mechanism import (
    AerodynamicLoad as AerodynamicLoad,
    ConstantProfile as ConstantProfile,
    Constraint as Constraint,
    DesignProblem as DesignProblem,
    FrictionLoad as FrictionLoad,
    Mechanism as Mechanism,
    Objective as Objective,
    OperatingPoint as OperatingPoint,
    PositionTableLoad as PositionTableLoad,
    SCurveMoveProfile as SCurveMoveProfile,
    SequenceProfile as SequenceProfile,
    SineProfile as SineProfile,
    Stage as Stage,
    SumLoad as SumLoad,
    TableProfile as TableProfile,
    Thread as Thread,
    TrapezoidalMoveProfile as TrapezoidalMoveProfile,
    TrapezoidalProfile as TrapezoidalProfile,
    Variable as Variable,
    all_parameters as all_parameters,
    get_parameter as get_parameter,
    set_parameter as set_parameter,
)
from .optimisation import Optimum as Optimum, optimise as optimise
from .process import end_on_signals as end_on_signals
from .programs import traced_physics as traced_physics
from .quantities import (
    Quantity as Quantity,
    assumptions as assumptions,
    available_quantities as available_quantities,
    catalogue as catalogue,
    compute as compute,
    quantity as quantity,
)
from .response import (
    Campbell as Campbell,
    FrequencyResponse as FrequencyResponse,
    MeshResponse as MeshResponse,
    campbell as campbell,
    frequency_response as frequency_response,
    mesh_response as mesh_response,
)
from .sensitivities import Sensitivity as Sensitivity, sensitivity as sensitivity
from .strength import (
    equivalent_load as equivalent_load,
    load_spectrum as load_spectrum,
    rating_life as rating_life,
)
from .sweeps import sweep as sweep
from .vibration import (
    FrequencyLoci as FrequencyLoci,
    Modes as Modes,
    frequency_loci as frequency_loci,
    modal as modal,
)
