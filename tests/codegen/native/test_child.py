"""The process in which libraries are compiled and tried: what crashes, crashes there alone."""

import functools
import os
import shlex
import signal
import stat
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from axisid import build, derive, load_axis
from axisid.codegen.artefacts.texts import axis_artefacts
from axisid.codegen.native.compiler import Compiler, find_compiler
from axisid.codegen.native.library_cache import _digest, cached_library, compiled_library
from axisid.codegen.native.native import Native
from axisid.codegen.native.trial import Trial
from axisid.codegen.printers import with_c_loop
from tests.codegen.native.placed import placed_library


@functools.cache
def text() -> str:
    return with_c_loop(axis_artefacts(derive(load_axis("emps")))["native.c"])


@pytest.fixture(autouse=True)
def cache(c_compiler: Compiler, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache and a folder for temporary files of this test's own."""
    (tmp_path / "temporary").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "temporary"))
    monkeypatch.setattr("tempfile.tempdir", None)
    monkeypatch.setenv("AXISID_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def compiler(folder: Path, *after: str, before: str = "") -> Path:
    """A compiler that does something more than the real one."""
    script = folder / "cc"
    real = shlex.join(find_compiler().command)
    script.write_text("\n".join(["#!/bin/sh", before, f'{real} "$@"', *after]) + "\n")
    script.chmod(0o755)
    return script


START = "struct lane lane = {.q = start SIDES_(, .steps = steps_in_all(samples))};"
CRASHES = {
    "when loaded": ("", "__attribute__((constructor)) static void f(void) { abort(); }", "SIGABRT"),
    "when called": (START, "abort();", "SIGABRT"),
    "by a bad address": (START, "*stopped = *(int *)8;", "SIGSEGV"),
    "by leaving": (START, "exit(0);", "exit code 0"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CRASHES)
def test_library_that_crashes_is_refused_and_never_kept(cache: Path, name: str) -> None:
    before, crash, how = CRASHES[name]
    crashing = text().replace(before, before + crash) if before else text() + crash
    native = Native(
        f"#include <stdlib.h>\n{crashing}", build(load_axis("emps"), native=False).functions
    )
    assert native.library() is None
    assert f"it ends its process ({how})" in native.refusal
    assert native.evaluator("direct_dynamics") is None
    assert not list(cache.glob("*.so"))


@pytest.mark.slow
def test_library_that_never_returns_is_refused(
    cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    endless = text().replace(START, "while (period > 0.0) *stopped = 1;" + START)
    assert endless != text()
    made = placed_library(endless, tmp_path / "made")
    copier = tmp_path / "cc"  # the limit is one of compiling, too, which may take its time
    copier.write_text(f'#!/bin/sh\nwhile [ "$1" != -o ]; do shift; done\ncp {made} "$2"\n')
    copier.chmod(0o755)
    monkeypatch.setenv("CC", str(copier))
    monkeypatch.setenv("AXISID_COMPILE_SECONDS", "4")
    native = Native(endless, build(load_axis("emps"), native=False).functions)
    assert native.library() is None
    assert native.refusal == "the compiled library does not run: it does not return within 4 s"


@pytest.mark.slow
def test_what_a_library_prints_disturbs_nobody(
    cache: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    noisy = '__attribute__((constructor)) static void f(void) { puts("hello"); fflush(stdout); }'
    compiled_library(f"#include <stdio.h>\n{text()}{noisy}", Trial)
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
def test_library_without_a_trial_is_built_again(cache: Path) -> None:
    """A digest is the mark of a trial: one of the content alone is none."""
    import hashlib

    compiled = build(load_axis("emps")).native.text
    path = placed_library(compiled, cache)
    digest = path.with_suffix(".sha256")
    assert digest.read_text() == _digest(path, path.name)
    plain = hashlib.sha256(path.name.encode() + path.read_bytes()).hexdigest()
    digest.write_text(plain)
    assert cached_library(compiled) is None
    assert build(load_axis("emps")).native.library() is not None
    assert digest.read_text() != plain


def test_no_interpreter_means_the_virtual_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "frozen", True, raising=False)
    native = build(load_axis("emps")).native
    assert native.library() is None
    assert native.refusal == "there is no Python interpreter to try a library in"


def test_other_systems_mean_the_virtual_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "getuid")
    native = build(load_axis("emps")).native
    assert native.evaluator("direct_dynamics") is None
    assert native.library() is None
    assert native.refusal == "it needs a POSIX system, such as Linux or macOS"


# Whoever starts the tests may have had a signal ignored.
PROGRAM = """
import signal
from axisid import build, load_axis
signal.signal(signal.SIGHUP, signal.SIG_DFL)
signal.signal(signal.SIGINT, signal.default_int_handler)
build(load_axis("emps")).native.library()
"""


def children(word: str) -> list[str]:
    done = subprocess.run(["pgrep", "-f", word], capture_output=True, text=True, check=False)
    return done.stdout.split()


def until(holds: Callable[[], bool], seconds: float = 90.0) -> bool:
    deadline = time.monotonic() + seconds
    while not holds() and time.monotonic() < deadline:
        time.sleep(0.02)
    return holds()


@pytest.mark.slow
@pytest.mark.parametrize(
    "end", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT, signal.SIGKILL], ids=lambda end: end.name
)
def test_process_that_ends_while_it_compiles_leaves_nothing(
    cache: Path, tmp_path: Path, end: signal.Signals
) -> None:
    # One that does not end by itself, with a child that does not end with it.
    stubborn = "trap '' TERM HUP INT; touch \"$TMPDIR/kept\"; sleep 61 & sleep 62"
    script = compiler(tmp_path, before=stubborn)
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM],
        env={**os.environ, "CC": str(script)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    assert until(lambda: bool(children(f"{script} -std")))
    workshop = children(str(tmp_path / "cache" / "build-") + "|" + str(tmp_path / "temporary"))
    assert until(lambda: any((tmp_path / "cache").glob("build-*/kept")))
    os.kill(process.pid, end)
    process.communicate(timeout=90)
    assert process.returncode
    assert until(lambda: not children(f"{script} -std"))
    assert until(lambda: not any(Path(f"/proc/{pid}").exists() for pid in workshop))
    left = [p.name for folder in (cache, tmp_path / "temporary") for p in folder.glob("*")]
    assert [name for name in left if not name.endswith(".lock")] == []


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["library", "digest"])
@pytest.mark.parametrize("what", ["pipe", "folder", "device", "loop"])
def test_what_is_no_regular_file_in_the_cache_is_not_read(
    cache: Path, what: str, kind: str
) -> None:
    path = placed_library(text(), cache)
    file = path if kind == "library" else path.with_suffix(".sha256")
    file.unlink()
    if what == "pipe":
        os.mkfifo(file)
    elif what == "folder":
        file.mkdir()
    elif what == "device":
        file.symlink_to("/dev/zero")
    else:
        file.symlink_to(file)
    begin = time.monotonic()
    assert cached_library(text()) is None
    library = build(load_axis("emps")).native.library()
    assert time.monotonic() - begin < 200
    assert stat.S_ISREG(library.path.stat().st_mode)


@pytest.mark.slow
def test_leavings_of_killed_builds_are_cleared_away(cache: Path) -> None:
    cache.mkdir(mode=0o700)
    old, new = cache / "build-old", cache / "build-new"
    for folder in (old, new):
        folder.mkdir()
        (folder / "native.c").write_text("")
    os.utime(old, (0, 0))
    compiled_library(text(), Trial)
    assert not old.exists()
    assert new.exists()
