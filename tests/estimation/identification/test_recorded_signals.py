"""Axes with recorded signals are identified: in the force, the drive and the law."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from axisid import (
    Record,
    build,
    identify,
    simulate,
    twin_record,
)
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.simulation.twin import trajectory
from tests.axes.recorded import MOVES, PERIOD_S, TRUTH, recorded_axis, recorded_values

#: Of which no noise moves the estimates.
METHODS = ("ddm-ls", "idm-iv", "ddm-iv")
KINDS = [("pressure", "linear"), ("pressure", "held"), ("supply", "linear"), ("feed", "held")]


def twin(axis: GeneratedAxis, kind: str, seed: int) -> Record:
    return twin_record(axis, signals=recorded_values(kind, seed), seed=seed)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "between"), KINDS)
def test_intervals_of_twelve_twins_hold_the_truth(kind: str, between: str) -> None:
    """95 % intervals: 8 of 12 or fewer come by chance in 0.2 %; no check fails."""
    axis, held, failed = build(recorded_axis(kind, between)), Counter[str](), list[str]()
    for seed in range(12):
        result = identify(axis, twin(axis, kind, 100 + seed))
        assert set(result.estimates) == {*METHODS, "idm-ls", "didim"}
        for method in METHODS:
            values = result[method].parameters.items()
            held.update(
                f"{method} {n}" for n, v in values if v.interval[0] <= TRUTH[n] <= v.interval[1]
            )
        failed += [check.name for check in result.verdict if check.status == "fail"]
    assert all(held[f"{method} {name}"] > 8 for method in METHODS for name in axis.names)
    assert not failed


@pytest.mark.slow
def test_a_feed_forward_of_the_wrong_sign_is_named() -> None:
    axis = build(recorded_axis("feed"))
    record = twin(axis, "feed", 2)
    result = identify(axis, replace(record, signals={"feed": -record.signals["feed"]}))
    (check,) = [c for c in result.verdict if c.name == "control law"]
    assert check.status == "fail"
    assert "feed times -1" in check.meaning


@pytest.mark.slow
@pytest.mark.parametrize("every", [4, 5])
def test_a_loop_at_a_clock_of_its_own_reads_the_signals_between_samples(every: int) -> None:
    """A loop at several times the log's rate, its pressure straight between the log's samples."""
    fast = PERIOD_S / every
    declared = recorded_axis("pressure")
    law = replace(declared.control, period=fast, reference_between="linear")
    axis = build(replace(declared, control=law))
    log = trajectory(MOVES, PERIOD_S)
    ticks, samples = np.arange(every * (len(log) - 1) + 1) / every, np.arange(len(log))
    (pressure,) = recorded_values("pressure", 5).values()
    loop = simulate(
        axis,
        [TRUTH[name] for name in axis.names],
        np.interp(ticks, samples, log),
        fast,
        signals={"pressure": np.interp(ticks, samples, pressure)},
    )
    record = Record(
        time=PERIOD_S * samples,
        position=loop.position[::every],
        reference=log,
        control=loop.control[::every],
        signals={"pressure": pressure},
        sample_period=PERIOD_S,
    )
    estimate = identify(axis, record, methods=["idm-iv"]).estimates["idm-iv"]
    for name, value in estimate.parameters.items():
        assert sum(value.interval) / 2 == pytest.approx(TRUTH[name], rel=5e-3)
    assert estimate.simulation_error_percent is not None
