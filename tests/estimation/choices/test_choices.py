"""The rows that say what users may choose are those that are run, and cheap to look at."""

from collections.abc import Callable, Iterable
from typing import Any

import pytest

from axisid import (
    Record,
    UsageError,
    fit,
    monte_carlo,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.choices import (
    COVARIANCE_ROWS,
    METHOD_ROWS,
    comparison_methods,
    method_names,
    same_estimates,
)
from axisid.estimation.estimates import COVARIANCES, covariance_of
from axisid.estimation.methods import METHODS
from axisid.estimation.regression import InverseForm
from tests.unjudged import identify


def test_every_row_is_in_the_table_that_is_run() -> None:
    assert [*METHODS] == [*method_names()]
    assert [*METHODS] == [method.name for method in METHODS.values()]
    assert [*COVARIANCES] == [row.name for row in COVARIANCE_ROWS]
    for row in COVARIANCE_ROWS:
        lags = getattr(covariance_of(row.name, 7), "lags", None)
        assert lags == (7 if row.takes_lags else None)


def test_models_are_compared_by_the_inverse_model_alone() -> None:
    assert all(METHODS[name].form is InverseForm for name in comparison_methods())


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        (identify, ({"methods": 5}, {"local": 5}, {"known": 5})),
        (fit, ({n: 5} for n in ("output", "weights", "bounds", "prior", "fixed", "free", "known"))),
        (monte_carlo, ({"runs": 1, "methods": 5}, {"runs": 1, "truth": 5})),
    ],
)
def test_what_is_no_list_and_no_mapping_is_refused_with_a_sentence(
    function: Callable[..., object],
    arguments: Iterable[dict[str, Any]],
    emps2015: GeneratedAxis,
    twin: Record,
) -> None:
    record = [] if function is monte_carlo else [twin]
    for each in arguments:
        with pytest.raises(UsageError, match=r"\b5\b"):
            function(emps2015, *record, **each)


def test_of_methods_that_give_one_estimate_one_is_told() -> None:
    assert same_estimates(method_names()) == {"ddm-iv": "idm-iv"}
    assert same_estimates(["ddm-iv", "idm-ls"]) == {}
    assert {row.same_as for row in METHOD_ROWS} <= {"", *method_names()}
