"""Bodies with their threads as solids, in STEP files."""

from ._bodies import StepBody as StepBody, ThreadedBody as ThreadedBody
from ._mass import BodyMassRule as BodyMassRule, SolidMass as SolidMass, solid_mass as solid_mass
from ._write import solid_volume as solid_volume, write_step as write_step
