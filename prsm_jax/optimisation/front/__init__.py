"""The front of two or three objectives: its points, their dominance and their optimality."""

from ._dominance import hypervolume as hypervolume, non_dominated as non_dominated
from ._result import FrontPoint as FrontPoint, ParetoFront as ParetoFront, senses as senses
from ._search import FrontSearch as FrontSearch
from ._summary import front_of as front_of
