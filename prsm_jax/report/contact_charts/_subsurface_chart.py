"""Section of the von Mises stress below a thread contact, without and with friction."""

import functools
from typing import Literal

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from ...contact import HertzContact, StressPeak, stress_peak, subsurface_stress, von_mises_stress
from ...fields import Scalar
from ...text import display_unit, in_unit
from .._parts import aside, colour_bar
from .._style import INK, Figure, drawn, page_figure

SectionAxis = Literal["major", "minor"]
_COLUMNS, _ROWS = 121, 61


@functools.cache
def _program():
    @eqx.filter_jit
    def section(points, semi_axes, pressure, poisson_ratio, traction):
        field = jax.vmap(
            lambda point: von_mises_stress(
                subsurface_stress(point, semi_axes, pressure, poisson_ratio, traction)
            )
        )(points)
        return field, stress_peak(semi_axes, pressure, poisson_ratio, traction)

    return section


@drawn
def subsurface_chart(
    contact: HertzContact,
    poisson_ratio: float | Scalar,
    friction: float = 0.1,
    along: SectionAxis = "major",
) -> Figure:
    """Draw the von Mises stress below a Hertz contact, without friction and in full sliding.

    The section contains the axis of the contact and the direction in which the other body drags
    this one, which points to the right. A cross marks the maximum.

    **Arguments:**

    - `contact`: a Hertz contact under load.
    - `poisson_ratio`: ν of the body that is drawn.
    - `friction`: coefficient of friction of the lower panel.
    - `along`: the axis of the contact that the section and the sliding follow; in a thread the
      slip runs along the flank's generator, which is the major axis.

    **Returns:** a matplotlib figure; lengths in mm or µm, stress in MPa.

    **Raises:** `ValueError` for a contact without load or an unknown axis; `MissingExtraError`
    without matplotlib.
    """
    if along not in ("major", "minor"):
        raise ValueError(f"along is {along!r}; choose major or minor")
    axes = np.array([float(contact.semi_major), float(contact.semi_minor)])
    if not axes.min() > 0:
        raise ValueError("the contact carries no load; a section has nothing to show")
    if along == "minor":
        axes = axes[::-1]
    arguments = (
        jnp.asarray(axes),
        jnp.asarray(float(contact.max_pressure)),
        jnp.asarray(float(poisson_ratio)),
    )
    x = np.linspace(-1.6, 1.6, _COLUMNS) * axes[0]
    z = np.linspace(0.0, 1.6, _ROWS) * axes.min()
    grid = np.stack(np.meshgrid(x, z, indexing="xy"), axis=-1).reshape(-1, 2)
    points = jnp.asarray(np.stack([grid[:, 0], np.zeros(len(grid)), grid[:, 1]], axis=-1))
    sections = []
    for coefficient in (0.0, float(friction)):
        field, peak = _program()(points, *arguments, jnp.asarray([coefficient, 0.0]))
        sections.append((coefficient, 1e-6 * np.asarray(field).reshape(_ROWS, _COLUMNS), peak))

    unit = display_unit("m", axes[0])
    figure = page_figure(min(2 * 110.0 * z[-1] / (x[-1] - x[0]) + 36.0, 220.0), 150.0)
    panels = figure.subplots(2, 1, sharex=True)
    from matplotlib.ticker import MaxNLocator

    highest = max(max(field.max(), 1e-6 * float(peak.value)) for _, field, peak in sections)
    levels = MaxNLocator(14).tick_values(0.0, highest)
    image = None
    for panel, (coefficient, field, peak) in zip(panels, sections, strict=True):
        image = panel.contourf(unit(x), unit(z), field, levels, cmap="cividis")
        panel.contour(unit(x), unit(z), field, levels, colors="white", linewidths=0.2)
        _decorate(panel, unit, axes[0], peak)
        name = "without friction" if coefficient == 0 else f"sliding, µ = {coefficient:g}"
        panel.set_title(name)
        panel.set_ylabel(f"depth in {unit.label}")
    panels[1].set_xlabel(f"along the {along} axis in {unit.label}")
    bar = colour_bar(figure, image, panels, "von Mises stress in MPa")
    bar.ax.yaxis.set_major_formatter("{x:.0f}")
    return figure


def _decorate(panel, unit, semi_axis: float, peak: StressPeak) -> None:
    """The loaded part of the surface, and the maximum with its value and depth."""
    panel.set_aspect("equal")
    panel.invert_yaxis()
    panel.plot(
        [unit(-semi_axis), unit(semi_axis)], [0, 0], color=INK, lw=3, solid_capstyle="butt",
        clip_on=False,
    )  # fmt: skip
    place = unit(float(peak.position[0])), unit(float(peak.position[2]))
    panel.plot(*place, marker="x", color=INK, markersize=6, mew=1.2, clip_on=False)
    words = f"{in_unit(peak.value, display_unit('Pa'))}\nat depth {in_unit(peak.depth, unit, 3)}"
    box = {"boxstyle": "round,pad=0.2", "facecolor": "white", "alpha": 0.75, "lw": 0}
    aside(panel, words, place, (8, -4), va="top", color=INK, bbox=box)
