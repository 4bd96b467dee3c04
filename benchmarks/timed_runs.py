"""What `speed.py` measures in a process of its own, by name: CPU seconds, or bytes, of each.

The process reads a name a line and answers each with its cost. What is not said to be shorter is
as long as the EMPS record: 24 841 samples at 1 kHz.
"""

import ctypes
import math
import resource
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from functools import cache
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, cheby1, sosfiltfilt

from axisid import Prefilter, Record, build, fit, identify, load_axis, monte_carlo, simulate
from axisid.codegen.runtime.library_cache import FLAGS, find_compiler
from axisid.estimation import simulate_batch
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling.declaration.experiment import back_and_forth

Array = NDArray[np.float64]

SAMPLES, PERIOD, NOISE = 24_841, 1e-3, 1e-6  # s, m
AXIS, PAPER = build(load_axis("emps")), build(load_axis("emps2015"))
TRUTH = np.array([95.1089, 203.5034, 20.3935, -3.1648])
RANDOM = np.random.default_rng(1)
LANES, BATCH, RUNS = 32, 64, 32  # of the hand-written registers; simulations; runs of a study
SETS = TRUTH * (1 + 0.02 * RANDOM.normal(size=(BATCH, 4)))
SHORT, LONG = 20_000, 100_000  # samples of the logs that memory is measured with
LEAST, LEAST_RUNS = 0.3, 3  # CPU seconds that a figure is measured for, and its runs
#: Without the verdict; an earlier commit computes none before it is read.
UNJUDGED = {"judge": False} if "judge" in signature(identify).parameters else {}
PUBLISHED = Prefilter(cutoff=60.0, decimate=10, drop=(49, 0), hold="raw", reversals="keep")


def cpu_seconds(run: Callable[[], object]) -> float:
    """CPU seconds of the fastest of as many runs as can be measured, two or more, after another.

    Not of their mean: a virtual machine that is given new memory for what a run writes pays for
    it in that run, up to four times the run itself.
    """
    costs, begin = [], time.process_time()
    while len(costs) < LEAST_RUNS or time.process_time() - begin < LEAST:
        before = time.process_time()
        run()
        costs.append(time.process_time() - before)
    return min(costs[1:])


@cache
def motion(samples: int) -> Array:
    """To and fro at the speeds of the EMPS record, again and again."""
    moves = back_and_forth(speeds=(0.04, 0.08, 0.12), acceleration=0.8, seconds=1.0, repeat=5)
    return np.resize(trajectory(moves, PERIOD), samples)


@cache
def twin(samples: int = SAMPLES) -> Record:
    """A record behind white noise."""
    noise = NOISE * np.random.default_rng(2).normal(size=samples)
    reference = motion(samples)
    loop = simulate(AXIS, TRUTH, reference, PERIOD, position_noise=noise)
    columns = {"reference": reference, "control": loop.control, "sample_period": PERIOD}
    return Record(time=loop.time, position=loop.measured_position, **columns)


@cache
def hand_written() -> ctypes.CDLL:
    """The yardstick, compiled with the flags of generated code; it computes the same motion."""
    flags = [flag for flag in FLAGS if flag != "-std=c11"]
    source = Path(__file__).with_name("hand_written.c")
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "hand_written.so"
        command = [*find_compiler().command, "-std=gnu11", "-Wno-psabi", *flags, str(source)]
        subprocess.run([*command, "-o", str(library), "-lm"], check=True)
        hand = ctypes.CDLL(str(library))
    assert np.abs(single(TRUTH).position - one_loop(hand)[0]).max() < 1e-9
    lanes = np.concatenate([out[0] for out in many_loops(hand)], axis=1)
    assert np.abs(batch("position")["position"] - lanes).max() < 1e-9
    return hand


def called(function: Any, parameters: Array, out: Array) -> Array:
    reference, period = motion(SAMPLES), ctypes.c_double(PERIOD)
    start = ctypes.c_double(reference[0])
    arrays = (reference.ctypes, parameters.ctypes)
    function(ctypes.c_ssize_t(SAMPLES), *arrays, period, start, *(row.ctypes for row in out))
    return out


def one_loop(hand: ctypes.CDLL) -> Array:
    return called(hand.scalar, TRUTH, np.empty((5, SAMPLES)))


def many_loops(hand: ctypes.CDLL) -> list[Array]:
    """Every block of lanes into arrays of its own."""
    blocks = (np.ascontiguousarray(SETS[n : n + LANES].T) for n in range(0, BATCH, LANES))
    return [called(hand.vector, block, np.empty((2, SAMPLES, LANES))) for block in blocks]


def single(parameters: Array) -> Any:
    return simulate(AXIS, parameters, motion(SAMPLES), PERIOD)


def batch(*wanted: str) -> Any:
    """Every set on one thread."""
    return simulate_batch(AXIS, SETS, motion(SAMPLES), PERIOD, wanted=wanted, threads=1)


def instruments(*, intervals: bool = False) -> Any:
    found = identify(AXIS, twin(), PUBLISHED, ["idm-iv"], **UNJUDGED)["idm-iv"]
    return found.parameters if intervals else found


@cache
def floor() -> Callable[[], None]:
    """The parts of an IDM-IV fit that none can avoid: filters, simulations, factorisations."""
    low_pass = butter(4, 2 * 60 * PERIOD, output="sos")
    decimation = cheby1(8, 0.05, 0.08, output="sos")
    columns = np.random.default_rng(0).normal(size=(SAMPLES - 49, 5))
    position, hand = twin().position, hand_written()
    solves = len(instruments().iterates) - 1

    def run() -> None:
        sosfiltfilt(low_pass, position, padlen=12)
        kept = sosfiltfilt(decimation, columns, axis=0, padlen=24)[::10]
        np.linalg.qr(kept[:, 1:])
        for _ in range(solves + 1):
            one_loop(hand)
            kept = sosfiltfilt(decimation, columns[:, 1:], axis=0, padlen=24)[::10]
        for _ in range(solves):
            np.linalg.qr(kept)

    return run


def study(prefilter: Prefilter | None) -> float:
    """One run of a block of the paper's axis, its twin included: 7801 samples."""
    return cpu_seconds(lambda: monte_carlo(PAPER, RUNS, prefilter=prefilter)) / RUNS


def fitted() -> Any:
    return fit(AXIS, twin(), "control")


@cache
def long_log() -> tuple[float, float]:
    """CPU seconds of each sample of a long judged log, and bytes of each that it has more."""
    peaks = []
    for samples in (SHORT, LONG):
        record, begin = twin(samples), time.process_time()
        identify(AXIS, record, methods=("idm-ls", "idm-iv")).to_dict()
        spent = time.process_time() - begin
        peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    unit = 1 if sys.platform == "darwin" else 1024
    return spent / LONG, unit * (peaks[1] - peaks[0]) / (LONG - SHORT)


COSTS: dict[str, Callable[[], float]] = {
    "C by hand": lambda: cpu_seconds(lambda: one_loop(hand_written())),
    "simulate": lambda: cpu_seconds(lambda: single(TRUTH)),
    "simulate, new parameters": lambda: cpu_seconds(
        lambda: single(TRUTH * (1 + 1e-9 * RANDOM.random()))
    ),
    "C by hand, in registers": lambda: cpu_seconds(lambda: many_loops(hand_written())) / BATCH,
    "simulate_batch": lambda: cpu_seconds(lambda: batch("position", "force")) / BATCH,
    "floor": lambda: cpu_seconds(floor()),
    "identify": lambda: cpu_seconds(instruments),
    "identify, intervals": lambda: cpu_seconds(lambda: instruments(intervals=True)),
    "identify, default methods, judged": lambda: cpu_seconds(
        lambda: identify(AXIS, twin()).to_dict()
    ),
    "Monte-Carlo run, published filter": lambda: study(PUBLISHED),
    "Monte-Carlo run, default filter": lambda: study(None),
    "fit": lambda: cpu_seconds(fitted),
    "fit, judged": lambda: cpu_seconds(lambda: fitted().checks),
    "long log, a sample": lambda: long_log()[0],
    "peak memory, a sample": lambda: long_log()[1],
}


def main() -> None:
    """Answer each name with what it costs, or "nan": another commit may lack what is called."""
    print("ready", flush=True)
    for line in sys.stdin:
        cost = math.nan
        try:
            cost = COSTS[line.strip()]()
        except Exception:
            traceback.print_exc()
        print(cost, flush=True)


if __name__ == "__main__":
    main()
