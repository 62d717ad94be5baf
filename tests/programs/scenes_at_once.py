"""Eight threads that calculate at once; run by the tests as a process of its own.

`python scenes_at_once.py SECONDS`: every thread goes round the scenes for so long, beginning at
another one, and compares with what one thread alone has found. Prints the rounds, and exits with 1
at the first number that differs.
"""

import dataclasses
import sys
import threading
import time

import jax
import jax.numpy as jnp
import numpy as np

import prsm_jax as prsm
from prsm_jax.mechanism import UnequalRoller

THREADS = 8


def _unequal():
    one = prsm.load("wu2022")
    rollers = (UnequalRoller(2, stiffness_factor=0.9), UnequalRoller(5, mass_factor=1.1))
    return dataclasses.replace(
        one, stages=(dataclasses.replace(one.stages[0], unequal_roller=rollers),)
    )


def scenes():
    """Name, function of one number, and the numbers of a batch."""
    unequal, wu, two = _unequal(), prsm.load("wu2022"), prsm.load("li2020_two_stage")
    shared = prsm.load("actuator_load_sharing")

    def modes(stiffness):
        moved = prsm.set_parameter(unequal, "stiffness.screw_roller", stiffness)
        found = prsm.modal(moved, shapes=True)
        return found.frequencies, found.strain_energy_shares()["screw_roller"]

    def slopes(stiffness):
        return jax.jacfwd(lambda k: modes(k)[0])(stiffness)

    def steady(load):
        found = prsm.steady_state(two, speed=100.0, load=load)
        return found.efficiency, found.contact_force

    def sharing(load):
        return prsm.compute(shared, ["largest_thread_load", "axial_deflection"], load=load)

    def response(stiffness):
        moved = prsm.set_parameter(wu, "stiffness.screw_roller", stiffness)
        hertz = jnp.geomspace(100.0, 1e4, 50)
        return prsm.frequency_response(moved, "screw u", "nut u", hertz).value

    def run(method):
        def simulated(load):
            scenario = prsm.Scenario(jnp.asarray(100.0), load, jnp.asarray(3e-4), samples=11)
            return prsm.simulate(two, scenario, method=method, throw=False).carrier_ratio

        return simulated

    stiffness, load = jnp.linspace(1e8, 3e8, 200), jnp.linspace(3e3, 7e3, 8)
    return {
        "modal": (modes, stiffness),
        "slopes of modal": (slopes, stiffness[:40]),
        "steady state": (steady, load),
        "load sharing": (sharing, load[:4]),
        "frequency response": (response, stiffness[:8]),
        "rosenbrock": (run("rosenbrock"), load),
        "implicit": (run("implicit"), load),
    }


def main(seconds):
    compiled = {name: (jax.jit(jax.vmap(f)), x) for name, (f, x) in scenes().items()}
    expected = {name: jax.tree.map(np.asarray, f(x)) for name, (f, x) in compiled.items()}
    names, rounds, wrong = list(compiled), [0] * THREADS, []
    end = time.monotonic() + seconds

    def work(number):
        turn = number
        while time.monotonic() < end or turn < number + len(names):
            name = names[turn % len(names)]
            function, numbers = compiled[name]
            found = jax.tree.map(np.asarray, function(numbers))
            same = jax.tree.map(
                lambda a, b: np.array_equal(a, b, equal_nan=True), found, expected[name]
            )
            if not all(jax.tree.leaves(same)):
                wrong.append(name)
                return
            turn += 1
            rounds[number] += 1

    threads = [threading.Thread(target=work, args=(number,)) for number in range(THREADS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    print("rounds", *rounds)
    if wrong:
        print("differs", *wrong)
        sys.exit(1)


if __name__ == "__main__":
    main(float(sys.argv[1]))
