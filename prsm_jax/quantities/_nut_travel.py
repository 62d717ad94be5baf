"""Travel and stiffness of the nut under load, computed once for all quantities."""

from ..fields import Scalar
from ..load_sharing import ElasticDeflection, Resting, elastic_deflection, tangent_stiffness
from ._analysis import Analysis


def elastic_of(analysis: Analysis, index: int) -> ElasticDeflection:
    """Elastic deflection of a stage (from 0) under the load of the operating point."""

    def make() -> ElasticDeflection:
        loaded, resting = analysis.distribution(index), None
        sharing = analysis.mechanism.stages[index].load_sharing
        if sharing is not None and sharing.has_reverse_flanks:
            unloaded = analysis.distribution(index, "none")
            resting = Resting(unloaded.deflection, unloaded.converged)
        deflection = elastic_deflection(loaded.chains, loaded.load, loaded.deflection, resting)
        analysis.require(deflection.converged)
        return deflection

    return analysis.once(("elastic", index), make)


def nut_tangent_of(analysis: Analysis, index: int) -> Scalar:
    """dF/dx between screw and nut of a stage (from 0) at the operating point [N/m]."""

    def make() -> Scalar:
        distribution = analysis.distribution(index)
        return tangent_stiffness(distribution.chains, distribution.equilibrium.state)

    return analysis.once(("nut_tangent_stiffness", index), make)
