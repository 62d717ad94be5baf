"""Half-space contact of flanks; tangential traction; stress below by influence functions."""

import functools
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array, mesh, stage, thread

import prsm_jax as prsm
from prsm_jax.contact import hertz_contact, subsurface_stress
from prsm_jax.halfspace import (
    flank_contact,
    flank_gap,
    grid_over,
    partial_slip,
    sliding_traction,
    solve_contact,
    subsurface_stress_field,
    tangent_plane,
)
from prsm_jax.halfspace._flank_gap import _crests
from tests.present import present
from tests.roots import root_between

MODULUS = array(1.15e11)
SHAPE = (32, 32)


def _hertz(first, second):
    total, difference = array(first + second), array((second - first) ** 2)
    return hertz_contact(array(100.0), total, difference, MODULUS)


@functools.cache
def _on_grid(first, second):
    """Exact Hertz contact, and its contact on a grid with the gap."""
    exact = _hertz(first, second)
    grid = grid_over(SHAPE, 1.3 * exact.semi_major, 1.3 * exact.semi_minor)
    x, y = grid.points
    gap = first * x**2 + second * y**2
    return exact, gap, _solve(grid, gap)


@eqx.filter_jit
def _solve(grid, gap):
    return solve_contact(grid, gap, MODULUS, load=array(100.0))


# --- tangential traction ---

_slip = eqx.filter_jit(partial_slip)


def test_partial_slip_against_cattaneo_and_mindlin():
    """Spheres: radius of the stick zone, traction, displacement; and sliding from μ F on."""
    exact, gap, found = _on_grid(100.0, 100.0)
    friction, force = 0.2, 10.0
    slip = _slip(found, gap, MODULUS, array(friction), array(force))
    radius = float(exact.semi_major)
    share = (1 - force / (friction * 100.0)) ** (1 / 3)
    area = float(jnp.sum(slip.stick.astype(float)) * found.grid.cell_area)
    # Cells are counted whole: 20 across the stick zone.
    assert area == pytest.approx(np.pi * (share * radius) ** 2, rel=5e-2)
    assert jnp.sum(slip.traction) * found.grid.cell_area == pytest.approx(force, rel=1e-10)
    assert not bool(slip.sliding)
    assert jnp.array_equal(slip.stick | slip.slip, found.contact)
    x, y = found.grid.points
    square = (x**2 + y**2) / radius**2
    expected = jnp.sqrt(jnp.maximum(1 - square, 0)) - share * jnp.sqrt(
        jnp.maximum(1 - square / share**2, 0)
    )
    error = jnp.abs(slip.traction / (friction * exact.max_pressure) - expected)
    # Two edges with infinite slopes, as in the normal contact.
    assert jnp.mean(error) < 4e-3
    # Mindlin 1949, both bodies alike: δ_x = 3μF/16a · 2(2 − ν)/G · (1 − (1 − Q/μF)^{2/3}).
    poisson = 0.3
    shear_modulus = float(MODULUS) * (1 - poisson**2) / (1 + poisson)
    mindlin = 3 * friction * 100.0 / (16 * radius) * 2 * (2 - poisson) / shear_modulus
    mindlin *= 1 - (1 - force / (friction * 100.0)) ** (2 / 3)
    assert slip.displacement(friction, poisson) == pytest.approx(mindlin, rel=1e-3)

    sliding = _slip(found, gap, MODULUS, array(friction), array(30.0))
    assert bool(sliding.sliding)
    assert int(sliding.code) == 3
    assert sliding.force == pytest.approx(20.0, rel=1e-12)
    np.testing.assert_allclose(sliding.traction, sliding_traction(found, friction), rtol=1e-12)
    none = _slip(found, gap, MODULUS, array(friction), array(0.0))
    # The same contact twice, each to its tolerance.
    assert jnp.max(jnp.abs(none.traction)) < 1e-6 * float(found.max_pressure)


def test_nothing_sticks_without_friction():
    """μ = 0 with and without a force: no traction, and derivatives that are numbers."""
    exact, gap, found = _on_grid(100.0, 100.0)

    def values(given):
        slip = partial_slip(found, gap, MODULUS, given[0], given[1], tolerance=1e-12)
        return jnp.stack([jnp.sum(slip.traction**2) / 1e18, 1e6 * slip.approach_difference])

    @jax.jit
    @jax.vmap
    def everything(given):
        value, slope = jax.linearize(values, given)
        pull = jax.linear_transpose(slope, given)
        forward = jax.vmap(slope)(jnp.eye(2)).T
        return value, forward, jax.vmap(lambda one: pull(one)[0])(jnp.eye(2))

    given = jnp.asarray([[0.0, 0.0], [0.0, 5.0], [0.2, 0.0], [0.2, 10.0]])
    value, forward, reverse = everything(given)
    assert jnp.all(value[:2, 0] == 0)
    # The whole approach, from where the nearest cells touch: nothing sticks.
    whole = found.approach - jnp.min(gap)
    np.testing.assert_allclose(value[:2, 1], 1e6 * whole, rtol=1e-6)
    assert jnp.all(jnp.isfinite(forward))
    np.testing.assert_allclose(forward, reverse, rtol=1e-7, atol=1e-9)
    # At Q = 0 the normal compliance 1/(2aE*) over μ, from which `displacement` has that of Mindlin;
    # half of it would be the derivative of a tie.
    compliance = 1 / (2 * 0.2 * float(exact.semi_major) * float(MODULUS))
    assert forward[2, 1, 1] == pytest.approx(1e6 * compliance, rel=1e-2)
    none = _slip(found, gap, MODULUS, array(0.0), array(0.0))
    assert (float(none.force), int(none.code), bool(none.sliding)) == (0.0, 3, True)
    assert jnp.array_equal(none.slip, found.contact)


# --- stress below ---

_DEPTHS = jnp.asarray([0.0, 0.1, 0.3, 0.44, 0.48, 0.52, 0.8, 1.5])


@eqx.filter_jit
def _below(grid, pressure, depths, traction_x, traction_y):
    return subsurface_stress_field(
        grid, pressure, depths, array(0.3), traction_x=traction_x, traction_y=traction_y
    )


def test_stress_below_a_sphere():
    """The textbook values at ν = 0.3, and the closed form on the axis (Johnson, section 3.4)."""
    exact, _, found = _on_grid(100.0, 100.0)
    radius, peak = float(exact.semi_major), float(exact.max_pressure)
    no_traction = jnp.zeros(SHAPE)
    stress = _below(found.grid, found.pressure, radius * _DEPTHS, no_traction, no_traction)
    largest, depth = stress.max_von_mises
    # 0.620 p₀ at 0.48 a; the grid of 25 cells leaves 0.1 %.
    assert largest == pytest.approx(0.620 * peak, rel=2e-3)
    assert depth == pytest.approx(0.481 * radius, rel=5e-3)
    depths = np.asarray(_DEPTHS[2:])
    axis = np.asarray(stress.tensor[2:, 15:17, 15:17].mean(axis=(1, 2))) / peak
    downwards = -1 / (1 + depths**2)
    radial = -1.3 * (1 - depths * np.arctan(1 / depths)) - downwards / 2
    # The four points are half a cell off the axis, where stresses differ by its square.
    np.testing.assert_allclose(axis[:, 2, 2], downwards, atol=3e-3)
    np.testing.assert_allclose(axis[:, 0, 0], radial, atol=3e-3)
    np.testing.assert_allclose(axis[:, 1, 1], radial, atol=3e-3)
    # τ_max = 0.310 p₀ is half the largest difference on the axis.
    assert np.max(axis[:, 0, 0] - axis[:, 2, 2]) / 2 == pytest.approx(0.310, rel=5e-3)


def test_stress_below_an_ellipse_with_friction():
    """Against the plane-wave solution of the Hertz ellipse, traction in both directions."""
    exact, _, found = _on_grid(68.456, 96.673)
    depths = exact.semi_minor * jnp.asarray([0.0, 0.3, 0.6, 1.2, 1.5, 2.0, 3.0, 4.0])
    friction = array(0.2), array(-0.1)
    tractions = [mu * found.pressure for mu in friction]
    stress = _below(found.grid, found.pressure, depths, *tractions)
    # On the surface: what was put on it.
    surface = stress.tensor[0]
    scale = float(exact.max_pressure)
    np.testing.assert_allclose(surface[..., 2, 2], -found.pressure, rtol=0, atol=1e-12 * scale)
    np.testing.assert_allclose(surface[..., 0, 2], -tractions[0], rtol=0, atol=1e-12 * scale)
    np.testing.assert_allclose(surface[..., 1, 2], -tractions[1], rtol=0, atol=1e-12 * scale)
    axes = jnp.stack([exact.semi_major, exact.semi_minor])
    x, y = found.grid.points
    rows, columns = np.array([4, 10, 16, 21, 29]), np.array([16, 3, 16, 24, 20])

    @jax.jit
    def analytic(points):
        return jax.vmap(
            lambda point: subsurface_stress(
                point, axes, exact.max_pressure, array(0.3), jnp.stack(friction)
            )
        )(points)

    for index in (1, 2, 4):
        flat = [x[rows, columns], y[rows, columns], jnp.full(5, depths[index])]
        expected = analytic(jnp.stack(flat, axis=-1))
        error = jnp.abs(stress.tensor[index, rows, columns] - expected)
        # Cells of constant pressure on a grid of 25 across: 0.15 % of p₀ nearest to the surface.
        assert jnp.max(error) < 2e-3 * scale


# --- real flanks ---

_STAGE = stage(roller_count=1, engaged_threads=1.0, geometry=thread(5e-3))
_WITH_CRESTS = stage(
    roller_count=1,
    engaged_threads=1.0,
    geometry=thread(5e-3, screw_addendum=0.3e-3, roller_addendum=0.05e-3),
)
_compiled = eqx.filter_jit(functools.partial(flank_contact, shape=SHAPE))


def _contact(one, side, load, **options):
    # The meshing is a program of its own, which other tests compile as well.
    return _compiled(one, side, load, meshing=mesh(one.thread), **options)


_plane, _gap = eqx.filter_jit(tangent_plane), eqx.filter_jit(flank_gap)


@pytest.mark.parametrize("side", ["screw", "nut"])
def test_gap_of_flanks_osculates_the_paraboloid(side):
    """Near the contact it is A x² + B y² of the exact curvatures, axes aligned; and symmetric."""
    geometry = thread(5e-3)
    meshing = mesh(geometry)
    plane = _plane(geometry, meshing, side)
    basis = np.stack([plane.major, plane.minor, plane.normal])
    np.testing.assert_allclose(basis @ basis.T, np.eye(3), atol=1e-14)
    inwards = 1 if side == "nut" else -1
    np.testing.assert_allclose(getattr(meshing, side).normal, inwards * plane.normal, atol=1e-12)
    curvature = getattr(meshing, side).curvature
    spread = jnp.sqrt(curvature.difference_squared)
    first, second = (curvature.total - spread) / 2, (curvature.total + spread) / 2
    sizes, errors = (2e-4, 2e-5), []
    for size in sizes:
        grid = grid_over((4, 4), array(size), array(size))
        x, y = grid.points
        gap = _gap(geometry, plane, side, grid).gap
        even = (gap + gap[::-1, ::-1]) / 2
        expected = first * x**2 + second * y**2
        # The odd part is of third order: a share of gap that falls with the size.
        errors.append(float(jnp.max(jnp.abs(gap / expected - 1))))
        np.testing.assert_allclose(even / expected, 1.0, atol=2e-3 * size / 2e-4)
    assert errors[0] < 0.02
    assert errors[1] == pytest.approx(errors[0] / 10, rel=0.3)


@pytest.mark.parametrize("side", ["screw", "nut"])
def test_contact_of_flanks_is_nearly_hertz(side):
    found = _contact(_STAGE, side, array(100.0))
    assert int(found.surface.code) == 0
    # Terms of third order and the grid: 0.1 % together.
    assert found.surface.max_pressure == pytest.approx(float(found.hertz.max_pressure), rel=1e-3)
    assert found.surface.approach == pytest.approx(float(found.hertz.approach), rel=1e-3)
    axial = found.surface.load / found.normal_per_axial
    assert axial == pytest.approx(100.0, rel=1e-12)
    expected = prsm.thread_contacts(prsm.Mechanism((_STAGE,)), 100.0)[0]
    pressure = getattr(expected, side).hertz.max_pressure
    assert found.hertz.max_pressure == pytest.approx(float(pressure), rel=1e-12)
    assert found.flanks.body_edge is None


def test_load_of_either_sign_and_none():
    """The magnitude of the load counts, as in Hertz contacts; without one the code says so."""
    pulled, pushed, none = (_contact(_STAGE, "screw", array(load)) for load in (-100.0, 100.0, 0.0))
    for one, other in zip(jax.tree.leaves(pulled), jax.tree.leaves(pushed), strict=True):
        np.testing.assert_array_equal(one, other)
    assert int(none.surface.code) == 3
    assert all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(none))
    for name in ("pressure", "contact", "displacement", "load", "max_pressure", "area"):
        assert not np.any(getattr(none.surface, name)), name
    for name in ("semi_major", "semi_minor", "max_pressure", "approach"):
        assert float(getattr(none.hertz, name)) == 0, name
    # The cells nearest to the contact point are less than an atom away from it.
    assert abs(float(none.surface.approach)) < 1e-12


def test_flanks_at_an_approach():
    """What a load brings about brings that load about; open flanks carry none; derivatives."""
    under_load = _contact(_STAGE, "screw", array(100.0))
    meshing = mesh(_STAGE.thread)

    def values(approach):
        found = flank_contact(
            _STAGE, "screw", shape=SHAPE, approach=approach, meshing=meshing, tolerance=1e-12
        )
        code = found.surface.code.astype(float)
        return jnp.stack([found.surface.load, 1e-9 * found.surface.max_pressure, code])

    @jax.jit
    @jax.vmap
    def everything(approach):
        value, slope = jax.linearize(values, approach)
        (reverse,) = jax.vmap(jax.linear_transpose(slope, approach))(jnp.eye(3))
        return value, slope(jnp.ones_like(approach)), reverse

    closed = float(under_load.surface.approach)
    step = 1e-4 * closed
    # An approach of exactly 0 is decided by the last digit of the gap.
    approaches = jnp.asarray([closed, closed + step, closed - step, -0.5 * closed, -1e-9])
    value, forward, reverse = everything(approaches)
    # The grid follows Hertz theory's approach instead of its load, 1e-3 apart.
    assert value[0, 0] == pytest.approx(float(under_load.surface.load), rel=1e-4)
    peak = float(under_load.surface.max_pressure)
    assert value[0, 1] == pytest.approx(1e-9 * peak, rel=1e-4)
    assert value[:, 2].tolist() == [0, 0, 0, 3, 3]
    np.testing.assert_array_equal(value[3:, :2], 0.0)
    np.testing.assert_array_equal(forward[3:, :2], 0.0)
    np.testing.assert_allclose(forward, reverse, rtol=1e-7)
    # Cells that change sides move the differences by the error of the grid.
    differences = (value[1] - value[2]) / (2 * step)
    np.testing.assert_allclose(forward[0], differences, rtol=5e-4, atol=1e-12)
    # F ∝ δ^{3/2} and p₀ ∝ δ^{1/2}.
    share = closed * forward[0, :2] / value[0, :2]
    np.testing.assert_allclose(share, [1.5, 0.5], rtol=2e-3)


def test_flanks_end_at_their_crests():
    """No pressure past a crest inside the contact, more beside it; a rounded edge is milder."""
    whole = _contact(_STAGE, "screw", array(100.0))
    cut = _contact(_WITH_CRESTS, "screw", array(100.0))
    rounded = _contact(_WITH_CRESTS, "screw", array(100.0), edge_radius=array(0.2e-3))
    assert whole.flanks.roller_edge is None
    edge = cut.flanks.roller_edge
    assert jnp.any(cut.surface.pressure > 0)
    assert not jnp.any(cut.surface.contact & (edge <= 0))
    assert jnp.any(whole.surface.contact & (edge < 0))
    assert cut.surface.load == pytest.approx(float(whole.surface.load), rel=1e-12)
    assert cut.surface.approach > 1.02 * whole.surface.approach
    assert cut.surface.max_pressure > 1.5 * whole.surface.max_pressure
    assert whole.surface.max_pressure < rounded.surface.max_pressure < cut.surface.max_pressure
    # The crest in space: the radius about the roller's axis where the distance vanishes.
    grid, plane = cut.surface.grid, cut.plane
    x, y = (np.asarray(c)[..., None] for c in grid.points)
    points = np.asarray(plane.origin) + x * np.asarray(plane.major) + y * np.asarray(plane.minor)
    radius = np.hypot(points[..., 0] - 20e-3, points[..., 1])
    np.testing.assert_allclose(present(edge), (5.05e-3 - radius) * np.sqrt(2), atol=1e-12)


@pytest.mark.parametrize(("x", "y"), [(9e-3, 0.0), (8.6e-3, 1.2e-3), (14.7e-3, -0.4e-3)])
def test_distances_from_crests(x, y):
    """From the outer circles of screw and roller and the inner one of the nut, drawn by hand."""
    geometry = thread(5e-3, screw_addendum=0.4e-3, roller_addendum=0.3e-3)
    roller = float(geometry.roller_radius)
    screw, axis = 3 * roller, 4 * roller
    from_centre, from_axis = np.hypot(x, y), np.hypot(x - axis, y)
    expected: dict[Any, Any] = {
        "screw": (screw + 0.4e-3 - from_centre, roller + 0.3e-3 - from_axis),
        "nut": (from_centre - (axis + roller - 0.4e-3), roller + 0.3e-3 - from_axis),
    }
    for side, distances in expected.items():
        found = [present(one) for one in _crests(geometry, side, array(x), array(y))]
        np.testing.assert_allclose(found, distances, rtol=1e-13, atol=1e-17)
    assert _crests(thread(5e-3), "screw", array(x), array(y)) == (None, None)


@pytest.mark.parametrize("side", ["screw", "nut"])
def test_the_contact_point_itself_has_a_gap_of_zero(side):
    """Grids with an odd number of cells have a cell on it, where only rounding is left."""
    grid = grid_over((5, 5), array(1e-4), array(1e-4))
    radii = jnp.asarray(np.random.default_rng(3).uniform(1e-3, 2e-2, 40))

    @jax.jit
    @jax.vmap
    def gaps(radius):
        geometry = thread(radius, 5e-3)
        plane = tangent_plane(geometry, prsm.mesh(geometry), side)
        return flank_gap(geometry, plane, side, grid).gap[2, 2]

    np.testing.assert_allclose(gaps(radii), 0, atol=2e-17)


def _distance_along_normal(flank, foot, normal, origin):
    """To where a flank z(x, y), shifted to the contact point, is met; None where it is not."""
    shift = flank(*origin[:2]) - origin[2]

    def above(distance):
        x, y, z = (foot[k] + distance * normal[k] for k in range(3))
        return flank(x, y) - shift - z

    places = np.linspace(-0.6e-3, 0.6e-3, 1201)
    with np.errstate(invalid="ignore"):
        heights = above(places)
    (crossings,) = np.nonzero(heights[:-1] * heights[1:] <= 0)
    if not len(crossings):
        return None
    nearest = crossings[np.argmin(np.abs(places[crossings]))]
    return root_between(above, places[nearest], places[nearest + 1], xtol=1e-16)


def test_a_gap_is_that_of_the_flanks_or_none():
    """Across a sharply curved arc: right to 1e-3 of the distance, not finite, or no material.

    Past its end there is no flank, whose continuation would touch the other one again.
    """
    profile, angle = 0.5e-3, np.pi / 4
    geometry = thread(4e-3, 10e-3, angle, roller_profile_radius=array(profile))
    plane = tangent_plane(geometry, mesh(geometry), "screw")
    grid = grid_over((25, 25), array(profile), array(profile))
    found = eqx.filter_jit(flank_gap)(geometry, plane, "screw", grid)
    gap = np.asarray(found.gap)
    there = np.isfinite(gap) & np.asarray(found.material)

    def screw(x, y):
        return np.hypot(x, y) - 12e-3 + 10e-3 / (2 * np.pi) * np.arctan2(y, x)

    def roller(x, y):
        offset = np.hypot(16e-3 - x, y) - 4e-3 + profile * np.sin(angle)
        arc = np.sqrt(profile**2 - offset**2) - profile * np.cos(angle)
        return arc - 10e-3 / (2 * np.pi) / 5 * np.arctan2(y, 16e-3 - x)

    origin, normal, major, minor = (
        np.asarray(v) for v in (plane.origin, plane.normal, plane.major, plane.minor)
    )
    assert there[12, 12]
    beyond = 0
    for place in np.ndindex(grid.shape):
        along, across = (float(c[place]) for c in grid.points)
        foot = origin + along * major + across * minor
        distances: list[Any] = [
            _distance_along_normal(f, foot, normal, origin) for f in (screw, roller)
        ]
        if None in distances:
            assert not there[place]
            beyond += 1
        elif there[place]:
            away = np.max(np.abs(foot - origin))
            assert abs(gap[place] - (distances[0] - distances[1])) <= 1e-3 * away + 2e-17
    assert 0 < beyond < 0.3 * gap.size
    assert np.mean(there) > 0.6


def test_roughness_on_flanks():
    """Heights as a function of the coordinates: peaks bring pressure where they are."""
    plain = _contact(_STAGE, "nut", array(100.0))
    length = float(plain.hertz.semi_major) / 4

    def waves(x, y):
        return 1e-7 * jnp.cos(2 * jnp.pi * x / length) * jnp.cos(2 * jnp.pi * y / length)

    found = _contact(_STAGE, "nut", array(100.0), heights=waves)
    assert int(found.surface.code) == 0
    heights = waves(*found.surface.grid.points)
    change = found.surface.pressure - plain.surface.pressure
    inside = plain.surface.pressure > 0.5 * plain.surface.max_pressure
    correlation = np.corrcoef(np.asarray(change[inside]), np.asarray(heights[inside]))[0, 1]
    assert correlation > 0.9
    assert found.surface.max_pressure > 1.1 * plain.surface.max_pressure
    # The heights lower the gap and nothing else. Flanks lie 10 to 30 mm from the axis: a last digit
    # of that is 3e-18 m.
    np.testing.assert_allclose(found.flanks.gap, plain.flanks.gap, rtol=1e-12, atol=1e-17)


@pytest.mark.usefixtures("unchecked")
def test_misuse_of_flanks_is_refused():
    with pytest.raises(ValueError, match="choose 'screw' or 'nut'"):
        flank_contact(_STAGE, "left", 100.0)
    wrong: tuple[dict[str, Any], ...] = ({}, {"load": 100.0, "approach": 1e-6})
    for given in wrong:
        with pytest.raises(ValueError, match="exactly one of the two"):
            flank_contact(_STAGE, "nut", shape=SHAPE, **given)
    with pytest.raises(prsm.MissingDataError, match="engaged_threads"):
        flank_contact(stage(engaged_threads=None), "nut", 100.0, SHAPE)


def test_only_what_is_asked_for_is_traced():
    """Normal contact, gap of flanks, slip and stress have labels of their own."""
    _, gap, found = _on_grid(100.0, 100.0)
    normal = prsm.programs.traced_physics(_solve, found.grid, gap)
    assert normal == {"halfspace_contact"}
    flanks = prsm.programs.traced_physics(
        lambda one: flank_contact(one, "nut", 100.0, SHAPE), _STAGE
    )
    assert flanks == {"halfspace_contact", "flank_gap", "hertz", "meshing"}
    assert "partial_slip" in prsm.programs.traced_physics(
        lambda g: partial_slip(found, g, MODULUS, 0.1, 1.0), gap
    )

    def size(**tractions):
        jaxpr = jax.make_jaxpr(
            lambda p: subsurface_stress_field(found.grid, p, _DEPTHS, 0.3, **tractions).tensor
        )(found.pressure)
        return len(str(jaxpr))

    assert size() < 0.7 * size(traction_x=found.pressure)
