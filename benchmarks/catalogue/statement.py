"""The statement of the problem, as it stands on the page."""

STATEMENT = """\
# Beat the catalogue

This page is written by `python -m benchmarks catalogue --docs docs`. Do not edit it by hand.

A maker's table has 90 sizes of planetary roller screws (`prsm_jax.catalogue_sizes.catalogue_rows`).
Find, within the envelope of each size, a design whose dynamic capacity, axial stiffness and mass
are all better than those of the size's own model, with static capacity and efficiencies no worse.
A design is compared with the model of a size, not with the maker's product.

All numbers are in `catalogue_benchmark.json` beside this page: under `problems`, `no_loss` or
`half_digit`, `sizes`, each size has the measures of its own design (`own`), the `limits`, the best
design (`starts`, `variables`, `measures`, `objective`) and the runs of NSGA-II (`rivals`), in SI
units where a name has no unit.

## The problem

A size gives the nominal diameter d₀, the lead L, the starts n₀, and the outer diameter D₀ and the
length l₀ of the nut. Its own design is that of `prsm_jax.catalogue_sizes.plain_catalogue_mechanism`
from these dimensions, the printed diameters of crest and root, and the axial play. Masses are not
given, so they follow from the dimensions. The shaft is 25 d₀ long; this length does not affect the
objectives.

| free | symbol | own value | bounds |
| --- | --- | --- | --- |
| `contact_angle` | λ | 45° | 43° to 60° |
| `profile_ratio` | κ | 1 | 0.5 to 2 |
| `length_ratio` | s | 1 | 0.5 to 1 |
| `roller_count` | N | as many as fit | whole, 4 to as many as fit |
| `starts` | n | n₀ | whole, n₀ to 8, rollers at least 3.2 mm thick |

The other dimensions follow from these:

* pitch p = L/n, radius of the roller r = d₀ / (2 (n − 2)), radius of the nut's thread n r;
* profile radius of the roller ρ = κ r / cos λ: with κ = 1 it is centred on the roller's axis;
* outer diameter of the nut 2 (n r + w) with the size's own wall w = D₀/2 − n₀ d₀ / (2 (n₀ − 2));
* length of the nut s l₀, of the rollers 0.85 s l₀; threads of a roller that carry load 0.6 s l₀/p,
  carriers of 0.02 s l₀, gears of 0.0625 s l₀;
* heights of the screw's thread above and below the nominal radius, in the size's own proportion to
  the pitch; the roller's addendum is the depth of the screw's thread less 0.05 p, but at least
  0.1 p;
* as many rollers as fit: N with a sin(π/N) ≥ 1.02 r + addendum of the roller and a = d₀/2 + r;
* gears by the rules of `plain_catalogue_mechanism`; they have no effect on the measures below.

```python
import dataclasses, math
import jax.numpy as jnp
import prsm_jax as prsm
from prsm_jax.catalogue_sizes import plain_catalogue_mechanism

# 30 x 5 mm, 5 starts: nut of 64 x 85 mm, crest 30.3 and root 29.5 mm; here with 6 starts.
d, lead, own, n = 30e-3, 5e-3, 5, 6
angle, ratio, length, rollers = math.radians(50), 1.2, 0.95, 14
r = d / (2 * (n - 2))
wall = 64e-3 / 2 - own * d / (2 * (own - 2))
design = plain_catalogue_mechanism(
    d, lead, n,
    nut_outer_diameter_mm=2e3 * (n * r + wall), nut_length_mm=85 * length,
    crest_diameter_mm=30 + 0.3 * own / n, root_diameter_mm=30 - 0.5 * own / n,
    largest_axial_play_mm=0.02,
)
design = prsm.set_parameter(design, "stage.1.screw.length", 25 * d)
thread = dataclasses.replace(
    design.stages[0].thread,
    contact_angle=jnp.asarray(angle),
    roller_profile_radius=jnp.asarray(ratio * r / math.cos(angle)),
)
stage = dataclasses.replace(design.stages[0], thread=thread, roller_count=rollers)
design = dataclasses.replace(design, stages=(stage,))
print(prsm.compute(design, ["nut_unit_mass"])["nut_unit_mass"])  # kg
```

`prsm.compute` gives all measures, at the operating point of the mechanism (25 MPa times d₀²,
30 000 mm rpm over d₀). C is `dynamic_capacity`, K `axial_stiffness` (secant, of the contacts, equal
shares of the load in all threads), m `nut_unit_mass` (nut, rollers and carriers). Index 0 is the
size's own design.

**Maximise** t = min(ln C/C₀, ln K/K₀, ln m₀/m).

**Subject to**

* `static_capacity` at least that of the size's own design;
* `efficiency` and `efficiency_backward` each at least that of the size's own design less δ;
* `truncation_load`, above which a contact ellipse passes the end of a flank, at least the operating
  load, or at least that of the size's own design where this is smaller;
* no error of `prsm.check`.

There are two problems. In the first δ = 0: no loss at all. In the second δ = 0.005, half of the
last digit to which the catalogue prints efficiencies.

### Decisions and their reasons

* **Starts.** With lead and starts given, the pitch would be fixed. The lead is given; the starts
  are free whole numbers, the size's own among them, and give the pitch. The catalogue has 4 to 6
  starts; up to 8 are allowed. With fewer than n₀ the nut would be thicker than the size's.
* **Wall of the nut.** The wall is not free: with equal load sharing the model neglects its
  elasticity, so a thinner wall would have no disadvantage in the model. With the size's own wall
  the nut fits into its envelope.
* **Length.** The lengths of rollers and nut have the same ratio as in the size's own design. Only
  this ratio relates the number of loaded threads to the length.
* **One objective.** The smallest of three gains increases only if all three increase beyond it.
  With t as a further variable and three limits the problem is smooth.
* **Ends of flanks.** Capacities count only the part of an ellipse on its flank, without the
  pressure at the edge. The limit of `truncation_load` excludes designs that need this under the
  operating load, unless the size's own design needs it too.
* **Shaft.** With n₀ or more starts, the root of the screw is at least as thick as that of the size.
  A shaft of 8 mm and one metre would buckle; the length is therefore 25 d₀.
"""
