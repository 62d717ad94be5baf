"""Which quantities the tables of a verb show, for the assumptions that are named beneath them."""

CONTACT = ("max_pressure", "approach_screw", "approach_nut", "max_von_mises_screw")
VIBRATION = ("natural_frequencies",)
CRITICAL_SPEEDS = ("natural_frequencies", "carrier_ratio")
STEADY = ("efficiency", "carrier_ratio", "drive_torque", "contact_force", "loss_power")
TRANSIENT = ("efficiency", "carrier_ratio", "drive_torque", "contact_force")
