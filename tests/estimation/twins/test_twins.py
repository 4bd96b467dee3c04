"""Twins are the loops of records with noise, the same whatever stands beside them."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, identify
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.methods import METHODS
from axisid.estimation.problems import Problem
from axisid.estimation.twins import Chain, Twins
from axisid.estimation.twins.chain import Draws
from axisid.estimation.twins.twins import twin_of, twins_of

TRUTH = np.array([100.2, 236.9, 24.8])
NOISE = Chain(position=4e-6, disturbances=((0.01, 0.03),))


@pytest.fixture(scope="module")
def problem(emps2015: GeneratedAxis, twin: Record) -> Problem:
    return identify(emps2015, twin, methods="idm-iv").problem


def test_a_twin_without_noise_is_the_loop(problem: Problem) -> None:
    (data,) = problem.data
    silent = twin_of(data, TRUTH, Chain(), Draws(np.random.default_rng(0)))
    loops = problem.loops(METHODS["idm-iv"].fit(problem).form, TRUTH)
    np.testing.assert_allclose(silent.record.position, loops[0].position, atol=1e-9)
    assert twins_of(data, TRUTH, Chain(), 3) == []


def test_what_disturbs_a_twin_is_not_in_its_log_but_in_its_motion(problem: Problem) -> None:
    (data,) = problem.data
    chain, law = Chain(disturbances=((0.1, 0.05),)), problem.axis.axis.control
    assert law is not None
    rng = np.random.default_rng(5)
    rng.uniform()  # where the encoder stands, which has no steps
    rng.standard_normal(len(data))  # of the position, of no size
    noise = chain.drawn_disturbance(Draws(rng), len(data), data.period)
    silent = twin_of(data, TRUTH, Chain(), Draws(np.random.default_rng(5))).record
    record = twin_of(data, TRUTH, chain, Draws(np.random.default_rng(5))).record
    # The law answers what it sees: the control opposes what acts beside it, where the axis is slow.
    answer = record.control - silent.control
    assert np.corrcoef(answer, noise)[0, 1] < -0.8
    assert np.abs(record.position - silent.position).max() > 1e-6


def test_steps_of_an_encoder_are_those_of_the_twin(problem: Problem) -> None:
    (data,) = problem.data
    record = twin_of(data, TRUTH, Chain(position_step=1e-5), Draws(np.random.default_rng(2))).record
    whole = record.position / 1e-5
    np.testing.assert_allclose(whole - np.round(whole - whole[0]) - whole[0], 0.0, atol=1e-6)


@pytest.mark.slow
def test_one_step_from_the_estimate_is_a_whole_estimate(
    emps2015: GeneratedAxis, problem: Problem
) -> None:
    (data,) = problem.data
    for method in ("idm-iv", "didim"):
        fit = METHODS[method].fit(problem)
        twins = Twins(problem=problem, form=fit.form, at=TRUTH, chains=(NOISE,), count=6)
        steps = np.array([each.theta for each in twins.solutions(fit.form, fit.solver)])
        whole = [
            identify(emps2015, each.record, methods=method)[method].physical
            for each in twins_of(data, TRUTH, NOISE, 6, paired=True)
        ]
        np.testing.assert_allclose(
            steps.mean(axis=0), np.mean(whole, axis=0), atol=0.3 * steps.std(axis=0).max()
        )
        assert np.all(np.abs(steps - whole) < 0.6 * steps.std(axis=0))


@pytest.mark.slow
def test_twins_of_records_do_not_hang_on_their_order(emps2015: GeneratedAxis, twin: Record) -> None:
    other = replace(twin, position=twin.position + 1e-6)
    by_order = [
        identify(emps2015, records, methods="idm-iv", bootstrap=8)["idm-iv"]
        for records in ([twin, other], [other, twin])
    ]
    one, two = (each.parameters for each in by_order)
    for name in emps2015.names:
        assert one[name].interval == pytest.approx(two[name].interval, rel=1e-9)
