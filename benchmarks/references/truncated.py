"""Elastic half-spaces on the true flanks of one thread contact, in NumPy, flanks ending sharply.

Heights of the flanks along their common normal, Love's displacements of loaded rectangles, and the
conjugate gradients of Polonsky and Keer; nothing is shared with the package.
"""

import mpmath
import numpy as np

from .contact import gaps
from .hertz import hertz
from .meshing import DIGITS, Design, mesh_point


def hertz_pressure(design: Design, side: str, axial_force: float, modulus: float):
    """p₀ [Pa], the larger semi-axis [m] and the normal force [N] of a whole ellipse."""
    with mpmath.workdps(DIGITS):
        both = tuple(gaps(design, mesh_point(design)))
        smaller, larger, factor = both[0 if side == "screw" else 1]
        pressure, _, major, _ = hertz(axial_force * factor, smaller, larger, modulus)
        return pressure, major, float(axial_force * factor)


def _surfaces(design: Design, side: str):
    """Upper and lower flank z(x, y), their contact point, and the radii of both bodies there."""
    lead, starts, roller, contact_angle, profile = design
    flank = np.pi / 2 - contact_angle
    slope, centre = np.tan(flank), (starts - 1) * roller
    helical, roller_helical = lead / (2 * np.pi), lead / starts / (2 * np.pi)
    arc_centre = roller - profile * np.sin(flank)

    def of_body(x, y):
        return slope * np.hypot(x, y) + helical * np.arctan2(y, x)

    def of_roller(x, y):
        arc = np.sqrt(profile**2 - (np.hypot(x - centre, y) - arc_centre) ** 2)
        return arc - roller_helical * np.arctan2(y, centre - x)

    def of_roller_above(x, y):
        arc = np.sqrt(profile**2 - (np.hypot(x - centre, y) - arc_centre) ** 2)
        return -arc + roller_helical * np.arctan2(y, x - centre)

    if side == "nut":
        return of_roller_above, of_body, (starts * roller, 0.0), slope, helical, centre
    with mpmath.workdps(DIGITS):
        point = mesh_point(design)
    return of_body, of_roller, (float(point.x), float(point.y)), slope, helical, centre


def _gap(design: Design, side: str, addenda, along, across):
    """Gap over the tangent plane, and how far past either crest a point lies, along the flank."""
    upper, lower, (x0, y0), slope, helical, centre = _surfaces(design, side)
    radius = np.hypot(x0, y0)
    radial = np.array([x0, y0]) / radius
    gradient = slope * radial + helical / radius * np.array([-radial[1], radial[0]])
    normal = np.array([-gradient[0], -gradient[1], 1.0])
    normal /= np.linalg.norm(normal)
    first = np.array([radial[0], radial[1], 0.0])
    first -= (first @ normal) * normal
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    foot = np.array([x0, y0, 0.0])[:, None, None] + (
        first[:, None, None] * along + second[:, None, None] * across
    )

    def meets(surface):
        shift, distance = surface(x0, y0), np.zeros_like(along)
        for _ in range(6):
            x, y, z = foot + distance * normal[:, None, None]
            # Both flanks have nearly the slope of the plane: its normal serves as derivative.
            distance = distance + (surface(x, y) - shift - z) * normal[2]
        return distance

    body = np.hypot(foot[0], foot[1])
    roller = np.hypot(foot[0] - centre, foot[1])
    nominal = (design.starts - 2) * design.roller_radius
    past = [roller - design.roller_radius - addenda[1]]
    if side == "screw":
        past.append(body - nominal - addenda[0])
    else:
        past.append(design.starts * design.roller_radius - addenda[0] - body)
    stretch = np.hypot(1.0, slope)
    return meets(upper) - meets(lower), [stretch * one for one in past]


def _influence(count: int, step: float, modulus: float) -> np.ndarray:
    """Displacement by a unit pressure on one square cell (Love 1929), transformed."""
    index = np.minimum(np.arange(2 * count), 2 * count - np.arange(2 * count)) * step
    x, y = index[:, None], index[None, :]

    def corner(a, b):
        return a * np.arcsinh(b / np.abs(a)) + b * np.arcsinh(a / np.abs(b))

    half = step / 2
    total = corner(x + half, y + half) - corner(x - half, y + half)
    total = total - corner(x + half, y - half) + corner(x - half, y - half)
    return np.fft.rfft2(total / (np.pi * modulus))


def contact_pressure(
    design: Design, side: str, addenda, axial_force: float, modulus: float, cells: int = 128
) -> float:
    """`pressures` at the contact point, the crests being sharp."""
    return pressures(design, side, addenda, axial_force, modulus, cells)[0]


def pressures(
    design: Design,
    side: str,
    addenda,
    axial_force: float,
    modulus: float,
    cells: int = 128,
    edge_radius: float | None = None,
) -> tuple[float, float]:
    """Pressure at the contact point, and the largest one, over p₀ of the whole ellipse.

    **Arguments:** SI; `addenda`: heights of the threads of screw (and nut) and roller; `cells`
    along a side of the grid, which is 1.45 times as large as the ellipse; `edge_radius` of the
    crests' edges, which are sharp without it (then the largest pressure depends on the grid).
    """
    peak, major, force = hertz_pressure(design, side, axial_force, modulus)
    step = 2 * 1.45 * major / cells
    place = (np.arange(cells) - (cells - 1) / 2) * step
    along, across = np.meshgrid(place, place, indexing="ij")
    gap, past = _gap(design, side, addenda, along, across)
    inside = np.ones(gap.shape, bool)
    for one in past:
        if edge_radius is None:
            inside &= one < 0
        else:
            gap = gap + np.maximum(one, 0.0) ** 2 / (2 * edge_radius)
    kernel = _influence(cells, step, modulus)

    def displaced(pressure):
        wide = np.zeros((2 * cells, 2 * cells))
        wide[:cells, :cells] = pressure
        return np.fft.irfft2(np.fft.rfft2(wide) * kernel, s=wide.shape)[:cells, :cells]

    pressure = np.where(inside & (along**2 + across**2 < major**2), 1.0, 0.0)
    pressure *= force / (pressure.sum() * step**2)
    direction, before, grew = np.zeros_like(gap), 1.0, False
    for _ in range(2000):
        bears = pressure > 0
        rest = displaced(pressure) + gap
        rest -= rest[bears].mean()
        size = (rest[bears] ** 2).sum()
        direction = np.where(bears, rest + (0 if grew else size / before) * direction, 0.0)
        before = size
        answer = displaced(direction)
        answer -= answer[bears].mean()
        length = (rest * direction)[bears].sum() / (answer * direction)[bears].sum()
        changed = np.maximum(pressure - length * direction, 0.0)
        changed[~bears] = 0.0
        opens = inside & (changed == 0) & (rest < 0)
        grew = bool(opens.any())
        changed = np.where(opens, changed - length * rest, changed)
        changed *= force / (changed.sum() * step**2)
        moved = np.abs(changed - pressure).sum() / changed.sum()
        pressure = changed
        if moved < 1e-8:
            break
    middle = slice(cells // 2 - 1, cells // 2 + 1)
    at_point = float(np.sqrt(np.mean(pressure[middle, middle] ** 2)) / peak)
    return at_point, float(pressure.max() / peak)
