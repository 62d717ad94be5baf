"""A fork of a process that has calculated says so at once; every other fork goes on.

Each case is a process of its own with a time limit: what waits for ever cannot be ended from
inside.
"""

import os
import subprocess
import sys

import pytest

from tests.compilation_cache import cache_folder

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")

_BEFORE = """
import multiprocessing, os, subprocess, sys, threading
import jax, jax.numpy as jnp
import prsm_jax as prsm
"""
#: `told(name, call)` prints what a call in the child ends with.
_AFTER = """
mechanism = prsm.load("wu2022")
stiffness = jnp.linspace(1e8, 2e8, 1000)

def modes(k):
    return prsm.modal(prsm.set_parameter(mechanism, "stiffness.screw_roller", k)).frequencies

compiled = jax.jit(jax.vmap(modes))
compiled(stiffness).block_until_ready()

def told(name, call):
    try:
        print(name, "ended with", type(jax.block_until_ready(call())), flush=True)
    except prsm.PrsmError as error:
        print(f"{name}: {error}", flush=True)

"""
_REFUSED = (
    "this process was forked after JAX had calculated, and has none of its threads: it would wait "
    "for ever. Start processes with multiprocessing.get_context('spawn'), or fork before the first "
    "calculation"
)


def _ended(code):
    environment = os.environ | {
        "JAX_COMPILATION_CACHE_DIR": cache_folder(),
        "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
    }
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code],  # JAX and Python warn of the fork
        capture_output=True,
        text=True,
        timeout=120,
        env=environment,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.splitlines()


def test_forked_before_anything_is_calculated():
    """A process that is forked before JAX runs calculates as any other."""
    code = """
child = os.fork()
if child:
    raise SystemExit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
print(float(prsm.modal(prsm.load('wu2022')).frequencies[-1]) > 1e3, flush=True)
os._exit(0)
"""
    assert _ended(_BEFORE + code) == ["True"]


def test_forked_after_a_calculation():
    """What is called in the child, is compiled already, or runs in a thread of it."""
    code = """
child = os.fork()
if child:
    raise SystemExit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
told("load", lambda: prsm.load("actuator"))
told("modal", lambda: prsm.modal(mechanism))
told("compute", lambda: prsm.compute(mechanism, ["carrier_ratio"]))
told("simulate", lambda: prsm.simulate(mechanism))
told("compiled", lambda: compiled(stiffness))
told("compiled anew", lambda: jax.jit(modes)(1e8))
thread = threading.Thread(target=told, args=("compiled, in a thread", lambda: compiled(stiffness)))
thread.start()
thread.join()
os._exit(0)
"""
    names = ("load", "modal", "compute", "simulate", "compiled", "compiled anew")
    assert _ended(_BEFORE + _AFTER + code) == [
        f"{name}: {_REFUSED}" for name in (*names, "compiled, in a thread")
    ]


def test_children_that_do_not_calculate_and_the_parent_go_on():
    """A program that is started, from a fork as well; plain Python in a fork; a spawned process."""
    code = """
print(subprocess.run([sys.executable, "-c", "print(1)"], capture_output=True, text=True).stdout[0])
child = os.fork()
if not child:
    os.execv(sys.executable, [sys.executable, "-c", "print(2)"])
os.waitpid(child, 0)
with multiprocessing.get_context("fork").Pool(1) as pool:
    print(pool.map(len, ["abc"])[0], flush=True)
print(bool(compiled(stiffness)[0, -1] > 1e3))
"""
    assert _ended(_BEFORE + _AFTER + code) == ["1", "2", "3", "True"]
