"""Linear algebra has one thread in commands and in workers, unless the user says more."""

import os
import subprocess
import sys

import pytest

from axisid.support.one_thread import one_thread, started_with_one_thread

COMMAND = """
import os, sys
from axisid.commands.main import main
sys.argv = ["axisid", "--version"]
try:
    main()
finally:
    print(os.environ["OPENBLAS_NUM_THREADS"], "numpy" in sys.modules)
"""


@pytest.mark.parametrize(("said", "taken"), [(None, "1"), ("3", "3")])
def test_commands_say_so_before_numpy_is_imported(said: str | None, taken: str) -> None:
    environment = {k: v for k, v in os.environ.items() if k != "OPENBLAS_NUM_THREADS"}
    if said is not None:
        environment["OPENBLAS_NUM_THREADS"] = said
    done = subprocess.run(
        [sys.executable, "-c", COMMAND], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == f"{taken} False"


def test_what_the_user_said_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "4")
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    monkeypatch.delenv("BLIS_NUM_THREADS", raising=False)
    with started_with_one_thread():
        assert (os.environ["OMP_NUM_THREADS"], os.environ["MKL_NUM_THREADS"]) == ("4", "1")
    assert "MKL_NUM_THREADS" not in os.environ
    assert one_thread() == ["MKL_NUM_THREADS", "BLIS_NUM_THREADS"]
    for name in ("MKL_NUM_THREADS", "BLIS_NUM_THREADS"):
        monkeypatch.delenv(name)
