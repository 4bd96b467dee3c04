"""Many twins: the same numbers whoever runs them, and what they tell of a method."""

import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from axisid import build, fix, identify, load_axis, monte_carlo
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation import Chain, MonteCarlo
from axisid.estimation.monte_carlo.figures import Share
from axisid.estimation.monte_carlo.plan import DrawnChain, twins
from axisid.estimation.monte_carlo.runs import (
    INTERVALS,
    PARAMETER,
    BlockNumbers,
    Estimand,
    FailedRun,
    block_numbers,
)
from axisid.estimation.records.record import Record
from axisid.estimation.simulation.twin import twin_plan
from axisid.modeling.declaration import Move
from axisid.support.errors import EstimationError
from tests.estimation.monte_carlo.short import FILTER, MOVES, axis, study
from tests.refusals import refuses


@pytest.mark.slow
def test_numbers_are_the_same_in_any_blocks_and_threads() -> None:
    whole = study(3)
    assert study(3, block=2) == whole
    with ThreadPoolExecutor(2) as executor:
        assert study(3, block=1, executor=executor) == whole


@pytest.mark.slow
def test_numbers_are_the_same_in_processes() -> None:
    assert study(block=2, jobs=2) == study()


@pytest.mark.slow
def test_numbers_are_the_same_on_a_cluster_of_dask() -> None:
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=2, dashboard_address=None
        ) as local,
        distributed.Client(local) as client,
    ):
        assert study(block=2, executor=client.get_executor()) == study()


def test_more_runs_begin_with_the_same_ones() -> None:
    few = study(1, "idm-ls")
    assert np.array_equal(few.values, study(2, "idm-ls").values[:1])
    assert not np.array_equal(few.values, study(1, "idm-ls", seed=2).values)


def test_a_run_is_what_identify_makes_of_its_twin() -> None:
    made = study(2, "idm-iv", bootstrap=0)
    (_, record), *_ = twins(made.plan, [1])
    assert isinstance(record, Record)
    result = identify(axis(), record, FILTER, ["idm-iv"], bootstrap=0)
    values = [*result["idm-iv"].parameters.values()]
    sd = np.array([value.deviation for value in values])

    def near(found: Any, wanted: list[Any], in_deviations: float) -> None:
        apart = (np.asarray(found).T - np.array(wanted).T) / sd
        assert np.abs(apart).max() < in_deviations

    near(made.values[1], [value.value for value in values], 1e-6)
    near(made.corrected[1], [value.corrected for value in values], 1e-5)
    near(made.intervals("hac")[1], [value.interval for value in values], 1e-5)
    near(made.deviations("iid")[1], [value.sd for value in values], 1e-6)


def test_twins_of_the_first_runs_tell_the_bias_and_scale_of_all() -> None:
    plain, made = study(6, "idm-ls", bootstrap=0), study(6, "idm-ls")
    bias = made.values - made.corrected
    assert np.ptp(bias, axis=0) == pytest.approx(0.0, abs=1e-9)
    assert np.array_equal(made.values, plain.values)
    assert np.array_equal(plain.values, plain.corrected)
    scale = made.deviations("hac") / plain.deviations("hac")
    assert np.ptp(scale, axis=0) == pytest.approx(0.0, abs=1e-9)
    assert np.array_equal(made.deviations("iid"), plain.deviations("iid"))
    low, high = np.moveaxis(made.intervals("hac"), -1, 0)
    assert (low + high) / 2 == pytest.approx(made.corrected, rel=1e-9)
    (_, record), *_ = twins(made.plan, [0])
    assert isinstance(record, Record)
    alone = identify(axis(), record, FILTER, ["idm-ls"])["idm-ls"]
    deviations = np.sqrt(np.diag(alone.covariance))
    assert alone.filter_bias == pytest.approx(bias[0], abs=float(deviations.max()))


def test_a_twin_is_the_loop_under_its_own_noise() -> None:
    made = study(2)
    plan = twin_plan(made.plan.twin)
    (_, record), *_ = twins(made.plan, [1])
    drawn = DrawnChain(chain=made.plan.noise, seed=made.plan.seed, run=1)
    alone = plan.loop(drawn.position)
    assert np.array_equal(record.position, alone.measured_position)
    assert np.array_equal(record.control, alone.control)


def test_a_disturbance_acts_and_is_not_in_the_record() -> None:
    quiet, moved = (
        next(iter(twins(study(1, "idm-ls", noise=noise).plan, [0])))[1]
        for noise in (Chain(), Chain(disturbances=((0.0, 0.2),)))
    )
    answered = moved.control - quiet.control
    assert 0 < answered.std() < 0.1  # the law's answer, not the disturbance
    assert np.abs(moved.position - quiet.position).max() > 0


def numbers(values: np.ndarray[Any, Any], half: float) -> MonteCarlo:
    """A study whose estimates of one parameter are given, with intervals of a half width."""
    plan = replace(study(1, "idm-ls").plan, methods=("idm-iv",))
    block = np.full((len(values), 1, 2 + 3 * len(INTERVALS)), np.nan)
    block[:, 0, 0] = block[:, 0, 1] = values
    block[:, 0, 2:5] = np.column_stack([np.full(len(values), 1.0), values - half, values + half])
    made = BlockNumbers(
        runs=np.arange(len(values)),
        estimands=(Estimand("idm-iv", "M", PARAMETER, "kg"),),
        numbers=block,
        checks=("precision",),
        statuses=np.array([[2], [0], [-1], [-1]], dtype=np.int8)[: len(values)],
        judged=np.array([True, True, False, False])[: len(values)],
        failures=(FailedRun(run=3, of="idm-iv", reason="singular"),),
    )
    return MonteCarlo(plan=plan, numbers=made)


def test_bias_scatter_and_coverage_are_those_of_the_numbers() -> None:
    truth = 100.2
    made = numbers(truth + np.array([-1.0, 0.5, 2.5, np.nan]), half=2.0)
    figures = made.of("idm-iv", "M")
    assert figures.runs == 3
    assert figures.bias.value == pytest.approx(2 / 3)
    assert figures.bias.error == pytest.approx(figures.scatter.value / np.sqrt(3))
    assert figures.scatter.value == pytest.approx(np.std([-1.0, 0.5, 2.5], ddof=1))
    assert figures.coverage == {"hac": Share(2, 3)}
    assert figures.deviations == {"hac": 1.0}
    assert made.status(0) == "ok"
    assert (made.status(3), made.reason(3)) == ("failed", "idm-iv: singular")
    assert made.lost == {"idm-iv": {"singular": 1}}
    assert made.estimated("idm-iv") == Share(3, 4)
    (check,) = made.check_figures
    assert (check.fails, check.passes, check.missing) == (Share(1, 2), Share(1, 2), Share(0, 2))
    assert made.objected == Share(1, 2)
    assert {check.name: check.status for check in made.checks}["runs"] == "fail"
    assert made.belief == "with care"


def test_bias_of_few_runs_is_judged_by_students_law() -> None:
    few = numbers(100.2 + np.array([1.0, 1.3, 0.9, 1.2]), half=2.0)  # 12 standard errors
    assert few.biased == few.figures
    unsure = numbers(100.2 + np.array([1.0, 2.4, 0.6, 1.6]), half=2.0)  # 3.6, of 9.2 for so few
    assert unsure.figures[0].bias.value > 3 * unsure.figures[0].bias.error
    assert unsure.biased == ()
    assert numbers(np.full(4, 100.2 * (1 + 1e-15)), half=2.0).biased == ()
    certain = numbers(np.full(4, 100.7), half=2.0)  # the same error in every run
    assert certain.biased == certain.figures


def test_the_more_intervals_there_are_the_further_one_must_be_off() -> None:
    right, wrong = np.full(100, 0.0), np.where(np.arange(100) < 10, 3.0, 0.0)  # 90 % hold
    alone = numbers(100.2 + wrong, half=2.0)
    assert alone.miscovered(narrow=True) == alone.figures
    assert alone.miscovered(narrow=False) == ()
    block = alone.numbers
    others = tuple(Estimand("idm-iv", "M", PARAMETER, f"{i}") for i in range(9))
    whole = np.concatenate(
        [block.numbers, *[numbers(100.2 + right, half=2.0).numbers.numbers] * 9], 1
    )
    many = replace(
        alone, numbers=replace(block, estimands=(*block.estimands, *others), numbers=whole)
    )
    assert many.miscovered(narrow=True) == ()


@pytest.mark.slow
def test_what_one_method_refuses_costs_the_others_nothing() -> None:
    crank = build(load_axis("crank"))
    made = monte_carlo(crank, 1, ["ddm-ls", "idm-ls"], moves=MOVES, checks=0)
    assert made.statuses == ("partly",)
    assert {each.method for each in made.estimands} == {"idm-ls"}
    assert "direct regressor" in made.reason(0)


def test_another_axis_may_be_simulated_than_is_identified(emps: GeneratedAxis) -> None:
    made = monte_carlo(emps, 1, "idm-ls", twin=axis(), moves=MOVES, prefilter=FILTER)
    assert not made.plan.is_right
    assert made.of("idm-ls", "M").truth == 100.2
    (offset,) = (each for each in made if each.name not in axis().names)
    assert np.isnan(offset.truth)  # the twin has none
    assert offset.runs == 1
    assert offset.coverage == {}


def test_a_known_value_that_all_runs_share_has_no_coverage_and_may_be_wrong() -> None:
    def known(**values: Any) -> MonteCarlo:
        fixed = build(fix(load_axis("emps2015"), **values))
        return monte_carlo(fixed, 1, "idm-ls", moves=MOVES, prefilter=FILTER)

    unsure = known(M=(100.2, 0.5))
    kinds = {each.kind: each.coverage for each in unsure}
    assert kinds["physical"] == {}
    assert kinds["parameter"]
    assert unsure.plan.is_right
    assert known(M=100.2).plan.is_right
    assert not known(M=90.0).plan.is_right


def test_other_true_values_are_simulated() -> None:
    made = study(1, "idm-ls", truth={"M": 150.0})
    assert made.of("idm-ls", "M").truth == 150.0
    assert made.values[0, 0] == pytest.approx(150.0, rel=0.05)


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ({"runs": 0}, "study"),
        ({"runs": "3"}, "study"),
        ({"keep": 3}, "study"),
        ({"seed": -1}, "study"),
        ({"checks": 1.5}, "study"),
        ({"methods": "ols"}, "method"),
        ({"methods": ()}, "method"),
        ({"noise": 1e-6}, "noise"),
        ({"noise": Chain(anywhere=True)}, "study"),
        ({"noise": Chain(jitter=1e-5)}, "study"),
        ({"noise": Chain(is_measured_by_law=False)}, "study"),
        ({"truth": {"m": 1.0}}, "twin"),
        ({"truth": {"M": "heavy"}}, "axis"),
        ({"truth": 3}, "twin"),
        ({"moves": 3}, "axis"),
        ({"moves": "far"}, "axis"),
        ({"moves": [Move(distance=1e-9, speed=0.05, acceleration=0.75)]}, "too-short"),
        ({"runs": 10**9}, "study"),
        ({"prefilter": 60.0}, "filter"),
        ({"covariance": "ols"}, "method"),
        ({"start": "far"}, "method"),
        ({"loss": "l1"}, "method"),
        ({"jobs": 0}, "study"),
        ({"jobs": 2, "executor": ThreadPoolExecutor(1)}, "study"),
        ({"executor": "dask"}, "study"),
    ],
)
def test_what_makes_no_sense_is_refused(given: dict[str, Any], code: str) -> None:
    with refuses(code):
        study(**given)


def test_a_disturbance_that_the_drive_would_log_is_refused() -> None:
    declared = axis().axis
    logging = replace(declared, drive=replace(declared.drive, delay=1e-3, logged="applied"))
    with refuses("study"):
        study(1, twin=logging, noise=Chain(disturbances=((0.0, 0.1),)))


def test_a_study_of_which_nothing_comes_says_why() -> None:
    with pytest.raises(EstimationError) as refused:
        study(2, truth={"M": -1.0})
    assert refused.value.code == "no-twin-identified"
    assert "simulation" in str(refused.value)


@pytest.mark.parametrize("methods", ["idm-iv", "fit:control"])
def test_a_study_in_which_nothing_moves_says_so(methods: str) -> None:
    with refuses("no-twin-identified", says="does not move with .* Fc = 100000 N"):
        study(2, methods, truth={"Fc": 1e5})


def test_what_is_done_is_kept_when_a_study_is_interrupted() -> None:
    kept: list[MonteCarlo] = []

    def interrupt(done: int, total: int, what: str) -> None:
        if done >= 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        study(4, "idm-ls", block=1, progress=interrupt, keep=kept.append)
    (partial,) = kept
    assert len(partial) == 2
    assert np.array_equal(partial.values, study(2, "idm-ls").values)


def test_what_is_done_is_kept_whatever_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    module = sys.modules["axisid.estimation.monte_carlo.monte_carlo"]

    def failing(plan: Any, block: range, threads: int | None = None) -> BlockNumbers:
        if block.start:
            raise MemoryError
        return block_numbers(plan, block, threads)

    monkeypatch.setattr(module, "block_numbers", failing)
    kept: list[MonteCarlo] = []
    with refuses("study"):
        study(2, "idm-ls", block=1, keep=kept.append)
    assert [len(partial) for partial in kept] == [1]
