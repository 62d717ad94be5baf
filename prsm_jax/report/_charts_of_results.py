"""Which chart `plot` of a result draws, and its options."""

from typing import Any, Literal

import numpy as np

from ..calibration import Calibration
from ..contact import HertzContact, LineContactResult, StageContact
from ..dynamics import SteadyState, Transient
from ..halfspace import FlankContact, SubsurfaceStress
from ..load_sharing import ForceDeflection, LoadDistribution
from ..mechanism import LineContact, Mechanism
from ..optimisation import Optimum, ParetoFront
from ..response import Campbell, FrequencyResponse
from ..results import chart_for
from ..sensitivities import Sensitivity
from ..strength import LoadSpectrum
from ..studies import DriverStudy
from ..text import short_label
from ..uncertainty import CostCurve, ToleranceAnalysis, YieldCurve
from ..vibration import FrequencyLoci, Modes
from ._style import Figure
from .contact_charts import (
    contact_ellipses,
    force_deflection_chart,
    line_contact_chart,
    pressure_map,
    stress_section,
    subsurface_chart,
    thread_load_chart,
)
from .design_charts import (
    calibration_chart,
    contribution_bars,
    cost_chart,
    front_chart,
    life_chart,
    optimisation_chart,
    parallel_chart,
    sensitivity_bars,
    summarise_optimisation,
    tolerance_histograms,
    tornado_chart,
    yield_chart,
)
from .drawings import cross_section
from .motion_charts import loss_chart, power_flow_chart, steady_flow, transient_chart
from .study_charts import study_maps
from .vibration_charts import (
    campbell_chart,
    frequency_chart,
    frequency_loci_chart,
    response_chart,
)

# Charts that need nothing but the result.
for _kind, _chart in (
    (Calibration, calibration_chart),
    (CostCurve, cost_chart),
    (DriverStudy, study_maps),
    (FrequencyLoci, frequency_loci_chart),
    (LoadDistribution, thread_load_chart),
    (SubsurfaceStress, stress_section),
    (Transient, transient_chart),
    (YieldCurve, yield_chart),
):
    chart_for(_kind)(_chart)


@chart_for(SteadyState)
def _steady(state: SteadyState, kind: Literal["losses", "power"] = "losses") -> Figure:
    """Power balance and losses, or the flow of the power."""
    if kind == "power":
        return power_flow_chart(steady_flow(state))
    return loss_chart({"operating point": state})


@chart_for(Modes)
def _modes(modes: Modes, label: str = "natural frequencies") -> Figure:
    return frequency_chart({label: modes})


@chart_for(FrequencyResponse)
def _response(response: FrequencyResponse, modes: Modes | None = None) -> Figure:
    """`modes`: natural frequencies to mark."""
    return response_chart({f"{response.response} per {response.excitation}": response}, modes)


@chart_for(Campbell)
def _campbell(campbell: Campbell, max_speed: float | None = None) -> Figure:
    """`max_speed`: end of the speed axis [rad/s]; default three times the first crossing."""
    if max_speed is None:
        speeds = np.asarray(campbell.critical_speeds)
        max_speed = 3 * float(np.min(speeds[speeds > 0], initial=np.inf))
    return campbell_chart(campbell, max_speed)


@chart_for(ForceDeflection)
def _force_deflection(curve: ForceDeflection, label: str = "nut") -> Figure:
    return force_deflection_chart({label: curve})


@chart_for(StageContact)
def _contact(contact: StageContact, label: str = "threads") -> Figure:
    return contact_ellipses({label: contact})


@chart_for(HertzContact)
def _hertz(contact: HertzContact, poisson_ratio: float = 0.3, **options: Any) -> Figure:
    return subsurface_chart(contact, poisson_ratio, **options)


@chart_for(FlankContact)
def _flanks(contact: FlankContact, label: str = "thread") -> Figure:
    return pressure_map({label: contact})


@chart_for(LineContactResult)
def _line(line: LineContactResult, contact: LineContact) -> Figure:
    """`contact`: the flanks, `stage.line_contact`."""
    return line_contact_chart(contact, line)


@chart_for(LoadSpectrum)
def _life(spectrum: LoadSpectrum, capacity: float, **options: Any) -> Figure:
    """`capacity`: dynamic capacity [N]."""
    return life_chart(capacity, spectrum, **options)


@chart_for(Sensitivity)
def _sensitivity(table: Sensitivity) -> Figure:
    defined = np.asarray(table.elasticity_defined)[:, None]
    elasticity = np.where(defined, np.asarray(table.elasticity), np.nan)
    return sensitivity_bars(table.quantities, table.parameters, elasticity)


@chart_for(Optimum)
def _optimum(optimum: Optimum) -> Figure:
    found = summarise_optimisation(optimum)
    return optimisation_chart(
        found.history,
        found.limits,
        objective=found.objective,
        unit=found.objective_unit,
        violations=found.violations,
        feasible=found.feasible,
    )


@chart_for(ParetoFront)
def _front(front: ParetoFront, kind: Literal["plane", "parallel"] = "plane") -> Figure:
    return parallel_chart(front) if kind == "parallel" else front_chart(front)


@chart_for(ToleranceAnalysis)
def _tolerance(
    analysis: ToleranceAnalysis,
    quantity: str | None = None,
    kind: Literal["histograms", "contributions"] = "histograms",
) -> Figure:
    """Distributions or contributions; with `quantity`, its values at the ends of every zone."""
    if quantity is not None:
        return tornado_chart(analysis, quantity)
    return (contribution_bars if kind == "contributions" else tolerance_histograms)(analysis)


@chart_for(Mechanism)
def _mechanism(mechanism: Mechanism, stage: int = 1) -> Figure:
    return cross_section({short_label(mechanism.title) or "mechanism": mechanism}, stage=stage)
