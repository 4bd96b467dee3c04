"""Several records are one set of parameters, in any order, each filtered, weighted and checked."""

import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from axisid import (
    DataError,
    Identification,
    Prefilter,
    Record,
    UsageError,
    build,
    fit,
    leave_out,
    load_axis,
    twin_record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation.diagnostics.overlapping_records import RepeatedSamples
from axisid.estimation.findings import FindingOfRecords
from axisid.estimation.identification import filtered_records
from axisid.estimation.identification.joint_records import prefilters_of
from axisid.estimation.output_error import OutputFit
from axisid.estimation.records.record import record_labels
from tests.axes.stage import TRUTH, generated, stage, stage_record
from tests.refusals import refuses
from tests.unjudged import identify
from tests.verdicts import checks_of, finding_of, meaning_of, statuses

METHOD = ["idm-iv"]


@pytest.fixture(scope="module")
def plain():  # type: ignore[no-untyped-def]
    return build(leave_out(stage(), "tau0", "m_add"))


@pytest.fixture(scope="module")
def three() -> list[Record]:
    return [stage_record(seed) for seed in (1, 2, 3)]


@pytest.fixture(scope="module")
def loaded() -> Identification:
    gain = 35.15 * 1.02
    records = [
        stage_record(seed, gain, m_add=m, tau0=t)
        for seed, m, t in ((1, 0.0, 3.0), (2, 20.0, -5.0), (3, 20.0, 7.0))
    ]
    known = {"m_add": [0.0, (20.0, 0.01), (20.0, 0.01)]}
    return identify(generated(), records, known=known, local="tau0")


@pytest.mark.parametrize(
    "periods", [(1e-3, 2e-3), (1e-3, 1.5e-3), (1 / 300, 1 / 500, 3e-3), (2e-3, 5e-4)]
)
def test_rows_are_as_far_apart_in_all_records(periods: tuple[float, ...]) -> None:
    asked = Prefilter(cutoff=40.0, decimate=10)
    found = prefilters_of(asked, periods[0], periods)
    apart = [f.decimate * period for f, period in zip(found, periods, strict=True)]
    assert apart == pytest.approx([apart[0]] * len(apart), rel=1e-9)
    assert 0.5 * 10 * periods[0] <= apart[0] <= 2 * 10 * periods[0]
    assert {f.cutoff for f in found} == {40.0}
    assert prefilters_of(asked, 1e-3, [1e-3, 1.0000001e-3]) == [asked, asked]
    with refuses("parameters"):
        prefilters_of(asked, periods[0], [periods[0], 1.0137 * periods[0]])


@pytest.mark.slow
def test_three_records_agree_with_each_and_are_more_precise(plain, three) -> None:  # type: ignore[no-untyped-def]
    together = identify(plain, three)
    assert set(together.estimates) == {"idm-ls", "ddm-ls", "idm-iv", "ddm-iv", "didim"}
    alone = [identify(plain, record, methods=METHOD) for record in three]
    for name in ("M", "Fv", "Fc"):
        value = together["idm-iv"].parameters[name]
        assert value.corrected == pytest.approx(TRUTH[name], abs=4 * value.deviation)
        every = [one["idm-iv"].parameters[name] for one in alone]
        assert min(v.value for v in every) <= value.value <= max(v.value for v in every)
        assert value.sd == pytest.approx(np.mean([v.sd for v in every]) / np.sqrt(3), rel=0.1)
    assert len(together["idm-iv"].y) == sum(len(one["idm-iv"].y) for one in alone)


@pytest.mark.slow
def test_a_record_given_twice_halves_the_variance_and_is_told(plain, three) -> None:  # type: ignore[no-untyped-def]
    once, twice = (identify(plain, [three[0]] * n, methods=METHOD, bootstrap=0) for n in (1, 2))
    assert once.preferred.physical == pytest.approx(twice.preferred.physical, rel=1e-10)
    for name in ("iid", "hac"):
        ratio = twice["idm-iv"].covariances[name] / once["idm-iv"].covariances[name]
        # But for n - k of 714 and of 1428 rows, and for the lags.
        assert np.diag(ratio) == pytest.approx(0.5, rel=0.05 if name == "iid" else 0.3)
    assert "repeated records" not in statuses(once)
    check = checks_of(twice)["repeated records"]
    assert check.status == "fail"
    (pair,) = finding_of(check, RepeatedSamples).pairs
    assert pair.names == ("run 1 (record 1)", "run 1 (record 2)")
    assert pair.samples == len(three[0])


@pytest.mark.slow
def test_records_are_weighted_by_their_noise_which_pays(plain) -> None:  # type: ignore[no-untyped-def]
    quiet = stage_record(1)
    rng = np.random.default_rng(0)
    noisy = replace(quiet, control=quiet.control + rng.normal(0, 1.0, len(quiet)))
    result = identify(plain, [quiet, noisy], methods=METHOD)
    (first, second) = result.of_records
    assert first.weight / second.weight == pytest.approx(second.noise / first.noise, rel=0.1)
    assert second.noise > 1.5 * first.noise
    alone, worst = (identify(plain, each, methods=METHOD) for each in (quiet, noisy))
    both, alone, worst = (r["idm-iv"].parameters["M"].sd for r in (result, alone, worst))
    assert both < alone < worst
    assert "weights" in result.summary(every=True)


@pytest.mark.slow
def test_a_known_payload_tells_the_drive_gain_beside_a_value_in_each_record(
    loaded: Identification,
) -> None:
    assert list(loaded.local) == ["tau0"]
    for value, offset in zip(loaded.local["tau0"], (3.0, -5.0, 7.0), strict=True):
        assert value.value == pytest.approx(offset, abs=4 * value.deviation)
        assert 0 < value.deviation < 0.1
    output_error = loaded["didim"].parameters["drive_gain"]
    assert abs(output_error.value - 35.15 * 1.02) < 3 * output_error.deviation
    values, truth = loaded["idm-iv"].parameters, {**TRUTH, "drive_gain": 35.15 * 1.02}
    for name in ("M", "Fv", "Fc", "drive_gain"):
        assert values[name].value == pytest.approx(truth[name], abs=3 * values[name].deviation)
    assert values["drive_gain"].unit == "N/V"
    # The mass is known no better than the gain that it is in.
    mass, gain = (values[n].deviation / values[n].value for n in ("M", "drive_gain"))
    assert mass == pytest.approx(gain, rel=0.3)
    assert gain < 0.006
    assert statuses(loaded)["drive gain"] == "note"


@pytest.mark.slow
def test_a_gain_of_the_other_sign_is_a_known_value_of_another_record() -> None:
    records, known = [stage_record(1), stage_record(2, m_add=20.0)], {"m_add": [20.0, 0.0]}
    result = identify(generated(), records, methods="idm-ls", known=known, bootstrap=0)
    assert "in the order of the records" in meaning_of(result, "drive gain")


@pytest.mark.slow
def test_a_deviation_of_what_is_known_is_in_those_of_the_parameters() -> None:
    """And the declared gain can be believed, in which they are not then."""
    records = [stage_record(1), stage_record(2, m_add=20.0)]
    exact, vague, believed = (
        identify(
            generated(), records, methods=METHOD, known={"m_add": [0.0, (20.0, sd)]}, gain=gain
        )
        for sd, gain in ((0.0, "identified"), (0.4, "identified"), (0.0, "declared"))
    )
    first, second = (r["idm-iv"].parameters["drive_gain"] for r in (exact, vague))
    # 2 % of the payload are 2 % of the gain.
    added = np.sqrt(second.deviation**2 - first.deviation**2)
    assert added / second.value == pytest.approx(0.02, rel=0.05)
    assert first.value == second.value
    assert "drive_gain" not in believed["idm-iv"].parameters
    mass = believed["idm-iv"].parameters["M"]
    assert mass.value == pytest.approx(TRUTH["M"], abs=4 * mass.deviation)
    assert mass.deviation < 0.001 * mass.value
    with refuses("method", says="Choose from identified, declared"):
        identify(generated(), records, gain="mine")


@pytest.mark.slow
def test_each_record_has_a_part_that_is_judged_and_drawn_by_itself(loaded: Identification) -> None:
    every = zip(loaded.parts, loaded.records, loaded.of_records, strict=True)
    for part, record, of_one in every:
        estimate = part["idm-iv"]
        assert (part.record, len(estimate.y)) == (record, of_one.rows)
        left = estimate.y - estimate.X @ estimate.physical
        np.testing.assert_allclose(left, estimate.residuals, atol=1e-9)
        assert part.plot("force") is not None
    assert loaded.plot("record", record=3) is not None
    with pytest.raises(UsageError, match="3, numbered from 1"):
        loaded.plot("record", record=4)


@pytest.mark.slow
def test_the_gains_of_the_law_may_differ(plain) -> None:  # type: ignore[no-untyped-def]
    records = [twin_record(plain), twin_record(plain.with_gains({"kp": 120.0}))]
    right = identify(plain, records, methods=METHOD, known={"kp": [160.18, 120.0]})
    wrong = identify(plain, records, methods=METHOD)
    one, other = (checks_of(r)["control law"] for r in (right, wrong))
    assert (one.status, other.status) == ("pass", "fail")
    assert isinstance(other.finding, FindingOfRecords)
    assert other.finding.records == (record_labels(records)[1],)
    assert right["idm-iv"].parameters["M"].value == pytest.approx(TRUTH["M"], rel=0.002)


@pytest.mark.slow
def test_records_may_differ_in_period_and_length(plain) -> None:  # type: ignore[no-untyped-def]
    whole = stage_record(1)
    columns = whole.channels().items()
    half = Record(**{role: values[: len(whole) // 4 * 2 : 2] for role, values in columns})
    result = identify(plain, [whole, half], methods=["idm-ls"])
    assert [d.prefilter.decimate for d in result.problem.data] == [10, 5]
    assert result.preferred.parameters["M"].value == pytest.approx(TRUTH["M"], rel=0.01)


@pytest.mark.slow
def test_records_that_cannot_be_used_are_named_all_at_once_and_can_be_skipped(plain) -> None:  # type: ignore[no-untyped-def]
    good = [stage_record(1), stage_record(2)]
    short = {role: values[:60] for role, values in good[0].channels().items()}
    bad = Record(**short, provenance=replace(good[0].provenance, source="short"))
    with pytest.raises(DataError, match=r"1 of 3 records cannot be used: short.*skip_bad=True"):
        identify(plain, [good[0], bad, good[1]], methods=METHOD)
    result = identify(plain, [good[0], bad, good[1]], methods=METHOD, skip_bad=True)
    assert list(result.set_aside) == ["short"]
    assert result.preferred == identify(plain, good, methods=METHOD).preferred
    assert "1 record: short" in result.summary(every=True)
    for refused, given in (("2 of 2", [bad, bad]), ("no record is given", [])):
        with pytest.raises((DataError, UsageError), match=refused):
            identify(plain, given, methods=METHOD, skip_bad=True)
    one = identify(generated(), [good[0], bad], methods=["idm-ls"], local="tau0", skip_bad=True)
    assert "tau0" in one["idm-ls"].parameters


def test_what_rests_in_one_record_rests_in_all(plain) -> None:  # type: ignore[no-untyped-def]
    fast = stage_record(1)
    slow = replace(fast, position=1e-3 * fast.position, reference=1e-3 * fast.reference)
    alone, beside = (
        identify(plain, records, Prefilter(reversals="leave-out"), ["idm-ls"])
        for records in (slow, [fast, slow])
    )
    assert beside.problem.data[1].fastest == beside.problem.data[0].fastest > 0
    assert beside.problem.data[1].sampling.used.sum() < 0.2 * alone.data.sampling.used.sum()


def test_reversals_are_left_out_of_all_records_where_all_together_show_enough(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    short, long = twin.windowed((0.2, 0.9)), twin.windowed((2.0, 5.0))

    def left_out(*records: Record) -> list[bool]:
        bound = filtered_records([emps2015] * len(records), records, Prefilter())
        return [bool(data.excluded) for data in bound]

    assert left_out(short) == [False]  # hardly shows the mass without them
    assert left_out(long) == [True]
    assert left_out(short, long) == left_out(long, short) == [True, True]
    assert left_out(short, short) == [False, False]


@pytest.mark.slow
@pytest.mark.parametrize("by", [identify, fit, partial(fit, output="open-loop")])
def test_a_record_without_motion_costs_no_estimate(
    plain: GeneratedAxis,
    three: list[Record],
    by: Callable[[GeneratedAxis, list[Record]], Identification | OutputFit],
    rng: np.random.Generator,
) -> None:
    samples = len(three[0])
    still = replace(
        three[0],
        position=1e-6 * rng.normal(size=samples),
        control=1e-3 * rng.normal(size=samples),
        reference=np.where(np.arange(samples) < samples - 10, 0.0, 1e-6),
    )
    result = by(plain, [three[1], still])
    assert "nan" not in result.summary()
    assert not any("fault" in check.meaning for check in result.checks)
    assert json.dumps(result.to_dict(), allow_nan=False)


@pytest.mark.slow
@pytest.mark.parametrize(("by", "within"), [(identify, 1e-9), (fit, 1e-5)])
def test_estimates_deviations_and_checks_are_the_same_in_any_order(
    by: Callable[..., Identification | OutputFit], within: float
) -> None:
    """Of noise that shakes the axis, so that loops with such noise are drawn."""
    axis, found, statuses = build(load_axis("pendulum")), [], []
    records = [
        replace(made, provenance=replace(made.provenance, source=f"run {seed}"))
        for seed in (1, 3)
        for made in [twin_record(axis, seed=seed, position_noise=seed * 1e-4)]
    ]
    for given in (records, records[::-1]):
        result = by(axis, given)
        every = result.estimates.values() if isinstance(result, Identification) else [result]
        values = [v for each in every for v in each.parameters.values()]
        found.append([x for v in values for x in (v.value, v.deviation)])
        statuses.append([(check.name, check.status) for check in result.checks])
    assert found[1] == pytest.approx(found[0], rel=within)
    assert statuses[0] == statuses[1]
