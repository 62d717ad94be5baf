"""Charts of frequencies and responses."""

from ._campbell_chart import campbell_chart as campbell_chart
from ._frequency_chart import elastic_modes as elastic_modes, frequency_chart as frequency_chart
from ._frequency_loci_chart import frequency_loci_chart as frequency_loci_chart
from ._response_chart import response_chart as response_chart
