"""`PYTHONPATH=. python -m tests.calibration.example_data`: write the shipped example data."""

from pathlib import Path

import jax
import numpy as np

import prsm_jax as prsm
from prsm_jax import calibration

FOLDER = Path(calibration.__file__).parent / "data"
COEFFICIENT, SEED, NOISE = 0.082, 2022, 0.02
_HEAD = f"""\
# Generated, not measured: drive torque of the example wu2022, computed by prsm_jax with a friction
# coefficient of {COEFFICIENT} in the threads, and normal noise of {100 * NOISE:g} % (seed {SEED}).
# Try: prsm calibrate wu2022 --data wu2022_torque
operating_point.speed [rpm],operating_point.load [kN],drive_torque [N m]
"""


#: Force in the spacer [N] and effective length of the teeth [m] behind the curve; its noise [m].
PRELOAD, TOOTH_LENGTH, DEFLECTION_NOISE = 4.3e3, 0.7e-3, 0.05e-6
_DEFLECTION_HEAD = f"""\
# Generated, not measured: axial deflection of the example actuator_load_sharing, computed by
# prsm_jax with a preload of {PRELOAD / 1e3:g} kN and an effective tooth length of
# {1e3 * TOOTH_LENGTH:g} mm, and normal noise of {1e6 * DEFLECTION_NOISE:g} um (seed {SEED}).
# Try: prsm calibrate actuator_load_sharing --data actuator_deflection
#     --parameters split_nut.preload,tooth.effective_length
operating_point.load [kN],axial_deflection [um]
"""


def deflection_text() -> str:
    """The file of the force–deflection curve."""
    truth = prsm.mechanism.set_parameters(
        prsm.load("actuator_load_sharing"),
        {"split_nut.preload": PRELOAD, "tooth.effective_length": TOOTH_LENGTH},
    )
    load = np.array([sign * 2.0 * step for sign in (-1, 1) for step in range(1, 11)])
    deflection = jax.vmap(lambda one: prsm.compute(truth, ["axial_deflection"], load=one))(
        1e3 * load
    )["axial_deflection"]
    noise = DEFLECTION_NOISE * np.random.default_rng(SEED).normal(size=load.size)
    rows = zip(load, 1e6 * (np.asarray(deflection) + noise), strict=True)
    return _DEFLECTION_HEAD + "".join(f"{a:g},{b:.3f}\n" for a, b in rows)


def torque_text() -> str:
    """The file of torques."""
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


TEXTS = {"wu2022_torque": torque_text, "actuator_deflection": deflection_text}


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name, text in TEXTS.items():
        (FOLDER / f"{name}.csv").write_text(text(), encoding="utf-8")
        print(FOLDER / f"{name}.csv")
