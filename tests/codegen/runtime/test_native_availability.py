"""Compiled code: the same numbers as the virtual machine, whatever happens around its building."""

import functools
import os
import shlex
import signal
import stat
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy

from axisid import Constant, Coordinate, UsageError, build, derive, load_axis
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.codegen.generated_axes.texts import axis_artefacts
from axisid.codegen.printers import print_c_loop_header
from axisid.codegen.runtime.library_cache import (
    Compiler,
    NativeUnavailableError,
    cached_library,
    find_compiler,
)
from axisid.codegen.runtime.native_availability import Native
from axisid.control import cascade_pd
from axisid.modeling import LIBRARY
from axisid.modeling.declaration.axis import Axis
from axisid.modeling.declaration.drive import Drive
from axisid.modeling.quantities.symbols import Parameter
from tests.axes.bodies import body, rotor, turn
from tests.axes.simulated import AXES
from tests.codegen.runtime.placed import placed_library
from tests.command_line import Run

pytestmark = pytest.mark.usefixtures("c_compiler")

DECLARED = {**{name: load_axis(name) for name in LIBRARY}, **AXES}
#: Of one method that simulates, without twins, which the virtual machine is slow with.
QUICK = ("--method", "idm-iv", "--bootstrap", "0")
METRE = Constant(1.0, "m")
STRICT = ["-Wall", "-Wextra", "-Werror", "-pedantic", "-std=c11"]


@functools.cache
def text_of(name: str) -> str:
    """What is compiled and run, with the gains of a law as arguments."""
    return build(DECLARED[name]).native.text


def file_of(name: str) -> str:
    """What `axisid generate` writes, with the gains as numbers."""
    return axis_artefacts(derive(DECLARED[name]))["native.c"]


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache of this test's own."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("AXISID_CACHE", str(folder))
    return folder


def fresh(axis: Axis | None = None) -> GeneratedAxis:
    return build(axis or load_axis("emps"))


PROGRAM = """
import sys
from axisid import build, load_axis
native = build(load_axis("emps")).native
library = native.library()
print(library.path.name if library else native.refusal)
"""


def in_process(**environment: str) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-W", "error", "-c", PROGRAM],
        env={**os.environ, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.slow
@pytest.mark.parametrize(("optimise", "text"), [("-O0", file_of), ("-O2", text_of)])
@pytest.mark.parametrize("name", DECLARED)
def test_generated_c_compiles_without_a_warning(
    name: str, optimise: str, text: Callable[[str], str], tmp_path: Path
) -> None:
    (source := tmp_path / name / "native.c").parent.mkdir()
    source.write_text(text(name))
    (tmp_path / "loop.h").write_text(print_c_loop_header())
    command = [*find_compiler().command, *STRICT, optimise, "-c", str(source), "-o", os.devnull]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_cache_is_private_and_the_library_is_reused(cache: Path) -> None:
    library = fresh().native.library()
    assert library.path.parent == cache
    assert stat.S_IMODE(cache.stat().st_mode) == 0o700
    built = library.path.stat().st_mtime_ns
    again = fresh().native.library()
    assert again.path.stat().st_mtime_ns == built
    assert cached_library(text_of("emps")) == library.path
    assert {p.suffix for p in cache.iterdir()} == {".so", ".sha256", ".lock"}


@pytest.mark.slow
def test_edited_axis_never_meets_old_code(cache: Path) -> None:
    axis = load_axis("emps")
    old = fresh().native.library()
    edited = fresh(replace(axis, drive=Drive(gain=70.0, limit=10.0))).native.library()
    assert old.path != edited.path


@pytest.mark.slow
@pytest.mark.parametrize("damage", ["flip", "truncate", "no digest", "pipe"])
def test_damaged_library_is_found_before_it_is_loaded_and_rebuilt(cache: Path, damage: str) -> None:
    path = placed_library(text_of("emps"), cache)
    content = path.read_bytes()
    if damage == "flip":
        path.write_bytes(content[:2000] + bytes([content[2000] ^ 1]) + content[2001:])
    elif damage == "no digest":
        path.with_suffix(".sha256").unlink()
    elif damage == "truncate":
        path.write_bytes(content[: len(content) // 2])
    else:
        path.unlink()
        os.mkfifo(path)
    assert cached_library(text_of("emps")) is None
    library = fresh().native.library()
    assert library is not None
    assert cached_library(text_of("emps")) == path


@pytest.mark.slow
def test_two_processes_building_at_once_share_one_library(cache: Path) -> None:
    processes = [in_process() for _ in range(2)]
    outputs = [process.communicate(timeout=120) for process in processes]
    assert all(process.returncode == 0 for process in processes), outputs
    assert len({out for out, _ in outputs}) == 1
    assert len(list(cache.glob("*.so"))) == 1


def slow_compiler(tmp_path: Path, seconds: float) -> Path:
    script = tmp_path / "slow-cc"
    real = shlex.join(find_compiler().command)
    script.write_text(f'#!/bin/sh\nsleep {seconds}\nexec {real} "$@"\n')
    script.chmod(0o755)
    return script


@pytest.mark.slow
@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGKILL], ids=lambda end: end.name)
def test_end_during_a_build_leaves_nothing_that_is_loaded(
    cache: Path, tmp_path: Path, end: signal.Signals
) -> None:
    script = slow_compiler(tmp_path, 5)
    process = in_process(CC=str(script))
    deadline = time.monotonic() + 60
    while not list(cache.glob("build-*/output")) and time.monotonic() < deadline:
        time.sleep(0.02)
    time.sleep(0.5)  # until the compiler runs
    os.kill(process.pid, end)
    process.communicate(timeout=60)
    assert not list(cache.glob("*.so"))
    if end == signal.SIGINT:
        assert not list(cache.glob("build-*"))
        listed = subprocess.run(["pgrep", "-f", str(script)], capture_output=True, check=False)
        assert listed.returncode == 1
    out, err = in_process().communicate(timeout=120)
    assert out.strip().endswith(".so"), err


@pytest.mark.slow
def test_leavings_of_killed_builds_are_cleared_away(cache: Path) -> None:
    old, new = cache / "build-old", cache / "build-new"
    for folder in (old, new):
        folder.mkdir(mode=0o700, parents=True)
    cache.chmod(0o700)
    os.utime(old, (0, 0))
    assert fresh().native.library() is not None
    assert (old.exists(), new.exists()) == (False, True)


def test_hanging_compiler_is_ended(tmp_path: Path) -> None:
    script = slow_compiler(tmp_path, 600)
    (source := tmp_path / "native.c").write_text("")
    with pytest.raises(NativeUnavailableError, match=r"did not finish within 0.5 s"):
        Compiler((str(script),), "").compile(source, tmp_path / "native.so", 0.5)
    listed = subprocess.run(["pgrep", "-f", str(script)], capture_output=True, check=False)
    assert listed.returncode == 1


@pytest.mark.parametrize(
    ("compiler", "reason"),
    [
        ("absent-cc", "CC='absent-cc' was not found"),
        ("cc '", "cannot be read: No closing quotation"),
        ("false", "failed: exit code 1"),
        ("true", "failed: exit code 0"),
    ],
)
def test_no_working_compiler_means_no_library_and_a_reason(
    cache: Path, monkeypatch: pytest.MonkeyPatch, compiler: str, reason: str
) -> None:
    monkeypatch.setenv("CC", compiler)
    native = fresh().native
    assert native.library() is None
    assert reason in native.refusal
    assert not list(cache.glob("*.so"))


@pytest.mark.slow
def test_no_working_compiler_means_the_virtual_machine_and_one_line(
    cache: Path,
    run: Run,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("CC", "absent-cc")
    code, out, err = run("identify", "emps2015", *QUICK)
    assert code == 0
    assert "CC='absent-cc' was not found" in err
    assert "The CasADi virtual machine simulates" in err
    assert len(err.splitlines()) == 1
    assert "IDM-IV" in out


def test_unwritable_cache_means_no_library_and_says_what_to_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("AXISID_CACHE", str(tmp_path / "file" / "cache"))
    native = fresh().native
    assert native.library() is None
    assert "with AXISID_CACHE" in native.refusal


@pytest.mark.slow
def test_read_only_cache_still_serves_what_is_in_it(cache: Path) -> None:
    path = placed_library(text_of("emps"), cache)
    cache.chmod(0o500)
    try:
        assert fresh().native.library().path == path
    finally:
        cache.chmod(0o700)


@pytest.mark.slow
def test_cache_that_others_can_write_to_is_not_trusted(cache: Path) -> None:
    placed_library(text_of("emps"), cache)
    cache.chmod(0o777)
    assert cached_library(text_of("emps")) is None
    native = fresh().native
    assert native.library() is None
    assert "other users can write to it" in native.refusal


@pytest.mark.slow
def test_library_of_no_axis_is_no_fault_of_the_cache(cache: Path) -> None:
    native = Native("int nothing;", fresh().loop.functions)
    assert native.library() is None
    assert native.refusal.startswith("the compiled library cannot be loaded: ")
    assert "AXISID_CACHE" not in native.refusal
    assert not list(cache.glob("*.so"))


@pytest.mark.slow
def test_library_that_computes_wrong_values_is_refused(cache: Path) -> None:
    loop = fresh().loop
    wrong = text_of("emps").replace("row_out[1] = dq_;", "row_out[1] = 1.0000001 * dq_;")
    assert wrong != text_of("emps")
    native = Native(wrong, loop.functions)
    assert native.library() is None
    assert native.refusal == "the compiled idm_regressor computes wrong values"
    assert not list(cache.glob("*.so"))


def test_rows_refuse_wrong_arguments_before_they_reach_memory() -> None:
    axis = fresh(load_axis("emps2015"))
    assert axis.native.library() is not None
    q = np.zeros(5)
    for arguments in ((q, q), (q, q, q, q, np.ones(2)), (q, q, q[:3], q, np.ones(3))):
        with pytest.raises(UsageError, match="direct_dynamics"):
            axis.evaluate("direct_dynamics", *arguments)


@pytest.mark.slow
def test_names_that_c_knows_are_harmless(cache: Path) -> None:
    x, m = Coordinate("INFINITY"), Parameter("INFINITY_1", "kg", nominal=1.0)
    law = cascade_pd(kp=10.0, kv=10.0, period=1e-3)
    names = ["HUGE_VAL", "k", "samples", "NAN", "NULL", "ptrdiff_t", "M_PI", "errno", "stdin"]
    forces = [Parameter(name, "N") for name in names]
    terms = [c * sympy.sin(i * x.symbol / METRE) for i, c in enumerate(forces, 1)]
    built = build(body(*terms, coordinate=x, inertia=m, parameters=forces, control=law))
    assert built.native.library() is not None, built.native.refusal


@pytest.mark.slow
def test_what_is_not_a_number_loses_against_min_and_max_as_in_casadi(cache: Path) -> None:
    x, c = turn, Parameter("c", "N m")
    axis = rotor(
        c * sympy.Min(5, sympy.sqrt(x.symbol - 1)),
        Constant(1.0, "N m") * sympy.Max(3, sympy.log(x.symbol)),
        parameters=(c,),
        control=cascade_pd(kp=10.0, kv=10.0, period=1e-3),
    )
    built = build(axis)
    library = built.native.library()
    assert library is not None, built.native.refusal
    native = library.evaluate("idm_regressor", ([0.5], [0.0], [0.0], [0.0]))
    virtual = build(axis, native=False).evaluate("idm_regressor", 0.5, 0.0, 0.0, 0.0)
    for a, b in zip(native, virtual, strict=True):
        assert np.array_equal(a, b)


def test_c_compiler_of_zig_serves_where_there_is_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("ziglang")
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    assert find_compiler().command[1:] == ("-m", "ziglang", "cc")
