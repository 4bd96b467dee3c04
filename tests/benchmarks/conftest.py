"""A study run from the command line, as a small seeded version of itself."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture
def figures(root: Path) -> Callable[..., dict[str, Any]]:
    """The figures that a program of `benchmarks/` writes when it is given some options."""

    def run(study: str, *options: str) -> dict[str, Any]:
        command = [sys.executable, f"benchmarks/{study}.py", "--json", "-", *options]
        done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        found: dict[str, Any] = json.loads(done.stdout)
        return found

    return run
