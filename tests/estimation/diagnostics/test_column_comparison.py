"""A measured force, velocity or control beside what it should be: what does not fit is named."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from axisid import (
    Prefilter,
    Record,
    build,
    load_axis,
    twin_record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation.diagnostics import (
    compared_motion,
    derivative_check,
)
from axisid.estimation.diagnostics.column_comparison import force_check, limit_check
from axisid.estimation.diagnostics.column_findings import (
    ColumnCorrections,
    ColumnFault,
    ControlAgainstLimit,
    ForceAgainstControl,
    MeasuredMotion,
)
from axisid.estimation.records import AdvisedShift
from axisid.estimation.verdict_checks import Check
from tests.unjudged import identify
from tests.verdicts import checks_of, finding_of

GAIN = 35.15


def measured(commanded: np.ndarray, how: str, rng: np.random.Generator) -> np.ndarray:
    """What a current sensor makes of a commanded force: late, coarse, noisy."""
    rms = float(np.sqrt(np.mean(commanded**2)))
    pole, step = np.exp(-1e-3 / 2e-3), 0.01 * np.abs(commanded).max()
    noise = rng.normal(0.0, 1.0, len(commanded))
    slow = lfilter([1], [1, -0.98], noise)
    return {
        "late": lfilter([1 - pole], [1, -pole], commanded, zi=[pole * commanded[0]])[0],
        "coarse": step * np.round(commanded / step),
        "drifting": commanded + 0.05 * rms * slow / np.sqrt(np.mean(slow**2)),
        "noisy": commanded + 0.1 * rms * noise,
        "nothing else": commanded,
    }[how]


@pytest.mark.parametrize(
    ("scale", "shift", "status"),
    [(1.0, 0, "pass"), (0.5, 0, "fail"), (-1.0, 0, "fail"), (1, 9, "fail")],
)
def test_scale_sign_and_time_are_seen(
    emps2015: GeneratedAxis, twin: Record, scale: float, shift: int, status: str
) -> None:
    spoilt = replace(twin, force=np.roll(scale * GAIN * twin.control, shift))
    check = force_check(emps2015, spoilt)
    assert check.status == status
    if not shift:
        assert finding_of(check, ForceAgainstControl).factor == pytest.approx(scale, abs=5e-3)
    if scale == 0.5:
        assert check in identify(emps2015, spoilt, Prefilter(hold="zoh"), "idm-ls").verdict


@pytest.mark.parametrize("how", ["late", "coarse", "drifting", "noisy"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_what_a_current_loop_does_is_no_factor_and_a_factor_is_seen_through_it(
    emps2015: GeneratedAxis, how: str, seed: int
) -> None:
    record = twin_record(emps2015, seed=seed)
    force = measured(GAIN * record.control, how, np.random.default_rng(seed))
    assert force_check(emps2015, replace(record, force=force)).status == "pass"
    check = force_check(emps2015, replace(record, force=1.1 * force))
    assert check.status == "fail"
    finding = finding_of(check, ForceAgainstControl)
    assert finding.fault == "scale"
    assert finding.factor == pytest.approx(1.1, rel=0.01)
    assert finding.gain is not None
    assert finding.gain.fitting == pytest.approx(1.1 * GAIN, rel=0.01)


@pytest.mark.parametrize("how", ["late", "coarse", "drifting", "noisy", "nothing else"])
@pytest.mark.parametrize("share", [0.12, -0.12, 0.0])
def test_a_constant_beside_the_command_is_named_with_its_size(
    emps2015: GeneratedAxis, twin: Record, how: str, share: float, rng: np.random.Generator
) -> None:
    commanded = GAIN * twin.control
    force = measured(commanded, how, rng)
    offset = share * float(np.sqrt(np.mean(commanded**2)))
    check = force_check(emps2015, replace(twin, force=force + offset))
    assert check.status == ("fail" if share else "pass")
    if share:
        finding = finding_of(check, ForceAgainstControl)
        assert finding.fault == "offset"
        assert finding.offset == pytest.approx(offset, rel=0.1)


def test_what_a_gear_takes_and_masked_samples_are_no_factor(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """A load cell lacks the motor's share of inertia and friction: not a factor of the control."""
    commanded = GAIN * np.array(twin.control)
    lost = 0.06 * np.abs(commanded).mean() * np.sign(np.gradient(twin.position))
    assert force_check(emps2015, replace(twin, force=commanded - lost)).status == "pass"
    commanded[3000:3100] *= 0.5
    masked = replace(twin, force=commanded, masked=((2990, 3110),))
    assert force_check(emps2015, masked).status == "pass"


@pytest.mark.parametrize(
    ("scale", "noise", "measured_force", "status"),
    [
        (1.0, 0.0, False, "pass"),
        (1.0, 0.005, False, "pass"),
        (3.0, 0.0, False, "fail"),
        (3.0, 0.0, True, "note"),
    ],
)
def test_control_beyond_the_limit_is_told_with_its_share_but_for_a_converter_s_noise(
    emps2015: GeneratedAxis,
    twin: Record,
    rng: np.random.Generator,
    scale: float,
    noise: float,
    measured_force: bool,
    status: str,
) -> None:
    limit = 0.5 * float(np.abs(twin.control).max())
    low = build(replace(emps2015.axis, drive=replace(emps2015.axis.drive, limit=limit)))
    control = scale * np.clip(twin.control, -limit, limit)
    control += rng.normal(0, noise * limit, len(twin))
    force = GAIN * twin.control if measured_force else None
    check = limit_check(low, replace(twin, control=control, force=force))
    assert check.status == status
    share = 100 * np.mean(np.abs(control) > 1.02 * limit)
    assert check.figure == pytest.approx(share)
    finding = finding_of(check, ControlAgainstLimit)
    assert finding.share_percent == check.figure
    assert finding.is_beyond is (status != "pass")
    assert finding.has_force is measured_force


SIZE = 0.08  # m/s
COARSE = {"position_noise": 2e-5}


@pytest.fixture(scope="module")
def right(emps: GeneratedAxis) -> Record:
    return twin_record(emps, seed=3, velocity_noise=0.01 * SIZE, acceleration_noise=0.05)


def checked(axis: GeneratedAxis, record: Record, role: str = "velocity") -> Check:
    return derivative_check(axis, record, role, compared_motion(record, role))


def changed(record: Record, factor: float = 1.0, offset: float = 0.0) -> Record:
    return replace(record, velocity=factor * np.asarray(record.velocity) + offset)


@pytest.mark.parametrize("seed", range(1, 6))
def test_a_right_one_passes(emps: GeneratedAxis, seed: int) -> None:
    noise = {"velocity_noise": 0.01 * SIZE, "acceleration_noise": 0.05}
    for role, more in (("velocity", {}), ("acceleration", {}), ("velocity", COARSE)):
        check = checked(emps, twin_record(emps, seed=seed, **noise, **more), role)
        assert check.status == "pass", check.meaning


def test_factor_delay_and_offset_are_measured(right: Record) -> None:
    found = compared_motion(changed(right.shifted(velocity=2), 1.05, 0.004), "velocity")
    assert found.factor == pytest.approx(1.05, abs=3 * found.factor_deviation + 5e-4)
    assert found.delay == pytest.approx(2, abs=3 * found.delay_deviation)
    assert found.offset == pytest.approx(0.004, abs=3 * found.offset_deviation)
    *wrong, left = found.distances.values()
    assert min(wrong) > 1 > left


def test_part_of_a_sample_is_measured(emps: GeneratedAxis) -> None:
    record = twin_record(emps, velocity_noise=0.0)
    behind = np.gradient(record.position, record.period)  # central, so in time
    difference = np.concatenate([[0.0], np.diff(record.position) / record.period])
    for velocity, late in ((behind, 0.0), (difference, 0.5)):
        found = compared_motion(replace(record, velocity=velocity), "velocity")
        assert found.delay == pytest.approx(late, abs=0.01)


MINUS_THREE = AdvisedShift(role="velocity", samples=-3.0, is_whole=True)


def corrections(
    fault: ColumnFault,
    *,
    shift: AdvisedShift | None = None,
    unit: str | None = None,
    is_reversed: bool = False,
) -> ColumnCorrections:
    """Corrections of a column without a name."""
    return ColumnCorrections(
        column="NAME",
        faults=(fault,),
        shift=shift,
        likely_unit=unit,
        is_reversed=is_reversed,
        scale_reference="position",
    )


@pytest.mark.parametrize(
    ("factor", "late", "offset", "expected"),
    [
        (1.0, 3, 0.0, corrections("delay", shift=MINUS_THREE)),
        (1000.0, 0, 0.0, corrections("factor", unit="mm/s")),
        (-1.0, 0, 0.0, corrections("factor", is_reversed=True)),
        (1.0, 0, 0.005, corrections("offset")),
        (1.05, 0, 0.0, corrections("factor")),
    ],
)
def test_a_fault_of_a_column_has_its_correction(
    emps: GeneratedAxis,
    right: Record,
    factor: float,
    late: int,
    offset: float,
    expected: ColumnCorrections,
) -> None:
    check = checked(emps, changed(right.shifted(velocity=late), factor, offset))
    assert check.status == "fail"
    finding = finding_of(check, MeasuredMotion)
    assert finding.corrections == expected
    assert finding.factor == pytest.approx(factor, rel=2e-3)
    assert finding.delay == pytest.approx(late, abs=0.05)
    assert finding.offset == pytest.approx(offset, abs=2e-4 * abs(factor))
    assert (finding.is_wrong, finding.is_other_signal) == (True, False)
    assert finding.worst == check.figure


def test_a_column_that_holds_its_values_is_to_be_interpolated(
    emps: GeneratedAxis, right: Record
) -> None:
    held = np.repeat(np.asarray(right.velocity)[::8], 8)[: len(right)]
    finding = finding_of(checked(emps, replace(right, velocity=held)), MeasuredMotion)
    assert finding.corrections.faults == ("delay",)
    assert finding.corrections.shift is None


@pytest.mark.parametrize("what", ["control", "position", "noise", "walk", "constant"])
def test_another_signal_is_no_velocity(emps: GeneratedAxis, right: Record, what: str) -> None:
    noise = np.random.default_rng(1).normal(0, SIZE, len(right))
    others = {
        "control": right.control,
        "position": right.position,
        "noise": noise,
        "walk": np.cumsum(noise) / 30,
        "constant": 0.01 + 1e-9 * right.position,
    }
    check = checked(emps, replace(right, velocity=others[what]))
    assert check.status == "fail"
    finding = finding_of(check, MeasuredMotion)
    assert finding.is_other_signal
    assert finding.reference == "derivative of the position"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["emps", "belt_axis"])
@pytest.mark.parametrize(("factor", "offset"), [(1.0, 0.0), (1.05, 0.0), (0.98, 0.0), (1.0, 0.1)])
def test_a_wrong_scale_or_zero_of_a_velocity_alone_is_told(
    name: str, factor: float, offset: float
) -> None:
    axis = build(load_axis(name))
    record = twin_record(axis, velocity_noise=1e-4)
    moved = changed(record, factor, offset * float(np.ptp(record.velocity)))
    result = identify(axis, replace(moved, position=np.empty(0)), methods=["idm-ls"])
    right = factor == 1 and not offset
    check = checks_of(result)["measured velocity"]
    assert check.status == ("pass" if right else "fail")
    finding = finding_of(check, MeasuredMotion)
    assert finding.reference == "velocity of the simulated loop"
    assert finding.factor == pytest.approx(factor, abs=1e-3)
    assert finding.corrections.scale_reference == "reference"
    assert ("factor" in finding.corrections.faults) is (factor != 1)
