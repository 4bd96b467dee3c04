"""The control law against the record: what passes, and which fault the factors look like.

Laws that are no sums of products of their gains are checked by runs of them.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from typing import Any
from unittest.mock import ANY

import numpy as np
import pytest
import sympy
from scipy.interpolate import CubicSpline

from axisid import (
    Record,
    build,
    load_axis,
    read_record,
    simulate,
    twin_record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.control import BALANCED, cascade_p_pi, gain
from axisid.estimation import LawAgreement, Repairs, law_agreement
from axisid.estimation.diagnostics.control_law import (
    ControlScale,
    FoundByReading,
    LateControl,
    MovedZero,
    OtherGains,
    OtherScale,
    OtherVelocity,
    ReferenceClock,
    RepairedLaw,
    ScaledColumn,
    UndeclaredLimit,
    UnexplainedControl,
)
from axisid.estimation.diagnostics.control_law.law_faults import position_zero, reference_clock
from axisid.estimation.findings import Finding
from axisid.modeling.declaration import back_and_forth
from axisid.modeling.declaration.ready_laws import CASCADES
from axisid.support.missing import Missing
from tests.axes.cascaded import cascaded
from tests.axes.ready_laws import LAWS, with_law
from tests.estimation.law_replay.test_initial_state_of_record import carried
from tests.estimation.simulation.test_initial_state import vertical
from tests.law_findings import law_finding_of, repair_of_law
from tests.unjudged import identify
from tests.verdicts import finding_of


def times_of(check: LawAgreement) -> dict[str, float]:
    """How many times the declared one each gain is, of the first set that explains the control."""
    gains, *_ = law_finding_of(check, OtherGains).alternatives
    return {gain.name: gain.times for gain in gains}


@pytest.mark.slow
def test_emps_law_reproduces_the_record_to_a_quarter_percent(
    emps: GeneratedAxis, emps_record: Record
) -> None:
    check = law_agreement(emps, emps_record)
    assert check.passed
    assert check.residual_percent == pytest.approx(0.24, abs=0.005)
    assert check.factors == pytest.approx({"kp*kv": 1.0, "kv": 1.0}, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("kind", CASCADES)
def test_a_right_law_passes_where_the_reference_has_corners_and_steps(
    emps2015: GeneratedAxis, kind: str
) -> None:
    law = CASCADES[kind](kp=50.0, kv=500.0, period=1e-3)
    axis = build(replace(emps2015.axis, control=law))
    time = 1e-3 * np.arange(3000)
    ramps = 0.02 * np.interp(time % 1.5, [0.2, 0.5, 0.8, 1.1], [0.0, 1.0, 1.0, 0.0])
    reference = ramps + 1e-4 * (time > 1.35)
    made = simulate(axis, [100.0, 200.0, 20.0], reference, 1e-3)
    motion = {"position": made.position, "control": made.control}
    record = read_record({"time": time, "reference": reference, **motion}, axis)
    check = law_agreement(axis, record)
    assert check.passed, check.meaning


@pytest.mark.slow
@pytest.mark.parametrize(("acceleration", "share"), [(3.0, 0.03), (4.0, 0.1)])
def test_a_drive_at_its_limit_hides_no_law_and_blames_none(
    emps2015: GeneratedAxis, acceleration: float, share: float
) -> None:
    moves = back_and_forth(speeds=(0.15,), acceleration=acceleration, seconds=0.3, repeat=4)
    axis, experiment = emps2015.axis, emps2015.axis.experiment
    record = twin_record(replace(axis, experiment=replace(experiment, moves=moves)), seed=7)
    assert np.mean(np.abs(record.control) == axis.drive.limit) > share
    assert law_agreement(emps2015, record).passed
    wrong = {"kv": 1.1 * axis.control.gains["kv"]}
    assert not law_agreement(emps2015.with_gains(wrong), record).passed


def late(samples: int, *, at_least: bool = False, delay: int | None) -> Finding:
    return LateControl(
        residual_percent=ANY,
        samples=samples,
        is_at_least=at_least,
        is_before_law=samples < 0,
        blame="law or log",
        delay=delay,
        shift=-samples,
    )


def scaled(role: str, times: float, *, unit: str | None = None) -> Finding:
    column = {"position": "qm", "reference": "qg"}[role]
    repair = ScaledColumn(role=role, times=pytest.approx(times, rel=1e-3), column=column, unit=unit)
    return RepairedLaw(residual_percent=ANY, repaired_percent=ANY, repair=repair)


def other_scale(times: float, units: tuple[str, str] | None = None) -> Finding:
    scale = ControlScale(times=pytest.approx(times, rel=1e-3), units=units)
    return OtherScale(residual_percent=ANY, is_large=True, scale=scale, scaled_percent=ANY)


def by_gain_or_scale(times: float, units: tuple[str, str] | None = None) -> Finding:
    """The damping gain, or the scale that has the same effect."""
    return OtherGains(
        residual_percent=ANY,
        is_large=ANY,
        alternatives=ANY,
        has_right_gains=True,
        scale=ControlScale(times=pytest.approx(times, rel=1e-3), units=units),
    )


FAULTS: dict[str, tuple[Callable[[Record], Record], Finding]] = {
    "sign": (lambda r: replace(r, control=-r.control), other_scale(-1.0)),  # type: ignore[operator]
    "unit of the control": (
        lambda r: replace(r, control=1e-3 * r.control),  # type: ignore[operator]
        by_gain_or_scale(1e-3, ("mm", "m")),
    ),
    "unit of the positions": (
        lambda r: replace(r, position=1e3 * r.position, reference=1e3 * r.reference),  # type: ignore[operator]
        by_gain_or_scale(1e-3, ("mm", "m")),
    ),
    "converter": (lambda r: replace(r, control=0.8 * r.control), by_gain_or_scale(0.8)),  # type: ignore[operator]
    "delay": (lambda r: replace(r, control=np.roll(r.control, 2)), late(2, delay=2)),
    "long delay": (
        lambda r: replace(r, control=np.roll(r.control, 9)),
        late(5, at_least=True, delay=5),
    ),
    "control that comes early": (
        lambda r: replace(r, control=np.roll(r.control, -1)),
        late(-1, delay=None),
    ),
    "unit and delay": (
        lambda r: replace(r, control=1e3 * np.roll(r.control, 2)),  # type: ignore[operator]
        UnexplainedControl(residual_percent=ANY, is_large=True, may_be_injected=True),
    ),
    "small scaling": (lambda r: replace(r, control=1.05 * r.control), by_gain_or_scale(1.05)),  # type: ignore[operator]
    "unit of the position": (
        lambda r: replace(r, position=1e3 * r.position),
        scaled("position", 1e-3, unit="mm"),
    ),
    "scale of the position": (
        lambda r: replace(r, position=50 * r.position),
        scaled("position", 0.02),
    ),
    "unit of the reference": (
        lambda r: replace(r, reference=r.reference / 1e3),  # type: ignore[operator]
        scaled("reference", 1e3, unit=ANY),
    ),
    "sign of the position": (
        lambda r: replace(r, position=-r.position),
        scaled("position", -1.0),
    ),
    "constant": (
        lambda r: replace(r, control=r.control + 0.1),  # type: ignore[operator]
        RepairedLaw(
            residual_percent=ANY,
            repaired_percent=ANY,
            repair=MovedZero(
                position=ANY,
                unit="m",
                column="qm",
                control=pytest.approx(0.1, rel=0.05),
                control_unit="V",
                exceeds_limit=False,
            ),
        ),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS)
def test_faults_of_the_record_are_recognised(
    emps: GeneratedAxis, emps_record: Record, fault: str
) -> None:
    spoil, finding = FAULTS[fault]
    check = law_agreement(emps, spoil(emps_record))
    assert not check.passed
    assert law_finding_of(check, type(finding)) == finding


@pytest.mark.slow
@pytest.mark.parametrize("place", [0.0, 0.1])
def test_a_law_that_is_wrong_about_a_reference_at_rest_is_told(
    place: float, emps2015: GeneratedAxis, rng: np.random.Generator
) -> None:
    """As a test signal alone may move the axis."""
    record = twin_record(emps2015)
    signal, rest = rng.normal(size=len(record)), np.full(len(record), place)
    moved = replace(record, reference=rest, injected=signal, injected_at="control")
    assert not law_agreement(emps2015, moved).passed


@pytest.mark.slow
@pytest.mark.parametrize("idle", [{"ki": 0.0}, {"a": 1e-9, "b": 1e-9}])
def test_terms_that_do_nothing_or_cannot_be_told_apart_have_no_factor(
    emps: GeneratedAxis, emps_record: Record, idle: dict[str, float]
) -> None:
    law = emps.axis.control
    output = law.output + sum(map(gain, idle))
    declared = replace(law, gains={**law.gains, **idle}, output=output)
    check = law_agreement(build(replace(emps.axis, control=declared)), emps_record)
    assert check.passed
    assert {*check.factors} == {"kp*kv", "kv"}


@pytest.mark.slow
@pytest.mark.parametrize("times", [1.0, 0.8])
def test_a_span_that_is_no_measurement_moves_no_law_of_an_ideal_velocity(
    emps: GeneratedAxis, times: float
) -> None:
    record, still = twin_record(emps), slice(4000, 5000)
    position = record.position.copy()
    position[still] = position[still.start]
    stuck = replace(record, position=position, masked=((still.start, still.stop),))
    check = law_agreement(emps, replace(stuck, control=times * record.control))
    assert check.passed is (times == 1.0), check.sentence
    assert check.factors == pytest.approx({"kp*kv": times, "kv": times}, rel=1e-3)
    if times == 0.8:
        scale = law_finding_of(check, OtherGains).scale
        assert scale.times == pytest.approx(0.8, rel=1e-3)


def _rearranged(emps: GeneratedAxis, **parts: sympy.Expr) -> GeneratedAxis:
    """Its law with other products of gains for kp*kv and kv, and the gains that are in them."""
    law, signals = emps.axis.control, {str(by): signal for by, signal in emps.axis.control.terms}
    values = {**law.gains, "kd": law.gains["kv"]}
    output = parts["stiff"] * signals["kp*kv"] + parts["damped"] * signals["kv"]
    gains = {name: value for name, value in values.items() if gain(name) in output.free_symbols}
    return build(replace(emps.axis, control=replace(law, output=output, gains=gains)), native=False)


@pytest.mark.slow
@pytest.mark.parametrize("wrong", [1.0, 1.03])
def test_what_no_gain_multiplies_has_a_factor_and_no_gain_is_named_for_it(
    emps: GeneratedAxis, wrong: float
) -> None:
    record, kv = twin_record(emps), sympy.Float(wrong * emps.axis.control.gains["kv"])
    stiff = gain("kp") * emps.axis.control.gains["kv"]
    check = law_agreement(_rearranged(emps, stiff=stiff, damped=kv), record)
    assert check.passed is (wrong == 1.0), check.sentence
    assert check.factors == pytest.approx({"kp": 1.0, "1": 1 / wrong}, abs=1e-3)
    assert not isinstance(check.finding, OtherGains)
    kp = sympy.Float(emps.axis.control.gains["kp"])
    whole = law_agreement(_rearranged(emps, stiff=kp * kv, damped=kv), record)
    assert whole.factors == pytest.approx({"1": 1 / wrong}, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("wrong", [1.0, 1.02])
def test_a_product_of_gains_that_are_in_no_other_has_a_factor(
    emps: GeneratedAxis, wrong: float
) -> None:
    axis = _rearranged(emps, stiff=gain("kp") * gain("kv"), damped=gain("kd"))
    declared = axis.with_gains({"kp": wrong * axis.axis.control.gains["kp"]})
    check = law_agreement(declared, twin_record(emps))
    assert check.passed is (wrong == 1.0), check.sentence
    assert check.factors == pytest.approx({"kp*kv": 1 / wrong, "kd": 1.0}, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("size", [1.0, 1.2])
def test_a_wrong_gain_is_named_beside_a_test_signal_of_another_size(
    emps2015: GeneratedAxis, size: float
) -> None:
    time = 1e-3 * np.arange(len(twin_record(emps2015)))
    added = 0.5 * np.sin(2 * np.pi * 17 * time) + 0.4 * np.sin(2 * np.pi * 31 * time)
    record = twin_record(emps2015, injected=added, injected_at="control")
    declared = emps2015.with_gains({"kp": 0.95 * emps2015.axis.control.gains["kp"]})
    check = law_agreement(declared, replace(record, injected=size * record.injected))
    found = law_finding_of(check, OtherGains)
    assert times_of(check) == {"kp": pytest.approx(1 / 0.95, abs=1e-3)}
    assert found.injected_differs is (size != 1.0)
    assert check.factors == pytest.approx({"kp*kv": 1.053, "kv": 1.0, "injected": 1 / size}, 0.01)


@pytest.mark.slow
@pytest.mark.parametrize("drives", ["cascade_pd", "cascade_pd_difference", "cascade_pd_averaged"])
def test_the_velocity_that_the_drive_forms_is_found(emps2015: GeneratedAxis, drives: str) -> None:
    gains = {"kp": 160.18, "kv": 243.45, "period": 1e-3}
    record = twin_record(replace(emps2015.axis, control=CASCADES[drives](**gains)))
    for declared, law in CASCADES.items():
        found = law_agreement(
            build(replace(emps2015.axis, control=law(**gains)), native=False), record
        )
        assert found.passed is (declared == drives), (declared, found)
        assert found.passed or repair_of_law(found, OtherVelocity) == OtherVelocity(law=drives)


@pytest.mark.slow
def test_a_limit_that_the_drive_does_not_declare_is_named_with_its_size() -> None:
    axis = load_axis("vertical_screw")
    twin = twin_record(axis, seed=1)
    most = 0.8 * float(np.abs(twin.control).max())
    limited, free = (replace(axis, drive=replace(axis.drive, limit=at)) for at in (most, np.inf))
    spike = np.where(np.arange(len(twin)) == 4000, 60 * most, twin.control)
    at_limit = twin_record(limited, seed=1)
    noise = np.random.default_rng(1).normal(scale=1e-3 * most, size=len(at_limit))
    for declared, record, named in (
        (axis, at_limit, True),
        (axis, replace(at_limit, control=at_limit.control + noise), True),
        (free, replace(twin, control=spike), False),
    ):
        found = law_agreement(build(declared), record)
        assert not found.passed
        if named:
            assert repair_of_law(found, UndeclaredLimit).limit == pytest.approx(most, rel=2e-4)
        else:
            assert not isinstance(found.finding, RepairedLaw)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "gain", "off"),
    [
        ("emps2015", "kp", 0.005),
        ("emps2015", "kp", 0.02),
        ("emps2015", "kv", -0.05),
        ("vertical_screw", "kp", -0.01),
        ("vertical_screw", "kv", 0.02),
    ],
)
def test_a_gain_that_is_declared_a_little_wrong_is_named_with_its_value(
    name: str, gain: str, off: float
) -> None:
    """However much of the control that is: half a percent of kp is 5 to 10 % of it."""
    axis = build(load_axis(name))
    law = axis.axis.control
    declared = (1 + off) * law.gains[gain]
    found = law_agreement(axis.with_gains({gain: declared}), twin_record(axis))
    assert not found.passed
    alternatives = law_finding_of(found, OtherGains).alternatives
    (value,) = [g.value for gains in alternatives for g in gains if g.name == gain]
    assert value == pytest.approx(law.gains[gain], rel=0.1 * abs(off))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["emps", "vertical_screw", "pendulum", "belt_axis"])
def test_a_zero_apart_is_told_with_its_size_and_taken_off(name: str) -> None:
    axis = build(load_axis(name))
    record, law = twin_record(axis), axis.axis.control
    assert law_agreement(axis, record).passed
    control = np.asarray(record.control)
    unit, _ = position_zero(axis, law, replace(record, control=control + 1.0))
    away = unit / 3 * float(np.std(control))  # as much as makes a third of the control
    off = replace(record, position=record.position + away)
    found = law_agreement(axis, off)
    assert not found.passed
    repair = repair_of_law(found, MovedZero)
    assert repair.position == pytest.approx(away, rel=2e-2)
    assert repair.unit == axis.axis.coordinate.unit
    told, _ = position_zero(axis, law, off)
    assert told == pytest.approx(away, rel=2e-2)
    assert law_agreement(axis, replace(off, position=off.position - told)).passed


@pytest.mark.slow
def test_a_law_that_integrates_is_told_the_position_alone() -> None:
    record, _ = carried(0)
    found = law_agreement(vertical(BALANCED), replace(record, position=record.position + 1e-3))
    assert not found.passed
    repair = repair_of_law(found, MovedZero)
    assert repair.position == pytest.approx(1e-3, rel=2e-2)
    assert (repair.unit, repair.control) == ("m", None)


def log(axis: GeneratedAxis, share: float, *, sampled: bool, noise: float = 0.0) -> dict[str, Any]:
    """A twin whose stamps jitter, and its positions with them where they were sampled so."""
    twin = twin_record(axis)
    rng = np.random.default_rng(3)
    time = twin.time + share * twin.period * rng.normal(size=len(twin))
    columns = dict(twin.channels()) | {"time": time}
    if sampled:
        columns["position"] = CubicSpline(twin.time, twin.position)(time)
    columns["position"] = columns["position"] + noise * rng.normal(size=len(twin))
    return columns


def read(axis: GeneratedAxis, columns: dict[str, Any], *, resampled: bool) -> Record:
    repairs = Repairs(resample="auto") if resampled else None
    return read_record(columns, axis, columns={name: name for name in columns}, repairs=repairs)


@pytest.mark.parametrize("resampled", [False, True])
@pytest.mark.parametrize("sampled", [False, True])
@pytest.mark.parametrize(
    ("share", "wrong"),
    [
        *((share, "") for share in (0.01, 0.05)),
        *(pytest.param(0.05, gain, marks=pytest.mark.slow) for gain in ("kp", "kv")),
    ],
)
def test_a_right_law_passes_and_a_wrong_gain_is_named_whatever_of_a_log_jitters(
    emps: GeneratedAxis, share: float, wrong: str, sampled: bool, resampled: bool
) -> None:
    gains = {name: 1.1 * emps.axis.control.gains[name] for name in [wrong] if name}
    record = read(emps, log(emps, share, sampled=sampled), resampled=resampled)
    found = law_agreement(emps.with_gains(gains), record)
    assert found.passed is not bool(wrong), found.meaning
    if wrong:
        assert times_of(found)[wrong] == pytest.approx(1 / 1.1, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("resampled", [False, True])
def test_noise_of_its_own_between_the_ticks_leaves_the_law_open(resampled: bool) -> None:
    axis = build(load_axis("pendulum"))
    columns = log(axis, 0.05, sampled=True, noise=1e-5)
    found = law_agreement(axis, read(axis, columns, resampled=resampled))
    assert isinstance(found, Missing)


@pytest.mark.slow
def test_stamps_alone_that_jitter_need_no_resampling_and_few_digits_excuse_no_wrong_law(
    emps: GeneratedAxis,
) -> None:
    record = read(emps, log(emps, 0.05, sampled=False), resampled=True)
    told = {c.name: c for c in identify(emps, record, methods=["idm-iv"]).verdict}["control law"]
    assert told.status == "note"
    assert finding_of(told, FoundByReading).reading == "sampled rows"
    columns = log(emps, 1e-4, sampled=False)
    columns |= {"time": np.round(columns["time"], 7), "control": 1.2 * columns["control"]}
    assert not law_agreement(emps, read(emps, columns, resampled=False)).passed


P_PI, BACK = "cascade_p_pi, clamped", "cascade_p_pi, back-calculation"
_QUICK = (P_PI, "pid", "state_feedback")


@cache
def _axis(name: str, limit: float = 10.0) -> GeneratedAxis:
    axis = with_law(name, limit).axis
    experiment = axis.experiment
    return build(replace(axis, experiment=replace(experiment, position_noise=1e-6)), native=False)


@cache
def _record(name: str, limit: float = 10.0) -> Record:
    return twin_record(_axis(name, limit))


def _checked(name: str, gains: Mapping[str, float], limit: float = 10.0) -> LawAgreement:
    """The check of a law with some gains divided by what is given."""
    axis, law = _axis(name, limit).axis, LAWS[name]()
    declared = {**law.gains, **{gain: law.gains[gain] / off for gain, off in gains.items()}}
    axis = replace(axis, control=replace(law, gains=declared))
    return law_agreement(build(axis, native=False), _record(name, limit))


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [name if name in _QUICK else pytest.param(name, marks=pytest.mark.slow) for name in LAWS],
)
def test_a_right_law_passes(name: str) -> None:
    check = _checked(name, {})
    assert check.passed, check.sentence
    assert check.residual_percent < 1e-6
    if name in (P_PI, BACK):
        assert (np.abs(_record(name, 3.2).control) == 3.2).mean() > 0.01
        assert _checked(name, {}, 3.2).passed, "where its drive saturates"


@pytest.mark.slow
def test_a_gain_that_is_off_is_told_of_a_law_with_one_memory() -> None:
    def axis(kv: float) -> GeneratedAxis:
        law = cascade_p_pi(
            kp=60.0, kv=kv, tn=0.03, period=1e-3, velocity="ideal", anti_windup="clamping"
        )
        return build(replace(load_axis("emps2015"), control=law), native=False)

    check = law_agreement(axis(291.6), twin_record(axis(243.0)))
    assert isinstance(check, LawAgreement)
    assert check.factors == pytest.approx({"kp": 1.0, "kv": 1 / 1.2, "tn": 1.0}, rel=1e-3)


GAINS = [
    *((P_PI, gain, 10.0) for gain in ("kp", "kv", "tn")),
    (BACK, "tracking_time", 3.0),
    ("pid", "filter_time", 10.0),
    ("state_feedback", "k_integral", 10.0),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "gain", "limit"), GAINS)
def test_a_gain_that_is_wrong_alone_is_named_with_its_value(
    name: str, gain: str, limit: float
) -> None:
    check, value = _checked(name, {gain: 1.05}, limit), LAWS[name]().gains[gain]
    assert not check.passed
    found = law_finding_of(check, OtherGains)
    ((named,),) = found.alternatives
    assert (named.name, found.has_right_gains) == (gain, True)
    assert (named.times, named.value) == (pytest.approx(1.05, rel=1e-3), pytest.approx(value))
    assert check.factors[gain] == pytest.approx(1.05, rel=1e-4)
    assert {v for g, v in check.factors.items() if g != gain} == {1.0}
    assert check.fitted_residual_percent < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("times", "units"),
    [(0.8, None), (1e-3, ("mm", "m")), (-1.0, None)],
)
def test_another_scale_of_the_control_is_told_beside_the_gain_that_makes_as_much(
    times: float, units: tuple[str, str] | None
) -> None:
    record = _record(P_PI)
    scaled = replace(record, control=times * np.asarray(record.control))
    check = law_agreement(_axis(P_PI), scaled)
    assert not check.passed
    found = check.finding
    assert isinstance(found, OtherGains | OtherScale)
    assert found.scale == ControlScale(times=pytest.approx(times, rel=1e-6), units=units)
    if times == 0.8:
        assert times_of(check)["kv"] == pytest.approx(0.8)


@pytest.mark.slow
def test_what_no_gain_explains_is_said_to_be_something_else() -> None:
    """The drive averages its velocity; the law that is declared does not."""
    name = "cascade_p_pi, feed-forward"
    plain = replace(LAWS["cascade_p_pi"](), gains={"kp": 10.0, "kv": 400.0, "tn": 0.1})
    check = law_agreement(
        build(replace(_axis(name).axis, control=plain), native=False), _record(name)
    )
    assert law_finding_of(check, UnexplainedControl).is_large
    assert not check.passed


def _seven_digits(record: Record) -> Record:
    reference = np.round(np.asarray(record.reference), 7)
    return replace(record, position=np.round(record.position, 7), reference=reference)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "written"),
    [(P_PI, _seven_digits), ("pid", lambda r: replace(r, control=r.control + 0.1))],
)
def test_seven_digits_or_another_start_of_an_integral_are_no_fault(
    name: str, written: Callable[[Record], Record]
) -> None:
    check = law_agreement(_axis(name), written(_record(name)))
    assert check.passed, check.sentence


@cache
def _behind_encoder(step: float) -> tuple[GeneratedAxis, Record]:
    axis = cascaded()
    experiment = replace(axis.experiment, position_noise=0.0, resolution=step)
    found = build(replace(axis, experiment=experiment), native=False)
    return found, twin_record(found)


@pytest.mark.slow
@pytest.mark.parametrize("step", [1e-6, 2e-5])
def test_steps_of_an_encoder_excuse_no_other_control(step: float) -> None:
    """What they leave open of the control is that of a log which rounds, and this one does not."""
    axis, record = _behind_encoder(step)
    assert law_agreement(axis, record).passed
    wave = np.sqrt(2 * np.mean(record.control**2)) * np.sin(2 * np.pi * 11 * record.time)
    for control, kind in (
        (-record.control, OtherScale),
        (np.roll(record.control, -1), LateControl),
        (record.control + 0.2 * wave, UnexplainedControl),
        (record.control + 0.1 * wave, UnexplainedControl),
    ):
        found = law_agreement(axis, replace(record, control=control))
        assert not found.passed
        law_finding_of(found, kind)


@pytest.mark.slow
@pytest.mark.parametrize("coarser", [5, 20])
def test_a_right_law_behind_a_log_that_rounds_is_not_refused(coarser: int) -> None:
    axis, record = _behind_encoder(1e-6)
    rounded = coarser * 1e-6 * np.round(record.position / (coarser * 1e-6))
    found = law_agreement(axis, replace(record, position=rounded))
    assert isinstance(found, Missing) or found.passed
    assert not law_agreement(axis, replace(record, control=-record.control)).passed


@pytest.mark.slow
@pytest.mark.parametrize("rate", [5e-4, -2e-4])
def test_a_reference_on_another_clock_is_named_with_its_rate(rate: float) -> None:
    axis, record = _axis(P_PI), _record(P_PI)
    law, count = axis.axis.control, np.arange(float(len(record)))
    assert reference_clock(axis, law, record) is None
    stamped = CubicSpline(count, np.asarray(record.reference))(count / (1 + rate))
    other = replace(record, reference=stamped)
    assert reference_clock(axis, law, other) == pytest.approx(rate, rel=1e-2)
    found = law_agreement(axis, other)
    assert not found.passed
    assert repair_of_law(found, ReferenceClock).rate == pytest.approx(rate, rel=1e-2)
