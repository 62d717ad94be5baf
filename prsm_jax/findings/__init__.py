"""Findings on a mechanism: does it fit together, and do its masses and stiffnesses make sense?"""

from ._check import check as check
from ._locking import locking_findings as locking_findings
from ._masses import mass_findings as mass_findings
from ._stiffness import stiffness_findings as stiffness_findings
from ._strength import strength_findings as strength_findings
