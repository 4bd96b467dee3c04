"""Sentences of the checks of parameters have every number, name and setting of their findings."""

from dataclasses import replace

import pytest

from axisid.estimation.diagnostics.parameter_findings import (
    BeyondBounds,
    FarFromNominal,
    FarFromNominalValues,
    FewRows,
    FixedAtBounds,
    FixedValue,
    FixedValues,
    IdentifiedGain,
    OutsideBounds,
    Precision,
    RelativeError,
    Unidentified,
    WithinBounds,
)
from axisid.estimation.estimation_problem import ParameterAtBound
from axisid.estimation.findings import Finding
from axisid.estimation.signals import RestingAxis
from axisid.presentation.sentences import sentence

VAGUE = Unidentified(
    parameters=(RelativeError(name="m", percent=41.0),),
    reason="repeated column",
    alike=("b", "c"),
    rows=250.0,
    lacking=(),
)
BOTH = (*VAGUE.parameters, RelativeError(name="k", percent=None))
OUTSIDE = OutsideBounds(name="m", unit="kg", value=-2.5, lower=0.0, upper=9.0, is_at_bound=False)
HELD = ParameterAtBound(
    name="m", unit="kg", bound=0.0, is_lower=True, free=-1.5, deviation=0.25, reach=0.125
)
REST = RestingAxis(percent=37.0)
FIXED = FixedValue(
    name="m",
    unit="kg",
    value=1.25,
    standard_error=0.01,
    of_record=1.5,
    standard_error_of_record=0.02,
)
VALUES = FixedValues(
    values=(FIXED,),
    statistic=44.0,
    restrictions=2,
    p_value=1e-3,
    agree=False,
    is_bias_known=False,
)
GAIN = IdentifiedGain(
    identified=33.0,
    standard_error=0.5,
    declared=30.0,
    unit="N/V",
    distance=6.0,
    agreement="near",
)


def precision(*unidentified: Unidentified, negligible: tuple[RelativeError, ...] = ()) -> Precision:
    return Precision(
        largest_percent=3.25, has_others=True, negligible=negligible, unidentified=unidentified
    )


def beyond(advice: str, **others: object) -> BeyondBounds:
    return BeyondBounds(parameters=(OUTSIDE,), advice=advice, **others)


@pytest.mark.parametrize(
    ("finding", "parts"),
    [
        (FewRows(rows=1, parameters=3), ["1 row is", "3 parameters", "decimate"]),
        (FewRows(rows=20, parameters=3, samples_per_row=10), ["20 rows are", "one sample in 10"]),
        (precision(), ["every parameter", "3.25 %"]),
        (precision(negligible=BOTH[:1]), ["m cannot", "41 %", "1 % of the force", "Every other"]),
        (precision(negligible=BOTH), ["m and k cannot", "41 % and infinite"]),
        (
            precision(VAGUE),
            ["m is not", "41 %", "collinear with that of b and c", "fix(axis, m=VALUE)"],
        ),
        (
            precision(replace(VAGUE, parameters=BOTH, lacking=("one speed",))),
            ["m and k are not", "41 % and infinite", "collinear with those of b and c: one speed"],
        ),
        (precision(replace(VAGUE, reason="few rows", rows=4.0)), ["few rows (equivalent to 4 "]),
        (precision(replace(VAGUE, reason="cancelled")), ["cancel its part"]),
        (precision(replace(VAGUE, reason="below residual")), ["smaller than the residual"]),
        (WithinBounds(parameters=("m", "k")), ["m and k"]),
        (
            beyond("signs, units and gain"),
            ["m = -2.5 kg", "outside its bounds [0, 9]", "drive gain"],
        ),
        (beyond("interval reaches within"), ["95 %", "bounded=True"]),
        (beyond("other candidates explain more"), ["other candidates"]),
        (beyond("rests", rest=REST), ["37 %"]),
        (
            replace(beyond("rests"), parameters=(replace(OUTSIDE, is_at_bound=True),)),
            ["at a bound of"],
        ),
        (
            FixedAtBounds(parameters=(HELD,), distance=6.0, advice=None),
            ["bound 0 kg", "-1.5 +- 0.25 kg", "95 %", "0 to 0.125 kg"],
        ),
        (
            FixedAtBounds(
                parameters=(replace(HELD, reach=0.0),),
                distance=6.0,
                advice="signs, units and model",
            ),
            ["no width", "6 standard errors", "signs and units"],
        ),
        (
            FixedAtBounds(parameters=(HELD,), distance=6.0, advice="rests", rest=REST),
            ["6 standard errors", "37 %"],
        ),
        (
            VALUES,
            ["T squared 44", "2 restrictions", "p = 0.001", "1.25 +- 0.01 kg", "1.5 +- 0.02 kg"],
        ),
        (VALUES, ["The bias", "without a control law"]),
        (replace(VALUES, values=(), restrictions=1), ["no values", "1 restriction,"]),
        (
            replace(VALUES, values=(replace(FIXED, of_record=None, standard_error=0.0),)),
            ["m is fixed at 1.25 kg"],
        ),
        (replace(VALUES, agree=True), ["agrees", "T squared 44"]),
        (
            FarFromNominalValues(
                parameters=(
                    FarFromNominal(name="m", unit="kg", value=60.0, nominal=10.0, ratio=6.0),
                )
            ),
            ["m = 60 kg", "6 times", "10 kg"],
        ),
        (GAIN, ["33 +- 0.5 N/V", "declared 30 N/V", "+10 %", "6 standard errors"]),
        (replace(GAIN, agreement="far", distance=None), ["in the order of the records"]),
        (replace(GAIN, agreement="same"), ["agrees", "6 standard errors"]),
    ],
)
def test_every_branch_has_its_numbers_names_and_settings(
    finding: Finding, parts: list[str]
) -> None:
    text = sentence(finding)
    assert [part for part in parts if part not in text] == []
