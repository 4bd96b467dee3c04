"""A record's period is the declared law's, or the verdict says so; right logs raise no alarm."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from axisid import Record, identify, read_record, validate
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation import Repairs
from axisid.estimation.diagnostics.law.control_law import LawCheck, check_law
from axisid.support.errors import Missing
from tests.refusals import refuses


def in_words(check: LawCheck | Missing) -> str:
    """Whether a check failed, and what it says."""
    if isinstance(check, Missing):
        return f"not evaluated: {check}"
    return f"{'passed' if check.passed else 'failed'}: {check.sentence}"


def timed(record: Record, factor: float, **changes: Any) -> Record:
    """The record without its reference, by another clock."""
    changes = {"sample_period": None, "reference": None} | changes
    return replace(record, time=factor * record.time, **changes)


@pytest.mark.parametrize("factor", [0.5, 0.999, 0.9996, 1.0, 1.0004, 1.0006, 1000.0])
def test_other_time_fails_without_a_reference_but_crystals_may_differ(
    emps2015: GeneratedAxis, twin: Record, factor: float
) -> None:
    said = in_words(check_law(emps2015, timed(twin, factor)))
    if abs(factor - 1) < 5e-4:
        assert "not evaluated: " in said
        return
    assert said.startswith(f"failed: the record is sampled every {factor * 1e-3:.6g} s")
    assert "check the time column and its unit" in said


def test_every_result_fails_by_another_time(emps2015: GeneratedAxis, twin: Record) -> None:
    result = identify(emps2015, timed(twin, 1.05), methods=["idm-ls"])
    (check,) = (c for c in result.verdict if c.name == "control law")
    assert check.status == "fail"
    right = identify(emps2015, twin, methods=["idm-ls"])
    validated = validate(right, timed(twin, 1.05))
    assert "believe nothing before this is mended: the record is sampled" in "; ".join(
        map(str, validated.notes)
    )
    assert validated.to_dict()["time_base"]
    assert validate(right, twin).to_dict()["time_base"] is None


def test_confirmation_is_that_of_the_log_that_was_read(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    read = read_record(twin.channels(), emps2015, sample_period=1e-3)
    changed = replace(read, time=1.05 * read.time, sample_period=None)
    assert in_words(check_law(emps2015, changed)).startswith("failed")


def test_resampling_hides_no_other_time(emps2015: GeneratedAxis, twin: Record) -> None:
    slower = timed(twin, 2.0).channels()
    asked = Repairs(resample=1000.0)
    said = in_words(check_law(emps2015, read_record(slower, emps2015, repairs=asked)))
    assert said.startswith("failed: the record is sampled every 0.002 s")
    confirmed = read_record(slower, emps2015, sample_period=2e-3, repairs=asked)
    assert in_words(check_law(emps2015, confirmed)).startswith("not evaluated")
    with refuses("time", says=r"0\.003 s, but the time column steps by 0\.002"):
        read_record(slower, emps2015, sample_period=3e-3, repairs=asked)
    finer = read_record(twin.channels(), emps2015, repairs=Repairs(resample=2000.0))
    assert in_words(check_law(emps2015, finer)) == (
        "not evaluated: the record was resampled at 2000 Hz, the control law runs at 1000 Hz"
    )
    with refuses("loop-period", says=r"resampled every 0\.0005 s"):
        identify(emps2015, finer, methods=["idm-iv"])


@pytest.mark.parametrize("jitter", [0.0, 0.1, 0.3])
@pytest.mark.parametrize("rows", [300, 7801])
def test_jitter_and_lost_samples_are_no_other_time(
    emps2015: GeneratedAxis, twin: Record, rng: np.random.Generator, jitter: float, rows: int
) -> None:
    time = twin.time + 1e-3 * rng.uniform(-jitter, jitter, len(twin))
    kept = np.flatnonzero(rng.random(rows) > 0.03)
    uneven = {role: values[kept] for role, values in (twin.channels() | {"time": time}).items()}
    for factor, status in ((1.0, "passed"), (1.05, "failed: the record is sampled")):
        log = uneven | {"time": factor * uneven["time"]}
        record = read_record(log, emps2015, repairs=Repairs(resample="auto", gaps="split"))
        said = in_words(check_law(emps2015, record))
        assert said.startswith(status) or (status == "passed" and "is sampled" not in said)
