"""Long native calls: interrupted at once, and with the results of short ones."""

import subprocess
import sys
from importlib import import_module

import numpy as np
import pytest

from axisid import UsageError, build, load_axis, simulate

pytestmark = pytest.mark.usefixtures("c_compiler")

module = import_module("axisid.codegen.runtime.library")


REFERENCE = 0.1 * np.sin(np.arange(400_000) * 1e-3)

#: A process of its own, as a user's is: how long after Ctrl-C a long simulation, or an evaluation
#: at many samples, ends.
LONG = """
import os, signal, sys, threading, time
import numpy as np
from axisid import UsageError, build, load_axis, simulate
from axisid.estimation import simulate_batch

signal.signal(signal.SIGINT, signal.default_int_handler)
lanes = int(sys.argv[1])
axis = build(load_axis("emps"))
assert axis.native.library() is not None
reference = 0.1 * np.sin(np.arange(400_000 // max(lanes, 1)) * 1e-3)
simulate(axis, axis.nominal, reference[:10], 1e-3)
motion = np.ones((4, 4_000_000 if lanes < 0 else 1))
sent = []

def interrupt():
    sent.append(time.process_time())
    os.kill(os.getpid(), signal.SIGINT)

threading.Timer(0.3, interrupt).start()
try:
    for _ in range(5 if lanes >= 0 else 10**6):
        if lanes < 0:
            axis.evaluate("inverse_dynamics", *motion, axis.nominal)
        elif lanes:
            parameters = np.tile(axis.nominal, (lanes, 1))
            simulate_batch(axis, parameters, reference, 1e-3, substeps=1024)
        else:
            simulate(axis, axis.nominal, reference, 1e-3, substeps=1024)
except KeyboardInterrupt:
    print(time.process_time() - sent[0])
"""


@pytest.mark.slow
@pytest.mark.parametrize("lanes", [-1, 0, 1, 64])
def test_what_takes_long_ends_at_once_at_an_interrupt(lanes: int) -> None:
    done = subprocess.run(
        [sys.executable, "-c", LONG, str(lanes)], capture_output=True, text=True, check=True
    )
    assert float(done.stdout) < 1.0, done.stderr  # of two threads


@pytest.mark.slow
@pytest.mark.parametrize("native", [True, False])
def test_slices_change_no_bit(
    native: bool, rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    axis = build(load_axis("crank"), native=native)
    assert (axis.native.library() is not None) == native
    arguments = (*rng.normal(size=(4, 5000)), axis.nominal)
    whole = axis.evaluate("idm_regressor", *arguments[:4])
    monkeypatch.setattr(module, "_PART", 7)
    for a, b in zip(whole, axis.evaluate("idm_regressor", *arguments[:4]), strict=True):
        assert a.tobytes() == b.tobytes()
    assert axis.evaluate("inverse_dynamics", *arguments)[0].shape == (5000, 1)
    none = [np.empty(0)] * 4
    assert [each.shape for each in axis.evaluate("idm_regressor", *none)] == [(0, 4), (0, 1)]


@pytest.mark.slow
@pytest.mark.parametrize("native", [True, False])
def test_each_sample_may_have_parameters_of_its_own(
    native: bool, rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    axis = build(load_axis("crank"), native=native)
    assert (axis.native.library() is not None) == native
    motion, sets = rng.normal(size=(4, 20)), axis.nominal * rng.uniform(1, 2, (20, len(axis.names)))
    alone = [
        axis.evaluate("inverse_dynamics", *m, p)[0] for m, p in zip(motion.T, sets, strict=True)
    ]
    monkeypatch.setattr(module, "_PART", 7)
    together = axis.evaluate("inverse_dynamics", *motion, sets)[0]
    assert together.tobytes() == np.concatenate(alone).tobytes()
    with pytest.raises(UsageError, match=r"parameters has 19 values\. Give 20"):
        axis.evaluate("inverse_dynamics", *motion, sets[1:])


def test_threads_change_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    axis = build(load_axis("emps"))
    here = simulate(axis, axis.nominal, REFERENCE[:20_000], 1e-3)
    monkeypatch.setattr(module, "_FEW_STEPS", 0)
    apart = simulate(axis, axis.nominal, REFERENCE[:20_000], 1e-3)
    for name in ("position", "velocity", "force", "direction_before"):
        assert getattr(here, name).tobytes() == getattr(apart, name).tobytes()
