"""All findings of a mechanism together."""

from ..geometry import Finding, geometric_findings
from ..mechanism import Mechanism
from ._locking import locking_findings
from ._masses import mass_findings
from ._stiffness import stiffness_findings
from ._strength import strength_findings


def check(mechanism: Mechanism) -> tuple[Finding, ...]:
    """What an engineer should know about a mechanism before trusting its results, by name.

    Does it fit together: `feasible_ratio`, `roller_clearance`, `gear_assembly`,
    `carrier_clearance`, `meshing`, `contact_on_flank`, `tooth_thickness`. Do the numbers behind its
    vibration make sense: `inertia`, `mass`, `torsional_support`, `negative_stiffness`. Does
    friction let it move: `jamming`, `self_locking`. Does it last: `static_safety`, `rating_life`,
    `buckling`, `screw_speed`, `false_brinelling`, `backlash`. Do its numbers agree: `preload`,
    `engaged_threads`, `axial_backlash`. Nothing is raised; a mechanism without findings gives an
    empty tuple. Needs concrete numbers: inside a trace use the quantities instead
    (`roller_clearance`, …).

    **Arguments:**

    - `mechanism`: the mechanism.

    **Returns:** the findings, stage by stage.
    """
    found = [*geometric_findings(mechanism), *mass_findings(mechanism)]
    found += stiffness_findings(mechanism)
    found += locking_findings(mechanism)
    found += strength_findings(mechanism)
    return tuple(sorted(found, key=lambda finding: finding.stage))
