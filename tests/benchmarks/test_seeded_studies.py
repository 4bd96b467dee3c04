"""Studies in small, each with its contract: what it was made to show holds."""

import json
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid import simulate
from benchmarks.machines import Machine, records


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


Figures = Callable[..., dict[str, Any]]
fits: Any = import_module("fits")
pytestmark = pytest.mark.slow


def test_intervals_hold_the_truth_as_often_as_they_say(figures: Figures) -> None:
    found = figures("calibration", "--runs", "40")
    assert found.pop("runs") == 40
    assert set(found) == {"white_iid", "white_hac", "coloured_iid", "coloured_hac"}
    # 40 runs tell a share of 95 % to about 3.4 % (one standard deviation), of 60 % to 7.7 %.
    assert min(*found["white_hac"].values(), *found["coloured_hac"].values()) >= 0.85
    assert max(found["coloured_iid"].values()) <= 0.8


def test_no_faulty_log_gives_a_wrong_number_silently(figures: Figures) -> None:
    found = figures("faults", "--runs", "6")
    assert found["seed"] == 1
    assert found["runs"] >= 6
    wrong = [run for run in found["each"] if run["outcome"] in ("SILENT", "broken", "hung")]
    assert not wrong
    assert found["outcomes"]["clean"] >= 1, "faults are put into logs that raise no alarm"
    assert set(found["outcomes"]) <= {"refused", "told", "harmless", "clean", "alarm"}


def test_right_velocities_pass_and_wrong_ones_are_named(figures: Figures) -> None:
    found = figures("measured_velocity", "--runs", "1", "--alone", "1")
    assert found["runs"] >= 1
    right = ("white noise", "ripple", "coarse steps", "noisy encoder")
    for kind, shares in found["alarms"].items():
        assert set(shares.values()) == ({0.0} if kind in right else {1.0}), kind
    for label, share in found["alone"].items():
        assert share == (0.0 if label.endswith("times 1") else 1.0), label


def test_right_signals_pass_and_wrong_ones_are_named(figures: Figures) -> None:
    found = figures("recorded_signals", "--runs", "1")
    assert found.pop("runs") == 1
    for case, share in found.items():
        assert share == (0.0 if case.startswith("right") else 1.0), case


def test_a_payload_tells_the_gain_and_a_record_that_differs_is_named(figures: Figures) -> None:
    found = figures("records", "--runs", "10")
    payload = found["payload 0.2"]
    assert payload["sd_percent"] < 0.6  # 0.3 in 60 runs, of which 10 tell it to a quarter
    assert abs(payload["bias_in_standard_errors"]) < 4
    assert payload["coverage"] >= 0.9
    assert found["payload 0.5"]["sd_percent"] < payload["sd_percent"]
    offsets = found["local offsets"]
    assert offsets["mass_sd_of_four"] < offsets["mass_sd_of_one"]
    assert offsets["offset_error_rms_mV"] < 2
    assert found["mass 0 larger"]["fails"] == 0
    assert found["mass 0.05 larger"]["names_the_right_one"] == 1
    assert found["mass 0.2 larger"]["names_the_mass_alone"] == 1


def test_axes_that_rest_are_simulated_as_an_event_integrator_does(figures: Figures) -> None:
    found = figures("rests", "--axes", "6")
    assert found["axes"] == 6
    assert found["refusals"] == 0
    assert found["resting_share"] > 0.1
    assert found["off_median_m"] < 1e-9
    assert found["off_beyond_1_um"] == 0, "a count of the encoder may fall otherwise"


@pytest.mark.parametrize("case", ["voltage, ke", "half the period", "gear of 70 %", "supply"])
def test_parameters_of_an_integrators_record_are_inside_their_intervals(
    figures: Figures, case: str
) -> None:
    found = figures("voltage_drives", "--runs", "1", "--only", case)
    assert found.pop("runs") == 1
    for name, of in found.items():
        known = "rotor" not in name  # the loss of what turns the rotor is not declared
        assert (of["inside"] == 1.0) == known, name
        assert of["loop, relative"] < (2e-6 if known else 1e-3)


def test_what_a_bristle_is_declared_by_is_found_from_swings_and_dwells(figures: Figures) -> None:
    found = figures("presliding", "--runs", "2")
    assert max(map(abs, found["bias_percent"].values())) < 0.05
    assert not found["checks_failed"]
    assert found["steps"] <= 10


def test_fits_are_right_where_the_law_is_and_say_so_where_it_is_not(figures: Figures) -> None:
    written = figures("fits", "--runs", "2", "--only", "kp +1 %")
    assert max(written["slopes_off"].values()) < 1e-5
    right, wrong = fits.figures_of("white noise", runs=6, seed=1), written["cases"]["kp +1 %"]
    for of in right.values():
        assert max(map(abs, of["bias_percent"].values())) < 0.5
        assert not of["checks_failed"]
        assert of["most_jacobians"] <= 10
    assert wrong["position"]["bias_percent"]["Fv"] > 30
    assert wrong["position"]["checks_failed"]["law's factors"] == 2
    assert abs(wrong["control"]["bias_percent"]["Fv"]) < 1


def test_output_error_bears_an_encoder_that_biases_least_squares(figures: Figures) -> None:
    cases = figures("encoder", "--runs", "2", "--counts", "1000", "20")["cases"]
    assert [case["counts"] for case in cases] == [1000, 1000, 20, 20]
    fine, coarse = (case for case in cases if case["filter"] == "inappropriate")
    assert abs(fine["methods"]["idm-ls"]["bias_percent"][0]) < 2  # mass, half without its bias
    assert max(map(abs, fine["methods"]["didim"]["bias_percent"])) < 1
    assert min(fine["methods"]["didim"]["held"]) >= 0.5
    assert coarse["methods"]["idm-iv"]["estimated"] < 1  # the loop hunts, and shows no parameters
    assert coarse["clean"] == 0


field: Any = import_module("field")


@pytest.mark.parametrize(
    "machine",
    [
        Machine(coulomb=40.0),
        Machine(offset=150.0, coulomb=40.0),
        Machine(kp=25.0, kv=150.0, tn=0.05),
        Machine(kp=1200.0, ki=4000.0, kd=80.0),
        Machine(kp=15.0, kv=100.0, tn=0.1, period=5e-3),
    ],
    ids=["cascade", "weight", "P-PI", "PID", "P-PI, 5 ms"],
)
def test_a_machine_under_each_law_moves_and_rests_as_its_axis_is_simulated(
    machine: Machine,
) -> None:
    case = field.Case(machine=machine, declared=machine)
    reference = field.reference_of(case.motion, machine.period)[: round(3.2 / machine.period)]
    loop = simulate(case.axis, [*case.truth.values()], reference, machine.period)
    (columns,) = records(machine, reference, 1, seed=1)
    np.testing.assert_allclose(columns["position"], loop.position, atol=1e-7)
    np.testing.assert_allclose(columns["control"], loop.control, atol=2e-3)


control_laws: Any = import_module("control_laws")


@pytest.mark.parametrize("log", ["exact", "rounded", "control noise"])
def test_a_right_law_passes_and_a_wrong_gain_is_named(log: str) -> None:
    figures = control_laws.figures_of("cascade_p_pi", log, runs=1, seed=1)
    assert (figures.runs, figures.failed) == (1, 0)
    assert set(figures.named) == {f"{g} {off} %" for g in ("kp", "kv", "tn") for off in (5, 10)}
    assert figures.noticed == figures.changed


model_error: Any = import_module("model_error")


@pytest.mark.parametrize(("shape", "motion"), [("sine of 0.2 m", "moves")])
def test_the_band_holds_what_the_interval_misses(shape: str, motion: str) -> None:
    found = model_error.coverage(shape, motion, runs=12, seed=1)
    assert found["hac"]["Fc"] < 0.7
    assert found["shown"]["Fc"] > 0.9
    assert found["shown"]["Fv"] > 0.9


output_error: Any = import_module("output_error")


def test_didim_is_unbiased_and_more_precise_than_instruments() -> None:
    shares = output_error.written(output_error.figures_of("white noise", runs=12, seed=1))
    iv, didim = (shares["methods"][method] for method in ("idm-iv", "didim"))
    for name in output_error.TRUTH:
        assert didim["sd_percent"][name] < 0.75 * iv["sd_percent"][name]
        assert abs(didim["bias_percent"][name]) < 3 * didim["sd_percent"][name] / 12**0.5
        assert didim["held"][name] >= 0.9
    assert "fail" not in shares["method"]


def test_a_wrong_law_moves_didim_and_not_instruments(
    figures: Figures,
) -> None:
    written = figures("output_error", "--runs", "3", "--only", "kp +5 %")
    shares = written["cases"]["kp +5 %"]
    iv, didim = (shares["methods"][method]["bias_percent"] for method in ("idm-iv", "didim"))
    assert didim["Fv"] > 1.0 > 0.6 > abs(iv["Fv"])
    assert shares["control_law"] == {"fail": 3}
    assert "pass" not in shares["method"]
    assert shares["believed"] == {"idm-iv": 3}
    assert set(written["seconds"]) == {"idm-iv", "didim"}


verdicts: Any = import_module("verdicts")


@pytest.mark.parametrize("by", ["identify", "control"])
@pytest.mark.parametrize("name", ["PD, 2 s", "P-PI, 5 ms, 1 um, dwells"])
def test_a_right_machine_passes_and_holds(name: str, by: str) -> None:
    found = verdicts.right_figures(verdicts.runs_of(name, runs=3, seed=1, by=(by,))[by])
    assert (found["fail"], found["not"]) == (0, 0)
    assert found["hold"] > 75


@pytest.mark.parametrize(
    ("fault", "by"),
    [
        ("quadratic", "identify"),
        ("offset", "identify"),
        ("offset", "control"),
        ("cogging", "identify"),
    ],
)
def test_what_is_wrong_is_named(fault: str, by: str) -> None:
    named = verdicts.cases(1)[f"{fault}; stage"].named
    found = verdicts.wrong_figures(
        verdicts.runs_of(f"{fault}; stage", runs=3, seed=1, by=(by,))[by], named
    )
    assert (found["runs"], found["noticed"], found["named"]) == (1, 1, 1)
