"""A terminal shows what a pipe gets, dressed; progress is shown there and only there."""

import io
import os
import pty
import subprocess
import sys
import time
import warnings
from pathlib import Path

import click
import pytest

from axisid import Identification, Record
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.commands.options import outputs
from axisid.commands.options.outputs import print_document, progress_line
from axisid.presentation.documents import CheckGroup, Checks
from axisid.support.progress import with_progress
from tests.command_line import Run


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("COLUMNS", "80")
    return Terminal()


def in_terminal(*arguments: str, columns: int = 120, **environment: str) -> str:
    """What the command line draws on a terminal of its own."""
    main, other = pty.openpty()
    variables = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "COLUMNS")}
    variables |= {"TERM": "xterm", "COLUMNS": str(columns), **environment}
    process = subprocess.Popen(
        [sys.executable, "-m", "axisid", *arguments],
        stdin=other,
        stdout=other,
        stderr=other,
        env=variables,
    )
    os.close(other)
    drawn = b""
    while True:
        try:
            part = os.read(main, 1 << 16)
        except OSError:  # the other end is closed
            break
        if not part:
            break
        drawn += part
    os.close(main)
    assert process.wait() == 0, drawn
    return drawn.decode().replace("\r\n", "\n")


@pytest.mark.slow
def test_on_a_terminal_the_verdict_is_coloured_and_the_text_that_of_a_pipe(
    run: Run, result: Identification
) -> None:
    assert run("identify", "emps2015", "--all") == (0, result.summary(every=True), "")
    drawn = in_terminal("identify", "emps2015", "--all", columns=100)
    assert click.style("pass   ", fg="green") in drawn
    visible = drawn.rpartition("\x1b[2K")[2]  # after a progress line, on a busy machine
    assert click.unstyle(visible) == result.summary(every=True)


@pytest.mark.parametrize(
    ("variables", "coloured"),
    [({}, True), ({"NO_COLOR": ""}, True), ({"NO_COLOR": "1"}, False), ({"TERM": "dumb"}, False)],
)
def test_colours_can_be_refused(
    terminal: Terminal,
    monkeypatch: pytest.MonkeyPatch,
    variables: dict[str, str],
    coloured: bool,
) -> None:
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys, "stdout", terminal)
    print_document((Checks(judged=(CheckGroup("fail", ("one",), "two"),)),))
    assert ("\x1b" in terminal.getvalue()) == coloured
    assert click.unstyle(terminal.getvalue()) == "FAIL   one: two.\n"


def wait_for(text: str, terminal: Terminal) -> None:
    """Give the thread that draws as long as a busy machine may need."""
    end = time.monotonic() + 60
    while text not in terminal.getvalue():
        assert time.monotonic() < end, f"{text!r} is not drawn: {terminal.getvalue()!r}"
        time.sleep(0.01)


def test_progress_appears_late_says_the_step_and_is_erased(
    terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A warning comes above the line, and an error does not leave it."""
    monkeypatch.setattr(sys, "stderr", terminal)
    with (
        pytest.raises(ValueError, match="broken"),
        progress_line("working", delay=0.05) as line,
    ):
        wait_for("working", terminal)
        for step, said in zip(with_progress(["a", "b"], line, str.upper), "AB", strict=True):
            wait_for(f"{said} ({'AB'.index(said) + 1} of 2)", terminal)
            assert step == said.lower()
        with warnings.catch_warnings():
            warnings.simplefilter("always")
            warnings.warn("careful", RuntimeWarning, stacklevel=1)
        raise ValueError("broken")
    drawn = terminal.getvalue()
    assert "\x1b[2K" in drawn.partition("careful")[0][-200:]
    assert drawn.endswith("\x1b[2K")


@pytest.mark.parametrize(
    ("term", "delay", "is_one"), [("xterm", 60.0, True), ("xterm", 0.0, False), ("dumb", 0.0, True)]
)
def test_what_is_quick_or_no_terminal_shows_no_progress(
    monkeypatch: pytest.MonkeyPatch, terminal: Terminal, term: str, delay: float, is_one: bool
) -> None:
    monkeypatch.setenv("TERM", term)
    stream = terminal if is_one else io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    with progress_line("working", delay):
        time.sleep(0.05)
    assert stream.getvalue() == ""


def test_without_a_terminal_progress_is_printed_in_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(outputs, "SECONDS_PER_LINE", 0.01)
    with progress_line("working") as line:
        line(4, 60, "step 5")
        end = time.monotonic() + 10.0
        while "step 5 (5 of 60)" not in stream.getvalue():
            assert time.monotonic() < end
            time.sleep(0.01)
    printed = stream.getvalue()
    assert printed.startswith("axisid: ")
    assert printed.endswith(" s\n")
    time.sleep(0.05)
    assert stream.getvalue() == printed


@pytest.mark.slow
def test_sweep_and_compare_announce_their_steps(emps2015: GeneratedAxis, twin: Record) -> None:
    from axisid import compare, friction_ladder, sweep

    said: list[tuple[int, int, str]] = []
    sweep(emps2015, twin, (60.0, 30.0), methods=["idm-ls"], progress=lambda *s: said.append(s))
    assert said == [(0, 2, "cut-off 30 Hz"), (1, 2, "cut-off 60 Hz")]
    said.clear()
    compare(friction_ladder(emps2015.axis), twin, progress=lambda *s: said.append(s))
    assert [s[0] for s in said] == [*range(4)]
    assert said[0] == (0, 4, "estimate of viscous")


@pytest.mark.slow
def test_a_title_that_the_locale_cannot_print_is_no_fault(tmp_path: Path) -> None:
    axis = tmp_path / "mine.py"
    axis.write_text(
        "from dataclasses import replace\nfrom axisid import load_axis\n"
        "axis = replace(load_axis('emps2015'), title='Pr\u00fcfstand')\n",
        encoding="utf-8",
    )
    done = subprocess.run(
        [sys.executable, "-m", "axisid", "show", str(axis)],
        capture_output=True,
        check=False,
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
    )
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.startswith(b"emps2015: Pr")
