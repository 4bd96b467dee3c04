"""Studies in small, each with its contract: what it was made to show holds."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

import pytest

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
    assert min(fine["methods"]["didim"]["held"]) > 0.5
    assert coarse["methods"]["idm-iv"]["estimated"] < 1  # the loop hunts, and shows no parameters
    assert coarse["clean"] == 0
