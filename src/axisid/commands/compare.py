"""``axisid compare`` and ``axisid compare-results``: models of one axis, or two results."""

from collections.abc import Iterator

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
    is_log,
    json_option,
    leave_out_option,
    progress_line,
    put_result,
    stages,
    takes,
)
from axisid.estimation.choices import comparison_methods
from axisid.support.checks import refuse
from axisid.support.errors import UsageError


class _ListedAxes(Command):
    """A command whose ``--axes`` takes all names up to the next option or record."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the arguments, after ``--axes`` is repeated before each of its names."""
        return super().parse_args(ctx, list(_repeated(args, "--axes")))


def _repeated(args: list[str], option: str) -> Iterator[str]:
    """Yield the arguments, with an option repeated before each of the names that follow it.

    The names end before the next option, or before a log.
    """
    listing = False
    for before, arg in zip(["", *args], args, strict=False):
        if before == option and arg.startswith("-"):
            raise click.BadOptionUsage(
                option, f"{option} needs an axis, but {arg} follows. Name an axis after {option}."
            )
        if arg.startswith("-"):
            listing = arg == option
        elif listing and before != option:
            listing = not is_log(arg)
            yield from [option] * listing
        yield arg


@click.command(
    cls=_ListedAxes,
    short_help="Compare several models of an axis.",
    epilog="Examples: axisid compare --ladder emps2015, or "
    "axisid compare log.csv --axes a.py b.py c.py",
)
@click.argument("record", nargs=-1, shell_complete=complete_file)
@click.option(
    "--axes",
    multiple=True,
    metavar="AXIS...",
    shell_complete=complete_axis,
    help="Candidates: two or more declarations, each a name in the library or a file.",
)
@click.option(
    "--ladder",
    metavar="AXIS",
    shell_complete=complete_axis,
    help="Candidates: this declaration with a series of friction laws, each with more terms than "
    "the law before.",
)
@click.option(
    "--quadratic",
    is_flag=True,
    help="Add to the ladder a candidate with the friction term Fq dq |dq|.",
)
@click.option(
    "--stribeck",
    type=float,
    metavar="V",
    help="Add to the ladder a candidate with the friction term Fs exp(-(dq/V)^2) sign(dq). V is in "
    "m/s or rad/s.",
)
@click.option(
    "--method",
    type=click.Choice(comparison_methods()),
    default=comparison_methods()[0],
    show_default=True,
    help="Estimator of all candidates.",
)
@takes("filtering", Filtering)
@takes("reading", Reading)
@takes("sharing", Sharing)
@leave_out_option(has_fix=False)
@json_option
@force_option
def compare(
    record: tuple[str, ...],
    axes: tuple[str, ...],
    ladder: str | None,
    quadratic: bool,
    stribeck: float | None,
    method: str,
    filtering: Filtering,
    reading: Reading,
    sharing: Sharing,
    left_out: tuple[str, ...],
    json_file: str | None,
    force: bool,
) -> None:
    """Fit several models of one machine to one or several RECORDs, and recommend a model.

    Without a RECORD, a simulated record of the first candidate (its twin) is used.

    The candidates are the declarations given by --axes, or one declaration with the friction laws
    of --ladder: viscous; viscous and Coulomb; viscous and Coulomb with an offset; and directional,
    with different viscous and Coulomb friction in the two directions. All candidates are fitted to
    the same rows and compared by their prediction error on held-out rows. --leave-out removes a
    parameter from every candidate that has this parameter.
    """
    filtering.prefilter()  # refused before anything is read
    named = [*([] if ladder is None else [ladder]), *axes]
    check_targets([Target("--json", json_file, "compare")], (*record, *named), force=force)
    if not named:
        raise click.UsageError(
            "no candidates are named. Add --axes AXIS AXIS..., or --ladder AXIS."
        )
    if ladder is None and (quadratic or stribeck is not None):
        raise click.UsageError(
            "--quadratic and --stribeck add candidates to a ladder. Add --ladder AXIS, or omit "
            "both options."
        )
    inputs = axis_and_records(named[0], record, reading, sharing)
    inputs.say_set_aside()

    candidates: dict[str, stages.Axis] = {}
    if ladder is not None:
        candidates |= stages.friction_ladder(
            _without(inputs.axis.declared, left_out), quadratic=quadratic, stribeck=stribeck
        )
    for name in axes:
        axis = _without(stages.load_axis(name), left_out)
        label = name if axis.name in candidates else axis.name
        if label in candidates:
            raise UsageError(f"the axis {name} is given twice. Name each axis once.")
        candidates[label] = axis
    for name in left_out:
        refuse(
            UsageError,
            (
                not any(name in {p.name for p in axis.left_out} for axis in candidates.values()),
                "no candidate has this parameter. axisid show AXIS lists the parameters",
            ),
            *(
                (
                    # The ladder adds its friction terms after parameters were left out.
                    name in {p.name for p in axis.parameters},
                    f"the candidate {label!r} of the ladder contains {name}, a parameter of its "
                    "friction law. Leave out only parameters that all candidates have, or name the "
                    "candidates with --axes",
                )
                for label, axis in candidates.items()
            ),
            before=f"--leave-out {name}: ",
        )
    with progress_line("comparing") as line:
        built = {name: stages.build(axis) for name, axis in candidates.items()}
        result = stages.compare(
            built,
            inputs.records,
            filtering.prefilter(inputs.records[0].period),
            method,
            progress=line,
            skip_bad=sharing.skip_bad,
            **inputs.shared,
        ).with_set_aside(inputs.set_aside)
    put_result(result, json_file)


@click.command(
    "compare-results",
    cls=Command,
    short_help="Compare two results.",
    epilog="Example: axisid identify emps2015 --json a.json && "
    "axisid identify emps2015 --cutoff 40 --json b.json && axisid compare-results a.json b.json",
)
@click.argument("first", shell_complete=complete_file)
@click.argument("second", shell_complete=complete_file)
@json_option
@force_option
def compare_results(first: str, second: str, json_file: str | None, force: bool) -> None:
    """Compare the results FIRST and SECOND, two files that `axisid identify --json` wrote.

    The table shows the difference of each parameter in combined standard errors. Settings and
    checks that differ are listed.
    """
    check_targets([Target("--json", json_file, "compare-results")], (first, second), force=force)
    put_result(stages.compare_results(first, second), json_file)


def _without(axis: "stages.Axis", names: tuple[str, ...]) -> "stages.Axis":
    """Return the axis without the named parameters; names of other parameters are ignored."""
    return stages.leave_out(axis, *({p.name for p in axis.parameters} & {*names}))
