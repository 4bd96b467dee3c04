"""How often the law check fails on right ready laws, and notices and names what is wrong.

Twins of the paper's axis under every ready law, and of others of the library under theirs, with
noise in the loop; what is logged of them may be rounded or noisy besides. Of a right law the check
should fail in no run; with one gain declared 5 or 10 % too low, that gain is to be named with its
value to 2 % of itself, where the record shows it. A law without its feed-forward or anti-windup, or
with a delay that is not the drive's, is to be noticed.

    python benchmarks/control_laws.py                     a table
    python benchmarks/control_laws.py --json -            one JSON object
    python benchmarks/control_laws.py --only "pid"        one law
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from figures import give, parser_of

from axisid import Record, build, load_axis, twin_record
from axisid.codegen.generated_axes import GeneratedAxis
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
from axisid.estimation import LawAgreement, law_agreement
from axisid.estimation.diagnostics.control_law import FoundByReading, OtherGains

_T, _KV = 1e-3, 243.45
_OFF = (1.05, 1.1)


def _p_pi(**others: object) -> ControlLaw:
    given = {"kp": 60.0, "kv": _KV, "tn": 0.03, "period": _T, **others}
    return cascade_p_pi(**given)  # type: ignore[arg-type]


@dataclass(frozen=True, kw_only=True)
class Case:
    """A law, where its drive saturates, and an axis of the library.

    Attributes
    ----------
    law : ControlLaw
    limit : float
        In the drive's unit.
    axis : str
    without : mapping of str to ControlLaw
        The law without one of its parts, by what is missing.
    """

    law: ControlLaw
    limit: float = 10.0
    axis: str = "emps2015"
    without: Mapping[str, ControlLaw] = field(default_factory=dict)

    @property
    def wrong(self) -> dict[str, ControlLaw]:
        """Laws that differ by more than a gain."""
        late = replace(self.law, delay=self.law.delay + 1)
        return {**self.without, "a delay of 1 sample": late}


def _own(name: str, **without: ControlLaw) -> Case:
    """An axis of the library under its own law."""
    axis = load_axis(name)
    assert axis.control is not None
    named = {key.replace("_", " "): law for key, law in without.items()}
    return Case(law=axis.control, limit=axis.drive.limit, axis=name, without=named)


def _joint_law(**others: object) -> ControlLaw:
    """That of `servo_joint`, changed."""
    given = {
        "kp": 25.0,
        "kv": 6.0,
        "tn": 0.02,
        "period": _T,
        "velocity": "averaged",
        "velocity_feed_forward": 1.0,
        "anti_windup": "clamping",
        **others,
    }
    return cascade_p_pi(**given)  # type: ignore[arg-type]


LAWS: dict[str, Case] = {
    "cascade_pd_averaged": Case(law=cascade_pd_averaged(kp=160.18, kv=_KV, period=_T)),
    "cascade_p_pi": Case(law=_p_pi()),
    "cascade_p_pi, feed-forward": Case(
        law=_p_pi(
            kp=40.0,
            velocity="averaged",
            velocity_feed_forward=0.9,
            acceleration_feed_forward=2.0,
        ),
        without={
            "no feed-forward": _p_pi(kp=40.0, velocity="averaged"),
            "no feed-forward of the acceleration": _p_pi(
                kp=40.0, velocity="averaged", velocity_feed_forward=0.9
            ),
        },
    ),
    "cascade_p_pi, phase-locked loop": Case(
        law=_p_pi(kp=40.0, tn=0.05, velocity="pll", pll_bandwidth=500.0)
    ),
    "cascade_p_pi, velocity filter": Case(law=_p_pi(velocity_filter=2e-3, tn=0.05)),
    "cascade_p_pi, speed limit": Case(law=_p_pi(speed_limit=0.13)),
    "cascade_p_pi, clamped": Case(
        law=_p_pi(anti_windup="clamping"), limit=3.2, without={"no anti-windup": _p_pi()}
    ),
    "cascade_p_pi, back-calculation": Case(
        law=_p_pi(anti_windup="back_calculation", tracking_time=0.02),
        limit=3.2,
        without={"no anti-windup": _p_pi()},
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
        law=dynamixel_position(p=7000.0, i=2000.0, d=6000.0, ff1=30.0, ff2=200.0, period=_T),
        without={"no feed-forward": dynamixel_position(p=7000.0, i=2000.0, d=6000.0, period=_T)},
    ),
    "servo_joint": _own("servo_joint", no_feed_forward=_joint_law(velocity_feed_forward=0.0)),
    "servo_joint, saturated": Case(
        law=_joint_law(),
        limit=2.7,
        axis="servo_joint",
        without={"no anti-windup": _joint_law(anti_windup="none")},
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
    """Runs of a law by log; failed and unjudged ones; what is wrong, noticed, and named."""

    runs: int = 0
    failed: int = 0
    unjudged: int = 0
    changed: dict[str, int] = field(default_factory=dict)
    noticed: dict[str, int] = field(default_factory=dict)
    named: dict[str, int] = field(default_factory=dict)


def with_law(case: Case, law: ControlLaw) -> GeneratedAxis:
    """The axis of a case under a law."""
    axis = load_axis(case.axis)
    experiment = axis.experiment
    assert experiment is not None
    if case.axis == "emps2015":
        experiment = replace(experiment, position_noise=1e-6)
    drive = replace(axis.drive, limit=case.limit)
    return build(replace(axis, control=law, drive=drive, experiment=experiment))


def figures_of(name: str, log: str, *, runs: int, seed: int, right_alone: bool = False) -> Figures:
    """Check the right law in every run, and one with each gain off in turn."""
    case, found = LAWS[name], Figures()
    right = with_law(case, case.law)
    wrong = {
        (gain, times): right.with_gains({gain: value / times})
        for gain, value in case.law.gains.items()
        for times in (() if right_alone else _OFF)
        if value
    }
    others = {} if right_alone else {k: with_law(case, law) for k, law in case.wrong.items()}
    for k in range(runs):
        record = LOGS[log](twin_record(right, seed=seed + k))
        found.runs += 1
        passed = _passed(right, record)
        found.failed += passed is False
        found.unjudged += passed is None
        for (gain, times), axis in wrong.items():
            check = law_agreement(axis, record)
            told = isinstance(check, LawAgreement)
            key = f"{gain} {100 * (times - 1):.0f} %"
            found.changed[key] = found.changed.get(key, 0) + 1
            found.noticed[key] = found.noticed.get(key, 0) + (told and not check.passed)
            found.named[key] = found.named.get(key, 0) + (told and _named(check, gain, times))
        for key, axis in others.items():
            found.changed[key] = found.changed.get(key, 0) + 1
            found.noticed[key] = found.noticed.get(key, 0) + (_passed(axis, record) is False)
    return found


def _passed(axis: GeneratedAxis, record: Record) -> bool | None:
    """Whether the law passes; None where the check says why it cannot tell."""
    check = law_agreement(axis, record)
    return check.passed if isinstance(check, LawAgreement) else None


def _named(check: LawAgreement, gain: str, times: float) -> bool:
    """Return whether the gain is named with its value."""
    found = check.finding
    if isinstance(found, FoundByReading):
        found = found.finding
    if not isinstance(found, OtherGains):
        return False
    for gains in found.alternatives:
        for other in gains:
            if other.name == gain:
                return math.isclose(other.times, times, rel_tol=0.02)
    return False


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
        "unjudged": figures.unjudged / figures.runs,
        "noticed": {key: figures.noticed[key] / n for key, n in figures.changed.items()},
        "named": {key: n / figures.changed[key] for key, n in figures.named.items()},
    }


def _unjudged(shares: Mapping[str, object]) -> str:
    share = 100 * float(str(shares["unjudged"]))
    return f", cannot tell {share:.0f} %" if share else ""


def _lines(name: str, logs: Mapping[str, Mapping[str, object]]) -> Iterator[str]:
    for log, shares in logs.items():
        failed = 100 * float(str(shares["failed"]))
        yield f"{name:<34}{log:<16}fails {failed:.0f} %{_unjudged(shares)}"
        noticed, named = shares["noticed"], shares["named"]
        assert isinstance(noticed, dict)
        assert isinstance(named, dict)
        for key, seen in noticed.items():
            share = named.get(key, seen)
            if min(share, seen) < 1:
                said = f", named {100 * share:.0f} %" if key in named else ""
                yield f"{'':<34}{key}: noticed {100 * seen:.0f} %{said}"


if __name__ == "__main__":
    main()
