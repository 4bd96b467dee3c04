"""The order in which records are given changes no number: what is drawn is each record's own."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from axisid import Record, build, fit, identify, load_axis, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.support.arrays import Array


@pytest.fixture(scope="module")
def pendulum() -> GeneratedAxis:
    return build(load_axis("pendulum"))


@pytest.fixture(scope="module")
def records(pendulum: GeneratedAxis) -> tuple[Record, ...]:
    """Of noise that shakes the axis, so that loops with such noise are drawn."""
    made = [twin_record(pendulum, seed=s, position_noise=s * 1e-4) for s in (1, 3)]
    return tuple(
        replace(record, provenance=replace(record.provenance, source=f"run {i}"))
        for i, record in enumerate(made)
    )


def _either_way(
    records: Sequence[Record], found: Callable[[list[Record]], Array]
) -> tuple[Array, Array]:
    return found([*records]), found([*reversed(records)])


@pytest.mark.slow
def test_estimates_and_deviations_are_the_same(
    pendulum: GeneratedAxis, records: Sequence[Record]
) -> None:
    def found(given: list[Record]) -> Array:
        result = identify(pendulum, given, methods=["idm-ls", "idm-iv", "didim"])
        values = [v for e in result.estimates.values() for v in e.parameters.values()]
        return np.array([(value.corrected, value.deviation) for value in values])

    one, other = _either_way(records, found)
    assert other == pytest.approx(one, rel=1e-9)


@pytest.mark.slow
def test_checks_are_the_same(pendulum: GeneratedAxis, records: Sequence[Record]) -> None:
    def found(given: list[Record]) -> Array:
        result = identify(pendulum, given, methods=["idm-iv", "didim"])
        return np.array([f"{check.name}: {check.status}" for check in result.verdict])

    one, other = _either_way(records, found)
    assert list(one) == list(other)


@pytest.mark.slow
def test_fits_and_their_deviations_are_the_same(
    pendulum: GeneratedAxis, records: Sequence[Record]
) -> None:
    def found(given: list[Record]) -> Array:
        result = fit(pendulum, given)
        values = result.parameters.values()
        return np.array([(value.value, value.deviation) for value in values])

    one, other = _either_way(records, found)
    assert other == pytest.approx(one, rel=1e-5)
