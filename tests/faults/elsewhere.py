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
}
