"""A small seeded version of the study of several records."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

PROGRAM = [sys.executable, "benchmarks/records.py", "--json", "-", "--runs", "10"]


def test_a_payload_tells_the_gain_and_a_record_that_differs_is_named(root: Path) -> None:
    done = subprocess.run(PROGRAM, cwd=root, capture_output=True, text=True, check=True)
    figures = json.loads(done.stdout)
    payload = figures["payload 0.2"]
    assert payload["sd_percent"] < 0.6  # 0.3 in 60 runs, of which 10 tell it to a quarter
    assert abs(payload["bias_in_standard_errors"]) < 4
    assert payload["coverage"] >= 0.9
    assert figures["payload 0.5"]["sd_percent"] < payload["sd_percent"]
    offsets = figures["local offsets"]
    assert offsets["mass_sd_of_four"] < offsets["mass_sd_of_one"]
    assert offsets["offset_error_rms_mV"] < 2
    assert figures["mass 0 larger"]["fails"] == 0
    assert figures["mass 0.05 larger"]["names_the_right_one"] == 1
    assert figures["mass 0.2 larger"]["names_the_mass_alone"] == 1
