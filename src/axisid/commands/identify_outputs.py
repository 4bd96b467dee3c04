"""What ``axisid identify`` prints and writes once the estimates are there."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from axisid.commands.options.outputs import print_result, put_json
from axisid.presentation.console import ProgressLine, print_document

if TYPE_CHECKING:
    from axisid.estimation.identification import Identification
    from axisid.estimation.records import Record
    from axisid.presentation.report import Outputs


def put_identification(
    result: "Identification",
    json_file: str | None,
    others: "Sequence[Record]",
    draws: int,
    outputs: "Outputs",
    *,
    every: bool,
    full: bool,
    like: int | None = None,
) -> None:
    """Write the result, then print it, and fail if a method came to nothing."""
    from axisid.estimation.checks import joined
    from axisid.estimation.studies import validate
    from axisid.presentation.text import missing_notes
    from axisid.presentation.views import as_blocks
    from axisid.support.errors import EstimationError, UsageError
    from axisid.support.remedy import as_options

    with ProgressLine("judging the estimates"):
        validations = [validate(result, other, like=like) for other in others]
        names = [each.record.provenance.source for each in validations]
        check = joined([each.check for each in validations], names)
        result = replace(result, further=() if check is None else (check,))
        written = None if json_file is None else result.to_dict(draws)
        document = (
            ()
            if json_file == "-"
            else as_blocks(result, draws=draws, every=every, full=full, wording=as_options)
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

    for path in outputs.write(result, validations, say):
        click.echo(f"wrote {path}", err=json_file == "-")
    if refused is not None:
        raise refused
    if result.failed:
        raise EstimationError("; ".join(missing_notes(result.failed, as_options)))
