"""What a law remembers sees the law's output as one number, and not as its expression again."""

import numpy as np
import pytest
import sympy
from hypothesis import given, settings, strategies as st

from axisid.codegen.lowering import law_by_gains
from axisid.codegen.lowering.program import evaluate
from axisid.control import (
    LIMITED_OUTPUT,
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    PERIOD,
    REFERENCE,
    UNLIMITED_OUTPUT,
    ControlLaw,
    Memory,
    gain,
    integral,
)
from axisid.support.arrays import Array

POINTS = 200
LAST = Memory("q1", following=MEASURED_POSITION, start=MEASURED_POSITION)
SIGNALS = (
    REFERENCE,
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    LAST.symbol,
    REFERENCE - MEASURED_POSITION,
    (MEASURED_POSITION - LAST.symbol) / PERIOD,
    sympy.sin(MEASURED_POSITION),
)
Terms = list[tuple[sympy.Expr, float]]
SIZES = st.floats(-1e3, 1e3).filter(lambda value: abs(value) > 1e-3)
TERMS = st.lists(st.tuples(st.sampled_from(SIGNALS), SIZES), min_size=1, max_size=5)


def law_with(anti_windup: str, terms: Terms, error: Terms, slope: float) -> ControlLaw:
    """A law of products of gains and signals, with the integral of an error."""
    gains = {"ki": slope} | {f"k{i}": abs(value) for i, (_, value) in enumerate(terms)}
    output = gain("ki") * gain("integral")
    for i, (signal, value) in enumerate(terms):
        output += (1 if value > 0 else -1) * gain(f"k{i}") * signal
    integrated = sum((value * signal for signal, value in error), start=sympy.S.Zero)
    held = integral(integrated, output, anti_windup=anti_windup, tracking=1 / gain("ki"))
    return ControlLaw(name="own", period=1e-3, output=output, gains=gains, memory=(LAST, held))


def next_state(law: ControlLaw, limit: float) -> Array:
    """What the law remembers after a sample, at random points."""
    rng = np.random.default_rng(1)
    read = ("reference", "measured_position", "measured_velocity")
    elements = {name: rng.normal(size=POINTS) for name in (*read, "q1", "integral")}
    elements |= {name: np.full(POINTS, value) for name, value in law.gains.items()}
    elements["output_limit"] = np.full(POINTS, limit)
    return evaluate(law_by_gains(law, ())[0], elements)["next_state"]


@given(TERMS, TERMS, SIZES)
@settings(max_examples=6)
def test_anti_windup_does_nothing_to_an_own_law_where_its_limit_is_not_reached(
    terms: Terms, error: Terms, slope: float
) -> None:
    """To the last bit, whatever the order in which the output is added up."""
    wanted = next_state(law_with("none", terms, error, slope), np.inf)
    for limit in (np.inf, 1e9):
        for anti_windup in ("clamping", "back_calculation"):
            law = law_with(anti_windup, terms, error, slope)
            np.testing.assert_array_equal(next_state(law, limit), wanted)


@pytest.mark.parametrize("limit", [np.inf, 1e9])
def test_a_memory_reads_the_output_before_and_within_the_limit(limit: float) -> None:
    """Their difference is 0 where the limit is not reached, and the missing control beyond it."""
    missing = Memory("missing", following=UNLIMITED_OUTPUT - LIMITED_OUTPUT, start=0)
    output = gain("kp") * (REFERENCE - MEASURED_POSITION) - gain("kd") * MEASURED_VELOCITY
    law = ControlLaw(
        name="own",
        period=1e-3,
        output=output - gain("ki") * missing.symbol,
        gains={"kp": 1 / 3, "kd": 0.7, "ki": 0.1},
        memory=(missing,),
    )
    points = {"reference": 3.0, "measured_position": 0.1, "measured_velocity": 0.3, "missing": 0.2}
    elements = {name: np.array([value]) for name, value in (points | dict(law.gains)).items()}
    step = law_by_gains(law, ())[0]
    found = evaluate(step, elements | {"output_limit": np.array([limit])})
    assert found["next_state"] == 0.0
    found = evaluate(step, elements | {"output_limit": np.array([0.5])})
    assert found["next_state"] == found["control"] - 0.5 > 0
    assert not law.is_polynomial
