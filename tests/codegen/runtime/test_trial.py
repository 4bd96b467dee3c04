"""The trial of native code."""

from pathlib import Path

import pytest
import sympy

from axisid import Axis, Constant, Parameter, build
from axisid.codegen.runtime.library_cache import Compiler
from axisid.control import cascade_pd
from axisid.elements import Drive, coulomb, cubic_spring, end_stop, viscous
from tests.axes.bodies import body, x

pytestmark = pytest.mark.slow

m, fv = Parameter("m", "kg", nominal=95.0), Parameter("fv", "N/(m/s)", nominal=200.0)
fc, c = Parameter("fc", "N", nominal=20.0), Parameter("c", "N/m^12", nominal=1.0)
k = Parameter("k", "N/m^3", nominal=1.0)
SAMPLED = cascade_pd(kp=160.18, kv=243.45, period=1e-3)
CONTINUOUS = cascade_pd(kp=160.18, kv=243.45, period=1e-3, continuous=True)
METRE, SECOND = Constant(1.0, "m"), Constant(1.0, "s")


def declared(
    name: str, *resistance: sympy.Expr, law: object = SAMPLED, gain: float = 35.15
) -> Axis:
    parameters, drive = (fv, fc, c, k), Drive(gain=gain)
    more = {"parameters": parameters, "drive": drive, "control": law}
    return body(*resistance, coordinate=x, inertia=m, name=name, **more)


LOST = sympy.log(x.velocity * SECOND / METRE - 100)
# Faster than a millisecond somewhere about 1: what the plant or the loop does to rounding in a
# few samples of that length says nothing of the code; some have no value where it is tried.
FAST = {
    axis.name: axis
    for axis in (
        declared("published_law", viscous(fv, x), coulomb(fc, x), law=CONTINUOUS),
        declared("viscous_1e4", viscous(Constant(1e4, "N/(m/s)"), x)),
        declared("power_of_12", c * (x.symbol + SECOND * x.velocity + METRE) ** 12),
        declared("exponential", fc * sympy.exp(50 * x.symbol / METRE)),
        declared("high_gain", viscous(fv, x), gain=1e6),
        declared("hard_stop", coulomb(fc, x), end_stop(x, lower=-0.05, upper=0.05, stiffness=1e8)),
        declared("far_spring", cubic_spring(k, x, rest=1)),
        declared("fine_wave", fc * sympy.cos(2000 * x.symbol / METRE)),
        declared("imaginary", fc * sympy.sqrt(-1 - (x.symbol / METRE) ** 2)),
        declared(
            "lost", fc * sympy.Max(x.symbol / METRE - LOST, sympy.cos(x.symbol**2 / METRE**2))
        ),
        declared("root", coulomb(fc, x), fc * sympy.sqrt(x.symbol / METRE)),
    )
}


@pytest.fixture(autouse=True)
def _cache(c_compiler: Compiler, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AXISID_CACHE", str(tmp_path / "cache"))


@pytest.mark.parametrize("name", FAST)
def test_right_code_of_a_fast_model_passes(name: str) -> None:
    native = build(FAST[name]).native
    assert native.library() is not None, native.refusal
