"""``axisid fit``, ``axisid sweep`` and ``axisid law``."""

from pathlib import Path

import click

from axisid.commands.options import (
    Command,
    Filtering,
    Fitting,
    Reading,
    Sharing,
    Target,
    axis_and_records,
    check_targets,
    complete_axis,
    complete_file,
    force_option,
    json_option,
    leave_out_option,
    progress_line,
    put_result,
    stages,
    takes,
    write_page,
)
from axisid.support.errors import UsageError


@click.command(
    cls=Command,
    short_help="Fit the simulated loop to a record.",
    epilog="Examples: axisid fit emps2015, or "
    "axisid fit emps DATA_EMPS.mat --prior M=95+-2 --json fit.json, or "
    "axisid fit stage.py empty.csv loaded.csv --local tau0 --bound Fv=0..",
)
@click.argument("axis", shell_complete=complete_axis)
@click.argument("record", nargs=-1, shell_complete=complete_file)
@takes("asked", Fitting)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Seed of the random further starts.",
)
@takes("reading", Reading)
@takes("sharing", Sharing)
@click.option(
    "--fix",
    multiple=True,
    metavar="NAME=VALUE[+-SD]",
    help="Fix a parameter at this value, SI. With +-SD the value is a prior and the parameter is "
    "fitted. Can be repeated.",
)
@leave_out_option
@json_option
@click.option(
    "--report", metavar="FILE", help="Write an HTML page with verdict, table and figures."
)
@force_option
def fit(
    axis: str,
    record: tuple[str, ...],
    asked: Fitting,
    seed: int,
    reading: Reading,
    sharing: Sharing,
    fix: tuple[str, ...],
    left_out: tuple[str, ...],
    json_file: str | None,
    report: str | None,
    force: bool,
) -> None:
    """Fit AXIS to one or several RECORDs (or to its twin) by output error, without a filter.

    The closed loop is simulated from the recorded reference and initial state. The parameters are
    searched until the simulated control (or position) is as close to the record as possible.
    Encoder noise causes no bias. The declared control law must be exact; a check compares it with
    the record. Ctrl-C ends the search: the best values so far are printed and written, and the exit
    code is 130.
    """
    check_targets(
        [Target("--json", json_file, "fit"), Target("--report", report, "report")],
        (*record, axis),
        force=force,
    )
    inputs = axis_and_records(axis, record, reading, sharing, fixed=fix, left_out=left_out)
    inputs.say_set_aside()

    with progress_line(f"fitting {inputs.axis.axis.name}") as line:
        result = stages.fit(
            inputs.axis,
            inputs.records,
            progress=line,
            seed=seed,
            **asked.arguments(),
            **inputs.shared,
        )
    put_result(
        result,
        json_file,
        (report, lambda file: write_page(file, stages.fit_report_html, result)),
    )
    if result.interrupted:
        raise KeyboardInterrupt


@click.command(
    cls=Command,
    short_help="Identify with many cut-offs.",
    epilog="Examples: axisid sweep emps2015 --points 3, or "
    "axisid sweep emps DATA_EMPS.mat --figure sweep.png",
)
@click.argument("axis", shell_complete=complete_axis)
@click.argument("record", nargs=-1, shell_complete=complete_file)
@click.option("--from", "lowest", type=float, metavar="HZ", help="Lowest cut-off.")
@click.option("--to", "highest", type=float, metavar="HZ", help="Highest cut-off.")
@click.option("--points", type=int, default=12, show_default=True, help="Number of cut-offs.")
@takes("filtering", Filtering, without=("cutoff", "decimate"))
@takes("reading", Reading)
@takes("sharing", Sharing)
@leave_out_option
@json_option
@click.option("--figure", metavar="FILE", help="Draw the sweep into a .png, .svg or .pdf.")
@force_option
def sweep(
    axis: str,
    record: tuple[str, ...],
    lowest: float | None,
    highest: float | None,
    points: int,
    filtering: Filtering,
    reading: Reading,
    sharing: Sharing,
    left_out: tuple[str, ...],
    json_file: str | None,
    figure: str | None,
    force: bool,
) -> None:
    """Identify AXIS from one or several RECORDs (or its twin) with many cut-offs of the filter.

    LS drifts when noise begins to bias it, and IV stays. One cut-off is recommended. The decimation
    follows the cut-off.
    """
    check_targets(
        [
            Target("--json", json_file, "sweep"),
            Target("--figure", figure, "figure", (".png", ".svg", ".pdf")),
        ],
        (*record, axis),
        force=force,
    )
    if figure is not None:
        import axisid.presentation.matplotlib  # noqa: F401 - refused before anything is computed

    inputs = axis_and_records(axis, record, reading, sharing, left_out=left_out)
    inputs.say_set_aside()
    cutoffs = stages.default_cutoffs(1 / inputs.records[0].period, lowest, highest, points)
    with progress_line(f"sweeping {inputs.axis.axis.name}") as line:
        result = stages.sweep(
            inputs.axis,
            inputs.records,
            cutoffs,
            filtering.prefilter(),
            progress=line,
            skip_bad=sharing.skip_bad,
            **inputs.shared,
        ).with_set_aside(inputs.set_aside)

    def draw(file: str) -> list[str]:
        try:
            with progress_line(f"drawing {file}"):
                stages.sweep_figure(result, Path(file))
        except (OSError, ValueError) as error:
            raise UsageError(f"{file} cannot be drawn: {error}.") from error
        return [file]

    put_result(result, json_file, (figure, draw))


@click.command(
    cls=Command,
    short_help="Find the control law of a record.",
    epilog="Examples: axisid law emps2015, or axisid law emps DATA_EMPS.mat --json law.json",
)
@click.argument("axis", shell_complete=complete_axis)
@click.argument("record", required=False, shell_complete=complete_file)
@takes("reading", Reading)
@json_option
@force_option
def law(
    axis: str,
    record: str | None,
    reading: Reading,
    json_file: str | None,
    force: bool,
) -> None:
    """Find the ready control law that explains a RECORD of AXIS, or of its twin.

    The gains and the delay of each ready law are estimated from half of the rows. The laws are
    compared by their residual on the other half. A control law that AXIS declares is ignored.
    """
    logs = () if record is None else (record,)
    check_targets([Target("--json", json_file, "law")], (*logs, axis), force=force)
    inputs = axis_and_records(axis, logs, reading, Sharing(local=(), known={}))
    with progress_line(f"finding the law of {inputs.axis.axis.name}") as line:
        result = stages.find_law(inputs.axis, inputs.records[0], progress=line)
    put_result(result, json_file)
