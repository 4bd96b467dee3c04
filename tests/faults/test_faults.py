"""Every class of fault that was ever found ends as the catalogue says: a sentence, an exit code."""

import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest
from time_limit import in_time

from tests.command_line import Run
from tests.faults.fault import Fault, Misuse

# What hangs is ended from outside, as it makes no calls that could be counted; no fault takes more
# than seconds, here or on a machine that others use too.
_SECONDS = 200
#: What an earlier run wrote, which the same command may write anew.
_KEPT = {
    command: f'{{"schema": "axisid.{schema}/1"}}\n'
    for command, schema in (
        ("identify", "identification"),
        ("sweep", "sweep"),
        ("compare", "comparison"),
    )
}

_HERE = Path(__file__).parent
_PAGES = [
    import_module(f"tests.faults.{file.stem}")
    for file in sorted(_HERE.glob("*.py"))
    if not file.stem.startswith("test_") and file.stem != "fault"
]
FAULTS: list[Fault] = [fault for page in _PAGES for fault in page.FAULTS]
MISUSES: list[Misuse] = [misuse for page in _PAGES for misuse in getattr(page, "MISUSES", ())]


def _parameter(fault: Fault) -> object:
    return pytest.param(fault, id=fault.name, marks=pytest.mark.slow if fault.is_slow else ())


@pytest.fixture(autouse=True)
def _in_time() -> Iterator[None]:
    """End what hangs, as a failure."""
    with in_time(_SECONDS):
        yield


@pytest.mark.parametrize("fault", [_parameter(fault) for fault in FAULTS])
def test_fault_ends_in_a_sentence_and_an_exit_code(
    fault: Fault, run: Run, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for variable, value in fault.environment.items():
        monkeypatch.setenv(variable, value.format(folder=here))
    parts = fault.make if isinstance(fault.make, tuple) else fault.make(here)
    made = [part(here) if callable(part) else part for part in parts]
    arguments = [part for part in made if part is not None]
    earlier = _KEPT.get(str(arguments[0])) if fault.code and "--json" not in arguments else None
    if earlier:
        output = here / "earlier-result.json"
        output.write_text(earlier)
        arguments = [*arguments, "--json", str(output)]
    kept = {file: file.read_bytes() for file in here.rglob("*") if file.is_file()}
    code, out, err = run(*arguments)
    assert code == fault.code, err
    said = err if fault.code else out + err
    assert re.search(fault.says, " ".join(said.split())), said
    assert "Traceback" not in err
    assert "internal fault" not in err
    if fault.code:
        left = {file: file.read_bytes() for file in here.rglob("*") if file.is_file()}
        assert left == kept, "a refused command changes no file and leaves none"
    if fault.after is not None:
        fault.after(here, out)


@pytest.mark.parametrize("misuse", MISUSES, ids=lambda misuse: misuse.name)
def test_misuse_raises_its_sentence(misuse: Misuse) -> None:
    with pytest.raises(misuse.error, match=misuse.says):
        misuse.call()


def test_names_are_told_apart() -> None:
    names = [fault.name for fault in (*FAULTS, *MISUSES)]
    assert len(names) == len(set(names))
