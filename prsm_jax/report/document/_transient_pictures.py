"""All pictures of one transient, written into a folder."""

from pathlib import Path

from ...dynamics import Transient, body_forces
from ...mechanism import Mechanism
from .._style import save_figures
from ..animations import save_motion_animation
from ..motion_charts import (
    energy_flow,
    force_orbit,
    history_chart,
    power_flow_chart,
    power_history_chart,
    settles,
    transient_chart,
)


def save_transient_pictures(
    folder: str | Path, mechanism: Mechanism, run: Transient, *, animation: bool = True
) -> tuple[Path, ...]:
    """Write every picture of a transient: overview, histories, forces, powers, energy, motion.

    `transient`, `histories`, `force-orbit`, `powers` and `energy-flow` as PNG and SVG, and
    `motion.gif`. The overview `transient` is written only for a screw at constant speed, the energy
    flow not for one that never moves, and the force orbit only for standard and inverted roller
    screws.

    **Arguments:**

    - `folder`: where to write; made if it is not there.
    - `mechanism`, `run`: the mechanism and its transient.
    - `animation`: whether to write the animation.

    **Returns:** the paths written.

    **Raises:** `MissingExtraError` without matplotlib.
    """
    # Everything that can fail runs before the folder is made.
    figures = {
        "histories": history_chart(mechanism, run),
        "powers": power_history_chart(mechanism, run),
    }
    if all(stage.type in ("standard", "inverted") for stage in mechanism.stages):
        figures["force-orbit"] = force_orbit(mechanism, run, body_forces(mechanism, run))
    if settles(run):
        figures["transient"] = transient_chart(run)
    flow = energy_flow(mechanism, run)
    if flow.total > 0:
        figures["energy-flow"] = power_flow_chart(flow, "Energy flow of the whole transient")
    written = save_figures(folder, figures)
    if animation:
        written += (save_motion_animation(Path(folder) / "motion", mechanism, run),)
    return written
