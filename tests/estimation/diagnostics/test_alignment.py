"""The delay between force and motion; a control that is logged early, or a law of another delay."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from axisid import (
    Coordinate,
    Identification,
    Parameter,
    Prefilter,
    Record,
    build,
    load_axis,
    newton,
    read_record,
    twin_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.control import cascade_pd_difference
from axisid.elements import Drive, coulomb, viscous
from axisid.estimation import law_agreement
from axisid.estimation.diagnostics import estimate_delay
from axisid.estimation.diagnostics.alignment_findings import (
    DeclaredTooLong,
    DelayBeyondRange,
    ForceDelay,
    LoggedAtOtherTime,
)
from axisid.estimation.diagnostics.control_law import LateControl, MovedColumn
from axisid.estimation.verdict_checks import Check
from axisid.modeling import Experiment, back_and_forth
from tests.law_findings import repair_of_law
from tests.unjudged import identify
from tests.verdicts import checks_of, finding_of

FINE = Prefilter(cutoff=180.0, decimate=3, drop=(50, 50))


@pytest.fixture(scope="module")
def quiet(emps2015: GeneratedAxis) -> Record:
    return twin_record(emps2015, position_noise=0.0)


def checked(axis: GeneratedAxis, record: Record, prefilter: Prefilter | None = None) -> Check:
    return checks_of(identify(axis, record, prefilter, "idm-ls"))["alignment"]


@pytest.mark.parametrize("early", [-1, 0, 1, 2])
def test_whole_samples_beside_the_half_of_the_hold_are_found(
    emps2015: GeneratedAxis, quiet: Record, early: int
) -> None:
    """A control that is written down early has to be taken from earlier rows."""
    shifted = replace(quiet, control=np.roll(quiet.control, -early))
    best = estimate_delay(emps2015, shifted, FINE).best
    assert best == pytest.approx(0.5 + early, abs=0.05)


def test_real_record_moves_viscous_friction_by_four_and_a_half_per_half_sample(
    emps: GeneratedAxis, emps_record: Record
) -> None:
    prefilter = Prefilter(cutoff=100.0, drop=(49, 0), reversals="keep")
    found = estimate_delay(emps, emps_record, prefilter)
    assert 0.1 < found.best < 0.5
    assert found.sensitivity[1] / 2 == pytest.approx(4.4, abs=0.2)


@pytest.mark.slow
def test_deviation_of_the_delay_is_the_scatter_of_its_estimates(
    emps2015: GeneratedAxis, quiet: Record
) -> None:
    noise = np.random.default_rng(8).normal(0.0, 1.0, (60, len(quiet)))
    found = [
        estimate_delay(emps2015, replace(quiet, control=quiet.control + each), Prefilter())
        for each in noise
    ]
    scatter = float(np.std([p.best for p in found], ddof=1))
    assert np.mean([p.deviation for p in found]) == pytest.approx(scatter, rel=0.3)


@pytest.mark.slow
def test_delay_beyond_the_range_or_that_the_record_does_not_tell_is_said_to_be_so(
    emps2015: GeneratedAxis, quiet: Record
) -> None:
    noise = np.random.default_rng(8).normal(0.0, 30.0, len(quiet))
    late = checked(emps2015, replace(quiet, control=np.roll(quiet.control, -5)), FINE)
    assert late.status == "fail"
    found = finding_of(late, ForceDelay)
    assert (found.delay, found.is_at_end) == (3.0, True)
    noisy = checked(emps2015, replace(quiet, control=quiet.control + noise))
    assert noisy.status == "not evaluated"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("declared", "is_at_least"),
    [(1e-3, False), (3e-3, False), (2e-2, True)],
)
def test_a_declared_delay_that_is_not_there_is_said_to_be_too_long(
    emps2015: GeneratedAxis, twin: Record, declared: float, is_at_least: bool
) -> None:
    axis = emps2015.axis
    late = build(replace(axis, drive=replace(axis.drive, delay=declared)))
    verdict = checks_of(identify(late, twin, methods="idm-ls"))
    assert verdict["alignment"].status == "fail"
    remedy, *_ = finding_of(verdict["alignment"], ForceDelay).remedies
    assert isinstance(remedy, DeclaredTooLong)
    assert (remedy.declared, remedy.is_at_least) == (declared, is_at_least)
    if is_at_least:
        assert 0 < remedy.excess < declared
        assert remedy.remaining == pytest.approx(declared - remedy.excess)
    else:
        assert remedy.excess == pytest.approx(declared, rel=0.5)
        assert remedy.remaining == 0.0
    assert verdict["missing terms"].status != "fail"


TRUTH = {"J": 0.0021, "b": 0.0080, "c": 0.045}


@cache
def small_axis(delay: int) -> GeneratedAxis:
    """A light rotary axis, a thousand samples a second."""
    q, J = Coordinate("q", "rad"), Parameter("J", "kg m^2", nominal=0.002)
    b, c = Parameter("b", "N m s/rad", nominal=0.007), Parameter("c", "N m", nominal=0.05)
    law = cascade_pd_difference(period=1e-3, kp=25.0, kv=2.0)
    axis = newton(
        "small",
        coordinate=q,
        parameters=(J, b, c),
        inertia=J,
        resistance=(viscous(b, q), coulomb(c, q)),
        drive=Drive(gain=0.1, unit="A"),
        control=replace(law, delay=delay),
        experiment=Experiment(
            moves=back_and_forth(
                speeds=(2.0, 5.0, 10.0), acceleration=150.0, seconds=0.4, repeat=2
            ),
            truth=TRUTH,
            position_noise=2e-5,
        ),
    )
    return build(axis)


@cache
def logged(delay: int, early: int) -> Record:
    record = twin_record(small_axis(delay), seed=5)
    return record.shifted(control=-early) if early else record


@cache
def result(true: int, declared: int, early: int) -> Identification:
    """Of a loop with a true and a declared delay, whose control is logged so many samples early."""
    record = logged(true, early)
    return identify(small_axis(declared), record, Prefilter.suited(record.period))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("true", "declared", "early", "law", "alignment"),
    [
        (0, 0, 0, "pass", "pass"),
        (1, 1, 0, "pass", "pass"),
        # Told to declare no delay, and obeying, one had b a sixth too low, with care.
        (1, 1, 1, "fail", "note"),
        (1, 0, 1, "pass", "fail"),
        (0, 1, 0, "fail", ""),
        (1, 0, 0, "fail", ""),
        (2, 1, 0, "fail", ""),
    ],
)
def test_who_is_to_blame_for_a_delay_is_told_with_what_mends_it(
    true: int, declared: int, early: int, law: str, alignment: str
) -> None:
    checks = checks_of(result(true, declared, early))
    assert checks["control law"].status == law
    if law == "fail":
        late = finding_of(checks["control law"], LateControl)
        if early:
            assert (late.blame, late.shift, late.delay) == ("log", early, None)
        else:
            assert (late.blame, late.shift, late.delay) == ("law", 0, true)
    if not alignment:
        return
    assert checks["alignment"].status == alignment
    found = finding_of(checks["alignment"], ForceDelay)
    moved = LoggedAtOtherTime(role="control", samples=early)
    assert (moved in found.remedies) is (early > 0)
    if alignment == "note":  # the shift of the log, and no delay of the drive
        assert found.apart == pytest.approx(1.0, abs=0.15)
        assert found.remedies == (moved,)


@pytest.mark.slow
def test_shifted_as_advised_it_is_the_truth() -> None:
    moved = logged(1, 1).shifted(control=1)
    found = identify(small_axis(1), moved, Prefilter.suited(moved.period))
    assert not [check.name for check in found.verdict if check.status == "fail"]
    for name, true in TRUTH.items():
        value = found["idm-iv"].parameters[name]
        assert abs(value.corrected - true) < 4 * value.sd_hac


@pytest.mark.slow
@pytest.mark.parametrize("role", ["reference", "position"])
@pytest.mark.parametrize("samples", [1, -1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_reference_or_position_at_another_time_is_named(role: str, samples: int) -> None:
    axis = build(load_axis("rotary_table"))
    record = twin_record(axis, seed=2)
    check = law_agreement(axis, record.shifted(**{role: samples}))
    assert repair_of_law(check, MovedColumn) == MovedColumn(role=role, samples=-samples)


@pytest.mark.slow
def test_a_delay_beyond_the_range_has_a_cure(emps2015: GeneratedAxis, quiet: Record) -> None:
    early = 6
    check = checked(emps2015, replace(quiet, control=np.roll(quiet.control, -early)))
    (remedy,) = finding_of(check, ForceDelay).remedies
    assert check.status == "fail"
    assert isinstance(remedy, DelayBeyondRange)
    assert remedy.role == "control"
    assert 0 < remedy.samples <= early


@pytest.mark.slow
@pytest.mark.parametrize(("every", "acceleration", "status"), [(1, 0.8, "pass"), (5, 4.0, "fail")])
def test_a_log_slower_than_an_undeclared_loop_fails_where_that_moves_a_parameter(
    every: int, acceleration: float, status: str
) -> None:
    """The loop holds its control for a fifth of a sample, where the hold supposes a whole one."""
    base = load_axis("emps2015")
    moves = back_and_forth(speeds=(0.05, 0.1), acceleration=acceleration, seconds=0.02, repeat=8)
    experiment = replace(base.experiment, moves=moves, position_noise=1e-8)
    law = cascade_pd_difference(kp=60.0, kv=150.0, period=2e-4)
    record = twin_record(build(replace(base, control=law, experiment=experiment)))
    columns = {name: values[::every] for name, values in record.channels().items()}
    columns["time"] = 2e-4 * every * np.arange(len(columns["position"]))
    undeclared = build(replace(base, control=None))
    roles = {name: name for name in columns}
    read = read_record(columns, undeclared, columns=roles)
    assert checks_of(identify(undeclared, read))["alignment"].status == status
