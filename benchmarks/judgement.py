"""How often each check fails on right models, and how often a wrong model is named.

Machines with noises of several kinds (`machines`, a simulator of its own) and the library's twins
are identified with nothing asked for. On a right model no check should fail in more than 2 % of the
runs; those with a level of their own: that level. A wrong model is ``noticed`` where any check
fails, and ``named`` where one that fails says what is wrong. Where reversals are kept, the filter
moves estimates most, which its check may say; there it is the intervals that count. Of least
squares it is counted how often an interval is said to miss for noise, and how often it does.
The library's twins without noise are right to 0.003 %: nothing should fail there at all.

    python benchmarks/judgement.py                    a table
    python benchmarks/judgement.py --json -           one JSON object
    python benchmarks/judgement.py --only "sines"     the cases of a name
"""

import math
import re
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cache, partial

import numpy as np
from figures import give, parser_of
from library import prefilter_of
from machines import Array, Machine, autoregressive, records, white

from axisid import (
    AxisidError,
    Coordinate,
    Identification,
    Parameter,
    Prefilter,
    Record,
    build,
    identify,
    load_axis,
    newton,
    read_record,
    twin_record,
)
from axisid.codegen.artefacts import GeneratedAxis
from axisid.control import cascade_pd_difference
from axisid.elements import Drive, coulomb, offset, viscous
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling import LIBRARY, back_and_forth
from axisid.support.missing import Missing

_AT_ONCE = 100  # runs that are simulated together
#: What a drive is declared to do to commands, by the names of `Machine`.
OF_DRIVE = ("lag", "delay", "rate_limit", "quantisation", "deadband")


@dataclass(frozen=True, kw_only=True)
class Case:
    """A machine and what is declared of it.

    Attributes
    ----------
    machine : Machine
    has_offset : bool
        Whether an offset is declared.
    motion : str
        Of `reference_of`.
    named : str
        Regular expression of what has to be said of a wrong model; empty for a right one.
    rightly : tuple of str
        Checks that are right to fail on a right model, as a method that the record does not suit
        is far off.
    kept : bool
        Whether reversals are kept, which are else left out.
    methods : tuple of str, optional
        That are asked for; all by default.
    has_reference : bool
        Whether the reference is recorded.
    logged_step : float
        What the log rounds the position to, which the law does not have, m; 0 for nothing.
    logged_zero : float
        How far the logged position is from where the law reads it, m.
    is_late : bool
        Whether the drive is declared to act as it is told, whatever the machine's does.
    jitter : float
        Root mean square of what parts the stamps from even times, in periods.
    """

    machine: Machine
    has_offset: bool = False
    motion: str = "moves"
    named: str = ""
    rightly: tuple[str, ...] = ()
    kept: bool = False
    methods: tuple[str, ...] | None = None
    has_reference: bool = True
    logged_step: float = 0.0
    logged_zero: float = 0.0
    is_late: bool = False
    jitter: float = 0.0


@dataclass(kw_only=True)
class Figures:
    """What the runs of a case gave.

    Attributes
    ----------
    runs, identified : int
        All, and those that were not refused.
    failed : Counter
        Runs in which each check fails, and those that were refused.
    outside : Counter
        Identified runs in which the 95 % interval of each parameter misses the truth.
    rejected : int
        Identified runs in which Durbin-Wu-Hausman says at 1 % that least squares is biased.
    flagged, missed, unflagged : Counter
        Identified runs in which the interval of each parameter of idm-ls is said to miss, in which
        it does, and in which it does although it is not said to.
    noticed, named : int
        Runs in which any check fails, and in which one says what is wrong.
    """

    runs: int = 0
    identified: int = 0
    failed: Counter[str] = field(default_factory=Counter)
    outside: Counter[str] = field(default_factory=Counter)
    rejected: int = 0
    flagged: Counter[str] = field(default_factory=Counter)
    missed: Counter[str] = field(default_factory=Counter)
    unflagged: Counter[str] = field(default_factory=Counter)
    noticed: int = 0
    named: int = 0


_QUIET = Machine(resolution=5e-8, control_noise=white(2e-3))


def _with(**changes: object) -> Machine:
    return replace(_QUIET, **changes)  # type: ignore[arg-type]


RIGHT: dict[str, Case] = {
    "fine encoder": Case(machine=_QUIET),
    "white position noise": Case(machine=_with(position_noise=white(1e-6))),
    "white control noise": Case(machine=_with(control_noise=white(0.05))),
    "exact encoder": Case(machine=_with(resolution=0.0)),
    "control noise of 20 ms": Case(
        machine=_with(resolution=0.0, control_noise=autoregressive(0.05, 0.02, 1e-3))
    ),
    "force of 50 ms": Case(machine=_with(force_noise=autoregressive(2.0, 0.05, 1e-3))),
    "force of 500 ms": Case(machine=_with(force_noise=autoregressive(2.0, 0.5, 1e-3))),
    "2 s of it": Case(
        machine=_with(force_noise=autoregressive(2.0, 0.05, 1e-3)), motion="short moves"
    ),
    "coarse encoder": Case(
        machine=_with(resolution=5e-5),
        rightly=("least squares against instruments",),  # its mass is 4.3 % too small
    ),
    "encoder of 5 um": Case(machine=_with(resolution=5e-6)),
    "sines": Case(machine=_QUIET, motion="sines"),
    "weight": Case(machine=_with(offset=150.0, coulomb=40.0), has_offset=True),
    "high friction": Case(machine=_with(coulomb=90.0)),
    "drive with a lag": Case(machine=_with(lag=1e-3)),
    "drive with a lag and a delay": Case(
        machine=_with(lag=8e-4, delay=4e-4, position_noise=white(1e-6))
    ),
    "drive with a dead band": Case(machine=_with(deadband=0.1)),
    "drive with a rate, steps and a dead band": Case(
        machine=_with(rate_limit=300.0, quantisation=0.05, deadband=0.1, position_noise=white(1e-6))
    ),
}

#: Right models whose reversals are kept.
KEPT: dict[str, Case] = {
    "sines, kept": Case(machine=_QUIET, motion="sines", kept=True),
    "high friction, kept": Case(machine=_with(coulomb=90.0), motion="two sines", kept=True),
    "slow, high friction, kept": Case(machine=_with(coulomb=90.0), motion="slow sines", kept=True),
    "position noise, kept": Case(
        machine=_with(position_noise=white(3e-6)), motion="two sines", kept=True
    ),
    "slow, position noise, kept": Case(
        machine=_with(position_noise=white(3e-6)), motion="slow sines", kept=True
    ),
}

_QUIET_LOOPS = ("fine encoder", "white control noise", "force of 50 ms", "2 s of it", "sines")

#: Of which least squares is asked for alone, and those without a reference.
ALONE: dict[str, Case] = {
    f"{name}, least squares": replace(RIGHT[name], methods=("idm-ls",)) for name in _QUIET_LOOPS
}
FREE: dict[str, Case] = {
    f"{name}, no reference": replace(RIGHT[name], has_reference=False)
    for name in (*_QUIET_LOOPS, "white position noise", "encoder of 5 um")
}
FREE |= {
    f"position noise of {size} um, no reference": Case(
        machine=_with(resolution=0.0, position_noise=white(size * 1e-6)), has_reference=False
    )
    for size in (5, 10)
}

_SHORT = replace(RIGHT["2 s of it"], machine=_QUIET)

#: Short records, logs that are coarser than the encoder, and stamps that are uneven where the
#: sampling is not.
LOGGED: dict[str, Case] = {
    "2 s, force of 10 ms": replace(
        _SHORT, machine=_with(force_noise=autoregressive(2.0, 0.01, 1e-3))
    ),
    "2 s, force of 500 ms": replace(
        _SHORT,
        machine=_with(force_noise=autoregressive(2.0, 0.5, 1e-3)),
        rightly=("precision",),  # friction is known to 20 %
    ),
    "2 s, white control noise": replace(_SHORT, machine=_with(control_noise=white(0.05))),
    "2 s, coarse encoder": replace(
        _SHORT, machine=_with(resolution=5e-5), rightly=RIGHT["coarse encoder"].rightly
    ),
}
LOGGED |= {
    f"{name}, {log} log": replace(
        RIGHT[name],
        has_reference=False,
        logged_step=step,
        # What the filter moves is not known there: 0.03 % of the mass, nine deviations.
        rightly=("residuals against the motion", "normal residuals")
        if name in ("fine encoder", "sines")
        else (),
    )
    for name in ("fine encoder", "white control noise", "force of 50 ms", "sines")
    for log, step in (("0.1 um", 1e-7), ("0.5 um", 5e-7))
}
LOGGED |= {
    f"{name}, stamps {percent} % off": replace(RIGHT[name], jitter=percent / 100)
    for name in ("fine encoder", "white position noise", "force of 50 ms", "sines")
    for percent in (2, 4)
}

#: Of which DIDIM is asked for alone, and beside instruments as a second opinion.
OUTPUT_ERROR: dict[str, Case] = {
    f"{name}, {said}": replace(case, methods=methods, rightly=())
    for name, case in (RIGHT | KEPT).items()
    for said, methods in (("didim", ("didim",)), ("second opinion", ("idm-iv", "didim")))
}

_STAGE = _with(force_noise=white(1.0))

WRONG: dict[str, Case] = {
    "mass changes": Case(
        machine=replace(_STAGE, mass_at=lambda time: 100.0 if time < 9.0 else 110.0),
        named=r"\bM\b.*(chang|half|from .* s on)",
    ),
    "missing offset": Case(machine=replace(_STAGE, offset=3.0), named=r"offset"),
    "Stribeck peak": Case(
        machine=replace(
            _STAGE, resistance=lambda _, __, v: 8.0 * np.sign(v) * np.exp(-np.abs(v) / 0.01)
        ),
        named=r"[Ss]tribeck",
    ),
    "directional viscous": Case(
        machine=replace(_STAGE, resistance=lambda _, __, v: 12.0 * np.abs(v)),
        named=r"asymmetric_viscous|direction",
    ),
    "friction dip": Case(
        machine=replace(
            _STAGE,
            resistance=lambda _, __, v: (
                -4.0
                * np.sign(v)
                * np.maximum(0.0, 1.0 - np.abs(v) / 0.04)
                * np.minimum(1.0, np.abs(v) / 2e-3)
            ),
        ),
        named=r"[Ss]tribeck|speed",
    ),
    "position dependence": Case(
        machine=replace(
            _STAGE,
            resistance=lambda _, q, v: 2.5 * np.sign(v) * np.sin(2 * math.pi * q / 0.1),
        ),
        named=r"position",
    ),
    "kp declared 10 % low": Case(machine=replace(_STAGE, kp=1.1 * 160.18), named=r"\bkp is 1\."),
    "kv declared 10 % low": Case(machine=replace(_STAGE, kv=1.1 * 243.45), named=r"\bkv is 1\."),
    "log of 11 bit, no reference": Case(
        machine=_QUIET, has_reference=False, logged_step=0.09 / 2**11, named=r"M by about -\d"
    ),
    "position 10 um from its zero": Case(
        machine=_QUIET, logged_zero=1e-5, named=r"\+1e-05 m away from its zero"
    ),
    "lag not declared": Case(
        machine=_with(lag=1e-3), is_late=True, named=r"delay or its lag, 0\.000[89]|0\.001"
    ),
    "delay not declared": Case(
        machine=_with(delay=6e-4), is_late=True, named=r"delay or its lag, 0\.000[567]"
    ),
    "dead band not declared": Case(
        machine=_with(deadband=0.1),
        is_late=True,
        named=r"dead band, Drive\(deadband=0\.(1|099|098)\)",
    ),
    "position noise, least squares": Case(
        machine=_with(position_noise=white(1e-6)), methods=("idm-ls",), named=r"\bM misses for it"
    ),
}

CASES = RIGHT | KEPT | ALONE | FREE | LOGGED | OUTPUT_ERROR | WRONG


def _moves() -> Array:
    moves = back_and_forth(speeds=(0.04, 0.08, 0.12), acceleration=0.8, seconds=0.75, repeat=3)
    return np.asarray(trajectory(moves, 1e-3))


#: Amplitudes in m, frequencies in Hz.
_SINES = {
    "sines": ((0.02, 0.5), (0.005, 1.3), (0.002, 2.9)),
    "two sines": ((0.02, 0.3), (0.004, 1.1)),
    "slow sines": ((0.05, 0.1), (0.01, 0.4)),
}


def _sines(motion: str) -> Array:
    time = 1e-3 * np.arange(18000)
    begin = np.minimum(1.0, time / 0.5)
    waves = _SINES[motion]
    return np.asarray(begin * sum(a * np.sin(2 * math.pi * f * time) for a, f in waves))


@cache
def reference_of(motion: str) -> Array:
    """The commanded positions of a motion by its name."""
    if motion in _SINES:
        return _sines(motion)
    reference = _moves()
    return reference[:2000] if motion == "short moves" else reference


@cache
def declared(*, has_offset: bool, **drive: float) -> GeneratedAxis:
    """The axis as it is declared, whatever the machine has besides."""
    q = Coordinate("q", unit="m")
    mass = Parameter("M", "kg", nominal=100.0, lower=0.0)
    fv, fc, f0 = Parameter("Fv", "N/(m/s)"), Parameter("Fc", "N"), Parameter("F0", "N")
    plain = Machine()
    law = cascade_pd_difference(kp=plain.kp, kv=plain.kv, period=plain.period)
    return build(
        newton(
            "stage",
            coordinate=q,
            parameters=(mass, fv, fc, *((f0,) if has_offset else ())),
            inertia=mass,
            resistance=(viscous(fv, q), coulomb(fc, q), *((offset(f0),) if has_offset else ())),
            drive=Drive(gain=plain.gain, unit="V", limit=plain.limit, **drive),  # type: ignore[arg-type]
            control=law,
        )
    )


def _count(figures: Figures, result: Identification, truth: dict[str, float], named: str) -> None:
    figures.runs += 1
    figures.identified += 1
    failed = [check for check in result.verdict if check.status == "fail"]
    figures.failed.update({check.name for check in failed})
    figures.noticed += bool(failed)
    figures.named += any(re.search(named, str(check.note)) for check in failed) if named else 0
    endogeneity = result.diagnosis.endogeneity
    figures.rejected += not isinstance(endogeneity, Missing) and endogeneity.p_value < 0.01
    for name, value in result.preferred.parameters.items():
        low, high = value.interval
        figures.outside[name] += not low <= truth[name] <= high
    biases = result.diagnosis.noise_biases.get("idm-ls", {})
    for name, bias in biases.items():
        low, high = result["idm-ls"].parameters[name].interval
        missed = not low <= truth[name] <= high
        figures.flagged[name] += bias.misses
        figures.missed[name] += missed
        figures.unflagged[name] += missed and not bias.misses


def _recorded(columns: dict[str, Array], case: Case) -> dict[str, Array]:
    kept = {n: each for n, each in columns.items() if case.has_reference or n != "reference"}
    if case.logged_step:
        kept["position"] = case.logged_step * np.round(kept["position"] / case.logged_step)
    kept["position"] = kept["position"] + case.logged_zero
    if case.jitter:
        # Each record has its own, and the same one each time.
        off = np.random.default_rng(int(1e9 * np.abs(kept["control"]).sum()) % 2**32)
        stamps = kept["time"] + 1e-3 * case.jitter * off.normal(size=len(kept["time"]))
        kept["time"] = np.maximum.accumulate(stamps + 1e-9 * np.arange(len(stamps)))
    return kept


def _prefilter(record: Record, case: Case) -> Prefilter | None:
    suited = Prefilter.suited(record.period)
    return replace(suited, reversals="keep") if case.kept else None


def figures_of(name: str, *, runs: int, seed: int, together: int = 1) -> Figures:
    """Identify the runs of a case, each from one record or from several together."""
    case = CASES[name]
    machine = case.machine
    drive = {} if case.is_late else {name: getattr(machine, name) for name in OF_DRIVE}
    axis = declared(has_offset=case.has_offset, **drive)
    truth = {"M": machine.mass, "Fv": machine.viscous, "Fc": machine.coulomb, "F0": machine.offset}
    figures = Figures()
    for begin in range(0, runs, _AT_ONCE):
        batch = together * min(_AT_ONCE, runs - begin)
        made = [*records(machine, reference_of(case.motion), batch, seed + begin)]
        for first in range(0, batch, together):
            columns = made[first : first + together]
            try:
                given = [read_record(_recorded(each, case), axis) for each in columns]
                result = identify(axis, given, _prefilter(given[0], case), case.methods)
            except AxisidError as error:
                figures.runs += 1
                figures.failed[f"refused: {type(error).__name__}"] += 1
                continue
            _count(figures, result, truth, case.named)
    return figures


def twin_figures(name: str, *, runs: int, seed: int, clean: bool = False) -> Figures:
    """Identify the twins of a library axis, those of an exact encoder where they are clean."""
    axis = build(load_axis(name))
    figures = Figures()
    for k in range(runs):
        record = twin_record(axis, seed=seed + k, **({"position_noise": 0.0} if clean else {}))
        result = identify(axis, record, prefilter_of(name))
        _count(figures, result, dict(record.provenance.truth), "")
    return figures


def written(figures: Figures, case: Case | None) -> dict[str, object]:
    """Shares of the runs."""
    shares: dict[str, object] = {
        "runs": figures.runs,
        "failed": {name: n / figures.runs for name, n in figures.failed.most_common()},
    }
    if case is not None and case.rightly:
        shares["rightly"] = list(case.rightly)
    if case is None or not case.named:
        shares["held"] = {name: 1 - n / figures.identified for name, n in figures.outside.items()}
        shares["least_squares"] = {
            name: {
                "flagged": flagged / figures.identified,
                "held": 1 - figures.missed[name] / figures.identified,
                "held_unflagged": None
                if flagged == figures.identified
                else 1 - figures.unflagged[name] / (figures.identified - flagged),
            }
            for name, flagged in figures.flagged.items()
        }
        shares["rejected"] = figures.rejected / max(figures.identified, 1)
    else:
        shares |= {"noticed": figures.noticed / figures.runs, "named": figures.named / figures.runs}
    return shares


def _lines(kind: str, name: str, shares: dict[str, object]) -> Iterator[str]:
    said = {k: shares[k] for k in ("noticed", "named") if k in shares}
    head = "  ".join(f"{k} {100 * float(str(v)):.0f} %" for k, v in said.items())
    held = shares.get("held")
    if isinstance(held, dict):
        head = "held " + "  ".join(f"{n} {100 * v:.0f}" for n, v in held.items())
        head += f"  endogeneity rejected {100 * float(str(shares['rejected'])):.0f} %"
    yield f"{kind:<13}{name:<44}{head}"
    yield from _of_least_squares(shares.get("least_squares"))
    failed = shares["failed"]
    assert isinstance(failed, dict)
    right = shares.get("rightly", ())
    assert isinstance(right, list | tuple)
    for check, share in failed.items():
        yield f"{'':<8}{100 * share:5.1f} %  {check}{', rightly' * (check in right)}"


def _of_least_squares(shares: object) -> Iterator[str]:
    """What intervals of least squares are said to do, and do; only where something is said."""
    told = shares if isinstance(shares, dict) else {}
    for name, of_one in told.items():
        if of_one["flagged"]:
            flagged, held = (100 * of_one[k] for k in ("flagged", "held"))
            yield f"{'':<8}idm-ls {name}: said to miss {flagged:.0f} %, held {held:.0f} %"


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=40, help="of each case (default 40)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", metavar="NAME", help="one case")
    parser.add_argument("--together", type=int, default=1, help="records of each run (default 1)")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    options = parser.parse_args()
    tables = {
        "right": RIGHT,
        "kept": KEPT,
        "alone": ALONE,
        "free": FREE,
        "logged": LOGGED,
        "output error": OUTPUT_ERROR,
        "wrong": WRONG,
        "twin": LIBRARY,
        "clean": LIBRARY,
    }
    kinds = {kind: list(table) for kind, table in tables.items()}
    chosen = [
        (kind, name)
        for kind, names in kinds.items()
        for name in names
        if options.only in (None, name)
    ]
    work = partial(_of_kind, runs=options.runs, seed=options.seed, together=options.together)
    with ProcessPoolExecutor(options.jobs) as pool:
        done = list(pool.map(work, *zip(*chosen, strict=True)))
    figures = [(k, n, shares) for (k, n), shares in zip(chosen, done, strict=True)]
    tree = {kind: {n: s for k, n, s in figures if k == kind} for kind in kinds}
    give(tree, options.json, (line for one in figures for line in _lines(*one)))


def _of_kind(kind: str, name: str, *, runs: int, seed: int, together: int = 1) -> dict[str, object]:
    if kind == "clean":  # which are all alike
        return written(twin_figures(name, runs=1, seed=seed, clean=True), None)
    if kind == "twin":
        return written(twin_figures(name, runs=runs, seed=seed), None)
    found = figures_of(name, runs=runs, seed=seed, together=together)
    return written(found, CASES[name])


if __name__ == "__main__":
    main()
