"""Charts of frequencies and responses."""

from ._axis_compliance_chart import axis_compliance_chart as axis_compliance_chart
from ._axis_mode_shapes import axis_mode_shapes as axis_mode_shapes
from ._axis_pictures import save_axis_pictures as save_axis_pictures
from ._campbell_chart import campbell_chart as campbell_chart
from ._frequency_chart import elastic_modes as elastic_modes, frequency_chart as frequency_chart
from ._frequency_loci_chart import frequency_loci_chart as frequency_loci_chart
from ._nut_position_chart import (
    NUT_POSITION_QUANTITIES as NUT_POSITION_QUANTITIES,
    nut_position_chart as nut_position_chart,
)
from ._response_chart import response_chart as response_chart
