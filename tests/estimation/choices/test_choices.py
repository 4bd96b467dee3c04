"""The rows that say what users may choose are those that are run, and cheap to look at."""

from axisid.estimation.choices import (
    METHOD_ROWS,
    comparing,
    covariance_names,
    method_names,
    same_estimates,
    takes_lags,
)
from axisid.estimation.estimates import COVARIANCES, covariance_of
from axisid.estimation.methods import METHODS
from axisid.estimation.regression import InverseForm


def test_every_row_is_in_the_table_that_is_run() -> None:
    assert [*METHODS] == [*method_names()]
    assert [*METHODS] == [method.name for method in METHODS.values()]
    assert [*COVARIANCES] == [*covariance_names()]
    for name in COVARIANCES:
        lags = getattr(covariance_of(name, 7), "lags", None)
        assert lags == (7 if takes_lags(name) else None)


def test_models_are_compared_by_the_inverse_model_alone() -> None:
    assert all(METHODS[name].form is InverseForm for name in comparing())


def test_of_methods_that_give_one_estimate_one_is_told() -> None:
    assert same_estimates(method_names()) == {"ddm-iv": "idm-iv"}
    assert same_estimates(["ddm-iv", "idm-ls"]) == {}
    assert {row.same_as for row in METHOD_ROWS} <= {"", *method_names()}
