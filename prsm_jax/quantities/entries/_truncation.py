"""Quantities of contact ellipses that extend beyond the ends of their flanks."""

import functools

from ... import strength
from ...fields import Scalar
from ...mechanism import Stage
from .._analysis import Analysis, SharedLoad
from .._catalogue import quantity
from .._onsets import onsets_of
from ._strength import per_stage, sharing_factor_of

_cut = functools.partial(quantity, dimensions=("stage",), assumes=("cut_sharing",))


def _load_of(analysis: Analysis, index: int, stage: Stage, under: SharedLoad):
    """Load on one flank, and load of the most loaded thread over the mean."""
    load = analysis.load if under == "operating_point" else analysis.demand[1]
    sharing = sharing_factor_of(analysis, index, under)
    return strength.largest_flank_load(stage, load), sharing


def _truncation(analysis: Analysis, under: SharedLoad):
    def of(index: int, stage: Stage) -> Scalar:
        load, sharing = _load_of(analysis, index, stage, under)
        meshing, contact = analysis.meshing(index), analysis.reference_contact(index)
        return strength.contact_truncation(stage, load, meshing, contact, sharing)

    return per_stage(analysis, of)


@_cut(
    "contact_truncation",
    "τ",
    "1",
    "largest share of a contact ellipse's half-extent beyond the crest or root of a flank, under "
    "the load of the operating point; 0 if no ellipse is cut",
    shares=("operating_point",),
)
def contact_truncation(analysis: Analysis):
    return _truncation(analysis, "operating_point")


@_cut(
    "contact_truncation_largest",
    "τ_max",
    "1",
    "largest share of a contact ellipse's half-extent beyond the crest or root of a flank, under "
    "the largest load of operating point and duty cycle; 0 if no ellipse is cut",
    shares=("largest",),
)
def contact_truncation_largest(analysis: Analysis):
    return _truncation(analysis, "largest")


def _edge_pressure(analysis: Analysis, under: SharedLoad):
    def of(index: int, stage: Stage) -> Scalar:
        load, sharing = _load_of(analysis, index, stage, under)
        meshing, contact = analysis.meshing(index), analysis.reference_contact(index)
        onsets = onsets_of(analysis, index)
        return strength.edge_pressure(stage, load, meshing, contact, sharing, onsets)

    return per_stage(analysis, of)


_EDGE = (
    "largest pressure anywhere in the most loaded thread contact, including crests rounded by "
    "stage.thread.edge_radius (elastic half-spaces; lower where steel yields), under "
)


@_cut(
    "edge_pressure",
    "p_e",
    "Pa",
    _EDGE + "the load of the operating point",
    assumes=("cut_sharing", "edges", "contacts_without_friction"),
    shares=("operating_point",),
)
def edge_pressure(analysis: Analysis):
    return _edge_pressure(analysis, "operating_point")


@_cut(
    "edge_pressure_largest",
    "p_e,max",
    "Pa",
    _EDGE + "the largest load of operating point and duty cycle",
    assumes=("cut_sharing", "edges", "contacts_without_friction"),
    shares=("largest",),
)
def edge_pressure_largest(analysis: Analysis):
    return _edge_pressure(analysis, "largest")


@_cut(
    "truncation_load",
    "F_τ",
    "N",
    "axial load on one flank above which a contact ellipse extends beyond the crest or root of a "
    "flank; load sharing under the largest load",
    shares=("largest",),
)
def truncation_load(analysis: Analysis):
    def of(index: int, stage: Stage) -> Scalar:
        meshing, contact = analysis.meshing(index), analysis.reference_contact(index)
        sharing = sharing_factor_of(analysis, index)
        return strength.truncation_load(stage, meshing, contact, sharing)

    return per_stage(analysis, of)
