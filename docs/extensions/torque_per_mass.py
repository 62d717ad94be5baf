"""A quantity: drive torque over mass."""

import prsm_jax as prsm


@prsm.quantity("torque_per_mass", "M/m", "N·m/kg", "drive torque over mass of the mechanism")
def torque_per_mass(analysis):
    mass = prsm.compute(analysis.mechanism, ["mass"])["mass"]
    return analysis.steady.drive_torque / mass
