"""Comparing models: the law behind the data is found, and a richer one only where it is needed."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy

from axisid import (
    Axis,
    Coordinate,
    Parameter,
    Prefilter,
    Record,
    UsageError,
    build,
    compare,
    friction_ladder,
    load_axis,
    twin_record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.elements import Drive, spring
from axisid.estimation import Comparison
from axisid.estimation.model_selection.held_out import contiguous_blocks
from tests.axes.bodies import body
from tests.command_line import Refused, Run
from tests.refusals import refuses

ZOH = Prefilter(hold="zoh", drop=(48, 0))
RECIPE = Prefilter(cutoff=100.0, decimate=10, drop=(49, 0), hold="raw", reversals="keep")


@pytest.fixture(scope="module")
def ladder() -> dict[str, GeneratedAxis]:
    return {name: build(axis) for name, axis in friction_ladder(load_axis("emps2015")).items()}


@pytest.fixture(scope="module")
def symmetric(ladder: dict[str, GeneratedAxis], twin: Record) -> Comparison:
    return compare(ladder, twin, ZOH)


def directional_twin(axis: GeneratedAxis, unlike: float) -> Record:
    """The paper's experiment with friction that differs by direction, by a share of it."""
    truth = dict(zip(axis.names, [100.2, 236.9, 236.9, 24.8, 24.8], strict=True))
    truth["Fvm"] *= 1 + unlike
    truth["Fcm"] *= 1 + unlike
    experiment = load_axis("emps2015").experiment
    return twin_record(replace(axis.axis, experiment=replace(experiment, truth=truth)))


@pytest.mark.slow
def test_symmetric_friction_is_not_taken_for_a_directional_one(symmetric: Comparison) -> None:
    assert symmetric.recommended == "Coulomb"
    assert all(t.wald_p > 0.05 for t in symmetric.tests[1:])
    assert symmetric.tests[0].wald_p < 1e-16
    assert "viscous" not in symmetric.tied
    assert symmetric.checks == symmetric.result.checks


@pytest.mark.slow
def test_directional_friction_is_found(ladder: dict[str, GeneratedAxis]) -> None:
    found = compare(ladder, directional_twin(ladder["directional"], 0.1), ZOH)
    assert (found.recommended, found.tied) == ("directional", ("directional",))
    assert "richest candidate" in found.reason
    last = found.tests[-1]
    assert (last.smaller, last.larger, last.restrictions) == ("offset", "directional", 1)
    assert last.wald_p < 1e-3


@pytest.mark.slow
def test_a_richer_model_that_says_no_more_is_named(symmetric: Comparison) -> None:
    (test,) = (t for t in symmetric.tests if (t.smaller, t.larger) == ("Coulomb", "offset"))
    assert test.wald_p > 0.05
    assert "significantly better than Coulomb (Wald p = " in symmetric.summary()


def test_held_out_errors_are_those_of_a_run_by_hand(symmetric: Comparison) -> None:
    """The error of the third block, by the estimate from the others."""
    found = symmetric["Coulomb"]
    X, y = found.estimate.X, found.estimate.y
    block = contiguous_blocks(len(y), symmetric.gap, 5)[2]
    theta = np.linalg.lstsq(X[block.training], y[block.training], rcond=None)[0]
    error = (y - X @ theta)[block.held_out]
    assert found.equation.squares[2] == pytest.approx(float(error @ error), rel=1e-6)


@pytest.mark.slow
def test_candidates_that_cannot_be_told_apart_are_named(
    ladder: dict[str, GeneratedAxis],
) -> None:
    """A difference of 1 % in friction is lost in the noise: the poorer law is taken, and told."""
    record = directional_twin(ladder["directional"], 0.012)
    found = compare(ladder, record, ZOH)
    assert set(found.tied) > {found.recommended}
    assert found[found.recommended].size == min(found[name].size for name in found.tied)
    assert f"cannot tell {', '.join(found.tied[:-1])} and {found.tied[-1]} apart" in found.reason


@pytest.mark.slow
def test_axes_that_this_record_does_not_identify_are_left_out(
    ladder: dict[str, GeneratedAxis], twin: Record
) -> None:
    axis = ladder["Coulomb"].axis
    k, c = Parameter("k", "N/m"), Parameter("c", "N")
    twice = replace(axis, name="twice", parameters=(*axis.parameters, k, c),
                    force=axis.force + spring(k, axis.coordinate) + (k + c) * sympy.S.Zero
                    + c * sympy.sign(axis.coordinate.velocity)
                    * sympy.exp(axis.coordinate.symbol / 10**20))  # fmt: skip
    found = compare([ladder["Coulomb"], ladder["viscous"], twice], twin, ZOH)
    assert [*found.failures] == ["twice"]
    assert "twice is excluded" in found.summary()
    alone = compare({"good": ladder["Coulomb"], "twice": twice}, twin, ZOH)
    assert (alone.recommended, "the only candidate" in alone.reason) == ("good", True)


def test_without_a_loop_only_the_equation_is_compared(
    ladder: dict[str, GeneratedAxis], twin: Record
) -> None:
    free = {name: replace(ladder[name].axis, control=None) for name in ("viscous", "Coulomb")}
    found = compare(free, twin, ZOH)
    assert found.recommended == "Coulomb"
    assert all(c.estimate.simulation_error_percent is None for c in found.candidates)
    with refuses("comparison", says="no control law"):
        compare(free, twin, ZOH, "idm-iv")


def another(name: str, coordinate: Coordinate, drive: Drive) -> Axis:
    q = coordinate
    inertia = Parameter("J", "kg" if q.unit == "m" else "kg m^2", nominal=1.0)
    c = Parameter("c", "N" if q.unit == "m" else "N m")
    dry = c * sympy.sign(q.velocity)
    return body(dry, coordinate=q, inertia=inertia, parameters=(c,), name=name, drive=drive)


def test_axes_that_cannot_be_compared_are_refused(twin: Record) -> None:
    q, drive = Coordinate("q"), Drive(gain=35.15, limit=10.0)
    axis = another("one", q, drive)
    cases: list[tuple[list[Axis], str]] = [
        ([], "0 candidates cannot be compared"),
        ([axis], "1 candidate cannot be compared"),
        ([axis, axis], "'one' is the same axis as 'one'"),
        ([axis, another("two", Coordinate("x"), drive)], "coordinate x in m, but 'one' has q in m"),
        ([axis, another("two", Coordinate("q", "rad"), drive)], "the coordinate q in rad"),
        ([axis, another("two", q, Drive(gain=1.0))], "different drives .gain 1.0 and 35.15"),
        ([axis, replace(load_axis("emps2015"), name="one")], "two candidates are named 'one'"),
    ]
    for axes, message in cases:
        with pytest.raises(UsageError, match=message):
            compare(axes, twin)
    with refuses("comparison", says="'ddm-ls'"):
        compare([axis, load_axis("emps2015")], twin, method="ddm-ls")


def test_records_that_serve_no_candidate_are_refused(
    ladder: dict[str, GeneratedAxis], twin: Record
) -> None:
    n = 1200
    still = Record(
        time=twin.time[:n],
        position=np.linspace(0, 1, n),
        control=np.linspace(1, 2, n),
        sample_period=1e-3,
    )
    richest = {name: ladder[name] for name in ("offset", "directional")}
    with refuses("comparison", says="none of the candidates is identified: the record"):
        compare(richest, still, ZOH)
    found = compare(ladder, still, ZOH)
    assert set(found.failures) == set(richest)
    assert found.recommended is None
    assert "recommended: none; the smallest held-out error" in found.summary()
    assert [(c.status, c.meaning) for c in found.checks] == [("fail", found.reason)]
    with refuses("too-short", says="43"):
        compare(ladder, twin.windowed((None, 0.899)), ZOH)
    with refuses("missing-column"):
        compare(ladder, replace(twin, control=None), ZOH)


@pytest.mark.slow
def test_real_record_gives_the_published_directional_friction(
    emps_record: Record,
) -> None:
    """Row 2 of the published table to every printed digit, and the choice of its authors."""
    candidates = {name: build(each) for name, each in friction_ladder(load_axis("emps")).items()}
    result = compare(candidates, emps_record, RECIPE).to_dict()
    by_name = {c["name"]: c for c in result["candidates"]}
    estimate = by_name["directional"]["estimate"]
    published = {
        "M": "95.1540",
        "Fvp": "166.7061",
        "Fvm": "240.4236",
        "Fcp": "20.1440",
        "Fcm": "20.6277",
    }
    printed = {name: f"{p['value']:.4f}" for name, p in estimate["parameters"].items()}
    assert printed == published
    for name, error in (("directional", "3.1117"), ("offset", "4.0834")):
        assert f"{by_name[name]['estimate']['equation_error_percent']:.4f}" == error
    assert (result["recommended"], result["tied"]) == ("directional", ["directional"])
    held_out = {name: c["held_out_equation"]["error_percent"] for name, c in by_name.items()}
    assert held_out["directional"] < 3.3 < 4.0 < held_out["offset"]
    assert result["tests"][-1]["wald_p"] < 1e-10


AXIS = """
from axisid import Coordinate, Parameter, newton
from axisid.control import cascade_pd
from axisid.elements import Drive, coulomb, viscous

q = Coordinate("q")
M, Fv, Fc = Parameter("M", "kg", nominal=100.0), Parameter("Fv", "N/(m/s)"), Parameter("Fc", "N")
axis = newton(
    "stage", coordinate=q, parameters=(M, Fv, Fc), inertia=M,
    resistance=(viscous(Fv, q), coulomb(Fc, q)),
    drive=Drive(gain=35.15, unit="V", limit=10.0),
    control=cascade_pd(kp=160.18, kv=243.45, period=1e-3),
)
"""


@pytest.fixture
def files(here: Path, twin: Record) -> Path:
    """Two axes and a log, in the working directory."""
    text = AXIS.replace("Fv, Fc)", "Fv)").replace(
        "(viscous(Fv, q), coulomb(Fc, q))", "viscous(Fv, q)"
    )
    (here / "a.py").write_text(text)
    (here / "b.py").write_text(AXIS)
    (here / "c.py").write_text(AXIS.replace("stage", "third").replace("gain=35.15", "gain=7"))
    twin.write(here / "log.csv", load_axis("emps2015"))
    return here


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        # Two axes of one name go by what they were called on the command line.
        ("log.csv --axes a.py b.py", "stage b.py"),
        ("--axes a.py b.py log.csv", "stage b.py"),
        ("--axes a.py --axes b.py -- log.csv", "stage b.py"),
        ("log.csv --axes=a.py --axes=b.py", "stage b.py"),
        (
            "log.csv --ladder a.py --axes b.py --quadratic",
            "viscous Coulomb offset directional quadratic stage",
        ),
    ],
)
def test_axes_are_listed_in_any_usual_way(
    run: Run, files: Path, arguments: str, names: str
) -> None:
    code, _, err = run("compare", "--json", "out.json", "--hold", "zoh", *arguments.split())
    assert code == 0, err
    result = json.loads((files / "out.json").read_text())
    assert [c["name"] for c in result["candidates"]] == names.split()


@pytest.mark.slow
def test_a_parameter_is_left_out_of_every_candidate_that_has_it(run: Run, files: Path) -> None:
    text = (files / "b.py").read_text().replace("stage", "poor").replace("coulomb(Fc, q)", "Fc")
    (files / "d.py").write_text(text)
    arguments = "log.csv --axes a.py b.py d.py --leave-out Fv --hold zoh --json out.json"
    code, out, err = run("compare", *arguments.split())
    assert code == 0, err
    candidates = json.loads((files / "out.json").read_text())["candidates"]
    assert [[*c["estimate"]["parameters"]] for c in candidates] == [["M"], ["M", "Fc"], ["M", "Fc"]]
    assert [c["left_out"] for c in candidates] == [{"Fv": 0.0}] * 3
    arguments = arguments.replace("Fv", "Fc").replace("a.py", "")
    code, out, err = run("compare", *arguments.split())
    assert code == 0, err
    assert "stage and poor are the same model with different parameters." in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("log.csv --ladder b.py --leave-out Fc", "'Coulomb' of the ladder contains Fc"),
        ("log.csv --axes a.py b.py --leave-out Fz", "--leave-out Fz: no candidate"),
        ("log.csv", "--axes AXIS AXIS..., or --ladder AXIS"),
        ("log.csv --axes", "requires an argument"),
        ("log.csv --axes --ladder a.py", "--axes needs an axis"),
        ("log.csv --axes a.py", "1 candidate cannot be compared"),
        ("log.csv --axes a.py a.py", "is the same axis as 'stage'"),
        ("log.csv --axes a.py b.py b.py", "the axis b.py is given twice"),
        ("log.csv --axes a.py c.py", "different drives"),
        ("log.csv --axes a.py b.py --stribeck 0.1", "--ladder AXIS"),
        ("log.csv --axes a.py b.py --json b.py", "an input of this run"),
        ("--ladder emps2015 --columns time=t", "describes a record"),
    ],
)
def test_bad_command_lines_exit_2(
    refused: Refused, files: Path, arguments: str, message: str
) -> None:
    refused("compare", *arguments.split(), says=message)
