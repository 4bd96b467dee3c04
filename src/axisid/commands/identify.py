"""``axisid identify``: identify an axis from one or several records."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import click

from axisid.commands.options import (
    Command,
    Filtering,
    Inputs,
    Options,
    Reading,
    Sharing,
    Target,
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
    fix_option,
    force_option,
    json_option,
    leave_out_option,
    loss_option,
    method_option,
    option,
    print_document,
    print_result,
    progress_line,
    put_out,
    stages,
    takes,
)
from axisid.support.errors import AxisidError, EstimationError


@dataclass(frozen=True, slots=True, kw_only=True)
class Validating(Options):
    """Options of the validation on other records."""

    further: tuple[str, ...] = option(
        "Validate the estimates, without a new fit, on another record. Can be repeated.",
        name="validate",
        metavar="RECORD",
        multiple=True,
        shell_complete=complete_file,
    )
    like: int | None = option(
        "For the record of --validate, use the --local parameters and --known values of the Nth "
        "RECORD.",
        name="validate-like",
        type=click.IntRange(min=1),
        metavar="N",
    )


@click.command(
    cls=Command,
    short_help="Identify an axis from one or several records.",
    epilog="Example: axisid identify emps2015, or "
    "axisid identify emps DATA_EMPS.mat --cutoff 60 --json result.json --report report.html, or "
    "axisid identify pendulum.py log.csv --fix m=1.2+-0.01, or "
    "axisid identify stage.py empty.csv loaded.csv --local tau0 --known m_add=0,20+-0.01",
)
@click.argument("axis", shell_complete=complete_axis)
@click.argument("record", nargs=-1, shell_complete=complete_file)
@method_option
@takes("filtering", Filtering)
@takes("reading", Reading)
@takes("sharing", Sharing)
@fix_option(
    "Known value of a parameter, SI. Add +-SD, the standard deviation, to an uncertain value. Can "
    "be repeated."
)
@leave_out_option(has_fix=True)
@takes("validating", Validating)
@loss_option
@bounded_option
@bootstrap_option
@click.option("--all", "every", is_flag=True, help="Print all methods side by side, with notes.")
@click.option(
    "--full",
    is_flag=True,
    help="Print all methods as with --all, and also intervals, correlations and the numbers of "
    "every check.",
)
@json_option
@click.option(
    "--report", metavar="FILE", help="Write an HTML page with verdict, tables and figures."
)
@click.option("--figures", metavar="DIR", help="Write the figures into a folder, as PDF.")
@force_option
def identify(
    axis: str,
    record: tuple[str, ...],
    methods: tuple[str, ...],
    validating: Validating,
    filtering: Filtering,
    reading: Reading,
    sharing: Sharing,
    loss: str,
    bounded: bool,
    bootstrap: int,
    every: bool,
    full: bool,
    json_file: str | None,
    fix: tuple[str, ...],
    left_out: tuple[str, ...],
    report: str | None,
    figures: str | None,
    force: bool,
) -> None:
    """Identify AXIS from one or several RECORDs.

    Without a RECORD, a simulated record of the axis (its twin) is used.

    AXIS is an axis of the library (emps2015, emps, pendulum, vertical_screw, belt_axis,
    rotary_table, valve, crank, linear_motor, balanced_slide, servo_joint), or a TOML or Python file
    that declares an axis.
    RECORD is a log (delimited text, MATLAB, Parquet, NumPy .npz, MDF4, TDMS, JSON or a ROS bag), or
    a run.toml that describes a log. Values are in SI units unless the run.toml, the log or
    --columns states another unit. Several records form one regression with one set of parameters.
    Each record is filtered, weighted and checked separately.
    """
    filtering.prefilter()  # refused before anything is read
    check_targets(
        [Target("--json", json_file, "identify"), Target("--report", report, "report")],
        (*record, axis, *validating.further),
        force=force,
    )
    check_needed((("--validate-like",), ("--validate",)))
    if json_file == "-":
        check_idle("--full", "has no effect, because --json - prints JSON, which is complete")
    if figures is not None:
        numbers = ["", *(f"-{i + 1}" for i in range(len(record)) if len(record) > 1)]
        drawn = {f"{name}{i}.pdf": "figure" for name in stages.NAMES for i in numbers}
        check_folder(figures, "--figures", drawn, force=force)
    further = validating.further
    inputs = axis_and_records(axis, record, reading, sharing, further, fixed=fix, left_out=left_out)
    if further and (sharing.local or sharing.known) and validating.like is None:
        raise click.UsageError(
            "the --local parameters and --known values of the record of --validate are not given. "
            "Name a RECORD that has the same values by its number: --validate-like 1."
        )
    prefilter = filtering.prefilter(inputs.records[0].period)
    others = _held_out(inputs.axis, further, reading, prefilter)
    with progress_line(f"identifying {inputs.axis.axis.name}"):
        result = stages.identify(
            inputs.axis,
            inputs.records,
            prefilter,
            None if "all" in methods else methods,
            skip_bad=sharing.skip_bad,
            bounded=bounded,
            bootstrap=bootstrap,
            loss=loss,
            judge=False,  # once, with the further records
            **inputs.shared,
        ).with_set_aside(inputs.set_aside)

    like = None
    if validating.like is not None:
        like = _number_in_result(inputs, result.records, validating.like)
    with progress_line("checking the estimates"):
        validations = [stages.validate(result, other, like=like) for other in others]
        check = stages.joined(
            [each.check for each in validations],
            [each.record.provenance.source for each in validations],
        )
        result = replace(result, further=() if check is None else (check,))

    def show() -> None:
        with progress_line("checking the estimates"):
            document = stages.as_blocks(result, every=every, full=full)
        print_document(document)
        for validation in validations:
            click.echo()
            print_result(validation)

    if json_file == "-":
        for method, reason in result.skipped.items():
            _say(f"{method} was not run: {reason}")
    put_out(
        json_file,
        lambda: _document(result, validations),
        show,
        (
            report or figures,
            lambda _: stages.write_outputs(
                result, validations, _say, report=report, figures=figures, command=command_line()
            ),
        ),
    )
    if result.failed:
        raise EstimationError(" ".join(stages.missing_notes(result.failed)))


def _number_in_result(
    inputs: Inputs, identified_records: "Sequence[stages.Record]", number: int
) -> int:
    """Return the number, among the records of a result, of record `number` of the command line.

    Both numbers begin with 1. They differ if records were skipped.

    Parameters
    ----------
    inputs : Inputs
        Records that could be read, with the index of each on the command line (`Inputs.used`).
    identified_records : sequence of Record
        Records that the result was identified from, in their order.
    number : int
        Number of the record on the command line.
    """
    record_by_index = dict(zip(inputs.used, inputs.records, strict=True))
    wanted = record_by_index.get(number - 1)
    numbers = [i for i, record in enumerate(identified_records, 1) if record is wanted]
    if not numbers:
        raise click.BadParameter(
            f"record {number} is not among the {len(identified_records)} records that were used. "
            "Give the number of a record that was used.",
            param_hint="--validate-like",
        )
    return numbers[0]


def _held_out(
    axis: "stages.GeneratedAxis",
    logs: Sequence[str],
    reading: Reading,
    prefilter: "stages.Prefilter",
) -> list["stages.Record"]:
    """Return the records of --validate, read from logs; refuse a record that cannot be filtered.

    The records are filtered here, so that such a record is refused before the identification.
    """
    records = [replace(reading, windows=()).record(log, axis) for log in logs]
    for log, record in zip(logs, records, strict=True):
        try:
            _ = stages.FilteredRecord.bind(axis, record, prefilter).signals
        except AxisidError as error:
            raise type(error)(
                f"{log}, the record of --validate: {error}", code=error.code
            ) from error
    return records


def _document(
    result: "stages.Identification", validations: "Sequence[stages.Validation]"
) -> dict[str, Any]:
    """Return the JSON document of a result and of its validations.

    The first validation is the member ``validation``; ``validations`` has all if there are several.
    """
    with progress_line("checking the estimates"):
        written = result.to_dict()
    checked = [validation.to_dict() for validation in validations]
    several = {"validations": checked} if len(checked) > 1 else {}
    return {**written, **({"validation": checked[0]} if checked else {}), **several}


def _say(line: str) -> None:
    """Print a line on standard error."""
    click.echo(f"axisid: {line}", err=True)
