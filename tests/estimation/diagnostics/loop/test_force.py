"""A force column beside a control, and a control beside its limit: what does not fit is named."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from axisid import Prefilter, Record, build, identify, load_axis, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.diagnostics.loop.column_comparison import force_check, limit_check

GAIN = 35.15


def measured(commanded: np.ndarray, how: str, rng: np.random.Generator) -> np.ndarray:
    """What a current sensor makes of a commanded force: late, coarse, noisy."""
    rms = float(np.sqrt(np.mean(commanded**2)))
    if how == "late":
        pole = np.exp(-1e-3 / 2e-3)  # a lag of 2 ms
        return lfilter([1 - pole], [1, -pole], commanded, zi=[pole * commanded[0]])[0]
    if how == "coarse":
        step = 0.01 * np.abs(commanded).max()
        return step * np.round(commanded / step)
    if how == "drifting":
        slow = lfilter([1], [1, -0.98], rng.normal(0.0, 1.0, len(commanded)))
        return commanded + 0.05 * rms * slow / np.sqrt(np.mean(slow**2))
    return commanded + 0.1 * rms * rng.normal(0.0, 1.0, len(commanded))


@pytest.mark.parametrize(
    ("scale", "shift", "status"),
    [(1.0, 0, "pass"), (0.5, 0, "fail"), (-1.0, 0, "fail"), (1, 9, "fail")],
)
def test_scale_sign_and_time_are_seen(
    emps2015: GeneratedAxis, twin: Record, scale: float, shift: int, status: str
) -> None:
    force = np.roll(scale * 35.15 * twin.control, shift)
    check = force_check(emps2015, replace(twin, force=force))
    assert check.status == status
    if status == "fail":
        assert f"{scale:.3g} times" in check.meaning or shift


def test_it_stands_in_the_verdict(emps2015: GeneratedAxis, twin: Record) -> None:
    halved = replace(twin, force=0.5 * 35.15 * twin.control)
    checks = identify(emps2015, halved, Prefilter(hold="zoh"), "idm-ls").verdict
    assert [c.status for c in checks if c.name == "force against control"] == ["fail"]


@pytest.mark.parametrize("how", ["late", "coarse", "drifting", "noisy"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_what_a_current_loop_does_is_no_factor_and_a_factor_is_seen_through_it(
    emps2015: GeneratedAxis, how: str, seed: int
) -> None:
    record = twin_record(emps2015, seed=seed)
    force = measured(GAIN * record.control, how, np.random.default_rng(seed))
    statuses = {}
    for scale in (1.0, 1.1):
        check = force_check(emps2015, replace(record, force=scale * force))
        statuses[scale] = check.status
    assert statuses == {1.0: "pass", 1.1: "fail"}
    scale = float(check.meaning.split("the force column is ")[1].split()[0])
    assert scale == pytest.approx(1.1, rel=0.01)
    assert "scaled by it" in check.meaning


@pytest.mark.parametrize("how", ["late", "coarse", "drifting", "noisy", "nothing else"])
@pytest.mark.parametrize("share", [0.12, -0.12, 0.0])
def test_a_constant_beside_the_command_is_named_with_its_size(
    emps2015: GeneratedAxis, twin: Record, how: str, share: float, rng: np.random.Generator
) -> None:
    commanded = GAIN * twin.control
    force = commanded if how == "nothing else" else measured(commanded, how, rng)
    offset = share * float(np.sqrt(np.mean(commanded**2)))
    check = force_check(emps2015, replace(twin, force=force + offset))
    assert check.status == ("fail" if share else "pass")
    if share:
        said = check.meaning.split("the force column is ")[1]
        assert float(said.split()[0]) == pytest.approx(offset, rel=0.1)
        assert "Check the zero of the force's sensor" in said


def test_a_force_behind_a_gear_is_no_factor(emps2015: GeneratedAxis, twin: Record) -> None:
    """A load cell lacks the motor's share of inertia and friction: not a factor of the control."""
    commanded = GAIN * twin.control
    speed = np.gradient(twin.position, 1e-3)
    lost = 0.06 * np.abs(commanded).mean() * np.sign(speed)
    check = force_check(emps2015, replace(twin, force=commanded - lost))
    assert check.status == "pass"


def test_masked_samples_say_nothing_of_the_factor(emps2015: GeneratedAxis, twin: Record) -> None:
    force = GAIN * np.array(twin.control)
    force[3000:3100] *= 0.5
    masked = replace(twin, force=force, masked=((2990, 3110),))
    check = force_check(emps2015, masked)
    assert check.status == "pass"


@pytest.mark.parametrize(
    ("scale", "measured_force", "status"),
    [(1.0, False, "pass"), (3.0, False, "fail"), (3.0, True, "note")],
)
def test_control_beyond_the_limit_is_told_with_its_share(
    twin: Record, scale: float, measured_force: bool, status: str
) -> None:
    axis = load_axis("emps2015")
    low = build(replace(axis, drive=replace(axis.drive, limit=float(np.abs(twin.control).max()))))
    force = GAIN * twin.control if measured_force else None
    record = replace(twin, control=scale * twin.control, force=force)
    check = limit_check(low, record)
    assert check.status == status
    if status != "pass":
        share = np.mean(np.abs(scale * twin.control) > 1.02 * low.axis.drive.limit)
        assert check.figure == pytest.approx(100 * share)
        assert f"in {100 * share:.2g} % of" in check.meaning


def test_a_converter_s_noise_at_the_limit_is_not_beyond_it(
    twin: Record, rng: np.random.Generator
) -> None:
    axis = load_axis("emps2015")
    limit = 0.5 * float(np.abs(twin.control).max())
    low = build(replace(axis, drive=replace(axis.drive, limit=limit)))
    clipped = np.clip(twin.control, -limit, limit) + rng.normal(0, 0.005 * limit, len(twin))
    check = limit_check(low, replace(twin, control=clipped))
    assert check.status == "pass"
