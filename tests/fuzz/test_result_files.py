"""Result files with anything in them are compared and exported as they are, or refused in words."""

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import (
    build,
    fit,
    load_axis,
    load_result,
    monte_carlo,
    twin_record,
)
from benchmarks.random_axes import RandomAxis, random_axis
from tests.fuzz.cases import Fuzz, Run, WrongError, kept_to, one_of, places
from tests.unjudged import identify

#: What is put in the place of a value.
_VALUES: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1e308, -1e308, 5e-324, 10**400, 1e-300, "", "1", "x", "é", "\x00"),
    *(
        "\ud800",
        "a" * 3000,
        "\n",
        "*)",
        "*/",
        "\\",
        '"',
        [],
        [[]],
        {},
        {"a": 1},
        [None],
        [1e308] * 2,
    ),
    *("nan", "inf", "kg m^2", "%", "\u202e", "../..", "idm-ls", "axisid.stream/1", 2**63, 0.1),
)
#: Text that is put in as it is, JSON or not.
_TEXTS = ("NaN", "Infinity", "-Infinity", "1e400", "1E5", "0x10", "[" * 2000, "{", "}", ",", "\x00")

_ALIKE_NUMBERS = (None, 0, -1, 1, 2, 7, 0.5, 1e5, 1e308, -1e308, 1e200, 1e-300, 5e-324, 2**63)
_ALIKE_TEXTS = ("", "x", "%", "kg m^2", "é", "idm-ls", "hac", "iid", "position")


def changed_result(whole: Any, rng: np.random.Generator) -> str:
    """Draw the text of a result with something in it changed."""
    tree = deepcopy(whole)
    for _ in range(int(rng.choice([1, 1, 1, 2, 4]))):
        _change(tree, rng)
    text = json.dumps(tree)
    kind = rng.random()
    if kind < 0.1:
        return text[: int(rng.integers(len(text)))]
    if kind < 0.2:
        at = int(rng.integers(len(text)))
        return text[:at] + one_of(rng, _TEXTS) + text[at + int(rng.integers(3)) :]
    return text


def _drawn_place(tree: Any, rng: np.random.Generator) -> tuple[Any, Any]:
    """A place; what is near the root is as likely as the thousand numbers in its leaves."""
    there = list(places(tree))
    depth = int(rng.integers(1, max(level for level, *_ in there) + 1))
    _, holder, key = one_of(rng, [place for place in there if place[0] == depth])
    return holder, key


def _change(tree: Any, rng: np.random.Generator) -> None:
    holder, key = _drawn_place(tree, rng)
    kind = int(rng.integers(4))
    if kind == 0:
        del holder[key]
    elif kind == 1 and isinstance(holder, dict):
        holder[f"{key}x"] = holder.pop(key)
    elif kind == 2:
        _, other, place = one_of(rng, list(places(tree)))
        holder[key] = deepcopy(other[place])
    else:
        holder[key] = deepcopy(one_of(rng, _VALUES))


def altered_result(whole: Any, rng: np.random.Generator) -> str:
    """Draw the text of a result whose members keep their kinds, as an editor would leave them."""
    tree = deepcopy(whole)
    for _ in range(int(rng.choice([1, 1, 2]))):
        holder, key = _drawn_place(tree, rng)
        holder[key] = _alike(holder[key], rng)
    return json.dumps(tree)


def _alike(value: Any, rng: np.random.Generator) -> Any:
    """Another value of the same kind; of a list or an object one that lost or won a member."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, str):
        return one_of(rng, _ALIKE_TEXTS)
    if not isinstance(value, (dict, list)):
        return one_of(rng, _ALIKE_NUMBERS)
    members = list(value.items()) if isinstance(value, dict) else list(value)
    if not members or rng.random() < 0.2:
        return type(value)()
    one = one_of(rng, members)
    if rng.random() < 0.5:
        members.remove(one)
    else:
        members.append(("another", one[1]) if isinstance(value, dict) else one)
    return type(value)(members)


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
def test_changed_results_are_compared_or_refused(run: Run, result: Any, tmp_path: Path) -> None:
    first, second, output = (tmp_path / name for name in ("a.json", "b.json", "out.json"))
    first.write_text(json.dumps(result), encoding="utf-8")

    def check(text: str) -> None:
        second.write_text(text, encoding="utf-8", errors="surrogatepass")
        code, written = kept_to(
            run, "compare-results", first, second, "--json", output, output=output
        )
        if code == 0:
            json.loads(written, parse_constant=_refused)

    Fuzz(
        name="results compared",
        count=60,
        draw=lambda rng: changed_result(result, rng),
        check=check,
        shown=_text,
    ).run()


@pytest.mark.slow
def test_changed_results_are_exported_or_refused(
    run: Run, axis: RandomAxis, result: Any, tmp_path: Path
) -> None:
    declaration, file, output = (tmp_path / n for n in ("axis.toml", "a.json", "out.txt"))
    declaration.write_text(axis.toml, encoding="utf-8")

    def check(case: tuple[str, str]) -> None:
        text, target = case
        file.write_text(text, encoding="utf-8", errors="surrogatepass")
        code, written = kept_to(
            run,
            *("export", file, "--axis", declaration, "--to", target, "-o", output),
            output=output,
        )
        if code == 0 and target == "json":
            _compare(json.loads(text), json.loads(written, parse_constant=_refused))

    Fuzz(
        name="results exported",
        count=40,
        draw=lambda rng: (changed_result(result, rng), one_of(rng, TARGETS)),
        check=check,
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
