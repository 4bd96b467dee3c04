"""The noise of twins: what was asked for, and the same for a run whoever runs it."""

from dataclasses import replace
from typing import Any

import numpy as np

from axisid import identify
from axisid.estimation import Chain
from axisid.estimation.monte_carlo import declared_chain, declared_figures
from axisid.estimation.monte_carlo.plan import DrawnChain, twins
from axisid.estimation.records.record import Record
from axisid.estimation.simulation.twin import twin_plan
from tests.estimation.monte_carlo.short import FILTER, axis, study

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


def drawn(run: int = 3, **noise: Any) -> DrawnChain:
    return DrawnChain(chain=Chain(**noise), seed=7, run=run)


def test_a_run_has_its_own_noise_of_the_deviation_that_is_asked_for() -> None:
    one, other = drawn(position=2e-6), drawn(run=4, position=2e-6)
    assert abs(one.position(5000).std() / 2e-6 - 1) < 0.05
    assert np.array_equal(one.position(50), replace(one).position(50))
    assert not np.array_equal(one.position(50), other.position(50))


def test_one_source_of_noise_does_not_change_another() -> None:
    beside = drawn(
        position=1e-6,
        position_step=1e-5,
        anywhere=True,
        control=((0.0, 0.1),),
        disturbances=((0.0, 0.2),),
    )
    alone, plan = drawn(position=1e-6), twin_plan(axis())
    assert np.array_equal(alone.position(50), beside.position(50))
    assert np.array_equal(alone.own(plan).reference, plan.reference)
    assert not alone.own(plan).added
    own = beside.own(plan)
    assert 0 < own.reference[0] - plan.reference[0] < 1e-5
    assert abs(own.added["control"].std() / 0.2 - 1) < 0.05


def test_a_chain_has_what_options_give_and_the_rest_of_the_experiment() -> None:
    experiment = Chain.of_experiment(axis().axis)
    assert declared_chain(experiment) == experiment == Chain(position=3.8e-6)
    chain = declared_chain(experiment, **EVERY)
    assert chain.disturbances == ((0.02, 0.2),)
    assert declared_figures(chain) == EVERY


def test_figures_of_several_disturbances_are_of_their_sum() -> None:
    figures = declared_figures(Chain(disturbances=((0.0, 3.0), (0.1, 4.0))))
    assert (figures["disturbance"], figures["correlation_time"]) == (5.0, 0.1)


def test_a_study_takes_the_chain_of_a_record() -> None:
    (_, record), *_ = twins(study(1, "idm-ls").plan, [0])
    assert isinstance(record, Record)
    (chain,) = identify(axis(), record, FILTER, "idm-iv")["idm-iv"].inference.chains
    found = study(2, "idm-iv", noise=chain)
    assert found.plan.noise == chain.likeliest
    assert found.of("idm-iv", "M").runs == 2
