"""Noise that is drawn is what its chain says, and twins are the loops of records with it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from axisid import Record, identify
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.methods import METHODS
from axisid.estimation.problems import Problem
from axisid.estimation.twins import Chain, Twins
from axisid.estimation.twins.chain import (
    CORRELATION_TIMES,
    Draws,
    MeasuredChain,
    spectrum,
)
from axisid.estimation.twins.twins import twin_of, twins_of
from tests.refusals import refuses

PERIOD = 1e-3


@pytest.mark.parametrize("time", CORRELATION_TIMES)
def test_a_spectrum_is_of_variance_one_and_of_its_correlation(time: float) -> None:
    samples = 1 << 15
    correlation = np.fft.irfft(spectrum(time / PERIOD, samples), samples)
    assert correlation[0] == pytest.approx(1.0, rel=1e-9)
    one_later = np.exp(-PERIOD / time) if time else 0.0
    assert correlation[1] == pytest.approx(one_later, abs=1e-9)


def test_a_disturbance_is_the_sum_of_its_autoregressions() -> None:
    chain = Chain(disturbances=((0.0, 2.0), (0.05, 1.0)))
    rng = Draws(np.random.default_rng(1))
    noise = np.array([chain.drawn_disturbance(rng, 4000, PERIOD) for _ in range(40)])
    lag = 20
    assert np.mean(noise**2) == pytest.approx(4.0 + 1.0, rel=0.03)
    later = np.mean(noise[:, lag:] * noise[:, :-lag])
    assert later == pytest.approx(np.exp(-lag * PERIOD / 0.05), abs=0.06)
    # One end is no neighbour of the other.
    assert abs(np.mean(noise[:, 0] * noise[:, -1])) < 2.5


def test_twins_of_a_measured_chain_have_any_of_its_disturbances_and_opposite_ones_the_same() -> (
    None
):
    sizes = (1.0, 10.0, 100.0)
    chain = MeasuredChain(disturbances=((0.0, 1.0),), drawn=tuple(((0.0, sd),) for sd in sizes))
    assert chain.likeliest == Chain(disturbances=((0.0, 1.0),))
    found = set()
    for seed in range(30):
        noise, opposite = (
            chain.drawn_disturbance(Draws(np.random.default_rng(seed), sign), 4000, PERIOD)
            for sign in (1.0, -1.0)
        )
        np.testing.assert_array_equal(noise, -opposite)
        found.add(round(float(noise.std()), -int(np.log10(noise.std()))))
    assert found == set(sizes)
    assert not replace(chain, disturbances=()).is_silent


@pytest.mark.parametrize("time", [0.02, 1.0, 1e5])
def test_noise_is_stationary_from_the_first_sample_however_long_it_lasts(time: float) -> None:
    chain, rng, apart = Chain(disturbances=((time, 0.5),)), Draws(np.random.default_rng(2)), 400
    noise = np.array([chain.drawn_disturbance(rng, 1000, PERIOD) for _ in range(400)])
    assert noise[:, [0, -1]].std(axis=0) == pytest.approx(0.5, rel=0.15)
    moved = np.std(noise[:, apart:] - noise[:, :-apart])
    assert moved == pytest.approx(0.5 * np.sqrt(-2 * np.expm1(-apart * PERIOD / time)), rel=0.15)


def test_noise_of_the_control_is_in_the_log_beside_its_steps() -> None:
    control, rng = np.zeros(4000), Draws(np.random.default_rng(3))
    logged = Chain(control=((0.0, 0.3), (0.01, 0.4))).logged_control(rng, control, PERIOD)
    assert logged.std() == pytest.approx(0.5, rel=0.1)
    rounded = Chain(control_step=0.1).logged_control(rng, logged, PERIOD)
    assert np.unique(np.round(rounded % 0.1, 9) % 0.1).size <= 2
    assert np.abs(rounded - logged).max() <= 0.05 + 1e-12


@pytest.mark.parametrize(
    "given",
    [
        {"position": -1.0},
        {"control": 0.1},
        {"control": ((-0.1, 1.0),)},
        {"disturbances": ((0.1, 1.0, 2.0),)},
        {"jitter": None},
        {"velocity": np.inf},
    ],
)
def test_noise_that_makes_no_sense_is_refused(given: dict[str, Any]) -> None:
    with refuses("noise"):
        Chain(**given)


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
