"""The real record gives the published figures, and its ladder of models those of its page."""

import importlib
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import sympy

from axisid import Prefilter, Record, identify, simulate
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.estimation.signals import SampledFilter
from axisid.modeling.quantities import with_numbers
from axisid.support.arrays import relative_error_percent

PUBLISHED = {
    "M": ("95.1089", "0.1085"),
    "Fv": ("203.5034", "1.1460"),
    "Fc": ("20.3935", "0.1012"),
    "tau0": ("-3.1648", "0.0444"),
}
RECIPE = Prefilter(cutoff=100.0, decimate=10, drop=(49, 0), hold="raw", reversals="keep")


@pytest.mark.slow
def test_published_least_squares_to_every_printed_digit(
    emps: GeneratedAxis, emps_record: Record
) -> None:
    (estimate,) = identify(emps, emps_record, RECIPE, ["idm-ls"]).to_dict()["estimates"]
    for name, (value, sd) in PUBLISHED.items():
        parameter = estimate["parameters"][name]
        assert f"{parameter['value']:.4f}" == value
        assert f"{parameter['sd']:.4f}" == sd
    assert f"{estimate['equation_error_percent']:.4f}" == "4.0834"
    assert estimate["rows"] == 2480
    assert f"{estimate['condition_number']:.3f}" == "25.988"


def test_instrumental_variables_from_the_cad_value(
    emps: GeneratedAxis, emps_record: Record
) -> None:
    prefilter = Prefilter(cutoff=60.0, decimate=10, drop=(49, 0), hold="raw", reversals="keep")
    result = identify(emps, emps_record, prefilter, ["idm-iv", "ddm-iv"], start="nominal")
    inverse, direct = result["idm-iv"], result["ddm-iv"]
    assert inverse.iterates[0].physical.tolist() == [100.0, 0.0, 0.0, 0.0]
    assert len(inverse.iterates) - 1 <= 4
    assert inverse.physical == pytest.approx([95.177, 203.253, 20.425, -3.175], rel=5e-4)
    assert direct.physical == pytest.approx(inverse.physical, rel=1e-9)


def test_recovered_control_law_reproduces_the_recorded_control(
    emps: GeneratedAxis, emps_record: Record
) -> None:
    """To 0.24 % of its norm: the law, its velocity filter and its gains are the drive's."""
    law = emps.functions["control_law"]
    reference, position = emps_record.reference, emps_record.position
    before = np.concatenate([position[:1], position[:1], position[:-2]])
    last = np.concatenate([position[:1], position[:-1]])
    arguments = [reference, position, np.zeros_like(position)]
    control, _ = law.call([a[None, :] for a in arguments] + [np.vstack([last, before])])
    error = control.full()[0] - emps_record.control
    assert relative_error_percent(error[2:], emps_record.control[2:]) < 0.245


def test_simulated_loop_follows_the_machine(emps: GeneratedAxis, emps_record: Record) -> None:
    """Errors in percent of the measured signals' norms, filtered at 100 Hz; the force is not."""
    theta = np.array([95.1089, 203.5034, 20.3935, -3.1648])
    loop = simulate(emps, theta, emps_record.reference, 1e-3, start=emps_record.position[0])
    q, dq, ddq = SampledFilter(Prefilter(cutoff=100.0), 1e-3).motion(emps_record.position)
    force = emps.axis.drive.gain * emps_record.control
    pairs = [
        (loop.position, q, 0.002),
        (loop.velocity, dq, 0.15),
        (loop.acceleration, ddq, 7.0),
        (loop.force, force, 5.0),
    ]
    for simulated, measured, most in pairs:
        assert relative_error_percent((simulated - measured)[49:], measured[49:]) <= most


@pytest.mark.slow
@pytest.mark.parametrize(
    ("cutoff", "decimate", "raw", "aligned"), [(100.0, 10, 231.1, 234.6), (180.0, 3, 233.5, 237.4)]
)
def test_half_a_sample_of_the_hold_is_seen_in_viscous_friction(
    emps: GeneratedAxis,
    emps_record: Record,
    cutoff: float,
    decimate: int,
    raw: float,
    aligned: float,
) -> None:
    """Noise-free simulation with Fv = 236.9 along the record's reference."""
    theta = np.array([100.2, 236.9, 24.8, 0.0])
    loop = simulate(emps, theta, emps_record.reference, 1e-3)
    record = Record(
        time=np.arange(len(loop.control)) * 1e-3,
        position=loop.position,
        reference=emps_record.reference,
        control=loop.control,
        sample_period=1e-3,
    )
    for hold, expected in (("raw", raw), ("zoh", aligned)):
        prefilter = Prefilter(
            cutoff=cutoff,
            decimate=decimate,
            drop=(49, 0),
            hold=hold,  # type: ignore[arg-type]
            reversals="keep",
        )
        estimate = identify(emps, record, prefilter, ["idm-ls"])["idm-ls"]
        assert estimate.parameters["Fv"].value == pytest.approx(expected, abs=1.0)


ROOT = Path(__file__).resolve().parents[2]
DOCUMENT = (ROOT / "docs" / "emps_ladder.md").read_text()
FRICTION = {"Fv": 200.0, "Fc": 20.0, "Fd": -35.0, "kd": -3.0}


@pytest.fixture(scope="module")
def study() -> Iterator[ModuleType]:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "examples"))
        yield importlib.import_module("emps_ladder")


@pytest.fixture(scope="module")
def models(study: ModuleType) -> ModuleType:
    return importlib.import_module("emps_ladder_models")


@pytest.fixture(scope="module")
def data(study: ModuleType, emps_file: Path) -> Any:
    return study.read_data(emps_file)


def documented(words: str) -> list[float]:
    """Numbers of the document's row of the ladder that starts with some words."""
    (row,) = [line for line in DOCUMENT.splitlines() if line.startswith(f"| {words} |")][:1]
    return [float(n) for n in re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?", row.split("|", 2)[2])]


def test_without_terms_it_is_the_published_model(models: ModuleType) -> None:
    axis = models.axis_with()
    q = axis.coordinate
    M, Fv, Fc, tau0 = (p.symbol for p in axis.parameters)
    stated = M * q.acceleration + Fv * q.velocity + Fc * sympy.sign(q.velocity) + tau0
    assert sympy.expand(axis.force - stated) == 0
    assert axis.control is None


def test_friction_at_a_scale_of_one_is_what_it_was(models: ModuleType) -> None:
    terms = ("direction", "slope", "friction slope")
    values = {"M": 95.0, "tau0": -0.5, "k": 2.0, **FRICTION}
    whole, two = models.axis_with(terms), models.rescaled(terms, values)
    frozen = whole.force.xreplace({p.symbol: values[p.name] for p in whole.parameters})
    scale, tau0 = (p.symbol for p in two.parameters)
    q = whole.coordinate
    at = {q.symbol: 0.2, q.velocity: -0.1, q.acceleration: 0.7, tau0: -0.5}
    forces = [
        float(with_numbers(force).subs({**at, scale: size}))
        for force, size in ((frozen, 1.0), (two.force, 1.0), (two.force, 1.1))
    ]
    assert forces[0] == pytest.approx(forces[1], rel=1e-12)
    friction = -20.0 - 20.0 + 0.1 * -35.0 + 3.0 * (0.2 - 0.1232)
    assert forces[2] - forces[1] == pytest.approx(0.1 * friction, rel=1e-9)


@pytest.mark.slow
def test_document_has_the_held_out_errors_of_the_first_rungs(study: ModuleType, data: Any) -> None:
    starts: list[list[Any]] = [["nominal"]] * 4
    for terms, words in (((), "published"), (("direction",), "+ direction")):
        score = study.scored(data, study.Model(terms=terms), 1.0, study.leave_one_out(), starts)
        assert 1e6 * score.error == pytest.approx(documented(words)[1], rel=0.02)
        starts = [[values] for values in score.values]


@pytest.mark.slow
def test_document_has_what_a_force_leaves(study: ModuleType, data: Any) -> None:
    limits = importlib.import_module("emps_ladder_limits")
    model = study.Model(terms=("direction",))
    values = {"M": 92.83, "Fv": 200.8, "Fc": 20.75, "tau0": -0.157, "Fd": -38.47}
    found = limits.drifts(data, model, values)
    for name, of in found.items():
        stated = documented(f"{name} window")
        assert 50.0 * 1e3 * np.array([*of.values()]) == pytest.approx(stated, rel=0.05)
