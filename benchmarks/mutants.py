"""Faults put into the program one at a time, and whether the tests that are of it notice.

    python benchmarks/mutants.py [--only NAME ...] [--jobs 2]

Each mutant is an exact piece of text that its file has once, what stands there instead, and the few
tests that ought to fail. All of it happens in copies of the tree with a cache of compiled libraries
of their own; the tests run first on the program as it is. A mutant that survives is listed, and
makes the exit code 1.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

ROOT = Path(__file__).resolve().parents[1]
LIMIT_S = 600.0  # of the tests of one mutant; one that hangs is noticed too
_LEFT_OUT = (".git", ".venv", "__pycache__", ".*_cache", ".hypothesis", "dist", "build", "shared")

_LOOP = "codegen/printers/loop"
_VIRTUAL = "codegen/runtime/interpreted_loop.py"
_COVARIANCE = "estimation/regression/covariance.py"
_SIM, _REG = "tests/estimation/simulation", "tests/estimation/regression"
_CLOCKS = "tests/estimation/law_replay/test_two_clocks.py"
_PUSHED = f"{_SIM}/test_recorded.py::test_a_"
_PULSE = f"{_PUSHED}pulse_that_turns_the_velocity_back_within_a_sample_is_followed"
_WITHIN = f"{_PUSHED}pulse_is_followed_in_steps_within_a_sample"
_LANES_WITHIN = f"{_SIM}/test_recorded.py::test_lanes_in_steps_within_a_sample_are_the_single_loops"
_MOVED = f"{_SIM}/test_recorded.py::test_"
_PLACE = f"{_SIM}/test_position_events.py::test_"
_SWING = f"{_SIM}/test_states.py::test_a_light_stack_swings_within_a_sample_as_small_leaps_have_it"
_SANDWICH = f"{_REG}/test_covariance.py"
_DELTA = (
    f"{_REG}/test_coloured_errors.py::test_its_degrees_of_freedom_are_those_of_the_delta_method"
)
_NOISE = "estimation/noise_models/noise_estimation.py"
_MEASURED = "tests/estimation/noise_models/test_noise_estimation.py::test_"
_BASE, _DEPENDENCES = "modeling/derivation/base_model.py", "modeling/quantities/dependences.py"
_FOUND = "tests/modeling/quantities/test_dependences.py"
_APART = f"{_FOUND}::test_functions_that_agree_at_a_few_points_stay_apart"
_SEEN = "tests/modeling/derivation/test_null_space.py::test_what_trades_is_found_and_said_and"
_PLACED = "tests/modeling/quantities/test_features.py::test_crossings_are_found_between"
_COMBINED = "tests/modeling/derivation/test_combined_parameters.py"
_DERIVED = "tests/modeling/derivation/test_base_model.py"
_ALONG = "tests/estimation/law_replay/test_initial_state_of_record.py"

#: By name: a file, what it has once, what stands there instead, and the tests that ought to fail.
MUTANTS: Mapping[str, tuple[str, str, str, tuple[str, ...]]] = {
    # The event logic of the generated loop, and of the virtual machine.
    "a velocity that bends back is no event": (
        f"{_LOOP}/events.c",
        "end->first * direction < 0.0 ? (end->last * direction > 0.0 ? 1.0 : 0.0) : 0.0;",
        "end->first * direction < -1e300 ? 1.0 : 0.0;",
        (f"{_PULSE}[any-signal-True]",),
    ),
    "a dip of the velocity is none": (
        f"{_LOOP}/events.c",
        "if (dq == 0.0 || !(end->first * direction < 0.0 && end->last * direction > 0.0))",
        "if (dq * dq >= 0.0)",
        (f"{_PULSE}[any-law-True]",),
    ),
    "a dip is sought in the middle of its step": (
        f"{_LOOP}/events.c",
        "const double lowest = *span * end->first / (end->first - end->last);",
        "const double lowest = *span * 0.5;",
        (f"{_PULSE}[early-signal-True]",),
    ),
    "a dip lasts until the end of its step": (
        f"{_LOOP}/events.c",
        "    *span = lowest;\n    return 1;",
        "    return 1;",
        (f"{_PULSE}[early-signal-True]",),
    ),
    "a dip may bend at one end of its step alone": (
        f"{_LOOP}/events.c",
        "if (dq == 0.0 || !(end->first * direction < 0.0 && end->last * direction > 0.0))",
        "if (dq == 0.0 || !(end->first * direction < 0.0 || end->last * direction > 0.0))",
        (f"{_WITHIN}[any-True]",),
    ),
    "a step that begins at rest may dip at once": (
        f"{_LOOP}/events.c",
        "if (dq == 0.0 || !(end->first * direction < 0.0 && end->last * direction > 0.0))",
        "if (dq == 0.0 && !(end->first * direction < 0.0 && end->last * direction > 0.0))",
        (f"{_WITHIN}[any-True]",),
    ),
    "signals stand still within the samples of a batch": (
        f"{_LOOP}/batch.c",
        "now[j] += now[j + 1] * step * (double)(i - 1);",
        "now[j] += now[j + 1] * 0.0;",
        (_LANES_WITHIN,),
    ),
    "signals of a batch are a step ahead within a sample": (
        f"{_LOOP}/batch.c",
        "now[j] += now[j + 1] * step * (double)(i - 1);",
        "now[j] += now[j + 1] * step * (double)i;",
        (_LANES_WITHIN,),
    ),
    "signals of a batch go back within a sample": (
        f"{_LOOP}/batch.c",
        "now[j] += now[j + 1] * step * (double)(i - 1);",
        "now[j] -= now[j + 1] * step * (double)(i - 1);",
        (_LANES_WITHIN,),
    ),
    "a velocity that is found to be zero is not made so": (
        f"{_LOOP}/events.c",
        "    end->dq = 0.0;\n    return 1;",
        "    return 1;",
        (f"{_PULSE}[any-signal-True]",),
    ),
    "a straight signal does not move on while the axis rests": (
        f"{_LOOP}/events.c",
        "pass(later, middle);",
        "pass(later, left);",
        (f"{_PULSE}[any-signal-True]",),
    ),
    "the reference of a continuous law stands while the axis rests": (
        f"{_LOOP}/events.c",
        "later[0] = held[0] + held[1] * middle;",
        "later[0] = held[0] + held[1] * left;",
        (f"{_PULSE}[any-law-True]",),
    ),
    "what is held stops at an event": (
        f"{_LOOP}/events.c",
        "        pass(held, span);\n        left -= span;\n        if (passed >= 0) {",
        "        left -= span;\n        if (passed >= 0) {",
        (f"{_PULSE}[any-law-True]",),
    ),
    "the direction at rest is that of the last event": (
        f"{_LOOP}/events.c",
        "#if SIGNALS\n                mode->direction = at_rest(*q, held, mode, p);\n",
        "#if SIGNALS\n",
        (f"{_PULSE}[from rest-signal-True]",),
    ),
    "rounding moves an axis from rest": (
        f"{_LOOP}/events.c",
        "if (from_rest && *q == before && mode->direction == direction) {",
        "if (from_rest && *q != *q) {",
        (f"{_SIM}/test_simulation.py::test_rounding_moves_no_axis_from_rest[True]",),
    ),
    "a place that moves is met in the middle of a step": (
        f"{_LOOP}/events.c",
        "high *= first / (first - last);",
        "high *= 0.5;",
        (f"{_MOVED}a_stop_that_comes_and_goes_within_a_sample_is_met[True]",),
    ),
    "no place catches an axis": (
        f"{_LOOP}/events.c",
        "if (!(2.0 * fabs(dq) < CAUGHT * whole * slower))",
        "if (!(2.0 * fabs(dq) < 0.0 * whole * slower))",
        (f"{_PLACE}an_axis_that_two_forces_push_back_into_a_jump_rests_there[True]",),
    ),
    "what holds an axis at rest accelerates it": (
        f"{_LOOP}/sample.c",
        "    if (fabs(mode->direction) < 1.0)\n        lane->acceleration = 0.0;\n",
        "",
        (f"{_PUSHED}held_signal_jumps_at_its_sample_and_the_motion_with_it[True]",),
    ),
    "an axis that begins in a place stays in it": (
        f"{_LOOP}/modes.c",
        "mode->sides[i] = sign(s.by_position[i] * dq);",
        "mode->sides[i] = 0.0;",
        (f"{_PLACE}an_axis_that_begins_in_a_jump_leaves_it_against_the_force_ahead[0.5-True]",),
    ),
    "friction forgets within a step": (
        f"{_LOOP}/modes.c",
        "    copy_states(after.states, end->states);\n",
        "    (void)end;\n",
        (f"{_SWING}[True]",),
    ),
    "a slider at its limit goes on slipping": (
        f"{_LOOP}/modes.c",
        "s.value[i] <= 0.0 && s.by_position[i] * mode->direction < 0.0",
        "s.value[i] <= 0.0",
        (f"{_SWING}[True]",),
    ),
    "a lane rests in the direction in which it began": (
        f"{_LOOP}/batch.c",
        "b->end[l] = lane.mode.direction;",
        "b->end[l] = lane.direction;",
        (f"{_PLACE}batch_and_virtual_machine_take_the_same_events[jump]",),
    ),
    "the virtual machine sees no dip": (
        _VIRTUAL,
        "if not first < 0 < lasts[i] or not (i or at.dq):",
        "if not first < 0 < lasts[i] or not i:",
        (f"{_PULSE}[any-signal-False]",),
    ),
    "the virtual machine's step bends unnoticed": (
        _VIRTUAL,
        "bends = moved.first * direction < 0 < moved.last * direction",
        "bends = False",
        (f"{_PULSE}[any-law-False]",),
    ),
    "no place catches an axis of the virtual machine": (
        _VIRTUAL,
        "_CAUGHT * whole * min(backward, -forward)",
        "_CAUGHT * whole * min(0.0, -forward)",
        (f"{_PLACE}an_axis_that_two_forces_push_back_into_a_jump_rests_there[False]",),
    ),
    "sliders of the virtual machine go on slipping": (
        _VIRTUAL,
        "-1.0 if found.values[i] <= 0 and outwards else 1.0",
        "-1.0 if found.values[i] <= 0 else 1.0 + 0.0 * outwards",
        (f"{_SWING}[False]",),
    ),
    # Covariances.
    "the published variance is over n": (
        _COVARIANCE,
        "float(e @ e) / (len(e) - 1) * (factor @ factor.T)",
        "float(e @ e) / len(e) * (factor @ factor.T)",
        (f"{_SANDWICH}::test_classical_and_robust_are_those_of_statsmodels",),
    ),
    "the instruments of a lane are as sure as a regressor of their own": (
        "estimation/batched/identify_lanes.py",
        "self.instruments[own, :, place] @ self.mixing[place].T",
        "self.instruments[own, :, place] @ self.inverse[place].T",
        (
            "tests/estimation/batched/test_identify_lanes.py"
            "::test_a_lane_is_what_identify_makes_of_its_record",
        ),
    ),
    "variances have a degree of freedom for each row": (
        _COVARIANCE,
        "freedom=np.full(k, float(n - k))",
        "freedom=np.full(k, float(n))",
        (f"{_SANDWICH}::test_classical_and_robust_are_those_of_statsmodels",),
    ),
    "the sandwich is corrected for one parameter": (
        _COVARIANCE,
        "n / (n - k) * matrix",
        "n / (n - 1) * matrix",
        (f"{_SANDWICH}::test_classical_and_robust_are_those_of_statsmodels",),
    ),
    "the kernel is one lag wider": (
        _COVARIANCE,
        "width = lags + 1",
        "width = lags + 2",
        (f"{_SANDWICH}::test_hac_is_that_of_statsmodels",),
    ),
    "scores that were whitened are recoloured once": (
        _COVARIANCE,
        "bartlett_sum(white, lags) * np.outer(gain, gain)",
        "bartlett_sum(white, lags) * np.outer(gain, gain**0)",
        (f"{_SANDWICH}::test_whitened_products_are_those_of_whitened_scores",),
    ),
    "freedom knows nothing of the errors that the innovations make": (
        _COVARIANCE,
        "basis.T @ coloured(r))) / (1 - r**2)) for r in at)",
        "basis.T @ coloured(r))) / (1 - at[0]**2)) for r in at)",
        (_DELTA,),
    ),
    "the slope by a coefficient is over half its step": (
        _COVARIANCE,
        "slopes = (more - less) / (at[1] - at[0])",
        "slopes = (more - less) / _RESOLVED",
        (_DELTA,),
    ),
    "freedom takes the variance of the coefficient for 1/n": (
        _COVARIANCE,
        "relative_variances = (2 + slopes**2 * (1 - rho**2)) / n",
        "relative_variances = (2 + slopes**2) / n",
        (_DELTA,),
    ),
    "scores that alternate are not whitened": (
        _COVARIANCE,
        "slope, 0.0), -most, most)",
        "slope, 0.0), 0.0, most)",
        (f"{_SANDWICH}::test_scores_are_whitened_by_their_own_autocorrelation",),
    ),
    "twins are about their own mean as a record is": (
        _NOISE,
        "return (count + 1) / max(count - 1, 1)",
        "return count / max(count - 1, 1)",
        (f"{_MEASURED}power_about_another_mean_is_that_of_a_further_series",),
    ),
    "second differences are independent": (
        _NOISE,
        "2 * (1 + 2 * ((4 / 6) ** 2 + (1 / 6) ** 2))",
        "2 * (1 + 1 * ((4 / 6) ** 2 + (1 / 6) ** 2))",
        (f"{_MEASURED}squares_of_second_differences_count_as_so_many_independent_powers",),
    ),
    "twins that scatter little count more than their bands have": (
        _NOISE,
        "np.minimum(counts, independent)",
        "np.maximum(counts, independent)",
        (f"{_MEASURED}twins_have_as_many_independent_powers_as_their_scatter_shows",),
    ),
    "the variance of twins is by their number": (
        _NOISE,
        "steps.var(axis=0, ddof=1)",
        "steps.var(axis=0)",
        (f"{_MEASURED}twins_have_as_many_independent_powers_as_their_scatter_shows",),
    ),
    "the likelihood counts each band once": (
        _NOISE,
        "np.asarray(-(np.log(expected) + power / expected) @ counts)",
        "np.asarray(-(np.log(expected) + power / expected) @ counts**0)",
        (f"{_MEASURED}the_likelihood_is_that_of_means_of_exponential_powers",),
    ),
    "disturbances that no band shows are in the chain": (
        _NOISE,
        "unit_power > _MIN_BAND_SHARE * power, axis=1)",
        "unit_power > 0 * power, axis=1)",
        (f"{_MEASURED}autoregressions_are_those_that_a_band_shows",),
    ),
    "disturbances are told by their variances": (
        _NOISE,
        "zip(times, np.sqrt(variances), is_visible, strict=True)",
        "zip(times, variances, is_visible, strict=True)",
        (f"{_MEASURED}autoregressions_are_those_that_a_band_shows",),
    ),
    "noise is measured across the gaps of a record": (
        _NOISE,
        "np.concatenate([np.diff(noise[a:b], 2) for a, b in record.spans])",
        "np.diff(noise, 2)",
        (f"{_MEASURED}white_noise_is_measured_within_the_pieces_of_a_record",),
    ),
    "columns take nothing of the frequencies of rows": (
        _NOISE,
        "self._by_band(1 - np.minimum(taken, _MAX_LEVERAGE))",
        "self._by_band(1 - 0 * taken)",
        (f"{_MEASURED}a_spectrum_of_rows_is_flat_for_white_noise_beside_its_columns",),
    ),
    "the plug-in rule takes a square root": (
        _COVARIANCE,
        "abs(slope / level) ** (2 / 3) * n ** (1 / 3)",
        "abs(slope / level) ** (1 / 2) * n ** (1 / 3)",
        (f"{_SANDWICH}::test_the_plug_in_rule_is_that_of_andrews_for_an_autoregression",),
    ),
    "instruments are as sure as a regressor of their own": (
        "estimation/regression/linear.py",
        "    influence = np.linalg.solve(by_slopes, basis.T).T / X.scale",
        "    influence = (Z.basis @ Z.inverse.T).astype(float)",
        (f"{_SANDWICH}::test_instrumental_variables_are_those_of_linearmodels",),
    ),
    "a mapped covariance knows no signs": (
        _COVARIANCE,
        "mapped = jacobian @ covariance @ jacobian.T",
        "mapped = jacobian @ covariance @ abs(jacobian).T",
        (f"{_SANDWICH}::test_delta_method_is_exact_for_linear_maps",),
    ),
    # Rows, filters and instruments.
    "decimated rows end before the last sample": (
        "estimation/signals/prefilter.py",
        "first += (samples - sum(self.cut) - 1) % decimate",
        "first += (samples - sum(self.cut) - 2) % decimate",
        (
            "tests/estimation/signals/test_sampled_filter.py"
            "::test_matlab_alignment_ends_with_the_last_sample",
        ),
    ),
    "a reversal reaches one sample less": (
        "estimation/signals/sample_selection.py",
        "2 * reach + 1",
        "2 * reach - 1",
        (
            "tests/estimation/signals/test_reversals.py"
            "::test_samples_no_further_than_the_reach_from_a_turn_or_a_rest_are_near_it",
        ),
    ),
    "instruments are of the motion after a sample alone": (
        "estimation/regression/simulated_instruments.py",
        "after, earlier = map(at.equations, signals_about(form.axis, physical, loop))",
        "after = earlier = at.equations(signals_about(form.axis, physical, loop)[0])",
        (
            "tests/estimation/noise_models/test_noise_model.py::test_a_held_force_moves_a_free_mass_by_the_mean_of_both_its_sides",
        ),
    ),
    "the force held before a sample is that after it": (
        "estimation/simulation/loop_inputs.py",
        'out["held"] = np.where(since > 0, force[last], earlier[last])',
        'out["held"] = np.where(since > 0, force[last], force[last])',
        (f"{_CLOCKS}::test_before_a_sample_the_force_is_that_of_the_evaluation_before_it",),
    ),
    "what is held between samples is that of the next": (
        "estimation/simulation/loop_inputs.py",
        "row = np.floor(self.times + _COINCIDES).astype(np.intp)",
        "row = np.floor(self.times + 1 - _COINCIDES).astype(np.intp)",
        (f"{_CLOCKS}::test_before_a_sample_the_force_is_that_of_the_evaluation_before_it",),
    ),
    "the last sample of a log has no share in a mean": (
        "estimation/simulation/loop_inputs.py",
        "inside = np.clip(edges, 0, len(values))",
        "inside = np.clip(edges, 0, len(values) - 1)",
        (
            f"{_CLOCKS}::test_what_is_held_enters_a_slower_law_by_its_mean_until_the_next_evaluation",
        ),
    ),
    # The law along the record.
    "a late law acts at once": (
        "estimation/law_replay/replay.py",
        "rows[np.maximum(ticks.held - law_of(axis).delay, 0)]",
        "rows[ticks.held]",
        (f"{_ALONG}::test_a_late_law_with_an_integral_is_the_sum_by_hand",),
    ),
    "a law remembers what it measures now": (
        "estimation/law_replay/replay.py",
        "return np.vstack([start, after[:-1]])",
        "return after",
        (f"{_ALONG}::test_a_late_law_with_an_integral_is_the_sum_by_hand",),
    ),
    "what is added to a late law is in time": (
        "estimation/law_replay/replay.py",
        "late = self.held - delay",
        "late = self.held - 0 * delay",
        (f"{_ALONG}::test_what_is_added_to_a_late_law_is_as_late",),
    ),
    # The derivation.
    "a base parameter with a negative weight has bounds": (
        _BASE,
        "if min(low) < 0 or min(base.weights[i]) < 0:",
        "if min(low) < 0:",
        (f"{_COMBINED}::test_a_difference_has_no_bounds",),
    ),
    "a base parameter with a part that may be negative has bounds": (
        _BASE,
        "if min(low) < 0 or min(base.weights[i]) < 0:",
        "if min(base.weights[i]) < 0:",
        (f"{_COMBINED}::test_a_part_that_may_be_negative_leaves_no_bounds",),
    ),
    "a combined parameter starts from its first part": (
        _BASE,
        "nominal=base.at(start)[i],",
        "nominal=start[i],",
        (f"{_COMBINED}::test_a_sum_starts_from_the_sum_of_the_nominal_values",),
    ),
    "a combined parameter starts from nominal values where better ones are known": (
        _BASE,
        "start = [p.nominal if p.known is None else p.known for p in declared]",
        "start = [p.nominal for p in declared]",
        (f"{_COMBINED}::test_a_sum_starts_from_what_is_known_of_its_parts",),
    ),
    "the first inertia is the pivot of the direct map": (
        "modeling/derivation/direct.py",
        "next((p for p in scales if vanishes(rest[p])), next(iter(scales)))",
        "next(iter(scales))",
        (f"{_COMBINED}::test_the_pivot_of_the_direct_map_is_an_inertia_without_other_forces",),
    ),
    "functions are looked at in the same digits again": (
        _DEPENDENCES,
        "with numbers.workprec(2 * numbers.prec):",
        "with numbers.workprec(1 * numbers.prec):",
        (f"{_APART}[more digits than seventy]",),
    ),
    "what holds at the first points is believed": (
        _DEPENDENCES,
        "found, doubts = self._with_evidence(points, algebra)",
        "found, doubts = self._echelon_at(points), {}",
        (f"{_APART}[steps 1 um apart]",),
    ),
    "a doubt is no reason to keep a function": (
        _DEPENDENCES,
        "if failed or not self._is_shown(j, weights)",
        "if failed",
        (f"{_FOUND}::test_what_no_point_shows_leaves_a_doubt_and_merges_nothing",),
    ),
    "any weight will do": (
        _DEPENDENCES,
        "if not (simple or self.points.given or _has_numbers(self.functions)):",
        "if False:",
        (f"{_FOUND}::test_weights_that_are_no_fractions_need_a_declared_number",),
    ),
    "a parabola leads nowhere": (
        "modeling/quantities/features.py",
        "if bend == 0 or bend != bend:",
        "if bend * 0 == 0:",
        (f"{_PLACED}_and_beside_the_grid",),
    ),
    "the force of the base model is not compared": (
        "modeling/derivation/force_guard.py",
        "if point.is_real and abs(sum(values) - force) > allowed * sum(map(abs, values)):",
        "if force != force:",
        (f"{_DERIVED}::test_a_derivation_whose_force_is_another_is_refused",),
    ),
    "directions are those near the nominal values": (
        "modeling/derivation/null_space.py",
        "near = (nominal_point(parameters), generic_points(parameters)[0])",
        "near = generic_points(parameters)",
        (f"{_SEEN}_changes_no_force[a quotient beside a coefficient]",),
    ),
}


@dataclass(frozen=True)
class Outcome:
    """What became of a mutant: the first test that failed, none if it survives, and seconds."""

    name: str
    killer: str
    seconds: float


def copied(folder: Path) -> Path:
    """A copy of the tree, its links as they are."""
    return Path(shutil.copytree(ROOT, folder, True, shutil.ignore_patterns(*_LEFT_OUT)))


def text_with(name: str, tree: Path = ROOT) -> str:
    """A mutant's file with its fault; refused by name where the text is not there just once."""
    file, right, wrong, _ = MUTANTS[name]
    text = (tree / file).read_text()
    if text.count(right) != 1:
        raise SystemExit(f"mutant {name!r}: {file} has {text.count(right)} times {right!r}, not 1")
    return text.replace(right, wrong)


def first_failure(tree: Path, cache: Path, tests: Sequence[str]) -> str:
    """The first of the tests that fails in a copy of the tree; nothing where all pass."""
    paths = os.pathsep.join((str(tree / "src"), os.environ.get("PYTHONPATH", "")))
    own = {"PYTHONPATH": paths, "AXISID_CACHE": str(cache)}
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-rfE", "-n0", "-pno:cacheprovider"]
    try:
        ended = subprocess.run(
            [*command, *tests],
            cwd=tree,
            env=os.environ | own,
            capture_output=True,
            text=True,
            timeout=LIMIT_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"more than {LIMIT_S:.0f} s"
    found = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", ended.stdout, re.MULTILINE)
    if (ended.returncode != 0) != (found is not None):
        raise SystemExit(f"pytest cannot run {' '.join(tests)}:\n{ended.stdout}{ended.stderr}")
    return found[1] if found else ""


def tried(name: str, trees: "SimpleQueue[Path]", cache: Path) -> Outcome:
    """Run the tests of a mutant in a copy that nobody uses."""
    begun, tree = time.perf_counter(), trees.get()
    file, _, _, tests = MUTANTS[name]
    wrong = text_with(name, tree)
    right = (tree / file).rename(tree / f"{file}.right")  # with its time, by which Python compiles
    (tree / file).write_text(wrong)
    try:
        killer = first_failure(tree, cache, tests)
    finally:
        right.replace(tree / file)
        trees.put(tree)
    outcome = Outcome(name, killer, time.perf_counter() - begun)
    print(f"{outcome.seconds:6.1f} s  {name}: {killer or 'SURVIVES'}", flush=True)
    return outcome


def study(names: Sequence[str], jobs: int) -> list[Outcome]:
    """What becomes of mutants, so many at a time."""
    for name in names:
        text_with(name)
    with tempfile.TemporaryDirectory(prefix="axisid-mutants-") as folder:
        trees: SimpleQueue[Path] = SimpleQueue()
        copies = [copied(Path(folder, f"tree{i}")) for i in range(jobs)]
        cache = Path(folder, "native")
        tests = sorted({test for name in names for test in MUTANTS[name][3]})
        if failed := first_failure(copies[0], cache, tests):
            raise SystemExit(f"{failed} fails without a fault")
        for copy in copies:
            trees.put(copy)
        with ThreadPoolExecutor(jobs) as pool:
            return list(pool.map(lambda name: tried(name, trees, cache), names))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--only", nargs="+", choices=MUTANTS, default=list(MUTANTS), metavar="NAME")
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    started = time.perf_counter()
    outcomes = study(given.only, given.jobs)
    survivors = [each.name for each in outcomes if not each.killer]
    spent = time.perf_counter() - started
    print(f"{len(outcomes)} mutants in {spent:.0f} s, {len(survivors)} survive: {survivors}")
    sys.exit(bool(survivors))
