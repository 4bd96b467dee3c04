"""Methods are rows of a table: one of a test's own goes through text, JSON and report."""

import json
from pathlib import Path

import numpy as np
import pytest

from axisid import Prefilter, Record, UsageError, identify
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.estimates import METHODS, Fit, Method, Problem
from axisid.estimation.regression import InverseForm, factor, least_squares


class EveryOther(Method):
    """Least squares of every other row: of no use but to be another method."""

    def fit(self, problem: Problem) -> Fit:
        form = self.form(problem.axis)
        measured = problem.rows(form)
        weights = np.where(np.arange(len(measured.left)) % 2, 1e-6, 1.0)
        weighted = factor(measured.regressor * weights[:, None], problem.axis.names)
        theta = least_squares((measured.left - measured.known) * weights, weighted).theta
        whole = least_squares(measured.left - measured.known, problem.factored(form, measured))
        residuals = measured.left - measured.known - measured.regressor @ theta
        from dataclasses import replace

        return Fit(
            form=form, measured=measured, solution=replace(whole, theta=theta, residuals=residuals)
        )


@pytest.fixture
def toy(monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setitem(METHODS, "toy", EveryOther(name="toy", form=InverseForm))
    return "toy"


def test_a_method_is_one_class_and_one_row(
    toy: str, emps2015: GeneratedAxis, twin: Record, tmp_path: Path
) -> None:
    result = identify(emps2015, twin, Prefilter())
    assert toy in result
    alone = identify(emps2015, twin, Prefilter(), toy)
    assert alone.judged.method == toy
    for each in (result, alone):
        assert "TOY" in each.summary()
        written = json.loads(json.dumps(each.to_dict()))
        assert toy in [e["method"] for e in written["estimates"]]
    assert np.abs(alone[toy].physical - result["idm-ls"].physical).max() > 0
    alone.plot("force")


def test_no_method_is_known_but_those_of_the_table(emps2015: GeneratedAxis, twin: Record) -> None:
    with pytest.raises(UsageError, match="there is no method 'toy'"):
        identify(emps2015, twin, methods=["toy"])
    assert list(METHODS) == [method.name for method in METHODS.values()]
    assert [name for name, m in METHODS.items() if m.by_simulation] == ["idm-iv", "ddm-iv"]
