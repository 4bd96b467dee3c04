"""Result files with anything in them are compared and exported as they are, or refused in words."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import build, fit, identify, load_axis, load_result, monte_carlo, twin_record
from benchmarks.random_axes import RandomAxis, random_axis
from tests.fuzz.cases import Fuzz, WrongError, one_of
from tests.fuzz.commands import kept_to
from tests.fuzz.result_files import altered_result, changed_result, smaller_results

TARGETS = ("c", "st", "python", "json", "toml", "csv", "latex")


@pytest.fixture(scope="module")
def axis() -> RandomAxis:
    return random_axis(np.random.default_rng(8))


@pytest.fixture(scope="module")
def result(axis: RandomAxis, tmp_path_factory: pytest.TempPathFactory) -> Any:
    file = tmp_path_factory.mktemp("axis") / "axis.toml"
    file.write_text(axis.toml, encoding="utf-8")
    built = build(load_axis(file))
    return json.loads(json.dumps(identify(built, twin_record(built)).to_dict()))


def _text(text: str) -> str:
    return text if len(text) < 3000 else f"{text[:1500]} ... {text[-1500:]}"


@pytest.mark.slow
def test_changed_results_are_compared_or_refused(result: Any, tmp_path: Path) -> None:
    first, second, output = (tmp_path / name for name in ("a.json", "b.json", "out.json"))
    first.write_text(json.dumps(result), encoding="utf-8")

    def check(text: str) -> None:
        second.write_text(text, encoding="utf-8", errors="surrogatepass")
        code, written = kept_to("compare-results", first, second, "--json", output, output=output)
        if code == 0:
            json.loads(written, parse_constant=_refused)

    Fuzz(
        name="results compared",
        count=60,
        draw=lambda rng: changed_result(result, rng),
        check=check,
        smaller=smaller_results,
        shown=_text,
    ).run()


@pytest.mark.slow
def test_changed_results_are_exported_or_refused(
    axis: RandomAxis, result: Any, tmp_path: Path
) -> None:
    declaration, file, output = (tmp_path / n for n in ("axis.toml", "a.json", "out.txt"))
    declaration.write_text(axis.toml, encoding="utf-8")

    def check(case: tuple[str, str]) -> None:
        text, target = case
        file.write_text(text, encoding="utf-8", errors="surrogatepass")
        code, written = kept_to(
            *("export", file, "--axis", declaration, "--to", target, "-o", output), output=output
        )
        if code == 0 and target == "json":
            _compare(json.loads(text), json.loads(written, parse_constant=_refused))

    Fuzz(
        name="results exported",
        count=40,
        draw=lambda rng: (changed_result(result, rng), one_of(rng, TARGETS)),
        check=check,
        smaller=lambda case: ((text, case[1]) for text in smaller_results(case[0])),
        shown=lambda case: f"--to {case[1]}\n{_text(case[0])}",
    ).run()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["identify", "fit", "monte_carlo"])
def test_altered_results_are_read_and_told_or_refused(
    kind: str, result: Any, tmp_path: Path
) -> None:
    file = tmp_path / "altered.json"
    if kind != "identify":
        emps = load_axis("emps2015")
        made = fit(emps, twin_record(emps)) if kind == "fit" else monte_carlo(emps, 3)
        made.save(file)
        result = json.loads(file.read_text(encoding="utf-8"))

    def check(text: str) -> None:
        file.write_text(text, encoding="utf-8")
        saved = load_result(file)
        saved.summary()
        saved.to_dict()
        saved._repr_html_()

    Fuzz(
        name=f"results of {kind} read",
        count=100,
        draw=lambda rng: altered_result(result, rng),
        check=check,
        smaller=smaller_results,
        shown=_text,
    ).run()


def _refused(name: str) -> None:
    raise WrongError(f"no JSON: it holds {name}")


def _compare(read: Any, written: Any) -> None:
    """Hold the numbers that were exported against those of the result."""
    own = {e["method"]: e["parameters"] for e in read["estimates"]}
    for method, parameters in written["parameters"].items():
        for name, value in parameters.items():
            if value["value"] != own[method][name]["value"]:
                raise WrongError(f"number: {name} by {method} is {value['value']!r}")
