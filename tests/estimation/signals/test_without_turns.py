"""Which samples the default leaves out: what remains of each parameter decides."""

from dataclasses import replace

import numpy as np
import pytest
import sympy

from axisid import (
    Parameter,
    Prefilter,
    Record,
    build,
    identify,
    load_axis,
    simulate,
    twin_record,
)
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.signals.filtered_record import FilteredRecord
from axisid.estimation.signals.signals import dependence
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling import Move
from tests.axes.bodies import stage
from tests.axes.unseen import with_stribeck

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
    paper = build(load_axis("emps2015"))
    slow, fast = (
        FilteredRecord.bind(a, r, Prefilter.suited(r.period, cutoff=cutoff)).prefilter
        for a, r, cutoff in ((axis, record, 20.0), (paper, twin_record(paper), 60.0))
    )
    assert (slow.reversals, fast.reversals) == ("keep", "leave-out")
    off = {}
    for reversals in ("keep", "leave-out"):
        chosen = Prefilter.suited(record.period, cutoff=20.0, reversals=reversals)
        mass = identify(axis, record, chosen, "idm-ls")["idm-ls"].parameters["M"]
        off[reversals] = abs(mass.corrected / record.provenance.truth["M"] - 1)
    assert off["keep"] < 1e-4 < 5e-4 < off["leave-out"]


def test_coulomb_friction_that_would_be_hardly_told_keeps_them_too() -> None:
    """At 30 Hz the paper's axis keeps two thirds of what tells its mass, not of its friction."""
    axis = build(load_axis("emps2015"))
    record = twin_record(axis)
    chosen = [
        FilteredRecord.bind(axis, record, Prefilter.suited(record.period, cutoff=cutoff))
        for cutoff in (40.0, 30.0)
    ]
    assert [each.prefilter.reversals for each in chosen] == ["leave-out", "keep"]


@pytest.mark.slow
def test_friction_near_rest_is_no_reason_to_keep_what_the_filter_rounds() -> None:
    axis = build(with_stribeck(1e-3))
    record = twin_record(axis)
    assert dependence(axis)["direction"].tolist() == [False, False, True, True]
    assert (
        FilteredRecord.bind(axis, record, Prefilter.suited(record.period)).prefilter.reversals
        == "leave-out"
    )


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
