"""``axisid identify --stream``: a log that is read in blocks."""

import click

from axisid.command_outputs import put_result
from axisid.filter_options import Filtering
from axisid.progress import ProgressLine
from axisid.record_options import Reading


def identify_streamed(
    axis: str,
    record: str | None,
    filtering: Filtering,
    reading: Reading,
    json_file: str | None,
    beyond: list[str],
    left_out: tuple[str, ...] = (),
) -> None:
    """Identify from a log that is read in blocks; some options ask for more than that can give."""
    if record is None or beyond:
        raise click.UsageError(
            "--stream identifies a RECORD by idm-ls alone; "
            + (f"leave out {' and '.join(beyond)}." if beyond else "name its file.")
        )
    from axisid.codegen import build
    from axisid.estimation import identify_stream
    from axisid.modeling import leave_out, load_axis

    with ProgressLine(f"reading {record} in blocks"):
        generated = build(leave_out(load_axis(axis), *left_out), native=False)
        blocks = reading.blocks(record, generated)
        result = identify_stream(
            generated,
            blocks,
            filtering.prefilter,
            sample_period=reading.sample_period,
            provenance=blocks.provenance(),
        )
    put_result(result, json_file)
