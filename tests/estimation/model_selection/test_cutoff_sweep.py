"""The sweep over cut-offs: which is recommended, by instruments and by the predicted motion."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from axisid import (
    Prefilter,
    Record,
    build,
    sweep,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation import Sweep
from axisid.estimation.model_selection.cutoff_sweep import default_cutoffs, motion_errors
from axisid.presentation.matplotlib import sweep_figure
from axisid.presentation.plots.result import sweep_plot
from tests.command_line import Refused, Run
from tests.refusals import refuses
from tests.unjudged import identify


@pytest.fixture(scope="module")
def swept(emps2015: GeneratedAxis, twin: Record) -> Sweep:
    return sweep(emps2015, twin, (25.0, 50.0, 100.0, 200.0, 400.0), Prefilter(hold="zoh"))


@pytest.mark.slow
def test_least_squares_drifts_and_instruments_hold(swept: Sweep) -> None:
    ls, iv = (
        np.array([e.physical[0] for e in swept.estimates(method) if e is not None])
        for method in ("idm-ls", "idm-iv")
    )
    assert np.all(np.abs(iv / 100.2 - 1) < 0.01)
    assert ls[0] == pytest.approx(100.2, rel=0.01)
    assert np.all(np.diff(ls) < 0)
    assert ls[-1] < 20


@pytest.mark.slow
def test_recommended_cutoff_is_one_where_the_judged_method_is_surest(swept: Sweep) -> None:
    """Of deviation, known bias and the farther neighbour, with those of both neighbours."""
    judged = [[*result.preferred.parameters.values()] for result in swept.results]
    found = np.array([[v.corrected for v in values] for values in judged])
    far = np.abs(np.diff(found, axis=0, prepend=found[:1], append=found[-1:]))
    sizes = [
        math.prod(math.hypot(v.deviation, v.filter_bias, step) / v.value for v, step in each)
        for each in map(zip, judged, np.maximum(far[1:], far[:-1]))
    ]
    around = np.convolve(np.log(sizes), np.ones(3), "valid")
    place = 1 + int(np.argmin(around))
    assert swept.recommended == swept.cutoffs[place]
    assert ("Sweep further" in swept.reason) == (place in (1, len(sizes) - 2))
    chosen = swept.results[swept.cutoffs.index(swept.recommended)]
    assert chosen.case.method.upper() in swept.reason
    assert (swept.belief, swept.checks) == ("believed", chosen.checks)


@pytest.mark.slow
@pytest.mark.parametrize("has_law", [False, True])
def test_without_instruments_the_steadiest_cutoff_is_recommended(
    emps2015: GeneratedAxis, twin: Record, *, has_law: bool
) -> None:
    """Near the best, and far from those that noise ruins."""
    axis = emps2015 if has_law else build(replace(emps2015.axis, control=None))
    cutoffs = (10.0, 20.0, 30.0, 45.0, 70.0, 110.0, 170.0, 260.0)
    result = sweep(axis, replace(twin, reference=None), cutoffs, methods=["idm-ls"])
    truth = twin.provenance.truth
    errors = {
        each.prefilter.cutoff: max(
            100 * abs(v.corrected / truth[name] - 1)
            for name, v in each.preferred.parameters.items()
        )
        for each in result.results
    }
    chosen = errors[result.recommended]
    assert chosen <= min(5 * min(errors.values()), 1.0) < errors[70.0] + errors[260.0]
    assert "there are no instruments to compare with" in result.recommendation
    assert f"recommended: {result.recommended:g} Hz" in result.summary()
    assert max(map(len, result.summary().splitlines())) <= 100


@pytest.mark.slow
def test_a_log_on_which_least_squares_stands_still_nowhere_has_no_recommendation(
    emps2015: GeneratedAxis, twin: Record, tmp_path: Path
) -> None:
    rng = np.random.default_rng(1)
    noisy = replace(twin, reference=None, position=twin.position + rng.normal(0.0, 2e-4, len(twin)))
    result = sweep(emps2015, noisy, (40.0, 60.0, 90.0, 130.0), methods=["idm-ls"])
    assert "depends on the cut-off everywhere" in result.recommendation
    assert result.to_dict()["recommended_cutoff"] is result.recommended is None
    sweep_figure(result, tmp_path / "sweep.png")
    assert sweep_plot(result, 60.0).marks == ((60.0, "used"),)


@pytest.mark.parametrize("cutoffs", [(60.0,), (60.0, 30.0)])
def test_two_cutoffs_do_not_show_where_noise_begins(
    emps2015: GeneratedAxis, twin: Record, cutoffs: tuple[float, ...]
) -> None:
    result = sweep(emps2015, twin, cutoffs, methods=["idm-ls"])
    assert result.cutoffs == tuple(sorted(cutoffs))
    assert result.recommended is None
    assert "3 or more" in result.reason
    assert [c.meaning for c in result.checks if c.status == "fail"] == [result.reason]


@pytest.mark.slow
def test_instruments_decide_where_noise_biases_least_squares_at_every_cutoff(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    result = sweep(emps2015, twin, (150.0, 250.0, 400.0), methods=["idm-ls", "idm-iv"])
    ls = next(r for r in result.results if r.prefilter.cutoff == result.recommended)["idm-ls"]["M"]
    assert abs(ls.filter_bias) > 3 * ls.deviation
    assert abs(ls.corrected - 100.2) < 3 * ls.deviation


@pytest.mark.slow
def test_cutoffs_that_give_nothing_are_told(emps2015: GeneratedAxis, twin: Record) -> None:
    result = sweep(emps2015, twin, (0.2, 60.0))
    assert set(result.failures) == {0.2}
    assert "No estimate at 0.2 Hz" in result.summary()
    with refuses("sweep", says="no cut-off gave an estimate"):
        sweep(emps2015, twin, (0.2,))


def test_default_cutoffs_are_in_equal_ratios() -> None:
    assert default_cutoffs(1000.0, points=4) == (20.0, 54.3, 147.0, 400.0)
    for bad in (
        {"lowest": 0.0},
        {"lowest": 50.0, "highest": 10.0},
        {"points": 0},
        {"points": 10**6},
    ):
        with refuses("sweep", says="500"):
            default_cutoffs(1000.0, **bad)  # type: ignore[arg-type]


@pytest.mark.slow
def test_command_prints_a_table_and_writes_json_and_a_figure(run: Run, tmp_path: Path) -> None:
    figure, file = tmp_path / "sweep.png", tmp_path / "sweep.json"
    options = ("--from", 30, "--to", 300, "--points", 3, "--hold", "zoh")
    code, out, err = run("sweep", "emps2015", *options, "--figure", figure, "--json", file)
    assert (code, err) == (0, "")
    assert re.search(r"(?s)cut-off \[Hz\].*DIDIM.*recommended: .*verdict", out)
    assert figure.read_bytes().startswith(b"\x89PNG")
    result = json.loads(file.read_text())
    assert len(result["results"]) == 3
    assert result["recommended_cutoff"] in [r["prefilter"]["cutoff"] for r in result["results"]]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--from", 300, "--to", 30), "are not valid"),
        (("--to", 900), "not below 500 Hz"),
        (("--figure", "sweep.xyz"), "the name must end in"),
        (("--figure", "no/such/sweep.png"), "the folder does not exist"),
    ],
)
def test_bad_options_exit_2(
    refused: Refused, here: Path, options: tuple[object, ...], message: str
) -> None:
    refused("sweep", "emps2015", "--points", 2, *options, says=message)
    assert not list(here.iterdir())


@pytest.mark.slow
def test_a_result_stands_among_the_sweep_as_it_is(emps2015: GeneratedAxis, twin: Record) -> None:
    swept = sweep(emps2015, twin, (30.0, 60.0, 90.0), methods=["idm-ls", "idm-iv"])
    result = identify(emps2015, twin, Prefilter(cutoff=60.0, decimate=12))
    beside = swept.with_result(result)
    filters = [(r.prefilter.cutoff, r.prefilter.decimate) for r in beside.results]
    assert filters == [(30.0, 14), (60.0, 12), (90.0, 5)]
    assert list(beside.results[1].estimates) == ["idm-ls", "idm-iv"]
    assert beside.results[1]["idm-iv"] is result["idm-iv"]
    value = result["idm-iv"].parameters["M"]
    assert f"{value.corrected:.5g}" in str(beside).split("\n\n")[1].splitlines()[4].split()


@pytest.mark.slow
def test_the_position_is_predicted_as_well_as_the_parameters_are_right(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    axis = build(replace(emps2015.axis, control=None))
    found = sweep(
        axis, replace(twin, reference=None), (25.0, 40.0, 55.0, 120.0), methods=["idm-ls"]
    )
    errors = motion_errors([(each, each["idm-ls"]) for each in found.results])
    truth = np.array([*twin.provenance.truth.values()])
    off = [np.abs(each["idm-ls"].physical / truth - 1).max() for each in found.results]
    assert np.argmax(errors) == np.argmax(off) == 3
    assert errors[3] > 10 * min(errors)
    assert re.search("predict the position with .* of 4 cut-offs are not considered", found.reason)


def test_nothing_is_told_of_a_position_that_was_not_measured(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    axis = build(replace(emps2015.axis, control=None))
    velocity = np.gradient(twin.position, twin.period)
    alone = Record(time=twin.time, velocity=velocity, control=twin.control)
    found = sweep(axis, alone, (25.0, 40.0, 60.0), methods=["idm-ls"])
    assert all(map(math.isnan, motion_errors([(r, r["idm-ls"]) for r in found.results])))
    assert "predict" not in found.reason


@pytest.mark.slow
def test_cutoffs_are_compared_by_what_all_of_them_identify(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    """A record that is too short for a low cut-off is set aside there, with what is its own."""
    records = [twin, twin, twin.windowed((2.0, 2.6))]
    swept = sweep(
        emps2015, records, (4.0, 20.0, 60.0), methods=["idm-iv"], local="M", skip_bad=True
    )
    assert len({len(each.preferred.parameters) for each in swept.results}) > 1
    assert swept.recommended in swept.cutoffs
