"""How coarse an encoder each method bears: a study in small, and what it looks like."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from axisid import UsageError
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation import Chain
from axisid.estimation.monte_carlo.plan import twins
from axisid.paper.encoder import (
    ENCODER_FILES,
    NOISE,
    REVOLUTION,
    EncoderStudy,
    run_encoder_study,
    write_encoder_study,
)
from tests.estimation.monte_carlo.short import study as study_of

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="module")
def study() -> EncoderStudy:
    return run_encoder_study(2, (1000, 20))


def test_twins_have_the_encoder_in_the_loop_and_in_the_record(emps2015: GeneratedAxis) -> None:
    experiment = emps2015.axis.experiment
    assert experiment.position_noise == NOISE
    step = REVOLUTION / 200
    noise = Chain(position=NOISE, position_step=step, anywhere=True)
    plan = study_of(2, "idm-ls", noise=noise).plan
    one, other = (record for _, record in twins(plan, [0, 1]))
    for twin in (one, other):
        counts = twin.position / step
        assert counts == pytest.approx(np.rint(counts), abs=1e-9)
        assert twin.reference is not None
    # Each begins elsewhere in a count, so that no two hunt alike.
    assert 0 < abs(one.reference[0] - other.reference[0]) < step


@pytest.mark.slow
def test_output_error_bears_an_encoder_that_biases_least_squares(study: EncoderStudy) -> None:
    fine, coarse = study.under("inappropriate")
    assert (fine.counts, coarse.counts) == (1000, 20)
    assert abs(fine.methods["idm-ls"].bias[0]) < 2  # mass, which is half without its bias
    assert abs(fine.methods["didim"].bias).max() < 1
    assert fine.methods["didim"].held.mean() > 0.8
    assert coarse.methods["idm-iv"].estimated < 1  # the loop hunts, and shows no parameters
    assert coarse.clean == 0


@pytest.mark.slow
def test_every_case_is_written(study: EncoderStudy, tmp_path: Path) -> None:
    assert {path.name for path in write_encoder_study(study, tmp_path)} == {*ENCODER_FILES}
    read = json.loads((tmp_path / "encoder.json").read_text(encoding="utf-8"))
    assert [case["counts"] for case in read["cases"]] == [1000, 1000, 20, 20]


@pytest.mark.parametrize(("runs", "counts"), [(1, (100,)), (3, (1.5,))])
def test_runs_and_counts_are_whole_numbers(runs: int, counts: tuple[int, ...]) -> None:
    with pytest.raises(UsageError) as refused:
        run_encoder_study(runs, counts)
    assert refused.value.code == "study"


def test_jobs_are_of_many_twins(run: Run) -> None:
    code, _, err = run("paper", "--jobs", "3")
    assert code == 2
    assert "--runs or --encoder" in err
