"""Mechanisms of a catalogue's sizes: by rules that predict the sizes, or by plain ones."""

from ..mechanism import Mechanism
from ._rules import built
from ._size_rules import FITTED, PLAIN


def catalogue_mechanism(
    nominal_diameter: float | int, lead: float | int, starts: float | int, **row: float | int
) -> Mechanism:
    r"""A standard roller screw of a catalogue's size, completed by rules.

    | number | rule |
    |---|---|
    | radius of the roller | $r_s/(n-2)$ |
    | addendum, dedendum of the screw | from crest and root, or 0.15, 0.25 pitches |
    | addendum of the roller | that dedendum less 0.05 pitches |
    | number of rollers | pitch circles that fit, less one |
    | nut | diameter, length given, or fitted to 90 sizes |
    | roller | nut's length less 14 mm, at least 0.65 of it |
    | loaded threads | nut's length less 20 mm, at least 0.45 of it |
    | gears | a quarter of the roller without loaded thread each |
    | carriers | 2, as wide as the roller's radius, 0.02 of the nut's length |
    | profile radius | 3.7 pitches; 4.6 pitches from a pitch of 3.5 mm on |
    | contact angle | 45° |
    | teeth | a standard module with at least 16 teeth, 20° |
    | screw | solid, one metre long |
    | steel | 210 GPa, 0.3, 7850 kg/m³, 4.2 GPa for $C_{0a}$, yield strength 900 MPa |
    | $C_a$ | equivalent balls, material factor 0.81 |
    | friction coefficient | $0.027 (n-1)$ |
    | axial play | 0.02, 0.04 or 0.07 mm by the pitch |
    | operating point | 25 MPa times $d_0^2$; 30 000 mm rpm over $d_0$ |

    The number of rollers is at least 3; where they have too little room, their addendum is lower,
    and below 0.1 pitches another roller is left out. `docs/catalogue_witness.md` has the reason and
    the error of each rule. Equal shares of the load in all threads are assumed.

    **Arguments:**

    - `nominal_diameter`: of the screw, $d_0$ [m].
    - `lead`: [m].
    - `starts`: of screw and nut, $n > 2$.
    - `row`: further columns of `catalogue_rows` by their names, in their units; without the
      capacities, which are results. The rules give all columns that are missing. The efficiencies
      and the torque of the preload are results too, and are ignored.

    **Raises:** `UnknownNameError` for another column; `ValueError` for a capacity, for a number
    that is not finite or is negative, and for dimensions that do not make a screw.
    """
    return built(FITTED, nominal_diameter, lead, starts, row)


def plain_catalogue_mechanism(
    nominal_diameter: float | int, lead: float | int, starts: float | int, **row: float | int
) -> Mechanism:
    r"""As `catalogue_mechanism`, by plain rules that are fitted to nothing.

    The benchmark (`docs/catalogue_benchmark.md`) starts from them. They differ in

    | number | rule |
    |---|---|
    | number of rollers | as many as fit with gaps of 0.04 radii between crests |
    | roller | 0.85 of the nut's length |
    | loaded threads | 0.6 of the nut's length |
    | profile radius | $r_R/\sin\alpha$ |
    | $C_a$ | Lundberg and Palmgren's theory, material factor 1.1 |
    | friction coefficient | 0.06 |
    | axial play | none |

    **Arguments:** as in `catalogue_mechanism`.

    **Raises:** as `catalogue_mechanism`.
    """
    return built(PLAIN, nominal_diameter, lead, starts, row)
