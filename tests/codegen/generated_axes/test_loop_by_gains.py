"""Gains of a law are arguments of what is compiled: another gain is another number, and no code."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from axisid import build, load_axis, simulate
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.generated_axes.texts import axis_artefacts
from axisid.codegen.printers import with_loop_header
from axisid.codegen.runtime import Native
from axisid.estimation import simulate_batch
from axisid.modeling.derivation import derive
from tests.axes.bodies import body
from tests.refusals import refuses

REFERENCE = 0.02 * np.sin(np.linspace(0, 12, 400)) ** 2
OTHER = {"kp": 140.0, "kv": 260.0}


def _declared_anew(axis: GeneratedAxis, *, native: bool = True) -> GeneratedAxis:
    law = axis.declared.control
    return build(replace(axis.declared, control=replace(law, gains=OTHER)), native=native)


def _path(axis: GeneratedAxis) -> str:
    library = axis.native.library()
    if library is None:
        pytest.skip(axis.native.refusal)
    return str(library.path)


def test_an_axis_with_another_gain_is_the_one_declared_with_it(emps: GeneratedAxis) -> None:
    changed, anew = emps.with_gains(OTHER), _declared_anew(emps)
    assert changed == anew
    assert changed.signature == anew.signature != emps.signature
    loops = [simulate(each, each.nominal, REFERENCE, 1e-3) for each in (changed, anew)]
    assert np.array_equal(loops[0].control, loops[1].control)
    inputs = (1e-3, 2e-3, 0.0, [1e-3, 1e-3])
    for name in ("control_law", "control_terms"):
        mine, theirs = (each.functions[name].call(inputs) for each in (changed, anew))
        assert all(np.array_equal(a.full(), b.full()) for a, b in zip(mine, theirs, strict=True))


def test_another_gain_is_not_compiled(emps: GeneratedAxis, monkeypatch: pytest.MonkeyPatch) -> None:
    path = _path(emps)
    monkeypatch.setattr("axisid.codegen.runtime.library_cache._build", None)
    assert _path(emps.with_gains({"kp": 3.0})) == path
    assert _path(_declared_anew(emps)) == path
    there = pickle.dumps(emps.with_gains(OTHER))
    assert _path(pickle.loads(there)) == path  # noqa: S301


@pytest.mark.slow
def test_numbers_are_those_of_code_that_has_the_gains_in_it(emps: GeneratedAxis) -> None:
    if emps.native.library() is None:
        pytest.skip(emps.native.refusal)
    text = with_loop_header(axis_artefacts(derive(emps.declared))["native.c"])
    literal = replace(emps, native=Native(text, emps.functions), loop=None)
    own, with_numbers = (simulate(each, each.nominal, REFERENCE, 1e-3) for each in (emps, literal))
    for name in ("position", "velocity", "acceleration", "control"):
        assert np.array_equal(getattr(own, name), getattr(with_numbers, name)), name


@pytest.mark.parametrize("native", [True, False])
def test_lanes_have_gains_of_their_own(emps: GeneratedAxis, *, native: bool) -> None:
    axis = emps if native else build(load_axis("emps"), native=False)
    gains = {"kp": np.array([100.0, 160.18, 200.0]), "kv": 250.0}
    lanes = np.tile(axis.nominal, (3, 1))
    reference = REFERENCE if native else REFERENCE[:60]
    batch = simulate_batch(axis, lanes, reference, 1e-3, gains=gains, wanted=["control"])
    for lane, kp in enumerate(gains["kp"]):
        own = axis.with_gains({"kp": float(kp), "kv": 250.0})
        alone = simulate(own, axis.nominal, reference, 1e-3)
        assert batch["control"][:, lane] == pytest.approx(alone.control, rel=1e-12, abs=1e-12)


def test_an_integral_in_balance_is_so_by_the_gains_of_its_lane() -> None:
    axis = build(load_axis("servo_joint"), native=False)
    tn = np.array([0.02, 0.05])
    still = np.full(20, 0.3)
    lanes = np.tile(axis.nominal, (2, 1))
    batch = simulate_batch(axis, lanes, still, 1e-3, gains={"tn": tn}, wanted=["position"])
    assert batch["position"] == pytest.approx(0.3, abs=1e-12)


def test_gains_that_cannot_change_are_refused(emps: GeneratedAxis) -> None:
    with refuses("law"):
        emps.with_gains({"ki": 1.0})
    with refuses("law"):
        build(body(control=None), native=False).with_gains({"kp": 1.0})
    with refuses("simulation-input"):
        simulate_batch(emps, emps.nominal[None], REFERENCE, 1e-3, gains={"kp": [1.0, 2.0]})
