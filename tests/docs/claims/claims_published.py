"""Claims of the page on published numbers, from the rows and functions of `prsm_jax.validation`."""

import functools

import numpy as np

from prsm_jax.validation import Row, validate
from prsm_jax.validation._examples import knees, steady, time_to_settle, transient
from prsm_jax.validation._newtons_equations import newtons_equations
from prsm_jax.validation._shape_function import _flatter_angle
from prsm_jax.validation._thread_contacts import LOADS, pairs_of_threads
from prsm_jax.validation.lisowski2014._lisowski2014_surfaces import LOW, flanks
from prsm_jax.validation.wu2022._wu2022_frequencies import stable_frequencies
from prsm_jax.validation.wu2022._wu2022_indefinite import static_energies
from tests.docs.claims import Claim
from tests.present import present

PAGE = "docs/published_tables.md"
SURFACES = "docs/contact_surfaces.md"
_ELEMENTS = "section 4: error at low load from elements of 0.01 mm"
LI2020, LI2021 = "li2020_two_stage", "li2021_two_stage"


@functools.cache
def rows(source: str) -> dict[str, Row]:
    """Rows of one source, by item."""
    return {row.item: row for row in validate(source)}


def row(source: str, start: str) -> Row:
    """The row whose item starts so."""
    (found,) = [one for item, one in rows(source).items() if item.startswith(start)]
    return found


def _energies(name: str):
    return lambda: [1e6 * energy for energy in static_energies()[name]]


def _negative() -> list[float]:
    names = ("f3, torsional", "f5, torsional", "t1, transverse", "t2, transverse")
    return [float(row("wu2022", f"Table 5, N = 7: {name}").published) for name in names]


def _stable() -> list[float]:
    found = stable_frequencies()[7]
    names = ("f2", "f3", "f4", "f5", "t1", "t2", "t3", "t4", "f1", "r")
    return [found[name] for name in names]


def _e_folding() -> list[float]:
    slowest = min(
        float(row("wu2022", f"Table 5, N = 7: {name}").computed) for name in ("t1", "t2", "f3")
    )
    return [1e6 / (2 * np.pi * slowest)]


def _lengths() -> list[float]:
    """By mass and by bending: E 212 GPa, 7850 kg/m³, d 8 mm, 2.199e5 N/m and 32.6 g."""
    bent = (3 * 212e9 * np.pi / 4 * 4e-3**4 / 2.199e5) ** (1 / 3)
    return [1e3 * 0.0326 / (7850 * np.pi * 4e-3**2), 1e3 * bent]


def _steps() -> list[float]:
    run = transient(LI2020)
    times = knees(np.asarray(run.time), np.asarray(run.efficiency))
    shares = [
        float(np.interp(time, run.time, run.carrier_ratio[stage]) / run.carrier_ratio[stage, -1])
        for stage, time in enumerate(times)
    ]
    return [*(1e3 * time for time in times), *(100 * share for share in shares)]


def _ring_gear() -> list[float]:
    """At the start, time of zero [ms], in the end, of both stages."""
    found = []
    for stage in (0, 1):
        force, time = np.asarray(newtons_equations(LI2020, stage).ring_gear), transient(LI2020).time
        after = int(np.argmax(force < 0))
        share = force[after - 1] / (force[after - 1] - force[after])
        zero = time[after - 1] + share * (time[after] - time[after - 1])
        found += [force[0], 1e3 * float(zero), force[-1]]
    return found


def _settling() -> list[float]:
    run = transient(LI2021)
    return [1e3 * time_to_settle(run, stage, within) for within in (1e-3, 1e-4) for stage in (0, 1)]


def _split_leads() -> list[float]:
    pairs = ((0.005, 0.015), (0.010, 0.010), (0.015, 0.005))
    return [
        float(steady(LI2021, ("stage.1.lead", a), ("stage.2.lead", b)).spline_friction[1])
        for a, b in pairs
    ]


def _efficiencies(name: str) -> list[float]:
    return [float(transient(name).efficiency[0]), float(steady(name).efficiency)]


def _equation_17() -> list[float]:
    found = row("li2020", "equation 17 as printed")
    return [float(found.computed), present(found.evidence)]


def _equation_23() -> list[float]:
    literal = float(row("li2021", "equation 23 as printed").computed)
    return [literal, literal / 7]


def _second_form() -> list[float]:
    start = "equation 35, second form: efficiency with spline friction"
    found = [row("li2020", f"{start} {value}") for value in ("0.10", "0.20")]
    return [-100 * present(one.relative_difference) for one in found]


def _flatter() -> float:
    return float(np.degrees(_flatter_angle()))


def _hertz(side: str, exact: bool) -> list[float]:
    convention = "exact" if exact else "lisowski2014"
    return (pairs_of_threads("lisowski2014")[convention][side].pressure / 1e6).tolist()


def _ratio(side: str) -> float:
    return _hertz(side, True)[0] / _hertz(side, False)[0]


def _axes_of_flanks() -> list[float]:
    hertz = flanks("screw", 25.0).hertz
    return [2e3 * float(hertz.semi_minor), 2e3 * float(hertz.semi_major)]


def _their_axes() -> list[float]:
    pair = pairs_of_threads("lisowski2014")["lisowski2014"]["screw"]
    return [2e3 * float(pair.semi_major[0]), 2e3 * float(pair.semi_minor[0])]


def _area(side: str) -> float:
    index = LOADS.index(25.0)
    pair, hertz = pairs_of_threads("lisowski2014")["lisowski2014"][side], flanks(side, 25.0).hertz
    own = float(hertz.semi_major * hertz.semi_minor)
    return float(pair.semi_major[index] * pair.semi_minor[index]) / own


_FEM = [("Table 1", "screw", load) for load in (25, 50, 100)]
_FEM += [("Table 2", "nut", load) for load in (50, 100)]


def _true(table: str, side: str, load: int) -> Row:
    return row(
        "lisowski2014", f"{table}: finite elements beside true flanks, {side} side, {load} N"
    )


def _departures() -> list[float]:
    return [
        100 * (float(one.published) / float(one.computed) - 1)
        for one in (_true(*key) for key in _FEM)
    ]


def _edges() -> list[float]:
    return [
        float(flanks("nut", 50.0, height).surface.max_pressure) / 1e9 for height in (75e-6, LOW)
    ]


def _edge_share() -> list[float]:
    found = flanks("nut", 50.0, LOW)
    return [float(found.surface.max_pressure / found.hertz.max_pressure)]


def _beyond() -> list[float]:
    """Largest departure from exact Hertz theory, what 32 cells leave open included [%]."""
    contacts = [flanks(side, float(load)) for _, side, load in _FEM]
    shares = [float(one.surface.max_pressure / one.hertz.max_pressure) for one in contacts]
    return [100 * max(abs(share - 1) for share in shares)]


def _by_flanks() -> list[float]:
    screw, nut = _hertz("screw", True), _hertz("nut", True)
    return [*screw, *nut[1:]]


def _gear(start: str) -> Row:
    return row("lin_parker1999", f"4 planets: {start}")


def _gears() -> list[float]:
    verdicts = [one.verdict for one in rows("lin_parker1999").values()]
    return [verdicts.count("reproduced"), len(verdicts)]


def _left_out_once() -> list[float]:
    found = [row("lin_parker1999", f"5 planets: {n}") for n in _LEFT_OUT_ONCE]
    return [max(abs(float(one.published) - float(one.computed)) for one in found)]


_LEFT_OUT_ONCE = ("rotational 4", "translational 2", "translational 5")
CLAIMS = [
    Claim(PAGE, "{} of the {} agree to half a unit of the printed digit", _gears),
    Claim(PAGE, "7382.4 Hz with 5 planets) agree to {} Hz", _left_out_once),
    *(
        Claim(
            PAGE,
            f"| {name} | {{}} | {{}} | {{}} |",
            lambda name=name: [
                float(_gear(name).published),
                float(_gear(name).computed),
                abs(present(_gear(name).relative_difference)),
            ],
        )
        for name in ("rotational 2", "translational 1", "translational 2")
    ),
]
CLAIMS += [
    Claim(PAGE, f"| {name} {directions}| {{}} µJ | {{}} µJ |", _energies(key))
    for name, directions, key in (
        ("screw sideways", "(two directions) ", "screw moved sideways"),
        ("nut sideways", "(two directions) ", "nut moved sideways"),
        ("ring gear turned", "", "ring gear turned"),
        ("nut turned", "", "nut turned"),
    )
]
CLAIMS += [
    Claim(PAGE, "printed as {} and {} Hz, and as {} and {} Hz (twice each)", _negative),
    Claim(PAGE, "by a factor e within {} µs.", _e_folding),
    Claim(
        PAGE,
        "torsional {}, {}, {}, {}; transverse, twice each, {}, {}, {}, {}; carrier {}; roller, "
        "four times, {}.",
        _stable,
    ),
    Claim(
        PAGE,
        "(four times {} for {}; {} for {})",
        lambda: [
            float(row("wu2022", "Table 5, N = 7: r,").published),
            float(row("wu2022", "Table 5, N = 7: r,").computed),
            float(row("wu2022", "Table 5, N = 10: t3,").published),
            float(row("wu2022", "Table 5, N = 10: t3,").computed),
        ],
    ),
    Claim(
        PAGE,
        "of the {} Hz mode: {} and {}, a zero is lost)",
        lambda: [
            float(row("wu2022", "Table 5, N = 7: t4,").published),
            float(row("wu2022", "Table 6: t4, entry y_s").computed),
            float(row("wu2022", "Table 6: t4, entry x_n").computed),
        ],
    ),
    Claim(
        PAGE,
        "The gear stiffness is {} times",
        lambda: [
            2.464e8 / float(row("wu2022", "Table 4: gear mesh stiffness, equations").computed)
        ],
    ),
    Claim(PAGE, "fits a length of {} mm, its bending stiffness one of {} mm", _lengths),
    Claim(PAGE, "| about 0.60, about 0.87 | {}, {} |", lambda: _efficiencies(LI2020)),
    Claim(PAGE, "at {} and {} ms; the carriers are then at {} and {} % of their steady", _steps),
    Claim(PAGE, "{} N, through 0 at {} ms, to {} N; stage 2 {} N, {} ms, {} N", _ring_gear),
    Claim(PAGE, "| below 0.45, nearly 0.80 | {}, {} |", lambda: _efficiencies(LI2021)),
    Claim(PAGE, "within 0.1 %: {} and {} ms; within 0.01 %: {} and {} ms", _settling),
    Claim(PAGE, "| figure 5d | {}, {}, {} N |", _split_leads),
    Claim(
        PAGE,
        "gear force at the start: {} N against {} N.",
        lambda: [float(transient(LI2020).ring_gear_force[stage, 0]) for stage in (0, 1)],
    ),
    Claim(PAGE, "with {} instead of {} rad/s²", _equation_17),
    Claim(PAGE, "an efficiency of {}, or of {} with all rollers", _equation_23),
    Claim(PAGE, "which gives an error of {} to {} %.", _second_form),
    Claim(
        PAGE,
        "({}, {} and {} MPa for 999, 1259 and 1585)",
        lambda: _hertz("screw", False),
    ),
    Claim(
        PAGE,
        "they are {} times as high at the screw and {} times at the nut",
        lambda: [_ratio("screw"), _ratio("nut")],
    ),
    Claim(PAGE, "1585 MPa at 100 N ({}; the printed", lambda: [_hertz("nut", False)[2]]),
    Claim(
        PAGE,
        "along the thread ({} mm at 25 N) than along the profile ({} mm)",
        _axes_of_flanks,
    ),
    Claim(PAGE, "{} by {} mm, an area {} times as large", lambda: [*_their_axes(), _area("screw")]),
    Claim(PAGE, "is longer and narrower, {} times as large", lambda: [_area("nut")]),
    Claim(PAGE, "by {}, {} and {} % (screw), {} and {} % (nut, 50 and 100 N)", _departures),
    Claim(PAGE, "then rises to {} and {} GPa (32 cells an axis)", _edges),
    Claim(
        PAGE,
        "belongs to {} N and a flatter pair, with profile angles of {}°",
        lambda: [
            float(row("shape_function", "load on one flank").computed),
            _flatter(),
        ],
    ),
    Claim(
        SURFACES,
        "| exact Hertz, curvatures of the flanks | {} | {} | {} | {} | {} |",
        _by_flanks,
    ),
    Claim(
        SURFACES,
        "| true flanks | {} | {} | {} | {} | {} |",
        lambda: [float(_true(*key).computed) for key in _FEM],
    ),
    Claim(SURFACES, "1585 (misprint for {})", lambda: [_hertz("nut", False)[2]]),
    Claim(
        SURFACES,
        "leave {} % in the largest cell",
        lambda: [float(row("lisowski2014", f"{_ELEMENTS}, screw side").computed)],
    ),
    Claim(
        SURFACES,
        "ends within {} mm of its nominal radius",
        lambda: [float(row("lisowski2014", "section 4: the contact of roller and nut").computed)],
    ),
    Claim(SURFACES, "(to {} times Hertz for 0.05 mm", _edge_share),
    Claim(
        SURFACES,
        "on 32 cells an axis, within {} % of that on the paraboloid",
        _beyond,
        rounded=False,
        least=0.5,
    ),
]
