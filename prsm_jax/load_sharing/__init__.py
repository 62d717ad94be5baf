"""How the axial load is shared among threads and rollers."""

from ._chains import (
    Chains as Chains,
    Control as Control,
    State as State,
    residual as residual,
)
from ._distribution import (
    LoadDistribution as LoadDistribution,
    SideLoads as SideLoads,
    load_distribution as load_distribution,
    stage_load_distribution as stage_load_distribution,
    stage_load_distributions as stage_load_distributions,
    tangent_stiffness as tangent_stiffness,
)
from ._equilibrium import Equilibrium as Equilibrium, equilibrium as equilibrium
from ._flank_law import flank_approach as flank_approach, flank_force as flank_force
from ._flanks import Flanks as Flanks
from ._force_deflection import (
    ForceDeflection as ForceDeflection,
    force_deflection as force_deflection,
)
from ._left_out import (
    LargestLoads as LargestLoads,
    without_each_error as without_each_error,
)
from ._stage_chains import (
    regularised as regularised,
    roller_classes as roller_classes,
)
from ._unloaded import (
    ElasticDeflection as ElasticDeflection,
    Resting as Resting,
    elastic_deflection as elastic_deflection,
    secant_or_tangent as secant_or_tangent,
)
from ._yamamoto import ToothCompliance as ToothCompliance, tooth_compliance as tooth_compliance
from .part_errors import error_names as error_names
