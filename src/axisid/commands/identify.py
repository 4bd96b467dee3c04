"""``axisid identify``."""

import math
import shlex
import sys
from typing import TYPE_CHECKING, Any

import click

from axisid.commands.options.completion import complete_axis, complete_file
from axisid.commands.options.estimator_options import (
    bootstrap_option,
    bounded_option,
    check_estimator,
    covariance_option,
    draws_option,
    drive_time_option,
    fix_option,
    lags_option,
    levels_options,
    loss_option,
    method_option,
    start_of_instruments,
)
from axisid.commands.options.filter_options import Filtering, filter_options
from axisid.commands.options.inputs import Inputs, axis_and_records, leave_out_option
from axisid.commands.options.option_checks import Command, check_idle, check_needed
from axisid.commands.options.outputs import (
    Target,
    check_folder,
    check_targets,
    force_option,
    json_option,
)
from axisid.commands.options.record_options import Reading, Window, record_options, window_of
from axisid.commands.options.several_options import (
    Sharing,
    columns_by_place,
    columns_of_option,
    sharing_options,
    skip_bad_option,
)
from axisid.presentation.console import ProgressLine

from .identify_outputs import put_identification

if TYPE_CHECKING:
    from collections.abc import Sequence

    from axisid.codegen.artefacts import GeneratedAxis
    from axisid.estimation.records import Record
    from axisid.estimation.signals import Prefilter


def _check_idle(methods: tuple[str, ...], covariance: str, json_file: str | None) -> None:
    """Refuse options that the others leave without effect."""
    check_needed(("--figure-format", "--figure-width"), ("--figures",))
    check_needed(("--no-sweep",), ("--report", "--figures"))
    check_needed(("--validate-window", "--validate-like"), ("--validate",))
    check_estimator(methods, covariance)
    if json_file == "-":
        check_idle("--full", "is of what is printed, and --json - has all of it in place of that")


def _finite(_: click.Context, parameter: click.Parameter, value: float) -> float:
    """No range that click knows leaves out what is no number."""
    if not math.isfinite(value):
        raise click.BadParameter("give a number of millimetres", param=parameter)
    return value


@click.command(
    cls=Command,
    short_help="Identify an axis from a record, or from several.",
    epilog="Example: axisid identify emps2015, or "
    "axisid identify emps DATA_EMPS.mat --cutoff 60 --json result.json --report report.html, or "
    "axisid identify pendulum.py log.csv --fix m=1.2+-0.01, or "
    "axisid identify stage.py empty.csv loaded.csv --local tau0 --known m_add=0,20+-0.01",
)
@click.argument("axis", shell_complete=complete_axis)
@click.argument("record", nargs=-1, shell_complete=complete_file)
@method_option
@filter_options(
    cutoff="Butterworth low-pass.  [default: 60, or a fifth of the log's rate if that is less]",
    order="Its order.  [default: 4]",
    decimate="Keep one row in N.  [default: 10, or more where the cut-off asks for it]",
    decimation="Rows aligned to the record's end or start.  [default: matlab]",
    drop="Samples left out at both ends.  [default: the filter's transient]",
    hold="zoh pairs motion with the mean of the forces held around a sample; raw with the one "
    "after it.  [default: zoh for a control that a drive holds, else raw]",
    reversals="Samples near a reversal or a rest, where the low-pass rounds what friction does at "
    "once.  [default: leave-out for axes with friction, unless that hides a parameter]",
)
@record_options
@columns_of_option
@sharing_options
@skip_bad_option
@fix_option(
    "A parameter that is known apart from the record, SI, with its standard deviation; again "
    "for each."
)
@leave_out_option
@drive_time_option(
    "Estimate the drive's lag or its delay too, from where it is declared; every deviation "
    "then has what its own adds. Of one record, which shows their sum alone."
)
@click.option("--no-native", is_flag=True, help="Simulate in the CasADi virtual machine, slower.")
@click.option(
    "--validate",
    "further",
    metavar="RECORD",
    multiple=True,
    shell_complete=complete_file,
    help="Hold the estimates, frozen, against another record; again for each.",
)
@click.option(
    "--validate-window",
    "second_windows",
    multiple=True,
    metavar="FROM..TO",
    help="As --window, of the record of --validate, which else is taken whole; that may be the "
    "same file.",
)
@click.option(
    "--validate-like",
    "like",
    type=click.IntRange(min=1),
    metavar="N",
    help="The record, of those that are identified from, whose --local parameters and --known "
    "values the record of --validate has.",
)
@covariance_option
@lags_option
@start_of_instruments
@loss_option
@bounded_option
@bootstrap_option
@levels_options
@draws_option
@click.option("--all", "every", is_flag=True, help="Print every method, side by side, with notes.")
@click.option(
    "--full",
    is_flag=True,
    help="Print that, with intervals, correlations and every check's figures.",
)
@json_option("Write the result as JSON; - for standard output.")
@click.option(
    "--report", metavar="FILE", help="Write a page of HTML to show: verdict, tables, figures."
)
@click.option("--figures", metavar="DIR", help="Write the figures into a folder.")
@click.option(
    "--figure-format",
    type=click.Choice(["pdf", "svg", "png"]),
    default="pdf",
    show_default=True,
    help="Of --figures.",
)
@click.option(
    "--figure-width",
    type=click.FloatRange(60, 400),
    default=160,
    show_default=True,
    metavar="MM",
    help="Of --figures; a column of a journal has 88.",
    callback=_finite,
)
@click.option("--no-sweep", is_flag=True, help="Page and figures without a sweep of the cut-off.")
@force_option
def identify(
    axis: str,
    record: tuple[str, ...],
    methods: tuple[str, ...],
    further: tuple[str, ...],
    second_windows: tuple[str, ...],
    like: int | None,
    filtering: Filtering,
    reading: Reading,
    columns_of: tuple[tuple[int, str], ...],
    sharing: Sharing,
    skip_bad: bool,
    covariance: str,
    lags: int | None,
    started_at: str,
    loss: str,
    bounded: bool,
    bootstrap: int,
    levels: dict[str, Any],
    draws: int | None,
    every: bool,
    full: bool,
    json_file: str | None,
    fix: tuple[str, ...],
    left_out: tuple[str, ...],
    drive_time: str | None,
    no_native: bool,
    report: str | None,
    figures: str | None,
    figure_format: str,
    figure_width: float,
    no_sweep: bool,
    force: bool,
) -> None:
    """Identify AXIS from one RECORD or several, or from its built-in twin if none is given.

    AXIS is a name of the library (emps2015, emps, pendulum, vertical_screw, belt_axis,
    rotary_table, valve, crank, linear_motor, balanced_slide, servo_joint) or a TOML or Python file
    that declares one.
    RECORD is a log: delimited text of any dialect, MATLAB, Parquet, NumPy .npz, MDF4, TDMS, JSON or
    a ROS bag. Values are SI unless the file or --columns says otherwise. Several records are one
    regression with one set of parameters, each filtered, weighted and checked by itself.
    """
    filtering.prefilter()  # refused before anything is read
    targets = [Target("--json", json_file, "identify"), Target("--report", report, "report")]
    check_targets(targets, (*record, axis, *further), force=force)
    own_columns = columns_by_place(columns_of, len(record))
    _check_idle(methods, covariance, json_file)
    _check_figures(figures, figure_format, len(record), force=force)
    inputs = axis_and_records(
        axis,
        record,
        reading,
        further,
        fixed=fix,
        left_out=left_out,
        drive_time=drive_time,
        no_native=no_native,
        skip_bad=skip_bad,
        own_columns=own_columns,
    )
    if further:
        sharing.check_validates(like)
    inputs, shared = sharing.of(inputs, len(record))

    from axisid.estimation.identification import identify as run

    generated, first = inputs.axis, inputs.records[0]
    prefilter = filtering.prefilter(first.period)
    held = tuple(window_of(text, "--validate-window") for text in second_windows)
    others = _held_out(generated, further, held, reading, prefilter)
    with ProgressLine(f"identifying {generated.axis.name}"):
        result = run(
            generated,
            inputs.records,
            prefilter,
            None if "all" in methods else methods,
            lags=lags,
            covariance=covariance,
            skip_bad=skip_bad,
            start=started_at,
            loss=loss,
            bounded=bounded,
            bootstrap=bootstrap,
            **levels,
            **shared,
        ).with_set_aside(inputs.set_aside)
    from axisid.presentation.report import Outputs

    outputs = Outputs(
        report=report,
        figures=figures,
        form=figure_format,
        width=figure_width,
        swept=not no_sweep,
        draws=draws or 0,
        command=shlex.join(["axisid", *sys.argv[1:]]),
    )
    own = None if like is None else _place(inputs, result.records, like)
    put_identification(
        result, json_file, others, draws or 0, outputs, every=every, full=full, like=own
    )


def _place(inputs: Inputs, used: "Sequence[Record]", number: int) -> int:
    """Number among the records that were used of one of the command line's."""
    read = dict(zip(inputs.used, inputs.records, strict=True)).get(number - 1)
    found = [i for i, record in enumerate(used, 1) if record is read]
    if not found:
        raise click.BadParameter(
            f"record {number} is none of the {len(used)} that were used",
            param_hint="--validate-like",
        )
    return found[0]


def _held_out(
    axis: "GeneratedAxis",
    logs: tuple[str, ...],
    windows: tuple[Window, ...],
    reading: Reading,
    prefilter: "Prefilter",
) -> list["Record"]:
    """Records for --validate; refused before the long part where the filter does not suit one."""
    from axisid.estimation.signals import FilteredRecord

    records = [reading.record(log, axis, windows) for log in logs]
    for record in records:
        _ = FilteredRecord.bind(axis, record, prefilter).signals
    return records


def _check_figures(folder: str | None, form: str, records: int, *, force: bool) -> None:
    """Refuse a folder of figures that holds others of the same names."""
    if folder is None:
        return
    from axisid.presentation.drawing import NAMES

    numbers = ["", *(f"-{i + 1}" for i in range(records) if records > 1)]
    drawn = {f"{name}{i}.{form}": "figure" for name in NAMES for i in numbers}
    check_folder(folder, "--figures", drawn, force=force)
