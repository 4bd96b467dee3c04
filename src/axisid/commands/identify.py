"""``axisid identify``."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import click

from axisid.commands.options import (
    Command,
    Estimating,
    Filtering,
    Inputs,
    Judging,
    Options,
    Reading,
    Sharing,
    Target,
    Window,
    axis_and_records,
    bootstrap_option,
    bounded_option,
    check_folder,
    check_idle,
    check_needed,
    check_targets,
    command_line,
    complete_axis,
    complete_file,
    draws_option,
    drive_time_option,
    fix_option,
    force_option,
    json_option,
    leave_out_option,
    method_option,
    option,
    print_result,
    put_json,
    read_windows,
    stages,
    takes,
)
from axisid.presentation.console import ProgressLine, print_document
from axisid.support.errors import AxisidError, EstimationError, UsageError
from axisid.support.remedy import as_options


def _check_idle(json_file: str | None) -> None:
    """Refuse options that the others leave without effect."""
    check_needed(("--figure-format", "--figure-width"), ("--figures",))
    check_needed(("--no-sweep",), ("--report", "--figures"))
    check_needed(("--validate-window", "--validate-like"), ("--validate",))
    if json_file == "-":
        check_idle("--full", "is of what is printed, and --json - has all of it in place of that")


def _finite(_: click.Context, parameter: click.Parameter, value: float) -> float:
    """No range that click knows leaves out what is no number."""
    if not math.isfinite(value):
        raise click.BadParameter("give a number of millimetres", param=parameter)
    return value


@dataclass(frozen=True, slots=True, kw_only=True)
class Validating(Options):
    """Other records that the estimates are held against."""

    further: tuple[str, ...] = option(
        "Hold the estimates, frozen, against another record; again for each.",
        name="validate",
        metavar="RECORD",
        multiple=True,
        shell_complete=complete_file,
    )
    windows: tuple[Window, ...] = option(
        "As --window, of the record of --validate, which else is taken whole; that may be the "
        "same file.",
        name="validate-window",
        read=read_windows,
        multiple=True,
        metavar="FROM..TO",
    )
    like: int | None = option(
        "The record, of those that are identified from, whose --local parameters and --known "
        "values the record of --validate has.",
        name="validate-like",
        type=click.IntRange(min=1),
        metavar="N",
    )


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
@takes(
    "filtering",
    Filtering,
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
@takes("reading", Reading)
@takes("sharing", Sharing)
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
@takes("validating", Validating)
@takes("estimating", Estimating)
@bounded_option
@bootstrap_option
@takes("levels", Judging)
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
    validating: Validating,
    filtering: Filtering,
    reading: Reading,
    sharing: Sharing,
    estimating: Estimating,
    bounded: bool,
    bootstrap: int,
    levels: Judging,
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
    check_targets(targets, (*record, axis, *validating.further), force=force)
    own_columns = sharing.own_columns(len(record))
    _check_idle(json_file)
    estimating.check(methods)
    _check_figures(figures, figure_format, len(record), force=force)
    inputs = axis_and_records(
        axis,
        record,
        reading,
        validating.further,
        fixed=fix,
        left_out=left_out,
        drive_time=drive_time,
        no_native=no_native,
        skip_bad=sharing.skip_bad,
        own_columns=own_columns,
    )
    if validating.further:
        sharing.check_validates(validating.like)
    inputs, shared = sharing.of(inputs, len(record))

    generated, first = inputs.axis, inputs.records[0]
    prefilter = filtering.prefilter(first.period)
    others = _held_out(generated, validating, reading, prefilter)
    with ProgressLine(f"identifying {generated.axis.name}"):
        result = stages.identify(
            generated,
            inputs.records,
            prefilter,
            None if "all" in methods else methods,
            skip_bad=sharing.skip_bad,
            bounded=bounded,
            bootstrap=bootstrap,
            **estimating.arguments(),
            **levels.arguments(),
            **shared,
        ).with_set_aside(inputs.set_aside)

    asked: dict[str, Any] = {
        "report": report,
        "figures": figures,
        "form": figure_format,
        "width": figure_width,
        "swept": not no_sweep,
    }
    like = validating.like
    own = None if like is None else _place(inputs, result.records, like)
    _put(result, json_file, others, draws or 0, asked, every=every, full=full, like=own)


def _place(inputs: Inputs, used: "Sequence[stages.Record]", number: int) -> int:
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
    axis: "stages.GeneratedAxis",
    validating: Validating,
    reading: Reading,
    prefilter: "stages.Prefilter",
) -> list["stages.Record"]:
    """Records for --validate; refused before the long part where the filter does not suit one."""
    records = [reading.record(log, axis, validating.windows) for log in validating.further]
    for log, record in zip(validating.further, records, strict=True):
        try:
            _ = stages.FilteredRecord.bind(axis, record, prefilter).signals
        except AxisidError as error:
            problem = f"{log}, to validate on: {error.problem}"
            raise type(error)(problem, error.remedy, code=error.code) from error
    return records


def _check_figures(folder: str | None, form: str, records: int, *, force: bool) -> None:
    """Refuse a folder of figures that holds others of the same names."""
    if folder is None:
        return

    numbers = ["", *(f"-{i + 1}" for i in range(records) if records > 1)]
    drawn = {f"{name}{i}.{form}": "figure" for name in stages.NAMES for i in numbers}
    check_folder(folder, "--figures", drawn, force=force)


def _put(
    result: "stages.Identification",
    json_file: str | None,
    others: "Sequence[stages.Record]",
    draws: int,
    asked: dict[str, Any],
    *,
    every: bool,
    full: bool,
    like: int | None = None,
) -> None:
    """Write the result, then print it, and fail if a method came to nothing."""
    with ProgressLine("judging the estimates"):
        validations = [stages.validate(result, other, like=like) for other in others]
        names = [each.record.provenance.source for each in validations]
        check = stages.joined([each.check for each in validations], names)
        result = replace(result, further=() if check is None else (check,))
        written = None if json_file is None else result.to_dict(draws)
        document = (
            ()
            if json_file == "-"
            else stages.as_blocks(result, draws=draws, every=every, full=full, wording=as_options)
        )
    refused: UsageError | None = None
    if json_file is not None and written is not None:
        checked = [validation.to_dict() for validation in validations]
        added: dict[str, Any] = {"validation": checked[0]} if checked else {}
        added |= {"validations": checked} if len(checked) > 1 else {}
        try:
            put_json(json_file, {**written, **added})
        except UsageError as error:
            refused = error  # told after the result, which it must not cost
    if json_file == "-":
        for method, reason in result.skipped.items():
            click.echo(f"axisid: without {method}: {reason.worded(as_options)}", err=True)
    else:
        print_document(document)
        for validation in validations:
            click.echo()
            print_result(validation)

    def say(line: str) -> None:
        click.echo(f"axisid: {line}", err=True)

    asked |= {"draws": draws, "command": command_line()}
    for path in stages.write_outputs(result, validations, say, **asked):
        click.echo(f"wrote {path}", err=json_file == "-")
    if refused is not None:
        raise refused
    if result.failed:
        raise EstimationError("; ".join(stages.missing_notes(result.failed, as_options)))
