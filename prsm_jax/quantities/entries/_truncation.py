"""Quantities of contact ellipses that extend beyond the ends of their flanks."""

from ... import strength
from ...fields import Scalar
from ...mechanism import Stage
from .._analysis import Analysis
from .._catalogue import quantity
from .._onsets import onsets_of
from ._strength import on_one_flank, per_stage, sharing_factor_of


def _at_operating_load(analysis: Analysis, index: int, stage: Stage) -> Scalar:
    return strength.contact_truncation(
        stage,
        strength.largest_flank_load(stage, analysis.load),
        analysis.meshing(index),
        analysis.reference_contact(index),
        sharing_factor_of(analysis, index, "operating_point"),
    )


@quantity(
    "contact_truncation",
    "τ",
    "1",
    "largest share of a contact ellipse's half-extent beyond the crest or root of a flank, under "
    "the load of the operating point; 0 if no ellipse is cut",
    ("stage",),
    assumes=("cut_sharing",),
    shares=("operating_point",),
)
def contact_truncation(analysis: Analysis):
    return per_stage(analysis, lambda i, stage: _at_operating_load(analysis, i, stage))


@quantity(
    "contact_truncation_largest",
    "τ_max",
    "1",
    "largest share of a contact ellipse's half-extent beyond the crest or root of a flank, under "
    "the largest load of operating point and duty cycle; 0 if no ellipse is cut",
    ("stage",),
    assumes=("cut_sharing",),
    shares=("largest",),
)
def contact_truncation_largest(analysis: Analysis):
    return per_stage(
        analysis,
        lambda i, stage: strength.contact_truncation(
            stage,
            on_one_flank(analysis, stage),
            analysis.meshing(i),
            analysis.reference_contact(i),
            sharing_factor_of(analysis, i),
        ),
    )


def edge_pressure_of(analysis: Analysis, index: int, stage: Stage, largest: bool) -> Scalar:
    load = on_one_flank(analysis, stage)
    if not largest:
        load = strength.largest_flank_load(stage, analysis.load)
    return strength.edge_pressure(
        stage,
        load,
        analysis.meshing(index),
        analysis.reference_contact(index),
        sharing_factor_of(analysis, index, "largest" if largest else "operating_point"),
        onsets_of(analysis, index),
    )


_EDGE = (
    "largest pressure anywhere in the most loaded thread contact, including crests rounded by "
    "stage.thread.edge_radius (elastic half-spaces; lower where steel yields), under "
)


@quantity(
    "edge_pressure",
    "p_e",
    "Pa",
    _EDGE + "the load of the operating point",
    ("stage",),
    assumes=("cut_sharing", "edges"),
    shares=("operating_point",),
)
def edge_pressure(analysis: Analysis):
    return per_stage(analysis, lambda i, stage: edge_pressure_of(analysis, i, stage, False))


@quantity(
    "edge_pressure_largest",
    "p_e,max",
    "Pa",
    _EDGE + "the largest load of operating point and duty cycle",
    ("stage",),
    assumes=("cut_sharing", "edges"),
    shares=("largest",),
)
def edge_pressure_largest(analysis: Analysis):
    return per_stage(analysis, lambda i, stage: edge_pressure_of(analysis, i, stage, True))


def truncation_load_of(analysis: Analysis, index: int, stage: Stage) -> Scalar:
    return strength.truncation_load(
        stage,
        analysis.meshing(index),
        analysis.reference_contact(index),
        sharing_factor_of(analysis, index),
    )


@quantity(
    "truncation_load",
    "F_τ",
    "N",
    "axial load on one flank above which a contact ellipse extends beyond the crest or root of a "
    "flank; load sharing under the largest load",
    ("stage",),
    assumes=("cut_sharing",),
    shares=("largest",),
)
def truncation_load(analysis: Analysis):
    return per_stage(analysis, lambda i, stage: truncation_load_of(analysis, i, stage))
