# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Real mechanisms: is the axis stiff enough, would another type do, and do makers agree?
#
# A servo motor moves a slide of 300 kg through a roller screw. Its controller measures the position
# at the motor. **Three questions:** can the position loop of 20 Hz be used over the whole stroke?
# Would another type of roller screw need less torque? And are the computed capacities those that a
# maker prints?
#
# ## Motion in space
# The model of notebook 02 has no motion along the axis. `spatial_modal` lets every body move in
# $x$, $y$, $z$ and turn about $z$, and each thread is a spring along its true normal. The table
# `[axis]` of the file adds what is around the roller screw: motor, coupling, the screw as an
# elastic shaft, thrust tube and load. The stiffness of the shaft depends on the position of the
# nut.

# %%
import equinox as eqx
import jax
import numpy as np
from IPython import get_ipython
from IPython.core.pylabtools import select_figure_formats

import prsm_jax as prsm
from prsm_jax import report
from prsm_jax.response import axis_compliance
from prsm_jax.validation import compare_catalogue

select_figure_formats(get_ipython(), {"png"})  # show figures, without pyplot
axis = prsm.load("actuator_axis")
names = (*report.NUT_POSITION_QUANTITIES, "first_transverse_frequency", "position_loop_frequency")
BEARING, TUBE = "screw.support.axial_stiffness", "axis.load.tube_stiffness"


def built(distance, bearing, tube):
    """The axis with its nut at a distance, and factors for thrust bearing and thrust tube."""
    found = prsm.set_parameter(axis, "nut_distance", distance)
    found = prsm.set_parameter(found, BEARING, bearing * prsm.get_parameter(axis, BEARING))
    return prsm.set_parameter(found, TUBE, tube * prsm.get_parameter(axis, TUBE))


distances = np.linspace(0.05, 0.45, 9)
# All designs of this notebook in one program: positions, then three changes at the farthest one.
rows = [(d, 1.0, 1.0) for d in distances] + [(0.45, 1.0, 1.5), (0.45, 2.0, 1.0), (0.45, 2.0, 1.5)]
found = jax.jit(jax.vmap(lambda row: prsm.compute(built(*row), names)))(np.array(rows))
positions = {name: np.asarray(values)[:9] for name, values in found.items()}
for row, at in (("middle", 4), ("far end", 8)):
    print(f"{row}, nut at {1e3 * distances[at]:.0f} mm:")
    for name in names[:3] + names[-2:]:
        print(f"  {name.replace('_', ' '):27} {positions[name][at]:8.1f} Hz")
    print(f"  servo stiffness             {positions['servo_stiffness'][at] / 1e6:8.1f} N/µm")

# %% [markdown]
# The first torsional mode is the position loop itself: everything that turns and moves, on the gain
# of the controller. In the first axial mode the load swings against the motor. At the
# *anti-resonance*, the first mode with the motor held, the load swings and the motor stands still:
# a loop that measures at the motor does not see it. The loop should be five times slower, as in the
# `[optimise]` table of the file.

# %%
limit = 5 * positions["position_loop_frequency"]
enough = positions["antiresonance_frequency"] >= limit
print(
    f"limit {limit[8]:.1f} Hz; kept up to a nut distance of {1e3 * distances[enough].max():.0f} mm"
)
charted = {name: positions[name] for name in report.NUT_POSITION_QUANTITIES}
report.nut_position_chart(distances, charted, given=0.25)

# %% [markdown]
# ## What to stiffen
# The modes at the far end, drawn along the axis, with the springs that hold their energy. If spring
# $i$ has the share $e_i$ of the energy, the frequency rises by half of $e_i$ times the relative
# increase of its stiffness.

# %%
far = prsm.set_parameter(axis, "nut_distance", 0.45)
modes = eqx.filter_jit(lambda m: prsm.spatial_modal(m, shapes=True))(far)
first = next(mode for mode in modes.elastic_modes() if mode.family == "axial")
for name, share in list(first.strain.items())[:5]:
    print(f"{first.frequency:.1f} Hz: {100 * share:4.1f} % in {name.replace('_', ' ')}")
report.axis_mode_shapes(far, modes, count=3)

# %% [markdown]
# Threads hold a small share: a stiffer nut would not help. The screw itself holds most of it;
# without another diameter, thrust tube and thrust bearing are left. As it is, with a tube of 1.5
# times the cross-section, with two pairs of bearings, and with both:

# %%
for (_, bearing, tube), value in zip(rows[8:], found["antiresonance_frequency"][8:], strict=True):
    print(f"bearing × {bearing:.0f}, tube × {tube:.1f}: anti-resonance {value:6.1f} Hz")
assert found["antiresonance_frequency"][11] > limit[8]

# %% [markdown]
# The compliance of the changed axis, as a shaker at the slide and an encoder at the motor would
# measure it. The gap in the lower curve is the anti-resonance.

# %%
stiffer = built(*rows[11])
report.axis_compliance_chart(axis_compliance(stiffer, np.geomspace(5.0, 500.0, 300)))

# %% [markdown]
# ## The family
# Four types of roller screws, each drawn from its example. In the standard type the rollers keep
# their place in the nut; the inverted one has them around the screw, which is the rod while the nut
# turns. Rollers of the recirculating type have grooves, and a cam lifts them back once per orbit.
# In the differential type the nut has grooves, too.

# %%
types = {
    prsm.load(name).stages[0].thread.type: prsm.load(name)
    for name in ("actuator_axis", "humanoid_leg", "recirculating_stage", "differential_stage")
}
report.cross_section({name: types[name] for name in ("standard", "inverted")})

# %%
report.cross_section({name: types[name] for name in ("recirculating", "differential")})

# %% [markdown]
# Which one needs the least torque? All get the same friction coefficient, 0.08, and only the losses
# of the threads count:

# %%
NAMES = ("loss_thread_sliding", "carrier_ratio", "nut_speed", "roller_migration")


@eqx.filter_jit
def at_friction(mechanism, coefficient):
    return prsm.compute(prsm.set_parameter(mechanism, "thread.coefficient", coefficient), NAMES)


print("type           turns  travel per turn  migration  carrier  efficiency of the threads")
for name, mechanism in types.items():
    value = {key: float(np.squeeze(v)) for key, v in at_friction(mechanism, 0.08).items()}
    output = float(mechanism.operating_point.load) * value["nut_speed"]
    efficiency = output / (output + value["loss_thread_sliding"])
    travel = 1e3 * value["nut_speed"] * 2 * np.pi / float(mechanism.operating_point.speed)
    migration, carrier = 1e3 * value["roller_migration"], value["carrier_ratio"]
    turning = mechanism.stages[0].thread.family.turning
    print(
        f"{name:14} {turning:5} {travel:13.4f} mm {migration:7.3f} mm {carrier:8.4f} "
        f"{100 * efficiency:17.2f} %"
    )

# %% [markdown]
# The type decides what turns, the lead and whether rollers migrate, but hardly the efficiency. The
# travel of the differential type depends on friction, as the speed of its carrier does, but little:

# %%
for coefficient in (0.06, 0.08, 0.10):
    value = at_friction(types["differential"], coefficient)
    speed = float(types["differential"].operating_point.speed)
    travel = 1e3 * float(value["nut_speed"]) * 2 * np.pi / speed
    print(f"differential, friction {coefficient:.2f}: {travel:.4f} mm per turn")

# %% [markdown]
# Gears that do not match the thread make rollers migrate in the other types, too. One tooth too
# many on the screw of the inverted example (`prsm check` finds it):

# %%
text = prsm.file.example_text("humanoid_leg")
wrong = prsm.loads(text.replace("roller_teeth = 16", "roller_teeth = 16\nring_teeth = 81"))
creep = prsm.compute(wrong, ["roller_migration"])["roller_migration"]
print(f"81 teeth for 80: rollers creep {1e3 * float(creep[0]):+.4f} mm per turn of the carrier")

# %% [markdown]
# ## Comparison with a maker's catalogue
# A maker prints 90 roller screws of 8 to 120 mm. Rules build a mechanism from the dimensions of
# each size; six numbers of the rules are fitted to every second diameter. How well are the others
# predicted?

# %%
comparison = compare_catalogue()
print("                                 sizes  median   90 % of sizes below")
for column in ("static_capacity_kn", "dynamic_capacity_kn", "nut_inertia_kg_mm2"):
    summary = comparison.summary(column, comparison.predicted_half)
    words = column.rsplit("_kn", 1)[0].rsplit("_kg", 1)[0].replace("_", " ")
    print(
        f"{words:32} {summary.sizes:5} {100 * summary.median:6.1f} % "
        f"{100 * summary.percentile_90:12.1f} %"
    )
report.catalogue_chart(comparison)

# %% [markdown]
# ## Answer
# * **The position loop** of 19.8 Hz may be used up to a nut distance of 300 mm. At the far end the
#   anti-resonance, 91.4 Hz, is below five times the loop, 98.8 Hz. A second pair of thrust bearings
#   and a tube with 1.5 times the cross-section raise it to 99.1 Hz; stiffer threads would hardly,
#   as those of the screw hold 3.1 % of the energy.
# * **Another type** would not need less torque per lead: with the same friction the threads of all
#   types have efficiencies of 85.15 to 85.19 %. The type decides what turns and how far: 10 mm per
#   turn with 5 starts, 0.6245 mm in the differential example.
# * **The catalogue** agrees: of the sizes that the rules were not fitted to, 90 % are within 10.8 %
#   of the printed static and 6.3 % of the dynamic capacity.
#
# More: [vibration](../docs/vibration.md), [types of roller screws](../docs/types.md), [the
# catalogue](../docs/catalogue_witness.md).
