"""``axisid show``: print the declaration of an axis and its models."""

import click

from axisid.commands.options import Command, complete_axis, print_document, progress_line, stages


@click.command(
    cls=Command,
    short_help="Print a declaration and the derived models.",
    epilog="Example: axisid show emps --format latex > emps.tex",
)
@click.argument("axis", shell_complete=complete_axis)
@click.option(
    "--format",
    "form",
    type=click.Choice(["text", "latex", "markdown"]),
    default="text",
    show_default=True,
    help="Output format: plain text, a LaTeX document, or Markdown with formulas.",
)
def show(axis: str, form: str) -> None:
    """Print the declaration of AXIS and the models derived from it.

    The output has the equation of motion, the inverse and the direct dynamic model with their
    regressors, the map between the parameters of both models, the identifiable parameters, the
    drive, the control law and the columns.
    """
    with progress_line(f"deriving {axis}"):
        model = stages.derive(stages.load_axis(axis))
        page = stages.axis_document(model) if form == "text" else stages.axis_page(model, form)
    if isinstance(page, str):
        click.echo(page, nl=False)
    else:
        print_document(page)
