"""The walks on the page of the architecture are those that numbers take."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.layers.room_order import WAY
from tests.layers.walks import WALKS


def test_derivatives_pass_the_functions_in_their_order():
    """In an interpreter of its own, because what other tests have traced is not called again."""
    command = [sys.executable, "-m", "tests.layers.walks"]
    done = subprocess.run(
        command, cwd=Path(__file__).parents[2], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("walk", WALKS, ids=lambda walk: walk.parameter)
def test_a_walk_never_goes_back_to_an_earlier_room(walk):
    place = {room: number for number, rooms in enumerate(WAY) for room in rooms}
    places = [place[module.split(".")[0]] for module, _ in walk.functions]
    assert places == sorted(places)
