"""Many twins: the same numbers whoever runs them, their noise, figures and files."""

import json
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
from pyarrow.parquet import read_schema as parquet_schema
from statsmodels.stats.proportion import proportion_confint

from axisid import (
    EstimationError,
    build,
    fit,
    fix,
    load_axis,
    monte_carlo,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation import Chain, MonteCarlo
from axisid.estimation.monte_carlo import (
    COLOURED,
    declared_chain,
    declared_figures,
    drawn_twin,
    runs,
)
from axisid.estimation.monte_carlo.drawn_twins import twins
from axisid.estimation.monte_carlo.run_files import write_runs
from axisid.estimation.monte_carlo.runs import (
    INTERVALS,
    PARAMETER,
    BlockNumbers,
    Estimand,
    FailedRun,
    block_numbers,
)
from axisid.estimation.monte_carlo.study_statistics import Mean, Share
from axisid.estimation.records import Record
from axisid.estimation.simulation.twin import twin_plan
from axisid.modeling.declaration import Move, back_and_forth
from tests.estimation.monte_carlo.short import FILTER, MOVES, axis, judged, study
from tests.refusals import refuses
from tests.unjudged import identify

#: Long enough to tell three parameters.
LONG_MOVES = back_and_forth(speeds=(0.1, 0.3), acceleration=1.5, seconds=0.3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("methods", "how"),
    [
        (("idm-ls", "idm-iv"), {}),
        (("idm-ls", "fit:control", "fit:position"), {"moves": LONG_MOVES, "checks": 1}),
    ],
)
def test_numbers_are_the_same_in_any_blocks_threads_and_processes(
    methods: tuple[str, ...], how: dict[str, Any]
) -> None:
    whole = study(3, methods, **how)
    assert study(3, methods, block=2, jobs=2, **how) == whole
    with ThreadPoolExecutor(2) as executor:
        assert study(3, methods, block=1, executor=executor, **how) == whole


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


def test_a_run_is_what_identify_makes_of_its_twin() -> None:
    made = study(2, "idm-iv", bootstrap=0)
    (_, record), *_ = twins(made.plan, [1])
    result = identify(axis(), record, FILTER, ["idm-iv"], bootstrap=0)
    values = [*result["idm-iv"].parameters.values()]
    sd = np.array([value.deviation for value in values])

    for found, wanted in (
        (made.values, [value.value for value in values]),
        (made.corrected, [value.corrected for value in values]),
        (made.intervals("hac"), [value.interval for value in values]),
        (made.deviations("iid"), [value.sd for value in values]),
    ):
        assert np.abs((found[1].T - np.array(wanted).T) / sd).max() < 1e-5


@pytest.mark.slow
def test_twins_of_the_first_runs_tell_the_bias_and_scale_of_all() -> None:
    plain, made = study(6, "idm-ls", bootstrap=0), study(6, "idm-ls")
    bias, scale = made.values - made.corrected, made.deviations("hac") / plain.deviations("hac")
    assert np.ptp([bias, scale], axis=1) == pytest.approx(0.0, abs=1e-9)
    assert np.array_equal(made.values, plain.values)
    assert np.array_equal(plain.values, plain.corrected)
    assert np.array_equal(made.deviations("iid"), plain.deviations("iid"))
    low, high = np.moveaxis(made.intervals("hac"), -1, 0)
    assert (low + high) / 2 == pytest.approx(made.corrected, rel=1e-9)
    (_, record), *_ = twins(made.plan, [0])
    alone = identify(axis(), record, FILTER, ["idm-ls"])["idm-ls"]
    deviations = np.sqrt(np.diag(alone.covariance))
    assert alone.filter_bias == pytest.approx(bias[0], abs=float(deviations.max()))


@pytest.mark.slow
def test_a_disturbance_acts_and_is_not_in_the_record() -> None:
    quiet, moved = (
        next(iter(twins(study(1, "idm-ls", noise=noise).plan, [0])))[1]
        for noise in (Chain(), Chain(disturbances=((0.0, 0.2),)))
    )
    assert 0 < (moved.control - quiet.control).std() < 0.1  # the law's answer
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
    scatter = np.std([-1.0, 0.5, 2.5], ddof=1)
    found = (figures.bias.value, figures.bias.error, figures.scatter.value)
    assert found == pytest.approx((2 / 3, scatter / np.sqrt(3), scatter))
    assert (figures.runs, figures.deviations) == (3, {"hac": 1.0})
    assert figures.coverage == {"hac": Share(2, 3)}
    assert made.outcomes[0] == ("ok", "")
    assert made.outcomes[3] == ("failed", "idm-iv: singular")
    assert made.lost == {"idm-iv": {"singular": 1}}
    (check,) = made.check_figures
    assert (check.fails, check.passes, check.missing) == (Share(1, 2), Share(1, 2), Share(0, 2))
    assert made.objected == Share(1, 2)
    assert {check.name: check.status for check in made.checks}["runs"] == "fail"
    assert made.belief == "with care"


@pytest.mark.slow
def test_bias_of_few_runs_is_judged_by_students_law() -> None:
    for values, is_biased in (
        (100.2 + np.array([1.0, 1.3, 0.9, 1.2]), True),  # 12 standard errors
        (100.2 + np.array([1.0, 2.4, 0.6, 1.6]), False),  # 3.6, of 9.2 for so few
        (np.full(4, 100.2 * (1 + 1e-15)), False),
        (np.full(4, 100.7), True),  # the same error in every run
    ):
        assert bool(numbers(values, half=2.0).biased) == is_biased


@pytest.mark.slow
def test_the_more_intervals_there_are_the_further_one_must_be_off() -> None:
    off = np.where(np.arange(100) < 10, 3.0, 0.0)  # 90 % hold
    alone, right = (numbers(100.2 + each, half=2.0) for each in (off, 0 * off))
    assert alone.miscovered(narrow=True) == alone.figures
    assert alone.miscovered(narrow=False) == ()
    estimands = tuple(Estimand("idm-iv", "M", PARAMETER, f"{i}") for i in range(10))
    whole = np.concatenate([alone.numbers.numbers, *[right.numbers.numbers] * 9], 1)
    many = replace(alone, numbers=replace(alone.numbers, estimands=estimands, numbers=whole))
    assert many.miscovered(narrow=True) == ()


@pytest.mark.slow
def test_what_one_method_refuses_costs_the_others_nothing() -> None:
    crank = build(load_axis("crank"))
    made = monte_carlo(crank, 1, ["ddm-ls", "idm-ls"], moves=MOVES, checks=0)
    status, reason = made.outcomes[0]
    assert ({each.method for each in made}, status) == ({"idm-ls"}, "partly")
    assert "direct regressor" in reason


@pytest.mark.slow
def test_another_axis_may_be_simulated_than_is_identified(emps: GeneratedAxis) -> None:
    how: dict[str, Any] = {"twin": axis(), "truth": {"M": 150.0}, "moves": MOVES}
    made = monte_carlo(emps, 1, "idm-ls", prefilter=FILTER, **how)
    assert not made.plan.is_right
    assert made.of("idm-ls", "M").truth == 150.0
    assert made.values[0, 0] == pytest.approx(150.0, rel=0.05)
    (offset,) = (each for each in made if each.name not in axis().names)
    assert np.isnan(offset.truth)  # the twin has none
    assert offset.runs == 1
    assert offset.coverage == {}


@pytest.mark.slow
def test_a_known_value_that_all_runs_share_has_no_coverage_and_may_be_wrong() -> None:
    def known(**values: Any) -> MonteCarlo:
        fixed = build(fix(load_axis("emps2015"), **values))
        return monte_carlo(fixed, 1, "idm-ls", moves=MOVES, prefilter=FILTER)

    unsure = known(M=(100.2, 0.5))
    assert {each.kind for each in unsure if not each.coverage} == {"physical"}
    rights = [each.plan.is_right for each in (unsure, known(M=100.2), known(M=90.0))]
    assert rights == [True, True, False]


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
        ({"methods": "fit:speed"}, "method"),
        ({"methods": "fit:force"}, "method"),  # twins log none
        ({"noise": 1e-6}, "noise"),
        ({"noise": Chain(anywhere=True)}, "study"),
        ({"noise": Chain(jitter=1e-5)}, "study"),
        ({"noise": Chain(position_step=1e-5)}, "study"),  # every twin the same
        ({"noise": Chain(is_measured_by_law=False)}, "study"),
        ({"truth": {"m": 1.0}}, "twin"),
        ({"truth": {"M": "heavy"}}, "axis"),
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


@pytest.mark.parametrize(
    ("methods", "truth", "says"),
    [
        ("idm-iv", {"M": -1.0}, "simulation"),
        ("idm-iv", {"Fc": 1e5}, "does not move with .* Fc = 100000 N"),
        ("fit:control", {"Fc": 1e5}, "does not move with .* Fc = 100000 N"),
    ],
)
def test_a_study_of_which_nothing_comes_says_why(
    methods: str, truth: dict[str, float], says: str
) -> None:
    with refuses("no-twin-identified", says=says):
        study(2, methods, truth=truth)


@pytest.mark.slow
@pytest.mark.parametrize("error", [KeyboardInterrupt, MemoryError])
def test_what_is_done_is_kept_whatever_ends_a_study(
    monkeypatch: pytest.MonkeyPatch, error: type[BaseException]
) -> None:
    module, kept = sys.modules["axisid.estimation.monte_carlo.monte_carlo"], list[MonteCarlo]()

    def failing(plan: Any, block: range, threads: int | None = None, **how: Any) -> BlockNumbers:
        if block.start == 2:
            raise error
        return block_numbers(plan, block, threads, **how)

    monkeypatch.setattr(module, "block_numbers", failing)
    with pytest.raises((EstimationError, KeyboardInterrupt)):
        study(3, "idm-ls", block=1, keep=kept.append)
    (partial,) = kept
    assert np.array_equal(partial.values, study(2, "idm-ls").values)


@pytest.mark.parametrize(("count", "of"), [(0, 1), (0, 20), (1, 20), (19, 20), (57, 60), (60, 60)])
def test_share_has_wilsons_interval(count: int, of: int) -> None:
    expected = proportion_confint(count, of, alpha=0.05, method="wilson")
    assert Share(count, of).interval == pytest.approx(expected, abs=1e-12)


def test_too_few_runs_tell_nothing() -> None:
    one = np.array([1.0])
    nothing = [Mean.of_values(one).error, Mean.of_scatter(one).value, Share(0, 0).value]
    assert np.isnan(nothing).all()
    assert Share(0, 0).interval == (0.0, 1.0)


def test_mean_and_scatter_have_the_errors_that_they_show_when_repeated() -> None:
    many = np.random.default_rng(1).normal(size=(1000, 50))
    means = [Mean.of_values(values) for values in many]
    scatters = [Mean.of_scatter(values) for values in many]
    for found in (means, scatters):
        stated = np.sqrt(np.mean([each.error**2 for each in found]))
        assert stated == pytest.approx(np.std([each.value for each in found]), rel=0.06)


EVERY = {
    "position": 2e-6,
    "resolution": 1e-5,
    "anywhere": True,
    "velocity": 1e-4,
    "acceleration": 0.0,
    "control": 0.1,
    "disturbance": 0.2,
    "correlation_time": 0.02,
}


def drawn(run: int = 3, **noise: Any) -> Record:
    return drawn_twin(twin_plan(axis()), Chain(**noise), 7, run)


def test_one_source_of_noise_does_not_change_another() -> None:
    quiet, alone = drawn(), drawn(position=1e-6)
    beside = drawn(position=1e-6, velocity=1e-4, control=((0.0, 0.1),))
    assert np.array_equal(alone.position, beside.position)
    assert not np.array_equal(alone.position, drawn(run=4, position=1e-6).position)
    assert abs((alone.position - quiet.position).std() / 1e-6 - 1) < 0.05
    assert abs((beside.control - alone.control).std() / 0.1 - 1) < 0.05
    assert np.array_equal(alone.reference, twin_plan(axis()).reference)
    disturbed = drawn(disturbances=((0.0, 0.2),))
    assert not np.array_equal(disturbed.position, quiet.position)
    moved = drawn(position_step=1e-5, anywhere=True, disturbances=((0.0, 0.2),))
    assert 0 < moved.reference[0] - quiet.reference[0] < 1e-5


def test_a_chain_has_what_options_give_and_the_rest_of_the_experiment() -> None:
    experiment = Chain.of_experiment(axis().axis)
    assert declared_chain(experiment) == experiment == Chain(position=3.8e-6)
    chain = declared_chain(experiment, **EVERY)
    assert chain.disturbances == ((0.02, 0.2),)
    assert declared_figures(chain) == EVERY
    figures = declared_figures(Chain(disturbances=((0.0, 3.0), (0.1, 4.0))))
    assert (figures["disturbance"], figures["correlation_time"]) == (5.0, 0.1)


@pytest.mark.slow
def test_a_study_takes_the_chain_of_a_record() -> None:
    (_, record), *_ = twins(study(1, "idm-ls").plan, [0])
    (chain,) = identify(axis(), record, FILTER, "idm-iv")["idm-iv"].inference.chains
    found = study(2, "idm-iv", noise=chain)
    assert found.plan.noise == chain.likeliest
    assert found.of("idm-iv", "M").runs == 2


@pytest.mark.slow
def test_npz_and_parquet_have_the_same_columns(tmp_path: Path) -> None:
    npz, parquet = tmp_path / "runs.npz", tmp_path / "runs.parquet"
    for file in (npz, parquet):
        write_runs(judged(), file)
    frame = pl.read_parquet(parquet)
    with np.load(npz) as arrays:
        assert frame.columns == [name for name in arrays if name != "axisid.monte_carlo"]
        for name in frame.columns:
            assert np.array_equal(arrays[name].astype(str), frame[name].to_numpy().astype(str))
        told = json.loads(str(arrays["axisid.monte_carlo"]))
    assert (told["seed"], told["truth"]["idm-iv.M"], told["checks"]) == (1, 100.2, 1)
    assert told["chain"]["position"] == told["noise"]["position"] == 3.8e-6
    assert (told["prefilter"]["cutoff"], told["settings"]["covariance"]) == (60, "hac")
    units = {f.name: (f.metadata or {}).get(b"unit", b"") for f in parquet_schema(parquet)}
    assert {name: unit.decode() for name, unit in units.items() if unit} == told["units"]
    assert (units["idm-iv.M"], units["idm-iv.Fc.hac.low"], units["run"]) == (b"kg", b"N", b"")
    assert units["ddm-ls.direct.theta1"] == b"1/kg"


def test_a_file_that_cannot_be_written_is_the_users(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for code, name in (("file", "file/runs.npz"), ("study", "runs.csv")):
        with refuses(code):
            write_runs(judged(), tmp_path / name)


@pytest.mark.slow
def test_a_run_is_what_fit_makes_of_its_twin() -> None:
    made = study(3, ("idm-ls", "fit:control", "fit:position"), moves=LONG_MOVES, checks=1)
    (_, record), *_ = twins(made.plan, [2])
    alone = fit(axis(), record, "position")
    places = [i for i, each in enumerate(made.estimands) if each.method == "fit:position"]
    assert made.values[2, places].tolist() == alone.physical.tolist()
    wanted = [value.interval for value in alone.parameters.values()]
    np.testing.assert_array_equal(made.intervals(COLOURED)[2, places], wanted)
    iid = made.deviations("iid")[2, places]
    np.testing.assert_allclose(iid, np.sqrt(np.diag(alone.covariances["iid"])))


@pytest.mark.slow
def test_what_a_fit_refuses_is_a_failure_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object, **__: object) -> None:
        raise EstimationError("no end.")

    monkeypatch.setattr(runs, "fit", refused)
    found = study(2, ("idm-ls", "fit:control"), moves=LONG_MOVES)
    assert found.lost == {"fit:control": {"no end.": 2}}
    assert ({each.method for each in found}, found.outcomes[1][0]) == ({"idm-ls"}, "partly")
