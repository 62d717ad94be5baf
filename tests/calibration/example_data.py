"""`PYTHONPATH=. python -m tests.calibration.example_data`: write the shipped example data."""

from pathlib import Path

import jax
import numpy as np

import prsm_jax as prsm
from prsm_jax import calibration

FILE = Path(calibration.__file__).parent / "data" / "wu2022_torque.csv"
COEFFICIENT, SEED, NOISE = 0.082, 2022, 0.02
_HEAD = f"""\
# Generated, not measured: drive torque of the example wu2022, computed by prsm_jax with a friction
# coefficient of {COEFFICIENT} in the threads, and normal noise of {100 * NOISE:g} % (seed {SEED}).
# Try: prsm calibrate wu2022 --data wu2022_torque
operating_point.speed [rpm],operating_point.load [kN],drive_torque [N m]
"""


def text() -> str:
    """The file."""
    truth = prsm.set_parameter(
        prsm.load("wu2022"), "stage.friction.thread.coefficient", COEFFICIENT
    )
    speed, load = np.meshgrid([300.0, 1000.0, 2000.0], np.arange(1.0, 9.0), indexing="ij")
    torque = jax.vmap(
        lambda one, other: prsm.compute(truth, ["drive_torque"], speed=one, load=other)
    )(np.pi / 30 * speed.ravel(), 1e3 * load.ravel())["drive_torque"]
    noise = np.random.default_rng(SEED).normal(size=speed.size)
    rows = zip(speed.ravel(), load.ravel(), np.asarray(torque) * (1 + NOISE * noise), strict=True)
    return _HEAD + "".join(f"{a:g},{b:g},{c:.4f}\n" for a, b, c in rows)


if __name__ == "__main__":
    FILE.parent.mkdir(exist_ok=True)
    FILE.write_text(text(), encoding="utf-8")
    print(FILE)
