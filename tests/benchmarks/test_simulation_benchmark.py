"""The benchmark keeps its contract. It is not a timed test: the figures are not judged here."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from axisid.codegen.native.compiler import find_compiler
from axisid.codegen.native.errors import NativeUnavailableError

pytestmark = pytest.mark.slow

CONTRACT = {
    "single_over_hand_c",
    "batch_over_hand_simd",
    "scipy_over_single",
    "virtual_machine_over_single",
    "identify_over_floor",
    "identify_with_intervals_over_floor",
    "generate_cold_s",
    "load_warm_ms",
}


def test_benchmark_prints_its_contract_and_checks_its_yardsticks(root: Path) -> None:
    try:
        find_compiler()
    except NativeUnavailableError as error:
        pytest.skip(str(error))
    done = subprocess.run(
        [sys.executable, "benchmarks/simulation.py", "--json", "-", "--times", "2"],
        cwd=root,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    figures = json.loads(done.stdout)
    assert set(figures) >= CONTRACT
    shares = {name: value for name, value in figures.items() if "_share_" in name}
    assert all(value >= 0 for value in shares.values())
    assert sum(shares.values()) == pytest.approx(1)
    assert all(value > 0 for name, value in figures.items() if name not in shares)
