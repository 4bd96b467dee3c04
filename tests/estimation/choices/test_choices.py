"""The rows that say what users may choose are those that are run, and cheap to look at."""

import subprocess
import sys

import pytest

from axisid.commands.compare import compare
from axisid.commands.export import export
from axisid.commands.identify import identify
from axisid.estimation.choices.covariances import COVARIANCE_ROWS, covariance_names, takes_lags
from axisid.estimation.choices.methods import (
    METHOD_ROWS,
    comparing,
    method_names,
    same_estimates,
)
from axisid.estimation.estimates import COVARIANCES
from axisid.estimation.methods import METHODS
from axisid.estimation.regression import InverseForm


def test_every_row_is_in_the_table_that_is_run() -> None:
    assert [*METHODS] == [*method_names()]
    assert [*METHODS] == [method.name for method in METHODS.values()]
    assert [*COVARIANCES] == [*covariance_names()]
    for name, model in COVARIANCES.items():
        lags = getattr(model.covariance(7), "lags", None)
        assert lags == (7 if takes_lags(name) else None)


@pytest.mark.parametrize(
    ("command", "option", "names"),
    [
        (identify, "methods", (*method_names(), "all")),
        (identify, "covariance", covariance_names()),
        (export, "method", method_names()),
        (compare, "method", comparing()),
    ],
)
def test_the_command_line_offers_the_rows(
    command: object, option: str, names: tuple[str, ...]
) -> None:
    (found,) = (each for each in command.params if each.name == option)  # type: ignore[attr-defined]
    assert (*found.type.choices,) == names


def test_what_is_asked_for_by_default_is_in_the_tables() -> None:
    assert covariance_names()[0] == "hac"
    assert comparing()[0] == "idm-ls"


def test_models_are_compared_by_the_inverse_model_alone() -> None:
    assert all(METHODS[name].form is InverseForm for name in comparing())


def test_of_methods_that_give_one_estimate_one_is_told() -> None:
    assert same_estimates(method_names()) == {"ddm-iv": "idm-iv"}
    assert same_estimates(["ddm-iv", "idm-ls"]) == {}
    assert {row.same_as for row in METHOD_ROWS} <= {"", *method_names()}


def test_no_two_rows_have_one_label() -> None:
    assert len({row.label for row in COVARIANCE_ROWS}) == len(COVARIANCE_ROWS)


def test_the_rows_load_no_stage() -> None:
    rooms = ("methods", "covariances")
    program = "import sys\n" + "\n".join(f"import axisid.estimation.choices.{r}" for r in rooms)
    program += "\nprint(sorted({'numpy', 'scipy', 'sympy', 'casadi'} & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"
