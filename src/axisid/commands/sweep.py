"""``axisid sweep``."""

from pathlib import Path

import click

from axisid.commands.options import (
    Command,
    Filtering,
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
    put_result,
    stages,
    takes,
)
from axisid.presentation.console import ProgressLine
from axisid.support.errors import UsageError


@click.command(
    cls=Command,
    short_help="Identify at many cut-offs; recommend one.",
    epilog="Examples: axisid sweep emps2015 --points 3, or "
    "axisid sweep emps DATA_EMPS.mat --figure sweep.png",
)
@click.argument("axis", shell_complete=complete_axis)
@click.argument("record", nargs=-1, shell_complete=complete_file)
@click.option("--from", "lowest", type=float, metavar="HZ", help="Lowest cut-off.")
@click.option("--to", "highest", type=float, metavar="HZ", help="Highest cut-off.")
@click.option("--points", type=int, default=12, show_default=True, help="How many cut-offs.")
@takes("filtering", Filtering, without=("cutoff", "decimate"))
@takes("reading", Reading)
@takes("sharing", Sharing)
@leave_out_option
@json_option("Write the results as JSON; - for stdout.")
@click.option("--figure", metavar="FILE", help="Draw the sweep: .png, .svg or .pdf.")
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
    """Identify AXIS from one RECORD or several (or its twin) at many cut-offs, and recommend one.

    Least squares drifts where noise begins to bias it; instruments stay. The decimation follows the
    cut-off.
    """
    targets = [
        Target("--json", json_file, "sweep"),
        Target("--figure", figure, "figure", (".png", ".svg", ".pdf")),
    ]
    check_targets(targets, (*record, axis), force=force)
    if figure is not None:
        import axisid.presentation.drawing  # noqa: F401 - refused before anything is computed

    inputs = axis_and_records(
        axis,
        record,
        reading,
        left_out=left_out,
        skip_bad=sharing.skip_bad,
    )
    shared = sharing.of(inputs, len(record))
    inputs.say_set_aside()

    generated, data = inputs.axis, inputs.records
    cutoffs = stages.default_cutoffs(1 / data[0].period, lowest, highest, points)
    with ProgressLine(f"sweeping {generated.axis.name}") as line:
        result = stages.sweep(
            generated,
            data,
            cutoffs,
            filtering.prefilter(),
            progress=line,
            skip_bad=sharing.skip_bad,
            **shared,
        ).with_set_aside(inputs.set_aside)
    put_result(result, json_file)
    if figure is not None:
        try:
            with ProgressLine(f"drawing {figure}"):
                stages.sweep_figure(result, Path(figure))
        except (OSError, ValueError) as error:
            raise UsageError(f"{figure} cannot be drawn: {error}.") from error
        click.echo(f"wrote {figure}", err=json_file == "-")
