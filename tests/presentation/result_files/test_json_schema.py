"""What is written as JSON is what the schema documents, no more and no less.

Files that hold what their schema allows and no result can be, by every door that reads one.
"""

import json
import runpy
from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import pytest
from jsonschema import Draft202012Validator

from axisid import (
    Prefilter,
    Record,
    compare,
    compare_results,
    export,
    fit,
    friction_ladder,
    load_axis,
    load_result,
    sweep,
    twin_record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation.control_law_search import find_law
from axisid.presentation.result_files import plain, schema_of
from axisid.presentation.result_files.identification import WrittenIdentification
from axisid.presentation.result_files.output_fit import WrittenOutputFit
from axisid.presentation.result_files.studies import (
    WrittenComparison,
    WrittenLawSearch,
    WrittenSweep,
)
from axisid.support.arrays import from_json
from tests.refusals import refuses
from tests.unjudged import identify

DOCUMENTS = (
    WrittenIdentification,
    WrittenSweep,
    WrittenComparison,
    WrittenLawSearch,
    WrittenOutputFit,
)


@pytest.fixture(scope="module")
def schema(root: Path) -> dict[str, Any]:
    document: dict[str, Any] = json.loads(
        (root / "docs" / "schema" / "results-1.json").read_text(encoding="utf-8")
    )
    return document


@pytest.fixture(scope="module")
def checker(schema: dict[str, Any]) -> Draft202012Validator:
    return Draft202012Validator(schema)


@pytest.mark.slow
def test_the_file_of_the_schema_is_one_and_what_the_classes_make(
    root: Path, schema: dict[str, Any]
) -> None:
    Draft202012Validator.check_schema(schema)
    made = runpy.run_path(str(root / "docs" / "results_schema.py"))["schema_text"]()
    assert json.loads(made) == schema, "run: python docs/results_schema.py"


def _check(checker: Draft202012Validator, written: dict[str, Any]) -> None:
    """It is what the schema documents, and is read and written again as it was."""
    checker.validate(written)
    document = next(d for d in DOCUMENTS if schema_of(d) == written["schema"])
    read = msgspec.json.decode(json.dumps(written), type=document, dec_hook=from_json)
    members = {name: value for name, value in written.items() if name != "digest"}
    assert json.dumps(plain(read)) == json.dumps(members)


@pytest.mark.slow
def test_schema_and_classes_refuse_the_same(schema: dict[str, Any]) -> None:
    checker = Draft202012Validator({**schema["$defs"]["identification"], "$defs": schema["$defs"]})
    axis = load_axis("linear_motor")
    whole = _short(json.loads(json.dumps(identify(axis, twin_record(axis)).to_dict())))
    values: tuple[Any, ...] = (None, True, 0, 1.5, "x", [], {}, [0.5, 2.5])
    for i, place in enumerate(_places(whole)):
        if place == ("levels",):  # an empty one is filled with defaults, which are always written
            continue
        spoiled = deepcopy(whole)
        holder: Any = spoiled
        for key in place[:-1]:
            holder = holder[key]
        holder[place[-1]] = values[i % len(values)]
        try:
            msgspec.json.decode(json.dumps(spoiled), type=WrittenIdentification, dec_hook=from_json)
            accepted = True
        except msgspec.ValidationError:
            accepted = False
        assert accepted == checker.is_valid(spoiled), place


def _short(value: Any) -> Any:
    """The same with two members of each list."""
    if isinstance(value, dict):
        return {key: _short(each) for key, each in value.items()}
    return [_short(each) for each in value[:2]] if isinstance(value, list) else value


def _places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Every place, of each list the first."""
    keys = list(value) if isinstance(value, dict) else range(min(len(value), 1))
    for key in keys:
        yield (*path, key)
        if isinstance(value[key], (dict, list)):
            yield from _places(value[key], (*path, key))


@pytest.mark.slow
@pytest.mark.parametrize(
    "made",
    [
        lambda axis, record: identify(axis, record).to_dict(draws=20),
        lambda axis, record: identify(axis, record, methods="ddm-iv").to_dict(),
        lambda axis, record: sweep(axis, record, (30.0, 90.0)).to_dict(),
        lambda axis, record: find_law(axis, record.windowed((0.0, 1.0))).to_dict(),
        lambda axis, record: compare(friction_ladder(axis.declared), record).to_dict(),
        lambda axis, record: fit(axis, record, bootstrap=8, starts=2).to_dict(),
        lambda axis, record: fit(
            axis,
            record,
            output="position",
            bounds={"Fc": (None, 20.0)},
            prior={"M": (100.0, 1.0)},
        ).to_dict(),
        lambda axis, record: fit(
            axis, record, fixed={"M": 100.0}, loss="huber", start="nominal"
        ).to_dict(),
    ],
    ids="draws ddm-iv sweep law comparison fit bounds fixed".split(),
)
def test_what_is_written_is_what_the_schema_says(
    checker: Draft202012Validator,
    emps2015: GeneratedAxis,
    twin: Record,
    made: Callable[[GeneratedAxis, Record], dict[str, Any]],
) -> None:
    _check(checker, made(emps2015, twin))


@pytest.mark.slow
def test_identification_with_a_second_record(
    checker: Draft202012Validator, run: Any, tmp_path: Path, twin: Record
) -> None:
    path = twin.write(tmp_path / "second.csv", load_axis("emps2015"))
    _, out, _ = run("identify", "emps2015", "--validate", str(path), "--json", "-")
    written = json.loads(out)
    _check(checker, written)
    assert written["validation"]["methods"]


@pytest.mark.slow
def test_identification_that_lacks_what_can_be_lacking(
    checker: Draft202012Validator, emps2015: GeneratedAxis, twin: Record
) -> None:
    for axis, record in (
        (replace(emps2015.axis, control=None), twin),
        (emps2015.axis, replace(twin, reference=None)),
    ):
        written = identify(axis, record).to_dict()
        _check(checker, written)
        assert (written["instruments"], written["law_check"]["passed"]) == (None, None)


@pytest.mark.slow
def test_direct_model_has_a_further_covariance_where_it_is_chosen(
    checker: Draft202012Validator, emps2015: GeneratedAxis, twin: Record
) -> None:
    further = {}
    for chosen in ("hac", "robust"):
        written = identify(emps2015, twin, methods="ddm-ls", covariance=chosen).to_dict()
        _check(checker, written)
        further[chosen] = written["estimates"][0].get("theta_ddm_covariances", {})
    assert {chosen: [*each] for chosen, each in further.items()} == {
        "hac": [],
        "robust": ["robust"],
    }


@pytest.mark.slow
def test_physical_parameters_by_known_values(
    checker: Draft202012Validator, run: Any, root: Path, tmp_path: Path
) -> None:
    declared = (root / "examples" / "pendulum.py").read_text(encoding="utf-8")
    mass = 'm, l = Parameter("m", "kg", nominal=1.0), Parameter("l", "m", nominal=0.3)'
    for old, new in (
        ("theta = Coord", f"{mass}\ntheta = Coord"),
        ("J, mgl, fv", "J, m, l, fv"),
        ("-mgl *", "-9.81 * m * l *"),
        ('"mgl": 1.0', '"m": 0.5, "l": 0.2'),
    ):
        assert old in declared
        declared = declared.replace(old, new)
    (tmp_path / "rod.py").write_text(declared)
    plain, fixed = (
        json.loads(run("identify", tmp_path / "rod.py", *options, "--json", "-")[1])
        for options in ([], ["--fix", "m=0.5+-0.01", "--fix", "J=0.0626"])
    )
    for written in (plain, fixed):
        _check(checker, written)
    names = [set(w["estimates"][0]["physical"]["parameters"]) for w in (plain, fixed)]
    assert names == [{"J", "fv", "fc"}, {"J", "m", "l", "fv", "fc"}]
    physical = fixed["estimates"][2]["physical"]
    assert physical["base"] == {"m_l": "l*m"}
    assert physical["fixed"] == {
        "J": {"value": 0.0626, "sd": 0.0},
        "m": {"value": 0.5, "sd": 0.01},
    }
    assert physical["parameters"]["l"]["value"] == pytest.approx(0.2, rel=1e-3)
    assert physical["parameters"]["l"]["sd"] == pytest.approx(0.2 * 0.02, rel=1e-2)
    assert [c["status"] for c in fixed["verdict"] if c["name"] == "fixed values"] == ["pass"]


DOORS: dict[str, Callable[[Path], object]] = {
    "load_result": load_result,
    "export": lambda file: export(file, axis="emps2015"),
    "compare_results": lambda file: compare_results(file, file),
}


@pytest.fixture(scope="module")
def written(emps2015: GeneratedAxis, twin: Record) -> str:
    result = identify(emps2015, twin, Prefilter(cutoff=60.0), ["idm-ls", "idm-iv"])
    return json.dumps(result.to_dict())


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize(
    ("change", "said"),
    [({"judged": "ddm-iv"}, "'ddm-iv'"), ({"estimates": []}, "it has no summary")],
)
def test_every_door_refuses_what_no_result_can_be(
    written: str, tmp_path: Path, change: dict[str, Any], said: str, door: str
) -> None:
    file = tmp_path / "x.json"
    file.write_text(json.dumps({**json.loads(written), **change}))
    with refuses("result-file", says=f"contradicts itself: .*{said}"):
        DOORS[door](file)


@pytest.mark.slow
@pytest.mark.parametrize("door", DOORS)
def test_every_door_refuses_a_file_that_was_changed_after_it_was_written(
    emps2015: GeneratedAxis, twin: Record, tmp_path: Path, door: str
) -> None:
    file = tmp_path / "x.json"
    identify(emps2015, twin, methods=["idm-ls"]).save(file)
    content = json.loads(file.read_text())
    laid_out = json.dumps(content).replace("1.0,", "1,")  # in another way, which changes nothing
    file.write_text(laid_out)
    DOORS[door](file)
    content["estimates"][0]["parameters"]["M"]["sd_hac"] *= 2
    file.write_text(json.dumps(content))
    with refuses("changed-result", says="remove the member digest"):
        DOORS[door](file)
    del content["digest"]
    file.write_text(json.dumps(content))
    DOORS[door](file)
