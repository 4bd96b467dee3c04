"""Files that hold what their schema allows and no result can be, by every door that reads one."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from axisid import Prefilter, Record, compare_results, export, identify, load_result
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from tests.refusals import refuses

DOORS: dict[str, Callable[[Path], object]] = {
    "load_result": load_result,
    "export": lambda file: export(file, axis="emps2015"),
    "compare_results": lambda file: compare_results(file, file),
}


@pytest.fixture(scope="module")
def written(emps2015: GeneratedAxis, twin: Record) -> str:
    result = identify(emps2015, twin, Prefilter(cutoff=60.0), ["idm-ls", "ddm-ls", "idm-iv"])
    return json.dumps(result.to_dict())


def _set(*path: str | int, value: Any) -> Callable[[dict[str, Any]], None]:
    """Put a value in place of a member, or what a function makes of it."""

    def change(content: Any) -> None:
        *others, last = path
        for name in others:
            content = content[name]
        content[last] = value(content[last]) if callable(value) else value

    return change


def _ls(*path: str | int, value: Any) -> Callable[[dict[str, Any]], None]:
    return _set("estimates", 0, *path, value=value)


def _ddm(*path: str | int, value: Any) -> Callable[[dict[str, Any]], None]:
    return _set("estimates", 1, *path, value=value)


CONTRADICTIONS = {
    "a judged method that is not there": (_set("judged", value="ddm-iv"), "no 'ddm-iv'"),
    "no estimates": (_set("estimates", value=[]), "no 'idm-iv'"),
    "an unknown method": (_ls("method", value="ols"), "no method 'ols'"),
    "a method twice": (_ls("method", value="idm-iv"), "two estimates of one method"),
    "another covariance": (
        _ls("covariances", value={"classical": [[1.0]]}),
        "are not of its 3 parameters",
    ),
    "a deviation by the gain": (
        _ls("gain_slopes", value={"M": 1.0}),
        "slopes by the drive gain of idm-ls are of other parameters",
    ),
    "more by the gain than its slope": (
        _ls("parameters", "M", "sd_gain", value=1.0),
        "what the drive gain adds to M by",
    ),
    "a covariance of fewer": (_ls("covariance", value=[[1.0]]), "are not of its 3 parameters"),
    "a ragged covariance": (_ls("covariance", 1, value=[1.0]), "is not of 3 parameters"),
    "a negative variance": (_ls("covariance_hac", 0, 0, value=-1.0), "has a negative variance"),
    "one side of a covariance": (_ls("covariance_hac", 0, 1, value=1e9), "is not symmetric"),
    "a correlation of fewer": (_ls("correlation", value=[]), "are not of its 3 parameters"),
    "a negative deviation": (
        _ls("parameters", "M", "sd_hac", value=lambda sd: -sd),
        "a deviation of M by idm-ls is negative",
    ),
    "a deviation of nothing": (
        _ls("parameters", "M", "sd_robust", value=1e200),
        "the deviation robust of M by idm-ls is not its covariance's",
    ),
    "a covariance without its deviations": (
        _ls("covariances", value={"hc3": [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]}),
        "has no deviation for the covariance 'hc3'",
    ),
    "an interval backwards": (
        _ls("parameters", "Fc", "interval_95", value=lambda ends: ends[::-1]),
        "ends before it begins",
    ),
    "a value out of its interval": (
        _ls("parameters", "M", "value", value=-5.0),
        "does not hold its value less its bias",
    ),
    "a curvature of nothing": (_ls("curvatures", value={}), "are of other parameters"),
    "an iterate of nothing": (_ls("iterations", value=[{}]), "are of other parameters"),
    "an iteration's error too many": (
        _ls("iteration_simulation_errors_percent", value=[1.0]),
        "have errors of other ones",
    ),
    "draws of nothing": (
        _ls(
            "drawn",
            value={
                "W": {"median": 1.0, "interval_95": [0.0, 2.0], "draws": 9, "lost": 0, "seed": 0}
            },
        ),
        "are of other parameters",
    ),
    "a negative error": (_ls("equation_error_percent", value=-1.0), "is negative"),
    "too few rows": (_ls("rows", value=3), "has 3 rows for 3 parameters"),
    "more rows than samples": (_ls("rows", value=10**10), "there are 10000000000 rows of"),
    "no samples": (_set("record", "samples", value=-5), "rows of -5 samples"),
    "residuals' columns of unlike lengths": (
        _ls("residual_tests", "cross_correlation", "columns", 0, value=[1.0]),
        "no summary can be made of it",
    ),
    "no period": (_set("record", "sample_period", value=0.0), "the sample period is 0 s"),
    "a segment of nothing": (_set("record", "segments", value=[[5, 5]]), "rows 5 to 5 are not of"),
    "a mask beyond": (_set("record", "masked", value=[[0, 10**9]]), "rows 0 to 1000000000 are not"),
    "a negative drop": (_set("prefilter", "drop", value=[-1, 0]), r"drops \(-1, 0\)"),
    "direct covariances that are gone": (
        _ddm("theta_ddm_covariance_hac", value=None),
        "and their covariances are not of one",
    ),
    "a direct covariance of fewer": (
        _ddm("theta_ddm_covariance", value=[[1.0]]),
        "the covariance iid of ddm-ls is not of 3 parameters",
    ),
    "a chosen direct covariance of fewer": (
        _ddm("theta_ddm_covariances", value={"robust": [[1.0]]}),
        "the covariance robust of ddm-ls is not of 3 parameters",
    ),
}


@pytest.mark.parametrize(
    ("name", "door"),
    [*((name, "load_result") for name in CONTRADICTIONS), *(("no samples", d) for d in DOORS)],
)
def test_every_door_refuses_what_no_result_can_be(
    written: str, tmp_path: Path, name: str, door: str
) -> None:
    change, said = CONTRADICTIONS[name]
    content = json.loads(written)
    change(content)
    file = tmp_path / "x.json"
    file.write_text(json.dumps(content))
    with refuses("contradictory-result", says=f"contradicts itself: .*{said}"):
        DOORS[door](file)
