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
# # Accuracy and speed: what does a digit cost?
#
# Approximations, loose tolerances and single precision save time and cost digits. **The question:**
# which of them are worth it? `prsm bench` measures every method of this package and its rivals
# against references of higher precision, and writes the results into one JSON file, which this
# notebook reads. Then it measures three things itself.

# %%
import json
import time
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from IPython import get_ipython
from IPython.core.pylabtools import select_figure_formats
from matplotlib.figure import Figure

import prsm_jax as prsm

select_figure_formats(get_ipython(), {"png"})  # show figures, without pyplot
results = json.loads(Path("../docs/accuracy_and_speed.json").read_text(encoding="utf-8"))
problems = {(c["case"], p["name"]): p for c in results["cases"] for p in c["problems"]}
for case in results["cases"]:
    print(f"{case['case']:18} {case['date'][:10]}  {case['machine']['processor']}")

# %% [markdown]
# ## Do the defaults lie on the front?
# A method is on the front if no other of this package is faster and as accurate, or as fast with
# half its error. Defaults on the front:

# %%
rows = [(key, row) for key, p in problems.items() for row in p["results"] if row["default"]]
print(f"{sum(row['on_front'] for _, row in rows)} of {len(rows)} defaults lie on the front; not:")
for (case, problem), row in rows:
    if not row["on_front"]:
        print(f"  {case}, {problem}: {row['method']}")


# %%
COLOURS = [f"C{index}" for index in (0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 0, 1)]
MARKERS = "osD^vPX<>*hd"


def chart(case, problem):
    """Largest error over run time, one marker for each setting; a ring is a default."""
    found = problems[case, problem]
    figure = Figure(figsize=(8.5, 4.2), layout="constrained")
    axes = figure.subplots()
    names = dict.fromkeys(row["method"] for row in found["results"])
    for name, colour, marker in zip(names, COLOURS, MARKERS, strict=False):
        rows = [r for r in found["results"] if r["method"] == name and r["largest_error"]]
        rival = any(row["kind"] == "rival" for row in rows)
        axes.plot(
            [row["best_s"] for row in rows],
            [row["largest_error"] for row in rows],
            color=colour,
            marker=marker,
            linestyle="--" if rival else "-",
            fillstyle="none" if rival else "full",
            label=name + (" (rival)" if rival else ""),
        )
        rings = [row for row in rows if row["default"]]
        ring = {"marker": "o", "ms": 15, "mfc": "none", "mec": "black", "ls": "none"}
        axes.plot([r["best_s"] for r in rings], [r["largest_error"] for r in rings], **ring)
    axes.set(xscale="log", yscale="log", title=found["title"])
    axes.set(xlabel=f"run time per {found['instance']} [s]", ylabel="largest relative error [1]")
    axes.grid(color="0.9")
    figure.legend(loc="outside right upper", fontsize=8, frameon=False)
    return figure


chart("hertz", "range")

# %% [markdown]
# For contacts, exact theory costs as much as the approximations. Integrated transients
# are different: each digit costs steps, and where the closed form applies it is better than all of
# them.

# %%
chart("transient", "settle")

# %% [markdown]
# ## One at a time, or many at once?
# A call from Python costs some tens of microseconds, whatever it calculates. The chart shows the
# run time of the efficiency of a design, in batches of growing size, on this machine:

# %%
mechanism = prsm.load("wu2022")
design = jnp.asarray([prsm.get_parameter(mechanism, n) for n in ("lead", "contact_angle")])


def efficiency(numbers):
    moved = prsm.set_parameter(mechanism, "lead", numbers[0])
    return prsm.steady_state(prsm.set_parameter(moved, "contact_angle", numbers[1])).efficiency


def seconds(function, *arguments):
    """Best of some calls; the first one, which compiles, is not among them."""
    jax.block_until_ready(function(*arguments))
    times = []
    for _ in range(7):
        start = time.perf_counter()
        jax.block_until_ready(function(*arguments))
        times.append(time.perf_counter() - start)
    return min(times)


def line(x, y, across, up, title):
    """A line with markers on logarithmic axes."""
    figure = Figure(figsize=(6.5, 3.4), layout="constrained")
    axes = figure.subplots()
    axes.loglog(x, y, "o-")
    axes.set(xlabel=across, ylabel=up, title=title)
    axes.grid(color="0.9")
    return figure


many = jax.jit(jax.vmap(efficiency))
sizes = (1, 100, 10_000)
each = [seconds(many, jnp.tile(design, (size, 1))) / size * 1e6 for size in sizes]
line(sizes, each, "designs in a batch", "run time per design [µs]", "Efficiency")

# %% [markdown]
# So map over hundreds or thousands of designs at once.
#
# ## Exact derivatives, or differences?
# The error of central differences falls with the square of the step until rounding takes over. The
# best step is different for each quantity, and it gives eight or nine digits. Automatic
# differentiation has no step.

# %%
slope = jax.jit(jax.grad(efficiency))
exact = slope(design)[0]
steps = np.logspace(-1, -9, 17)
moved = np.tile(np.asarray(design), (2 * len(steps), 1))
moved[:, 0] *= np.concatenate([1 + steps, 1 - steps])
ends = np.asarray(jax.vmap(efficiency)(jnp.asarray(moved))).reshape(2, -1)
found = (ends[0] - ends[1]) / (2 * steps * float(design[0]))
error = np.abs(found / float(exact) - 1)
across, up = "step over lead [1]", "relative error of the difference [1]"
line(steps, error, across, up, "Derivative of the efficiency by the lead")

# %%
value = seconds(jax.jit(efficiency), design)
print(f"best difference: {error.min():.0e} at a step of {steps[error.argmin()]:.0e}")
print(f"value {value * 1e6:.0f} µs, gradient {seconds(slope, design) * 1e6:.0f} µs")
assert error.min() < 1e-7

# %% [markdown]
# ## Single or double precision?
# Single precision has seven digits, and sums and differences leave fewer.

# %%
small = prsm.programs.to_precision(mechanism, jnp.float32)
pair = [float(prsm.steady_state(m).efficiency) for m in (mechanism, small)]
print(f"efficiency {pair[0]:.9f} in float64, {pair[1]:.9f} in float32")
assert abs(pair[1] / pair[0] - 1) < 1e-5

# %% [markdown]
# ## Answer
# The defaults first: nearly all lie on the front. Batches for sweeps, exact derivatives always,
# approximations to reproduce a published formula. Single precision keeps six digits of the
# efficiency, 0.904719, which is enough for maps of very many designs.
#
# Next: [the whole axis, other types and a maker's catalogue](07_real_mechanisms.ipynb)
