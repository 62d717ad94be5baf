"""The studio: a local page to play with a design, and the state behind it."""

from ..optimisation import LimitReading as LimitReading
from ._folder import ChosenFolder as ChosenFolder
from ._guard import Guard as Guard, refusal as refusal
from ._history import History as History
from ._improve import Improvement as Improvement, Step as Step
from ._readings import Numbers as Numbers, Verdicts as Verdicts
from ._serve import needs_extra as needs_extra, open_socket as open_socket, serve as serve
from ._session import Session as Session
from ._variables import StudioVariable as StudioVariable, studio_variables as studio_variables
