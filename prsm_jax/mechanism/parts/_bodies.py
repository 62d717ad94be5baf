"""The bodies of a stage: given masses, or dimensions from which masses follow."""

from ...fields import (
    ACUTE_ANGLE,
    COUNT,
    NOT_NEGATIVE,
    POISSON_RATIO,
    POSITIVE,
    SLANT,
    Limited,
    Number,
    OptionalNumber,
    choice,
    number,
    optional_number,
    part,
)


class Material(Limited):
    """An isotropic elastic material."""

    youngs_modulus: Number = number("Pa", "Young's modulus, E")
    poisson_ratio: Number = number("1", "Poisson's ratio, ν", limit=POISSON_RATIO)
    density: OptionalNumber = optional_number(
        "kg/m³", "density, for masses derived from dimensions"
    )


class Support(Limited):
    """Springs from a body to the housing; absent ones are not modelled."""

    radial_stiffness: OptionalNumber = optional_number(
        "N/m", "bending (radial) stiffness of the support, equal in x and y unless y has its own"
    )
    torsional_stiffness: OptionalNumber = optional_number(
        "N/m", "torsional stiffness as a force per tangential displacement u = r θ"
    )
    radial_stiffness_y: OptionalNumber = optional_number(
        "N/m", "bending stiffness in y where it differs from that in x (radial_stiffness)"
    )
    axial_stiffness: OptionalNumber = optional_number(
        "N/m",
        "axial stiffness: of the screw's thrust bearing, or of the nut's mounting (to the load "
        "where [axis.load] is given, else to the housing)",
    )
    tilting_stiffness: OptionalNumber = optional_number(
        "N·m/rad",
        "moment per tilt about x or y at the middle of the nut, where bodies tilt; that of ring "
        "gear and carriers adds to the body with which they tilt",
        limit=NOT_NEGATIVE,
    )

    def __check_init__(self) -> None:
        if self.radial_stiffness_y is not None and self.radial_stiffness is None:
            raise ValueError(
                "the support has radial_stiffness_y but no radial_stiffness, which is the one in "
                "x; give both (0 N/m where there is no spring)"
            )


class Screw(Limited):
    """The screw; its outer radius is the nominal one of the thread."""

    mass: OptionalNumber = optional_number("kg", "mass; from length and density when absent")
    inertia: OptionalNumber = optional_number("kg·m²", "moment of inertia about the axis")
    length: OptionalNumber = optional_number("m", "length of the cylinder")
    bore_radius: OptionalNumber = optional_number(
        "m", "radius of a central bore", limit=NOT_NEGATIVE
    )
    material: Material | None = part("the body has the material of its stage")
    support: Support | None = part("the screw is free: no springs of its bearings")


class Roller(Limited):
    """One roller; its outer radius is the nominal one of the thread.

    **Raises:** `ValueError` at construction if the support has stiffnesses that pins do not have:
    rollers turn freely on their pins, and the pins are isotropic.
    """

    mass: OptionalNumber = optional_number("kg", "mass; from length and density when absent")
    inertia: OptionalNumber = optional_number("kg·m²", "moment of inertia about its own axis")
    length: OptionalNumber = optional_number("m", "length of the cylinder")
    bore_radius: OptionalNumber = optional_number(
        "m", "radius of a central bore", limit=NOT_NEGATIVE
    )
    material: Material | None = part("the body has the material of its stage")
    #: Pins of the roller in the carriers; if given, rollers also move in translation. An axial
    #: stiffness holds the roller in the nut (`spatial_modal`).
    support: Support | None = part("the rollers only rotate: no translation on their pins")

    def __check_init__(self) -> None:
        if self.support is None:
            return
        if self.support.torsional_stiffness is not None:
            raise ValueError(
                "roller.support has torsional_stiffness, but a roller turns freely on its pins; "
                "remove it"
            )
        if self.support.tilting_stiffness is not None:
            raise ValueError(
                "roller.support has tilting_stiffness, but the pins at both ends of a roller hold "
                "it against a tilt; give radial_stiffness alone"
            )
        if self.support.radial_stiffness_y is not None:
            raise ValueError(
                "roller.support has radial_stiffness_y, but the pins of a roller are isotropic; "
                "give radial_stiffness alone"
            )


class Nut(Limited):
    """The nut: a sleeve whose inner radius is the nominal one of the thread."""

    mass: OptionalNumber = optional_number("kg", "mass; from dimensions and density when absent")
    inertia: OptionalNumber = optional_number("kg·m²", "moment of inertia about the axis")
    length: OptionalNumber = optional_number("m", "length of the sleeve")
    wall_thickness: OptionalNumber = optional_number(
        "m", "wall outside the nominal thread radius; the outer radius follows"
    )
    material: Material | None = part("the body has the material of its stage")
    support: Support | None = part("the nut is free: no springs to its mounting")


class RingGear(Limited):
    """The ring gear: an annulus whose inner radius is the pitch radius."""

    mass: OptionalNumber = optional_number("kg", "mass; from dimensions and density when absent")
    inertia: OptionalNumber = optional_number("kg·m²", "moment of inertia about the axis")
    length: OptionalNumber = optional_number("m", "axial width of the annulus")
    wall_thickness: OptionalNumber = optional_number("m", "rim outside the pitch radius")
    material: Material | None = part("the body has the material of its stage")
    support: Support | None = part("the ring gear is free: no springs to its mounting")


class Carrier(Limited):
    """The carriers (planet cages): annuli centred on the circle of the roller axes."""

    mass: OptionalNumber = optional_number("kg", "mass of one carrier")
    inertia: OptionalNumber = optional_number("kg·m²", "moment of inertia of one carrier")
    length: OptionalNumber = optional_number("m", "axial thickness of one annulus")
    radial_width: OptionalNumber = optional_number("m", "radial width of the annulus")
    count: int = choice(
        "number of carriers in the stage (one at either end: 2)", default=2, limit=COUNT
    )
    material: Material | None = part("the body has the material of its stage")
    support: Support | None = part("the carriers are free to turn")


class Gear(Limited):
    """The gear pair that synchronises the rollers: a spur gear at the roller's ends in a ring gear.

    The teeth of an inverted roller screw are on its screw, in place of a ring gear. Pitch circles
    are the nominal circles of the threads, so the module 2 r_R / z_R and, unless given, the number
    of ring gear (or screw) teeth n z_R follow from the thread.
    """

    pressure_angle: Number = number("rad", "pressure angle", limit=ACUTE_ANGLE)
    roller_teeth: OptionalNumber = optional_number(
        "1",
        "number of teeth of the roller's gear, z_R; needed for the mesh stiffness",
        limit=POSITIVE,
    )
    face_width: OptionalNumber = optional_number("m", "face width; needed for the mesh stiffness")
    roller_profile_shift: Number = number("1", "profile shift coefficient of the roller", default=0)
    ring_profile_shift: Number = number("1", "profile shift coefficient of the ring", default=0)
    helix_angle: Number = number("rad", "helix angle of the gear teeth", default=0, limit=SLANT)
    mesh_factor: Number = number(
        "1",
        "mesh stiffness over single-tooth stiffness (0.75 ε_α + 0.25 in ISO 6336-1)",
        default=1,
        limit=POSITIVE,
    )
    ring_teeth: OptionalNumber = optional_number(
        "1",
        "number of teeth of the ring gear (of the screw in an inverted roller screw); n z_R, which "
        "matches the thread, when absent",
        limit=POSITIVE,
    )


class GivenStiffness(Limited):
    """Stiffnesses taken as given (measured, or from a paper) instead of being derived."""

    screw_roller: OptionalNumber = optional_number(
        "N/m", "thread contact stiffness of one roller with the screw, all its threads"
    )
    nut_roller: OptionalNumber = optional_number(
        "N/m", "thread contact stiffness of one roller with the nut, all its threads"
    )
    ring_roller: OptionalNumber = optional_number(
        "N/m", "gear mesh stiffness of one roller with the ring gear"
    )
