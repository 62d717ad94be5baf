"""How far a load moves the nut, and how stiff it is: found once for all quantities."""

from ..load_sharing import ElasticDeflection, Resting, elastic_deflection, tangent_stiffness
from ..mechanism import Scalar
from ._analysis import Analysis


def elastic_of(analysis: Analysis, index: int) -> ElasticDeflection:
    """What the load of the operating point does to the travel of a stage (from 0)."""

    def make() -> ElasticDeflection:
        loaded, resting = analysis.distribution(index), None
        sharing = analysis.mechanism.stages[index].load_sharing
        if sharing is not None and sharing.has_reverse_flanks:
            alone = analysis.distribution(index, "none")
            resting = Resting(alone.deflection, alone.converged)
        found = elastic_deflection(loaded.chains, loaded.load, loaded.deflection, resting)
        analysis.require(found.converged)
        return found

    return analysis.once(("elastic", index), make)


def nut_tangent_of(analysis: Analysis, index: int) -> Scalar:
    """dF/dx between screw and nut of a stage (from 0) at the operating point [N/m]."""

    def make() -> Scalar:
        found = analysis.distribution(index)
        return tangent_stiffness(found.chains, found.equilibrium.state)

    return analysis.once(("nut_tangent_stiffness", index), make)
