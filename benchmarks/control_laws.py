"""How often the law check fails on right ready laws, and names the gain of a wrong one.

The twin of one axis under every ready law, with noise in the loop; what is logged of it may be
rounded or noisy besides. Of a right law the check should fail in no run; with one gain declared
5 or 10 % too low, that gain is to be named with its value to 2 % of itself, where the record shows
it.

    python benchmarks/control_laws.py                     a table
    python benchmarks/control_laws.py --json -            one JSON object
    python benchmarks/control_laws.py --only "pid"        one law
"""

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from figures import give, parser_of

from axisid import Record, build, load_axis, twin_record
from axisid.codegen.artefacts import GeneratedAxis
from axisid.control import (
    ControlLaw,
    cascade_p_pi,
    cascade_pd_averaged,
    dynamixel_position,
    impedance,
    pid,
    pid_ideal,
    state_feedback,
)
from axisid.estimation import LawCheck, check_law

_T, _KV = 1e-3, 243.45
_OFF = (1.05, 1.1)


def _p_pi(**others: object) -> ControlLaw:
    given = {"kp": 60.0, "kv": _KV, "tn": 0.03, "period": _T, **others}
    return cascade_p_pi(**given)  # type: ignore[arg-type]


@dataclass(frozen=True, kw_only=True)
class Case:
    """A law, and where its drive saturates, V."""

    law: ControlLaw
    limit: float = 10.0


LAWS: dict[str, Case] = {
    "cascade_pd_averaged": Case(law=cascade_pd_averaged(kp=160.18, kv=_KV, period=_T)),
    "cascade_p_pi": Case(law=_p_pi()),
    "cascade_p_pi, feed-forward": Case(
        law=_p_pi(
            kp=40.0,
            velocity="averaged",
            velocity_feed_forward=0.9,
            acceleration_feed_forward=2.0,
        )
    ),
    "cascade_p_pi, phase-locked loop": Case(
        law=_p_pi(kp=40.0, tn=0.05, velocity="pll", pll_bandwidth=500.0)
    ),
    "cascade_p_pi, velocity filter": Case(law=_p_pi(velocity_filter=2e-3, tn=0.05)),
    "cascade_p_pi, speed limit": Case(law=_p_pi(speed_limit=0.13)),
    "cascade_p_pi, clamped": Case(law=_p_pi(anti_windup="clamping"), limit=3.2),
    "cascade_p_pi, back-calculation": Case(
        law=_p_pi(anti_windup="back_calculation", tracking_time=0.02), limit=3.2
    ),
    "pid": Case(law=pid(kp=39000.0, ki=2e5, kd=243.0, filter_time=1e-3, period=_T)),
    "pid, clamped": Case(
        law=pid(
            kp=20000.0,
            ki=2e5,
            kd=243.0,
            derivative_of="position",
            anti_windup="clamping",
            period=_T,
        ),
        limit=3.2,
    ),
    "pid_ideal": Case(law=pid_ideal(k=39000.0, ti=0.2, td=0.006, filter_time=1e-3, period=_T)),
    "impedance": Case(law=impedance(kp=30000.0, kd=243.0, period=_T)),
    "state_feedback": Case(
        law=state_feedback(k_position=39000.0, k_velocity=243.0, k_integral=2e5, period=_T)
    ),
    "dynamixel_position": Case(
        law=dynamixel_position(p=7000.0, i=2000.0, d=6000.0, ff1=30.0, ff2=200.0, period=_T)
    ),
}


def _rounded(record: Record) -> Record:
    """As a log with seven digits after the point has it; the drive had all."""
    return replace(
        record,
        position=np.round(record.position, 7),
        reference=np.round(np.asarray(record.reference), 7),
        control=np.round(np.asarray(record.control), 4),
    )


def _noisy(record: Record) -> Record:
    control = np.asarray(record.control)
    noise = np.random.default_rng(len(record)).normal(0.0, 0.02, len(record))
    return replace(record, control=control + noise)


#: What a log makes of what the drive has.
LOGS: Mapping[str, Callable[[Record], Record]] = {
    "exact": lambda record: record,
    "rounded": _rounded,
    "control noise": _noisy,
}


@dataclass(kw_only=True)
class Figures:
    """Runs of a law by log; failed ones; changes of gains and those noticed and named."""

    runs: int = 0
    failed: int = 0
    changed: dict[str, int] = field(default_factory=dict)
    noticed: dict[str, int] = field(default_factory=dict)
    named: dict[str, int] = field(default_factory=dict)


def with_law(case: Case, law: ControlLaw) -> GeneratedAxis:
    """The paper's axis under a law."""
    axis = load_axis("emps2015")
    experiment = axis.experiment
    assert experiment is not None
    return build(
        replace(
            axis,
            control=law,
            drive=replace(axis.drive, limit=case.limit),
            experiment=replace(experiment, position_noise=1e-6),
        )
    )


def figures_of(name: str, log: str, *, runs: int, seed: int, right_alone: bool = False) -> Figures:
    """Check the right law in every run, and one with each gain off in turn."""
    case, found = LAWS[name], Figures()
    right = with_law(case, case.law)
    wrong = {
        (gain, times): with_law(
            case, replace(case.law, gains={**case.law.gains, gain: value / times})
        )
        for gain, value in case.law.gains.items()
        for times in (() if right_alone else _OFF)
    }
    for k in range(runs):
        record = LOGS[log](twin_record(right, seed=seed + k))
        found.runs += 1
        found.failed += not _passed(right, record)
        for (gain, times), axis in wrong.items():
            check = check_law(axis, record)
            assert isinstance(check, LawCheck)
            key = f"{gain} {100 * (times - 1):.0f} %"
            found.changed[key] = found.changed.get(key, 0) + 1
            found.noticed[key] = found.noticed.get(key, 0) + (not check.passed)
            found.named[key] = found.named.get(key, 0) + _named(check, gain, times)
    return found


def _passed(axis: GeneratedAxis, record: Record) -> bool:
    check = check_law(axis, record)
    assert isinstance(check, LawCheck)
    return check.passed


def _named(check: LawCheck, gain: str, times: float) -> bool:
    """Whether the gain is named with what it is."""
    said = re.search(rf"\b{gain} is ([\d.]+) times", str(check.note))
    return said is not None and math.isclose(float(said[1]), times, rel_tol=0.02)


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=5, help="of each law and log (default 5)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", metavar="NAME", help="one law")
    parser.add_argument("--right", action="store_true", help="right laws alone")
    parser.add_argument("--log", metavar="NAME", help="one kind of log")
    options = parser.parse_args()
    tree = {
        name: {
            log: _written(
                figures_of(
                    name, log, runs=options.runs, seed=options.seed, right_alone=options.right
                )
            )
            for log in LOGS
            if options.log in (None, log)
        }
        for name in LAWS
        if options.only in (None, name)
    }
    give(tree, options.json, (line for name in tree for line in _lines(name, tree[name])))


def _written(figures: Figures) -> dict[str, object]:
    return {
        "runs": figures.runs,
        "failed": figures.failed / figures.runs,
        "noticed": {key: figures.noticed[key] / n for key, n in figures.changed.items()},
        "named": {key: figures.named[key] / n for key, n in figures.changed.items()},
    }


def _lines(name: str, logs: Mapping[str, Mapping[str, object]]) -> Iterator[str]:
    for log, shares in logs.items():
        yield f"{name:<34}{log:<16}fails {100 * float(str(shares['failed'])):.0f} %"
        noticed, named = shares["noticed"], shares["named"]
        assert isinstance(noticed, dict)
        assert isinstance(named, dict)
        for key, share in named.items():
            if share < 1:
                seen = 100 * noticed[key]
                yield f"{'':<34}{key}: noticed {seen:.0f} %, named {100 * share:.0f} %"


if __name__ == "__main__":
    main()
