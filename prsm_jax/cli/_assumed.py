"""Quantities in the tables of each verb; their assumptions are printed below the tables."""

CONTACT = ("max_pressure", "approach_screw", "approach_nut", "max_von_mises_screw")
VIBRATION = ("natural_frequencies",)
CRITICAL_SPEEDS = ("natural_frequencies", "carrier_ratio")
STEADY = ("efficiency", "carrier_ratio", "drive_torque", "contact_force", "loss_power")
TRANSIENT = ("efficiency", "carrier_ratio", "drive_torque", "contact_force")
