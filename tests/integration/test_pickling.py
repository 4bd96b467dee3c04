"""What the library gives can be copied and sent to another process, and is the same there."""

import copy
import dataclasses
import multiprocessing
import operator
import pickle
import warnings
from collections.abc import Iterator, Mapping
from multiprocessing.pool import Pool
from typing import Any

import numpy as np
import pytest

import axisid
from axisid import (
    AxisidError,
    Constant,
    DataError,
    EstimationError,
    FleetItem,
    ModelError,
    Prefilter,
    Signal,
    UsageError,
    build,
    compare,
    derive,
    fit,
    friction_ladder,
    identify,
    load_axis,
    load_result,
    simulate,
    sweep,
    trend,
    twin_record,
    validate,
)
from axisid.codegen.lowering.feed_forward import feed_forward
from axisid.elements import CONTROL, VELOCITY, State, formula_drive, voltage_drive
from axisid.estimation import (
    Chain,
    Classical,
    FailedRun,
    Hac,
    PublishedCovariance,
    RecordLanes,
    Repair,
    Repairs,
    Robust,
    SampledFilter,
    identify_lanes,
    simulate_batch,
    validate_fit,
)
from axisid.estimation.control_law_search import find_law
from axisid.estimation.diagnostics.control_law.law_agreement import law_agreement
from axisid.estimation.identification import DriveTime
from axisid.fleets import Fleet, FleetRow
from axisid.modeling import LIBRARY, Column
from axisid.support import arrays
from tests.estimation.monte_carlo.short import judged

FILTER = Prefilter(cutoff=60.0)


def sent(what: Any) -> Any:
    return pickle.loads(pickle.dumps(what))  # noqa: S301


def same(a: Any, b: Any) -> bool:
    """Whether two objects are equal to the last bit, all the way down."""
    if isinstance(a, Exception):
        return type(a) is type(b) and a.args == b.args
    return arrays.same(a, b)


@pytest.fixture(scope="module")
def objects(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """One of every kind that a user gets to see."""
    declared = load_axis("emps2015")
    axis = build(declared)
    record = twin_record(axis)
    found = identify(axis, record, FILTER)
    reference = record.reference
    log = tmp_path_factory.mktemp("log") / "log.csv"
    log.write_text("time,position,force\n0,1,2\n")
    saved = load_result(found.save(log.with_name("result.json")))
    ladder = friction_ladder(declared)
    lanes = RecordLanes(
        reference=reference.copy(),
        position=record.position[:, None].copy(),
        control=record.control[:, None].copy(),
        period=record.period,
    )
    bounded = fit(axis, record, bounds={"Fc": (None, 20.0)})
    return {
        "axis": declared,
        "model": derive(declared),
        "generated axis": axis,
        "coordinate": declared.coordinate,
        "column": Column("inc", resolution=4096, gear=50),
        "signal": Signal("pressure", "Pa", "held"),
        "state": State("z", "m", declared.coordinate.velocity, limit=1e-5),
        "parameter": declared.parameters[0],
        "constant": Constant(2.0, "kg", "plate"),
        "law": declared.control,
        "drive": (
            declared.drive,
            voltage_drive(kt=0.05, ke=0.05, resistance=1.2, efficiency=0.8),
            formula_drive(2.0 * CONTROL - VELOCITY),
        ),
        "experiment": declared.experiment,
        "record": record,
        "masked record": dataclasses.replace(record, masked=((5, 9),)),
        "prefilter": FILTER,
        "sampled filter": SampledFilter(FILTER, record.period),
        "repairs": Repairs(),
        "repair": Repair(kind="tail", count=1, text="a line left out at the end"),
        "identification": found,
        "estimate": found["idm-iv"],
        "value": found["idm-iv"].parameters["M"],
        "diagnosis": found.diagnosis,
        "verdict": found.verdict,
        "residual tests": found["idm-iv"].residual_tests,
        "draws": found["idm-iv"].propagate("Fv/M", draws=50),
        "covariances": (PublishedCovariance(), Classical(), Robust(), Hac()),
        "saved identification": saved,
        "saved estimate": saved["idm-iv"],
        "validation": validate(found, record),
        "sweep": sweep(axis, record, [40.0, 80.0], FILTER, ["idm-ls"]),
        "fit": bounded,
        "fit on another record": validate_fit(bounded, record),
        "comparison": compare(ladder, record, FILTER),
        "simulation": simulate(axis, axis.nominal, reference, record.period),
        "batch": simulate_batch(axis, [axis.nominal], reference, record.period),
        "lanes": (lanes, identify_lanes(axis, lanes)),
        "law check": law_agreement(axis, record),
        "law search": find_law(axis, record.windowed((0.0, 1.0))),
        "study": (
            judged(),
            judged().figures,
            judged().check_figures,
            Chain(position=1e-6, disturbances=((0.01, 0.1),)),
            FailedRun(run=3, of="idm-iv", reason="singular"),
        ),
        "block": axisid.control.difference(axisid.control.REFERENCE, name="q1", start=0),
        "drive time": DriveTime(
            name="lag",
            parameter=axisid.Parameter("Tc", "s"),
            value=1e-3,
            deviation=1e-5,
            interval=(0.98e-3, 1.02e-3),
        ),
        "fleet": Fleet(
            folder="results", rows=(FleetRow(name="a", log="a.csv", axis="emps2015", status="ok"),)
        ),
        "fleet item": FleetItem(log="a.csv", conditions={"temperature": 21.0}),
        "trend": trend([saved]),
        "feed-forward": feed_forward(
            derive(declared), {p.name: (1.0, "") for p in declared.parameters}
        ),
        **{
            f"error {kind.__name__}": kind("what was wrong")
            for kind in (AxisidError, ModelError, UsageError, DataError, EstimationError)
        },
    }


KINDS = (
    "axis,model,generated axis,coordinate,column,signal,state,parameter,constant,law,drive,"
    "experiment,"
    "record,masked record,prefilter,sampled filter,repairs,repair,identification,estimate,value,"
    "diagnosis,verdict,"
    "residual tests,draws,covariances,saved identification,saved estimate,validation,sweep,"
    "fit,fit on another record,comparison,simulation,batch,lanes,law check,study,"
    "law search,block,drive time,fleet,fleet item,trend,"
    "feed-forward,error AxisidError,"
    "error ModelError,error UsageError,error DataError,error EstimationError"
).split(",")


@pytest.fixture(scope="module")
def elsewhere() -> Iterator[Pool]:
    """Another process that knows nothing of this one."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        yield pool


#: What says when it is equal, to the last bit, in place of NumPy's array of truths.
EQUAL = (
    "generated axis,record,masked record,identification,estimate,saved identification,"
    "saved estimate,validation,sweep,fit,comparison,simulation,batch"
).split(",")


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_copy_is_equal(objects: dict[str, Any], kind: str) -> None:
    original = objects[kind]
    for copied in (copy.deepcopy(original), copy.copy(original), sent(original)):
        assert same(original, copied)
        if kind in EQUAL:
            assert original == copied != 3


@pytest.mark.slow
def test_one_bit_apart_is_not_equal(objects: dict[str, Any]) -> None:
    record, found = objects["record"], objects["identification"]
    moved = record.position.copy()
    moved[7] = np.nextafter(moved[7], np.inf)
    other = dataclasses.replace(record, position=moved)
    assert record != other
    assert validate(found, record) != validate(found, other)
    theta = found["idm-ls"].theta.copy()
    theta[0] = np.nextafter(theta[0], np.inf)
    estimate = dataclasses.replace(found["idm-ls"], theta=theta)
    assert estimate != found["idm-ls"]
    assert dataclasses.replace(found, estimates={"idm-ls": estimate}) != found
    assert objects["generated axis"] != build(load_axis("pendulum"))


@pytest.mark.parametrize("kind", KINDS)
def test_round_trip_through_another_process_changes_nothing(
    objects: dict[str, Any], kind: str, elsewhere: Pool
) -> None:
    assert same(objects[kind], elsewhere.apply(operator.getitem, ((objects[kind],), 0)))


def _types(held: Any) -> Iterator[type]:
    """The class of an object and of all that it holds."""
    yield type(held)
    if dataclasses.is_dataclass(held):
        held = [getattr(held, field.name) for field in dataclasses.fields(held)]
    elif isinstance(held, Mapping):
        held = list(held.values())
    if isinstance(held, (tuple, list)):
        for each in held:
            yield from _types(each)


def test_every_public_class_is_among_them(objects: dict[str, Any]) -> None:
    seen = {axisid.control.Memory, *_types(tuple(objects.values()))}
    faces = (axisid, axisid.modeling, axisid.codegen, axisid.estimation)
    named = [getattr(face, name) for face in faces for name in face.__all__]
    assert {each for each in named if isinstance(each, type)} - seen == set()
    assert set(KINDS) == set(objects)


@pytest.mark.parametrize("name", LIBRARY)
def test_axes_of_the_library_are_equal_elsewhere(name: str, elsewhere: Pool) -> None:
    axis = load_axis(name)
    assert elsewhere.apply(load_axis, (name,)) == axis
    assert sent(axis) == axis
    assert same(derive(axis), elsewhere.apply(derive, (axis,)))


def test_results_of_another_process_are_those_of_this_one(
    objects: dict[str, Any], elsewhere: Pool
) -> None:
    axis, record = objects["generated axis"], objects["record"]
    theirs = elsewhere.apply(identify, (axis, record, FILTER))
    assert same(objects["identification"], theirs)
    assert same(
        objects["simulation"],
        elsewhere.apply(simulate, (axis, axis.nominal, record.reference, record.period)),
    )


def test_generated_axis_is_built_once_in_a_process(objects: dict[str, Any]) -> None:
    axis = objects["generated axis"]
    first, second = (sent(axis) for _ in range(2))
    assert first is second
    assert copy.deepcopy(axis) is axis


@pytest.mark.slow
def test_virtual_machine_stays_the_virtual_machine(elsewhere: Pool) -> None:
    axis = sent(build(load_axis("emps2015"), native=False))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert axis.native.library() is None
    assert axis.native.refusal == "it was switched off"
