"""Classes of faults that need processes, signals or fonts of their own: where they are tested."""

from tests.faults.fault import Fault, Misuse

FAULTS: list[Fault] = []
MISUSES: list[Misuse] = []

#: By class of fault, tests as ``file::function``.
ELSEWHERE: dict[str, tuple[str, ...]] = {
    "an unusable cache": (
        "codegen/native/test_native.py::test_unwritable_cache_means_one_folder_for_the_user_and_nothing_else",
        "codegen/native/test_native.py::test_full_disk_means_the_virtual_machine",
    ),
    "a build that is killed": (
        "codegen/native/test_native.py::test_kill_during_a_build_leaves_nothing_that_is_loaded",
        "codegen/native/test_workshop.py::test_leavings_of_killed_builds_are_cleared_away",
    ),
    "a signal while it compiles": (
        "codegen/native/test_workshop.py::test_process_that_ends_while_it_compiles_leaves_nothing",
        "codegen/native/test_native.py::test_compiler_that_leaves_a_child_behind_does_not_hold_us_up",
    ),
    "an interrupt of a long native call": (
        "codegen/native/test_slices.py::test_long_simulation_ends_at_once_at_an_interrupt",
        "codegen/native/test_slices.py::test_long_evaluation_ends_at_once_at_an_interrupt",
        "commands/test_main.py::test_interrupt_exits_130",
    ),
    "a pickle or a deep copy": (
        "integration/test_pickling.py::test_copy_is_equal",
        "integration/test_pickling.py::test_round_trip_through_another_process_changes_nothing",
        "integration/test_pickling.py::test_every_public_class_is_among_them",
    ),
    "a font without the signs of an exponent": (
        "presentation/drawing/test_matplotlib.py::test_exponents_are_drawn_where_the_chosen_font_lacks_them",
    ),
    "a clock that was set back, joined logs": (
        "estimation/records/times/test_time_steps.py::test_clock_that_was_set_back_is_told_and_counted",
    ),
    "a period that drifts": (
        "estimation/records/times/test_time_steps.py::test_period_that_drifts_is_refused_and_may_be_resampled",
        "estimation/records/times/test_time_steps.py::test_slight_drift_is_told_and_jitter_is_no_drift",
    ),
    "spikes": (
        "estimation/records/faults/test_spikes.py::test_spikes_are_told_with_row_time_and_a_way_out",
    ),
    "rests that are kept": (
        "estimation/signals/test_without_turns.py::test_rests_that_are_kept_are_named_where_the_loop_does_not_follow",
    ),
    "a ripple": (
        "estimation/diagnostics/remainder/test_unexplained.py::test_a_ripple_is_told_with_its_frequency_and_a_cut_off",
        "estimation/diagnostics/remainder/test_unexplained.py::test_a_ripple_over_the_position_is_told_with_its_period",
    ),
    "an offset of the plant or of a converter": (
        "estimation/diagnostics/remainder/test_unexplained.py::test_an_offset_of_the_plant_is_proposed_with_its_size",
        "estimation/diagnostics/remainder/test_unexplained.py::test_a_converter_that_is_off_is_told_from_an_offset",
    ),
    "a declared time column beside a file's own clocks": (
        "estimation/logs/test_read_formats.py::test_time_column_that_the_axis_declares_gives_way_to_the_files_own_clocks",
        "estimation/logs/test_rosbag.py::test_time_column_that_the_axis_declares_gives_way_to_the_bags_clock",
    ),
    "right code of fast and stiff models": (
        "codegen/native/test_self_test.py::test_right_code_of_a_fast_model_passes",
        "codegen/native/test_self_test.py::test_fault_in_the_loop_of_a_fast_model_is_found",
    ),
    "a library that crashes or never returns": (
        "codegen/native/test_workshop.py::test_library_that_crashes_is_refused_and_never_kept",
        "codegen/native/test_workshop.py::test_library_that_never_returns_is_refused",
    ),
    "a contact shorter than a sample": (
        "estimation/simulation/test_position_events.py::test_contact_shorter_than_a_sample_is_met",
        "estimation/simulation/test_position_events.py::test_random_stops_are_met_within_a_micrometre_or_refused_with_a_sentence",
    ),
    "a force that is set-valued in the position": (
        "estimation/simulation/test_position_events.py::test_random_jumps_are_crossed_or_rested_in_as_in_closed_form",
        "estimation/simulation/test_position_events.py::test_axis_is_held_in_a_jump_until_the_drive_overcomes_it",
    ),
    "a wave of the position that passes within a sample": (
        "estimation/simulation/test_position_events.py::test_wave_of_the_position_is_resolved_however_fast_it_passes",
        "estimation/simulation/test_position_events.py::test_wave_too_short_for_the_speed_is_refused",
    ),
    "exported Python at special numbers": (
        "codegen/printers/test_python.py::test_python_has_the_values_of_c_for_every_size_of_number",
        "codegen/printers/test_python.py::test_an_axis_has_the_values_of_c_at_every_special_motion",
        "codegen/printers/test_python.py::test_exponentials_beyond_a_double_are_infinite_or_nothing_as_in_c",
    ),
    "lack of memory": (
        "support/files/test_memory.py::test_lack_of_memory_is_a_sentence",
        "support/files/test_memory.py::test_lack_of_memory_exits_3",
    ),
    "a drawing library that does not start": (
        "commands/test_main.py::test_matplotlib_that_does_not_start_is_told_before_anything_is_done",
    ),
    "numbers that SymPy takes out of exponents": (
        "codegen/accuracy/test_declared_check.py::test_every_target_has_the_declared_force_far_from_zero",
        "codegen/accuracy/test_declared_check.py::test_a_number_that_was_taken_out_of_an_exponent_is_seen",
    ),
    "a log without a reference, or its first rows alone, off by more than it says": (
        "estimation/problems/test_filter_bias.py::test_without_a_reference_it_is_found_by_a_loop_that_follows",
        "estimation/problems/test_filter_bias.py::test_what_noise_moves_without_a_reference_is_named",
    ),
}
