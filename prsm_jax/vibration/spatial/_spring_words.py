"""What springs of a model in space are called in tables and pictures."""

from collections.abc import Mapping

from ...mechanism import Side

#: Names of springs for a reader; several springs may have one.
_WORDS = {
    "screw_roller": "threads at the screw",
    "nut_roller": "threads at the nut",
    "sticking_screw_roller": "threads at the screw",
    "sticking_nut_roller": "threads at the nut",
    "ring_roller": "teeth",
    "pin_radial": "pins",
    "pin_tangential": "pins",
    "pin_axial": "pins",
    "screw_support_torsional": "screw held in rotation",
    "nut_support_torsional": "nut held in rotation",
    "carrier_support_torsional": "carrier support",
    "carrier_support_radial": "carrier support",
    "opposite_carriers_support_radial": "carrier support",
    "opposite_carriers_support_torsional": "carrier support",
    "screw_support_tilting": "screw held against tilting",
    "nut_support_tilting": "nut held against tilting",
    "screw_shaft_axial": "screw, stretching",
    "screw_shaft_torsional": "screw, twisting",
    "screw_shaft_beyond_nut": "screw beyond the nut",
    "far_bearing": "far bearing",
    "coupling": "coupling",
    "motor_shaft": "motor shaft",
    "position_gain": "position gain",
}


def strain_in_words(shares: Mapping[str, float], turning: Side = "screw") -> dict[str, float]:
    """Shares of the strain energy by the words for springs, largest first.

    Shares of springs with the same words are added.

    **Arguments:**

    - `shares`: by the name of the spring, as in `SpatialMode.strain`.
    - `turning`: the body that turns, which a thrust bearing holds along the axis.
    """
    held = "nut" if turning == "screw" else "screw"
    words_of = _WORDS | {
        f"{turning}_support_axial": "thrust bearing",
        f"{held}_support_axial": f"{held} mounting",
        "thrust_tube": "thrust tube" if turning == "screw" else "joint at the load",
    }
    found: dict[str, float] = {}
    for name, share in shares.items():
        words = words_of.get(name, name.replace("_", " "))
        found[words] = found.get(words, 0.0) + share
    return dict(sorted(found.items(), key=lambda item: -item[1]))
