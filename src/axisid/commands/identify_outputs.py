"""What ``axisid identify`` prints and writes once the estimates are there."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import click

from axisid.commands.options import print_result, put_json, stages
from axisid.presentation.console import ProgressLine, print_document
from axisid.support.errors import EstimationError, UsageError
from axisid.support.remedy import as_options


def put_identification(
    result: "stages.Identification",
    json_file: str | None,
    others: "Sequence[stages.Record]",
    draws: int,
    outputs: "stages.Outputs",
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

    for path in outputs.write(result, validations, say):
        click.echo(f"wrote {path}", err=json_file == "-")
    if refused is not None:
        raise refused
    if result.failed:
        raise EstimationError("; ".join(stages.missing_notes(result.failed, as_options)))
