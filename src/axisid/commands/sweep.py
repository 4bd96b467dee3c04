"""``axisid sweep``: identify with many cut-offs of the filter."""

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
    progress_line,
    put_result,
    stages,
    takes,
)
from axisid.support.errors import UsageError


@click.command(
    cls=Command,
    short_help="Identify with many cut-offs of the filter.",
    epilog="Examples: axisid sweep emps2015 --points 3, or "
    "axisid sweep emps DATA_EMPS.mat --figure sweep.png",
)
@click.argument("axis", shell_complete=complete_axis)
@click.argument("record", nargs=-1, shell_complete=complete_file)
@click.option(
    "--from",
    "lowest",
    type=float,
    metavar="HZ",
    help="Lowest cut-off, Hz.  [default: 0.02 of the sampling rate]",
)
@click.option(
    "--to",
    "highest",
    type=float,
    metavar="HZ",
    help="Highest cut-off, Hz.  [default: 0.4 of the sampling rate]",
)
@click.option(
    "--points",
    type=int,
    default=12,
    show_default=True,
    metavar="N",
    help="Number of cut-offs. The ratio of consecutive cut-offs is constant.",
)
@takes("filtering", Filtering, without=("cutoff", "decimate"))
@takes("reading", Reading)
@takes("sharing", Sharing)
@leave_out_option(has_fix=False)
@json_option
@click.option("--figure", metavar="FILE", help="Draw the sweep into a .png, .svg or .pdf file.")
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
    """Identify AXIS from one or several RECORDs with many cut-offs of the filter.

    Without a RECORD, a simulated record of the axis (its twin) is used.

    With a rising cut-off, noise begins to bias the least-squares estimates (LS), while the
    estimates by instrumental variables (IV) stay constant. One cut-off is recommended. The
    decimation follows from the cut-off.
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
