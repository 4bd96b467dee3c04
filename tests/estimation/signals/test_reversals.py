"""Samples near reversals and rests, and which of them the default leaves out."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import sympy

from axisid import (
    Axis,
    Parameter,
    Prefilter,
    Record,
    build,
    friction_ladder,
    load_axis,
    simulate,
    twin_record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation.methods import filtered_record
from axisid.estimation.signals.filtered_record import FilteredRecord
from axisid.estimation.signals.sample_selection import near_turns
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling import Move
from tests.axes.bodies import stage
from tests.axes.unseen import with_stribeck
from tests.estimation.methods.test_partially_linear import TRUTH as OF_STRIBECK, stribeck_axis
from tests.unjudged import identify


def test_samples_no_further_than_the_reach_from_a_turn_or_a_rest_are_near_it() -> None:
    velocity = np.repeat([1.0, -1.0, 0.01, -1.0], 20)
    near = np.flatnonzero(near_turns(velocity, 3, 0.1))
    assert near.tolist() == [*range(20 - 3, 20 + 4), *range(40 - 3, 60 + 4)]


@pytest.fixture(scope="module")
def stribeck() -> GeneratedAxis:
    return build(stribeck_axis())


@pytest.mark.slow
@pytest.mark.parametrize(("cutoff", "decimate"), [(60.0, 10), (100.0, 10), (400.0, 20)])
@pytest.mark.parametrize("method", ["idm-ls", "idm-iv"])
def test_stribeck_friction_without_noise_is_found_whatever_the_filter(
    stribeck: GeneratedAxis, cutoff: float, decimate: int, method: str
) -> None:
    record = twin_record(stribeck, position_noise=0.0)
    found = identify(stribeck, record, Prefilter(cutoff=cutoff, decimate=decimate), method)
    assert found[method].physical == pytest.approx(list(OF_STRIBECK.values()), rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "level"), [("belt_axis", "Fcp"), ("crank", "fc")])
def test_friction_of_linear_axes_comes_out_straighter(name: str, level: str) -> None:
    axis = build(load_axis(name))
    truth = axis.axis.experiment.truth[level]
    record = twin_record(axis)
    off = {}
    for reversals in ("keep", "leave-out"):
        filter_ = Prefilter.suited(record.period, reversals=reversals)
        value = identify(axis, record, filter_, "idm-ls")["idm-ls"].parameters[level].value
        off[reversals] = abs(value / truth - 1)
    assert off["leave-out"] < 0.2 * off["keep"]


@pytest.mark.parametrize(
    ("made", "cutoff", "reversals"),
    [
        (lambda: load_axis("emps2015"), 60.0, "leave-out"),
        # Two thirds of what tells its mass are left, not of its Coulomb friction.
        (lambda: load_axis("emps2015"), 40.0, "leave-out"),
        (lambda: load_axis("emps2015"), 30.0, "keep"),
        # The ramps of the vertical screw are within reach of its reversals.
        (lambda: load_axis("vertical_screw"), 20.0, "keep"),
        (stribeck_axis, 60.0, "leave-out"),
        # Friction near rest is no reason to keep what the filter rounds.
        (lambda: with_stribeck(1e-3), 60.0, "leave-out"),
        (lambda: friction_ladder(load_axis("emps2015"))["viscous"], 60.0, "keep"),
    ],
)
def test_default_leaves_them_out_where_there_is_friction_and_enough_is_left(
    twin: Record, made: Callable[[], Axis], cutoff: float, reversals: str
) -> None:
    axis = build(made())
    record = twin_record(axis) if axis.axis.experiment else twin
    chosen = FilteredRecord.bind(axis, record, Prefilter.suited(record.period, cutoff=cutoff))
    assert chosen.prefilter.reversals == reversals
    assert (chosen.sampling.excluded_samples > 0) == (reversals == "leave-out")


@pytest.mark.slow
def test_rows_and_signals_stay_together_and_what_is_silent_enters_none(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    data = filtered_record(emps2015, twin, Prefilter(reversals="leave-out"))
    spoilt = np.array(twin.control)
    for start, stop in data.excluded:
        spoilt[start:stop] = 1e3
    clean = data.reduce(np.asarray(twin.control))
    assert np.array_equal(data.reduce(spoilt), clean)
    assert len(data.sampling.rows) == len(clean)
    result = identify(emps2015, twin, data.prefilter)
    assert len(result["idm-iv"].rows) == len(result["idm-iv"].y)
    excluded = data.sampling.excluded_samples
    assert f"{excluded} samples near reversals" in " ".join(result.summary(every=True).split())
    assert result.to_dict()["prefilter"]["silent"] == excluded


PERIOD = 1e-3
TRUTH = (6.2, 14.0, 7.5)


def rested(axis: GeneratedAxis, rest: float, noise: float = 0.0) -> Record:
    """Six strokes of 0.5 s, each followed by a rest of so many seconds."""
    pieces, place = [], 0.0
    for k, speed in enumerate((0.1, 0.2, 0.4) * 2):
        stroke = place + trajectory((Move((-1) ** k * 0.4 * speed, speed, 3.0),), PERIOD)
        place = float(stroke[-1])
        pieces += [stroke, np.full(round(rest / PERIOD), place)]
    reference = np.concatenate(pieces)
    added = np.random.default_rng(0).normal(0.0, noise, len(reference)) if noise else None
    loop = simulate(axis, TRUTH, reference, PERIOD, position_noise=added)
    return Record(
        time=loop.time,
        position=loop.measured_position,
        reference=reference,
        control=loop.control,
    )


@pytest.mark.parametrize("rest", [0.0, 0.5, 2.0, 5.0])
@pytest.mark.parametrize("noise", [0.0, 5e-6])
def test_rests_are_left_out_however_long(rest: float, noise: float) -> None:
    axis = build(stage())
    result = identify(axis, rested(axis, rest, noise), methods=["idm-ls", "idm-iv"])
    assert result.prefilter.reversals == "leave-out"
    for estimate in result.estimates.values():
        assert estimate.physical == pytest.approx(TRUTH, rel=2e-3 if noise == 0 else 1e-2)


@pytest.mark.slow
def test_an_inertia_that_only_the_reversals_show_keeps_them() -> None:
    """At 20 Hz the ramps of the vertical screw are within reach of its reversals; of the paper's
    axis enough is left at 60 Hz.
    """
    axis = build(load_axis("vertical_screw"))
    record = twin_record(axis)
    off = {}
    for reversals in ("keep", "leave-out"):
        chosen = Prefilter.suited(record.period, cutoff=20.0, reversals=reversals)
        mass = identify(axis, record, chosen, "idm-ls")["idm-ls"].parameters["M"]
        off[reversals] = abs(mass.corrected / record.provenance.truth["M"] - 1)
    assert off["keep"] < 1e-4 < 5e-4 < off["leave-out"]


@pytest.mark.parametrize(
    ("cutoff", "reversals"), [(60.0, "leave-out"), (30.0, "keep"), (20.0, "keep")]
)
@pytest.mark.parametrize("nominal", [0.0, 5.0])
def test_a_partially_linear_axis_is_asked_by_its_jacobian(
    cutoff: float, reversals: str, nominal: float
) -> None:
    """As the linear one; an amount that begins at 0 hides nothing of what stands beside it."""
    paper = load_axis("emps2015")
    record = twin_record(paper)
    q = paper.coordinate.symbol
    wave = Parameter("a", "N", nominal=nominal)
    period = Parameter("p", "m", nominal=0.02, lower=1e-3, upper=0.5)
    force = paper.force + wave * sympy.sin(q / period.symbol)
    axis = build(
        replace(paper, parameters=(*paper.parameters, wave, period), force=force, experiment=None)
    )
    assert not axis.is_linear
    chosen = FilteredRecord.bind(axis, record, Prefilter.suited(record.period, cutoff=cutoff))
    assert chosen.prefilter.reversals == reversals
