"""How fast the closed loop is simulated, as ratios measured in one run.

The yardsticks are hand-written C of the same arithmetic (`hand_written.c`, one simulation and 32
side by side), SciPy's DOP853 with events between the samples, the CasADi virtual machine, and for a
whole fit the parts that no fit can avoid. Repetitions of the two sides alternate, so that a noisy
machine disturbs both; the medians are compared.

    python benchmarks/simulation.py            a table
    python benchmarks/simulation.py --json -   one JSON object
"""

import cProfile
import ctypes
import os
import pstats
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from figures import give, parser_of
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.signal import butter, cheby1, sosfiltfilt

from axisid import Prefilter, Record, build, identify, load_axis, read_record, simulate
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation import simulate_batch
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling.declaration.experiment import back_and_forth

Array = NDArray[np.float64]

HERE = Path(__file__).resolve().parent
SAMPLES, PERIOD, LANES = 24_841, 1e-3, 32
TRUTH = np.array([95.1089, 203.5034, 20.3935, -3.1648])
SCIPY_SAMPLES = 1_500
GENERATE_TIMES, LOAD_TIMES = 3, 5


def reference() -> Array:
    """A motion of the EMPS record's length and speeds."""
    moves = back_and_forth(speeds=(0.04, 0.08, 0.12), acceleration=0.8, seconds=1.0, repeat=5)
    return trajectory(moves, PERIOD)[:SAMPLES].copy()


def medians(*runs: Callable[[], Any], times: int) -> list[float]:
    """Median seconds of each run; the runs take turns."""
    taken: list[list[float]] = [[] for _ in runs]
    for run in runs:
        run()
    for _ in range(times):
        for record, run in zip(taken, runs, strict=True):
            begin = time.perf_counter()
            run()
            record.append(time.perf_counter() - begin)
    return [float(np.median(record)) for record in taken]


def hand_written(folder: Path) -> ctypes.CDLL:
    """Compile the yardstick with the flags that generated code gets."""
    from axisid.codegen.native.compiler import FLAGS, find_compiler

    library = folder / "hand_written.so"
    flags = [flag for flag in FLAGS if flag != "-std=c11"]
    source = HERE / "hand_written.c"
    command = [*find_compiler().command, "-std=gnu11", "-Wno-psabi", *flags, str(source)]
    subprocess.run([*command, "-o", str(library), "-lm"], check=True)
    return ctypes.CDLL(str(library))


def pointer(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def hand_single(hand: ctypes.CDLL, ref: Array) -> Array:
    out = np.empty((5, len(ref)))
    hand.scalar(
        ctypes.c_ssize_t(len(ref)),
        pointer(ref),
        pointer(TRUTH),
        ctypes.c_double(PERIOD),
        ctypes.c_double(ref[0]),
        *map(pointer, out),
    )
    return out


def hand_batch(hand: ctypes.CDLL, ref: Array, parameters: Array) -> list[Array]:
    """Every block of lanes into arrays of its own."""
    results = []
    for first in range(0, len(parameters), LANES):
        block = np.ascontiguousarray(parameters[first : first + LANES].T)
        out = np.empty((2, len(ref), LANES))
        hand.vector(
            ctypes.c_ssize_t(len(ref)),
            pointer(ref),
            pointer(block),
            ctypes.c_double(PERIOD),
            ctypes.c_double(ref[0]),
            *map(pointer, out),
        )
        results.append(out)
    return results


def scipy_simulation(axis: GeneratedAxis, ref: Array) -> Array:
    """DOP853 between the samples, velocity crossings as events, restarted after each."""
    M, Fv, Fc, offset = TRUTH
    law, limit = axis.axis.control, axis.axis.drive.limit
    assert law is not None
    kp, kv, gain = law.gains["kp"], law.gains["kv"], axis.axis.drive.gain
    q, dq = float(ref[0]), 0.0
    q1 = q2 = q
    positions = np.empty(len(ref))

    def stops(_: float, state: Array, *__: float) -> float:
        return float(state[1])

    stops.terminal = True  # type: ignore[attr-defined]
    for k, r in enumerate(ref):
        positions[k] = q
        control = kv * (kp * (r - q) - (q - q2) / (2 * PERIOD))
        tau = gain * min(max(control, -limit), limit)
        q2, q1, left = q1, q, PERIOD
        while left > 1e-12:
            push = tau - offset
            if dq == 0 and abs(push) <= Fc:
                break
            s = np.sign(dq) if dq else np.sign(push)
            stops.direction = -s  # type: ignore[attr-defined]
            solution = solve_ivp(
                lambda _, x, s=s, push=push: (x[1], (push - Fv * x[1] - Fc * s) / M),
                (0.0, left),
                (q, dq),
                method="DOP853",
                rtol=1e-10,
                atol=1e-12,
                events=stops,
            )
            q, dq = (float(x) for x in solution.y[:, -1])
            if solution.status == 1:
                dq = 0.0
            left -= float(solution.t[-1])
    return positions


def identification_floor(hand: ctypes.CDLL, record: Record, solves: int) -> Callable[[], None]:
    """The parts of an IDM-IV fit that none can avoid: filters, simulations, factorisations."""
    low_pass = butter(4, 2 * 60 * PERIOD, output="sos")
    decimation = cheby1(8, 0.05, 0.08, output="sos")
    assert record.reference is not None
    ref = np.ascontiguousarray(record.reference)
    columns = np.random.default_rng(0).normal(size=(len(ref) - 49, 5))

    def run() -> None:
        sosfiltfilt(low_pass, record.position, padlen=12)
        kept = sosfiltfilt(decimation, columns, axis=0, padlen=24)[::10]
        np.linalg.qr(kept[:, 1:])
        for _ in range(solves + 1):
            hand_single(hand, ref)
            kept = sosfiltfilt(decimation, columns[:, 1:], axis=0, padlen=24)[::10]
        for _ in range(solves):
            np.linalg.qr(kept)

    return run


def profile_shares(run: Callable[[], Any]) -> dict[str, float]:
    """Where a fit spends its time: shares of compiled code, linear algebra and the rest."""
    profile = cProfile.Profile()
    profile.enable()
    for _ in range(20):
        run()
    profile.disable()
    parts = {
        "filters_of_scipy": ("scipy/signal",),
        "compiled": ("codegen/native/library.py",),
        "linear_algebra": ("numpy/linalg", "estimation/regression/linear.py"),
    }
    spent = dict.fromkeys([*parts, "rest"], 0.0)
    for (file, _, _), (_, _, own, _, _) in pstats.Stats(profile).stats.items():  # type: ignore[attr-defined]
        name = next((p for p, where in parts.items() if any(w in file for w in where)), "rest")
        spent[name] += own
    total = sum(spent.values())
    return {name: value / total for name, value in spent.items()}


def in_fresh_process(statement: str, cache: str) -> float:
    """Seconds that a statement prints, run in a fresh interpreter with a cache of its own."""
    done = subprocess.run(
        [sys.executable, "-c", statement],
        env={**os.environ, "AXISID_CACHE": cache},
        check=True,
        capture_output=True,
        text=True,
    )
    return float(done.stdout)


_COLD = """
import time; begin = time.perf_counter()
from axisid import build, derive, load_axis
from axisid.codegen.artefacts import axis_artefacts
axis = load_axis("emps"); axis_artefacts(derive(axis)); assert build(axis).native.library()
print(time.perf_counter() - begin)
"""
_WARM = """
import time
from axisid import build, load_axis
axis = build(load_axis("emps")); begin = time.perf_counter(); assert axis.native.library()
print(1e3 * (time.perf_counter() - begin))
"""


def measure(times: int) -> dict[str, float]:
    """Run everything and return the contract's figures."""
    axis, virtual = build(load_axis("emps")), build(load_axis("emps"), native=False)
    ref = reference()
    rng = np.random.default_rng(1)
    parameters = TRUTH * (1 + 0.02 * rng.normal(size=(64, 4)))
    many = TRUTH * (1 + 0.02 * rng.normal(size=(256, 4)))
    record = make_record(axis, ref)
    figures: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as name:
        hand = hand_written(Path(name))
        check_agreement(axis, hand, ref, parameters)
        single, by_hand = medians(
            lambda: simulate(axis, TRUTH, ref, PERIOD), lambda: hand_single(hand, ref), times=times
        )
        figures["single_over_hand_c"] = single / by_hand
        others = iter(TRUTH * (1 + 1e-6 * np.arange(1, times + 2)[:, None]))
        other, by_hand = medians(
            lambda: simulate(axis, next(others), ref, PERIOD),
            lambda: hand_single(hand, ref),
            times=times,
        )
        figures["single_of_new_parameters_over_hand_c"] = other / by_hand
        wanted = ("position", "force")
        batch, by_hand = medians(
            lambda: simulate_batch(axis, parameters, ref, PERIOD, wanted=wanted, threads=1),
            lambda: hand_batch(hand, ref, parameters),
            times=max(times // 4, 3),
        )
        figures["batch_over_hand_simd"] = batch / by_hand
        one, two = medians(
            *(
                lambda n=n: simulate_batch(axis, many, ref, PERIOD, wanted=("force",), threads=n)
                for n in (1, 2)
            ),
            times=max(times // 8, 3),
        )
        figures["two_threads_speedup"] = one / two
        (by_scipy,) = medians(lambda: scipy_simulation(axis, ref[:SCIPY_SAMPLES]), times=3)
        by_scipy *= len(ref) / SCIPY_SAMPLES
        figures["scipy_over_single"] = by_scipy / single
        (machine,) = medians(lambda: simulate(virtual, TRUTH, ref, PERIOD), times=3)
        figures["virtual_machine_over_single"] = machine / single
        prefilter = Prefilter(cutoff=60.0, decimate=10, drop=(49, 0), hold="raw", reversals="keep")
        result = identify(axis, record, prefilter, ["idm-iv"])["idm-iv"]
        fit, with_intervals, floor = medians(
            lambda: identify(axis, record, prefilter, ["idm-iv"]),
            lambda: identify(axis, record, prefilter, ["idm-iv"])["idm-iv"].parameters,
            identification_floor(hand, record, len(result.iterates) - 1),
            times=times,
        )
        figures["identify_over_floor"] = fit / floor
        figures["identify_with_intervals_over_floor"] = with_intervals / floor
        shares = profile_shares(lambda: identify(axis, record, prefilter, ["idm-iv"]))
        figures |= {f"identify_share_{part}": share for part, share in shares.items()}
        figures["generate_cold_s"] = float(
            np.median([in_fresh_process(_COLD, f"{name}/cold{i}") for i in range(GENERATE_TIMES)])
        )
        figures["load_warm_ms"] = float(
            np.median([in_fresh_process(_WARM, f"{name}/cold0") for _ in range(LOAD_TIMES)])
        )
        figures["single_ms"], figures["batch_ms_per_simulation"] = 1e3 * single, 1e3 * batch / 64
        figures["identify_ms"] = 1e3 * fit
        figures["identify_with_intervals_ms"] = 1e3 * with_intervals
    return figures


def make_record(axis: GeneratedAxis, ref: Array) -> Record:
    """The real EMPS record where it is at hand; else a simulated one of its length and noise."""
    real = Path(os.environ.get("AXISID_DATA", HERE.parents[1] / "shared" / "data"))
    if (real / "emps" / "DATA_EMPS.mat").is_file():
        return read_record(real / "emps" / "DATA_EMPS.mat", axis, sample_period=PERIOD)
    noise = 5e-8 * np.random.default_rng(2).normal(size=len(ref))
    loop = simulate(axis, TRUTH, ref, PERIOD, position_noise=noise)
    return Record(
        time=loop.time,
        position=loop.measured_position,
        reference=ref,
        control=loop.control,
        sample_period=PERIOD,
    )


def check_agreement(axis: GeneratedAxis, hand: ctypes.CDLL, ref: Array, parameters: Array) -> None:
    """The yardsticks compute what they are compared with."""
    position = simulate(axis, TRUTH, ref, PERIOD).position
    for other in (hand_single(hand, ref)[0], scipy_simulation(axis, ref[:SCIPY_SAMPLES])):
        error = np.abs(position[: len(other)] - other).max()
        if error > 1e-9:
            raise SystemExit(f"a yardstick differs by {error:g} m")
    batch = simulate_batch(axis, parameters, ref, PERIOD, wanted=("position",))["position"]
    by_hand = np.concatenate([out[0] for out in hand_batch(hand, ref, parameters)], axis=1)
    if np.abs(batch - by_hand).max() > 1e-9:
        raise SystemExit("the batch yardstick differs")


TARGETS = {
    "single_over_hand_c": "at most 1.25",
    "batch_over_hand_simd": "at most 1.3",
    "scipy_over_single": "at least 300",
    "virtual_machine_over_single": "",
    "identify_over_floor": "at most 1.3",
    "generate_cold_s": "under 3",
    "load_warm_ms": "under 50",
}


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--times", type=int, default=40, help="repetitions (default 40)")
    options = parser.parse_args()
    figures = measure(options.times)
    lines = (f"{n:<38}{v:>12.4g}  {TARGETS.get(n, '')}".rstrip() for n, v in figures.items())
    give(figures, options.json, lines)


if __name__ == "__main__":
    main()
