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
# # From a file that describes a roller screw to a better roller screw
#
# The roller screw of an electromechanical actuator carries 12 kN. **The question:** is this design
# within its limits of pressure and size, and which one within them wastes the least power? `make
# demo` answers it with more limits and a report; this is the short form in Python.

# %%
import equinox as eqx
import jax
import numpy as np
from IPython import get_ipython
from IPython.core.pylabtools import select_figure_formats

import prsm_jax as prsm
from prsm_jax import report

select_figure_formats(get_ipython(), {"png"})  # show figures, without pyplot
mechanism = prsm.load("actuator")
report.cross_section({"as it is": mechanism})

# %% [markdown]
# Everything is a frozen pytree of numbers in SI units. Parts that are not in the file are `None`
# and are not computed.
#
# ## Steady state
# The steady state is algebra: the carrier ratio follows from the geometry of the contact, the
# forces from the load. Every loss has a name, and input minus output minus losses is zero to
# rounding.

# %%
steady = eqx.filter_jit(prsm.steady_state)(mechanism)
print(f"efficiency {steady.efficiency:.4f}, torque {steady.drive_torque:.2f} N·m")
for name, power in steady.losses.items():
    print(f"  {name}: {power:.2f} W")
print(f"power balance residual {steady.power_balance_residual:.1e}")
assert steady.power_balance_residual < 1e-12
report.power_flow_chart(report.steady_flow(steady), "Power in the steady state")

# %% [markdown]
# ## Derivatives
# `jax.grad` of anything with respect to every number of the mechanism at once, here of the largest
# pressure between screw and rollers:


# %%
def pressure(mechanism):
    (contacts,) = prsm.thread_contacts(mechanism)
    return contacts.screw.hertz.max_pressure


value, slope = eqx.filter_jit(jax.value_and_grad(pressure))(mechanism)
thread = slope.stages[0].thread
print(f"largest pressure {value / 1e6:.0f} MPa")
print(f"  per mm of lead              {float(thread.lead) * 1e-9:+7.1f} MPa")
print(f"  per degree of contact angle {float(np.radians(thread.contact_angle)) / 1e6:+7.1f} MPa")
print(f"  per mm of roller radius     {float(thread.roller_radius) * 1e-9:+7.1f} MPa")

# %% [markdown]
# ## A better design
# Lead, contact angle and roller radius may change. The efficiency shall be the highest within
# limits of pressure, diameter of the nut, torque and play between the teeth. (The `[optimise]`
# table of the file has more: loads shared by elastic threads, stiffness, the first axial frequency
# and the errors of `prsm check`. `prsm.optimise(mechanism)` keeps all of them.)

# %%
best = prsm.optimise(
    mechanism,
    {
        "lead": (5e-3, 20e-3),
        "contact_angle": tuple(np.radians([30, 60])),
        "roller_radius": (3e-3, 6e-3),
    },
    "efficiency",
    constraints={
        "max_pressure": (None, 2.0e9),
        "nut_outer_diameter": (None, 58e-3),
        "drive_torque": (None, 25.0),
        "axial_backlash": (1e-6, None),
    },
    starts=2,
    respect_findings=False,
)
print(best)
assert best.converged

# %% [markdown]
# The active constraints, and the change of the efficiency if a limit is raised by 1 %:

# %%
for constraint in best.constraints:
    if constraint.active:
        gain = constraint.multiplier * 0.01 * constraint.limit
        print(f"{constraint.name}: 1 % more of the limit changes the efficiency by {gain:+.1e}")

# %%
report.cross_section({"before": mechanism, "after": best.mechanism})

# %% [markdown]
# ## Around the optimum
# A sweep over lead and contact angle, everything else as in the optimum: no design within the
# limits is better. Outside is hatched.

# %%
limits = {
    "max_pressure": (None, 2.0e9),
    "drive_torque": (None, 25.0),
    "axial_backlash": (1e-6, None),
}
data = prsm.sweep(
    best.mechanism,
    {"lead": np.linspace(6e-3, 12e-3, 31), "contact_angle": np.radians(np.linspace(40, 60, 41))},
    quantities=["efficiency", *limits],
    findings=False,
)
inside = (data.max_pressure <= 2.0e9) & (data.drive_torque <= 25.0)
inside = inside & (data.axial_backlash >= 1e-6).all("stage")
assert data.efficiency.where(inside).max() <= best.optimum.objective
report.sweep_figure(data, "efficiency", constraints=limits)

# %% [markdown]
# ## Answer
# No: its nut has a diameter of 60 mm where 58 are allowed, and a pressure of 2092 MPa where 2000
# are. The most efficient design within the limits has a lead of 10.74 mm, a contact angle of 49.3°
# and rollers of 3.8 mm radius: 86.06 % in place of 85.87 %. Pressure, diameter and the play between
# the teeth stop it from becoming better.
#
# Next: [which frequencies does such a roller screw have?](02_vibration.ipynb)
