"""Least squares, instruments and DIDIM on twins with known truth: bias, scatter, coverage, time.

The paper's axis is simulated by `machines`, a simulator of its own, with the law of the paper. Of
each method there is the bias of the mean (instruments and DIDIM less the filter's own bias), the
scatter over the runs, the share of 95 % intervals that hold the truth, and what the second opinion
says: (a) white noise of the position in the loop, under the appropriate filter; (b) a coarse
encoder in the loop, under the inappropriate one; (c) the records of (a), a wrong law declared.

    python benchmarks/output_error.py                      a table
    python benchmarks/output_error.py --json -             one JSON object
    python benchmarks/output_error.py --only "kp +1 %"     the cases of a name
"""

import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cache, partial

import numpy as np
from figures import give, parser_of
from machines import Array, Machine, records, white

from axisid import (
    AxisidError,
    Identification,
    Prefilter,
    Record,
    build,
    identify,
    load_axis,
    read_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.control import cascade_pd, cascade_pd_difference
from axisid.estimation.diagnostics import SECOND_OPINION
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling.declaration import ControlLaw
from axisid.paper import APPROPRIATE, INAPPROPRIATE

METHODS = ("idm-ls", "idm-iv", "didim")
TRUTH = {"M": 100.2, "Fv": 236.9, "Fc": 24.8}
_AT_ONCE = 50  # runs that are simulated together
_TIMED = 7  # times that each method is timed, of which the least counts

_KP, _KV, _PERIOD = 160.18, 243.45, 1e-3
_MACHINE = Machine(
    mass=TRUTH["M"],
    viscous=TRUTH["Fv"],
    coulomb=TRUTH["Fc"],
    kp=_KP,
    kv=_KV,
    period=_PERIOD,
    has_tachometer=True,
    position_noise=white(3.8e-6),
)

_LIMITED = replace(_MACHINE, limit=3.6)  # in 5 % of the samples


def _law(kp: float = 1.0, kv: float = 1.0) -> ControlLaw:
    """The machine's, its gains times factors."""
    return cascade_pd(kp=kp * _KP, kv=kv * _KV, period=_PERIOD)


@dataclass(frozen=True, kw_only=True)
class Case:
    """A machine, the filter that its records pass, and the law that is declared of it.

    Attributes
    ----------
    machine : Machine
    prefilter : Prefilter
    law : ControlLaw
    limit : float
        Of the drive, as it is declared, V.
    has_right_law : bool
    """

    machine: Machine = _MACHINE
    prefilter: Prefilter = APPROPRIATE
    law: ControlLaw = field(default_factory=_law)
    limit: float = 10.0
    has_right_law: bool = True


def _wrong(law: ControlLaw) -> Case:
    return Case(law=law, has_right_law=False)


CASES: dict[str, Case] = {
    "white noise": Case(),
    "white noise, default filter": Case(prefilter=Prefilter()),
    "coarse encoder": Case(
        machine=replace(_MACHINE, position_noise=None, resolution=1e-5), prefilter=INAPPROPRIATE
    ),
    "kp +1 %": _wrong(_law(kp=1.01)),
    "kp +5 %": _wrong(_law(kp=1.05)),
    "kv +1 %": _wrong(_law(kv=1.01)),
    "plain difference": _wrong(cascade_pd_difference(kp=_KP, kv=_KV, period=_PERIOD)),
    "one sample late": _wrong(replace(_law(), delay=1)),
    "at its limit": Case(machine=_LIMITED, limit=_LIMITED.limit),
    "limit +0.7 %": Case(machine=_LIMITED, limit=1.007 * _LIMITED.limit, has_right_law=False),
}


@dataclass(kw_only=True)
class Figures:
    """What the runs of a case gave.

    Attributes
    ----------
    runs : int
    failed : Counter
        Runs without an estimate, by why.
    values, held, deviations : mapping of str to list
        By method: corrected parameters, whether their intervals hold the truth, and deviations of
        each run.
    apart, apart_deviations : list
        Instruments less DIDIM of each run, and what deviations are claimed of that.
    opinions, laws : Counter
        Of the runs, by the status of the checks "method" and "control law".
    believed : Counter
        By the method that is judged.
    """

    runs: int = 0
    failed: Counter[str] = field(default_factory=Counter)
    values: dict[str, list[list[float]]] = field(default_factory=dict)
    held: dict[str, list[list[bool]]] = field(default_factory=dict)
    deviations: dict[str, list[list[float]]] = field(default_factory=dict)
    apart: list[list[float]] = field(default_factory=list)
    apart_deviations: list[list[float]] = field(default_factory=list)
    opinions: Counter[str] = field(default_factory=Counter)
    laws: Counter[str] = field(default_factory=Counter)
    believed: Counter[str] = field(default_factory=Counter)


@cache
def reference() -> Array:
    """The twin's commanded positions."""
    experiment = load_axis("emps2015").experiment
    assert experiment is not None
    return np.asarray(trajectory(experiment.moves, _PERIOD))


@cache
def declared(name: str) -> GeneratedAxis:
    """The axis with the law of a case."""
    axis, case = load_axis("emps2015"), CASES[name]
    return build(replace(axis, control=case.law, drive=replace(axis.drive, limit=case.limit)))


def figures_of(name: str, *, runs: int, seed: int) -> Figures:
    """Identify the runs of a case."""
    case, axis, figures = CASES[name], declared(name), Figures()
    for begin in range(0, runs, _AT_ONCE):
        batch = min(_AT_ONCE, runs - begin)
        for columns in records(case.machine, reference(), batch, seed + begin):
            figures.runs += 1
            try:
                result = identify(
                    axis, read_record(columns, axis), case.prefilter, METHODS, judge=False
                )
                _count(figures, result)
            except AxisidError as error:
                figures.failed[str(error)[:80]] += 1
    return figures


def _count(figures: Figures, result: Identification) -> None:
    for method in METHODS:
        values = result[method].parameters
        figures.values.setdefault(method, []).append([v.corrected for v in values.values()])
        figures.deviations.setdefault(method, []).append([v.deviation for v in values.values()])
        inside = [v.interval[0] <= TRUTH[n] <= v.interval[1] for n, v in values.items()]
        figures.held.setdefault(method, []).append(inside)
    apart = result.diagnosis.differences[SECOND_OPINION].values()
    figures.apart.append([each.difference for each in apart])
    figures.apart_deviations.append([each.deviation for each in apart])
    checks = {check.name: check for check in result.verdict}
    figures.opinions[checks["method"].status] += 1
    figures.laws[checks["control law"].status] += 1
    figures.believed[result.preferred.method] += 1


def written(figures: Figures) -> dict[str, object]:
    """Percent of the truth, and shares of the runs."""
    truth = np.array([*TRUTH.values()])
    methods = {}
    for method, every in figures.values.items():
        off = 100 * (np.array(every) / truth - 1)
        claimed = 100 * np.array(figures.deviations[method]) / truth
        methods[method] = {
            "bias_percent": named(off.mean(axis=0)),
            "sd_percent": named(_scatter(off)),
            "claimed_sd_percent": named(claimed.mean(axis=0)),
            "held": named(np.mean(figures.held[method], axis=0)),
        }
    apart = 100 * np.array(figures.apart) / truth
    claimed = 100 * np.array(figures.apart_deviations) / truth
    return {
        "runs": figures.runs,
        "failed": dict(figures.failed),
        "methods": methods,
        "instruments_less_didim": {
            "mean_percent": named(apart.mean(axis=0)),
            "sd_percent": named(_scatter(apart)),
            "claimed_sd_percent": named(claimed.mean(axis=0)),
        },
        "method": dict(figures.opinions),
        "believed": dict(+figures.believed),
        "control_law": dict(figures.laws),
    }


def _scatter(values: Array) -> Array:
    return np.asarray(values.std(axis=0, ddof=1) if len(values) > 1 else 0 * values[0])


def named(values: Sequence[float] | Array) -> dict[str, float]:
    """Figures by parameter."""
    return {name: float(value) for name, value in zip(TRUTH, values, strict=True)}


def times(*, seed: int) -> dict[str, dict[str, float]]:
    """CPU seconds of one record by method: the estimate alone, and its deviations besides."""
    case, axis = CASES["white noise"], declared("white noise")
    (columns,) = records(case.machine, reference(), 1, seed)
    record = read_record(columns, axis)
    found: dict[str, list[tuple[float, float]]] = {"idm-iv": [], "didim": []}
    for _ in range(_TIMED):
        for method, seconds in found.items():
            seconds.append(_timed(axis, record, case.prefilter, method))
    return {
        method: dict(zip(("estimate", "deviations"), map(min, *seconds), strict=True))
        for method, seconds in found.items()
    }


def _timed(
    axis: GeneratedAxis, record: Record, prefilter: Prefilter, method: str
) -> tuple[float, float]:
    begin = time.process_time()
    estimate = identify(axis, record, prefilter, [method], judge=False)[method]
    found = time.process_time()
    _ = estimate.covariance
    return found - begin, time.process_time() - found


def _lines(name: str, shares: Mapping[str, object]) -> Iterator[str]:
    opinion, law = (shares[key] for key in ("method", "control_law"))
    yield f"{name}: {shares['runs']} runs, method {opinion}, control law {law}"
    methods = shares["methods"]
    assert isinstance(methods, dict)
    for method, of_one in methods.items():
        cells = [
            f"{p} {of_one['bias_percent'][p]:+7.3f} +- {of_one['sd_percent'][p]:.3f} "
            f"({of_one['claimed_sd_percent'][p]:.3f}) {100 * of_one['held'][p]:5.1f} %"
            for p in TRUTH
        ]
        yield f"  {method:<7}" + "   ".join(cells)


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=60, help="of each case (default 60)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", metavar="NAME", help="one case")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    options = parser.parse_args()
    names = [name for name in CASES if options.only in (None, name)]
    work = partial(figures_of, runs=options.runs, seed=options.seed)
    with ProcessPoolExecutor(options.jobs) as pool:
        done = {n: written(f) for n, f in zip(names, pool.map(work, names), strict=True)}
    seconds = times(seed=options.seed)
    lines = [line for name, shares in done.items() for line in _lines(name, shares)]
    lines += ["bias +- scatter (claimed deviation) in percent of the truth, intervals that hold it"]
    lines += [
        f"CPU time of {method}: {1e3 * of['estimate']:.1f} ms, with deviations "
        f"{1e3 * (of['estimate'] + of['deviations']):.1f} ms"
        for method, of in seconds.items()
    ]
    give({"cases": done, "seconds": seconds}, options.json, lines)


if __name__ == "__main__":
    main()
