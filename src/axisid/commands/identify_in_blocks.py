"""``axisid identify --stream``: a log that is read in blocks."""

import click

from axisid.commands.options.filter_options import FILTER_OPTIONS, Filtering
from axisid.commands.options.option_checks import check_allowed
from axisid.commands.options.outputs import put_result
from axisid.commands.options.record_options import RECORD_OPTIONS, Reading
from axisid.presentation.console import ProgressLine

_METHODS = ("idm-ls", "idm-iv")  # as of axisid.estimation.streaming, which takes long to import
_KNOWN = ("--stream", "--json", "--force", "--leave-out")


def identify_streamed(
    axis: str,
    record: str | None,
    methods: tuple[str, ...],
    filtering: Filtering,
    reading: Reading,
    json_file: str | None,
    left_out: tuple[str, ...] = (),
    *,
    no_native: bool = False,
) -> None:
    """Identify from a log that is read in blocks; some options ask for more than that can give."""
    own = "--stream identifies a RECORD by idm-ls, or by idm-iv, alone"
    if record is None:
        raise click.UsageError(f"{own}; name its file.")
    asked = _METHODS[:1] if methods == ("all",) else tuple(dict.fromkeys(methods))
    method_option = ("--method",) if len(asked) == 1 and asked[0] in _METHODS else ()
    loops = asked[0] == _METHODS[1]
    loop_option = ("--no-native",) if loops else ()
    check_allowed((*_KNOWN, *FILTER_OPTIONS, *RECORD_OPTIONS, *method_option, *loop_option), own)
    from axisid.codegen.artefacts import build
    from axisid.estimation.streaming import identify_stream
    from axisid.modeling.declaration import leave_out
    from axisid.modeling.text import load_axis

    with ProgressLine(f"reading {record} in blocks"):
        # Loops take five times as long in the virtual machine; rows alone have none.
        declared = leave_out(load_axis(axis), *left_out)
        generated = build(declared, native=loops and not no_native)
        blocks = reading.blocks(record, generated)
        result = identify_stream(
            generated,
            blocks,
            filtering.prefilter,
            method=asked[0],
            sample_period=reading.sample_period,
            provenance=blocks.provenance(),
        )
    put_result(result, json_file)
