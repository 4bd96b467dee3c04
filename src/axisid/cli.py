"""The command line. Stages are imported by the commands that need them, so that help is instant.

Exit codes: 0 done, 1 generated code is stale or an internal fault, 2 usage, 3 data, 4 model,
6 estimation.
"""

import io
import json
import os
import shlex
import sys
import warnings
from pathlib import Path
from textwrap import indent
from typing import TYPE_CHECKING, Any, Literal, NoReturn

import click

from axisid import __version__
from axisid.completion import complete_axis, complete_file, completion
from axisid.export_command import export
from axisid.progress import ProgressLine
from axisid.record_options import LOG_ENDINGS, Reading, record_options
from axisid.terminal import show_text

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from axisid.codegen import GeneratedAxis
    from axisid.estimation import Identification, Prefilter, Record
    from axisid.modeling import Axis
    from axisid.report import Outputs

_INTERRUPTED = 130
_FIGURES = (".png", ".svg", ".pdf")
_METHODS = ("idm-ls", "ddm-ls", "idm-iv", "ddm-iv")


@click.group(
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Example: axisid identify emps2015. Exit codes: 0 done, 1 stale code or internal fault, "
    "2 usage, 3 data, 4 model, 6 estimation.",
)
@click.version_option(__version__, prog_name="axisid", message="%(prog)s %(version)s")
def cli() -> None:
    """Identify one-degree-of-freedom electromechanical axes, from Newton to trustworthy numbers."""


cli.add_command(export)
cli.add_command(completion)


def main() -> NoReturn:
    """Run the command line: every failure is one sentence on stderr and an exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("default", RuntimeWarning)
            warnings.showwarning = _show_warning  # type: ignore[assignment]
            code = cli.main(prog_name="axisid", standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
    except click.ClickException as error:
        code = _refused(error)
    except (click.Abort, KeyboardInterrupt):
        code = _fail("interrupted", _INTERRUPTED)
    except BrokenPipeError:
        # Whoever read the output has left; nothing can be said to them.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 1
    except Exception as error:
        # Only an error that speaks to the user carries an exit code.
        known: int | None = getattr(error, "exit_code", None)
        if known is None and os.environ.get("AXISID_DEBUG"):
            raise
        if known is None:
            code = _fail(_fault(error), 1)
        else:
            headline = getattr(error, "headline", str(error))
            code = _fail(headline, known, getattr(error, "mistakes", ()))
    sys.exit(code)


def _show_warning(message: Warning | str, *_: Any) -> None:
    """One line on stderr in place of Python's two, which name a source line."""
    click.echo(f"axisid: {message}", err=True)


def _refused(error: click.ClickException) -> int:
    """What click says in one sentence; the help, which it gives for want of a command, whole."""
    if isinstance(error, click.exceptions.NoArgsIsHelpError):
        click.echo(error.format_message(), err=True)
        return error.exit_code
    return _fail(error.format_message(), error.exit_code)


def _fail(message: str, code: int, listed: "Iterable[str]" = ()) -> int:
    """One sentence on stderr; the mistakes of a declaration, one under the other."""
    click.echo(f"axisid: {' '.join(message.split())}", err=True)
    for mistake in listed:
        click.echo(indent(mistake, "  "), err=True)
    return code


def _fault(error: Exception) -> str:
    if isinstance(error, OSError):
        return f"{error.filename or 'standard output'} cannot be used: {error.strerror}."
    return (
        f"internal fault: {type(error).__name__}: {error}. Set AXISID_DEBUG=1 for the traceback "
        "and report it."
    )


@cli.command(
    short_help="Identify an axis from a record.",
    epilog="Example: axisid identify emps2015, or "
    "axisid identify emps DATA_EMPS.mat --cutoff 60 --json result.json --report report.html, or "
    "axisid identify pendulum.py log.csv --fix m=1.2+-0.01",
)
@click.argument("axis", shell_complete=complete_axis)
@click.argument("record", required=False, shell_complete=complete_file)
@click.option(
    "--method",
    type=click.Choice([*_METHODS, "all"]),
    default="all",
    show_default=True,
    help="Estimator; all runs what axis and record allow and says what it left out.",
)
@click.option("--cutoff", type=float, metavar="HZ", help="Butterworth low-pass.  [default: 60]")
@click.option("--order", type=int, metavar="N", help="Its order.  [default: 4]")
@click.option(
    "--decimate",
    type=int,
    metavar="N",
    help="Keep one row in N.  [default: 10, or more where the cut-off asks for it]",
)
@click.option(
    "--decimation",
    type=click.Choice(["matlab", "scipy"]),
    help="Rows aligned to the record's end or start.  [default: matlab]",
)
@click.option(
    "--drop",
    type=int,
    nargs=2,
    metavar="START END",
    help="Samples left out at both ends.  [default: the filter's transient]",
)
@click.option(
    "--hold",
    type=click.Choice(["raw", "zoh"]),
    help="zoh pairs motion with the mean of the forces held around a sample; raw with the one "
    "after it.  [default: zoh for a control that a drive holds, else raw]",
)
@click.option(
    "--reversals",
    type=click.Choice(["keep", "leave-out"]),
    help="Samples near a reversal or a rest, where the low-pass rounds what friction does at "
    "once.  [default: leave-out for axes with friction, unless it takes most of the record]",
)
@record_options
@click.option(
    "--fix",
    multiple=True,
    metavar="NAME=VALUE[+-SD]",
    help="A parameter that is known apart from the record, SI, with its standard deviation; again "
    "for each.",
)
@click.option("--no-native", is_flag=True, help="Simulate in the CasADi virtual machine, slower.")
@click.option(
    "--validate",
    "second",
    metavar="RECORD",
    shell_complete=complete_file,
    help="Hold the estimates, frozen, against a second record.",
)
@click.option(
    "--covariance",
    type=click.Choice(["hac", "robust", "iid"]),
    default="hac",
    show_default=True,
    help="What intervals, draws and tests assume of the residuals: hac autocorrelated, robust of "
    "any variance, iid alike and independent.",
)
@click.option(
    "--lags",
    type=click.IntRange(min=0),
    metavar="N",
    help="Rows over which the HAC deviations take residuals as alike.  [default: from the data]",
)
@click.option(
    "--draws",
    type=click.IntRange(2, 1_000_000),
    metavar="N",
    help="Add intervals from N draws of each estimate, which do without the delta method.",
)
@click.option(
    "--full", is_flag=True, help="Print intervals, correlations and every diagnostic's figures too."
)
@click.option(
    "--stream", is_flag=True, help="Read a log larger than memory in blocks; IDM-LS alone."
)
@click.option(
    "--json", "json_file", metavar="FILE", help="Write the result as JSON; - for standard output."
)
@click.option(
    "--report", metavar="FILE", help="Write a page of HTML to show: verdict, tables, figures."
)
@click.option("--figures", metavar="DIR", help="Write the figures into a folder.")
@click.option(
    "--figure-format",
    type=click.Choice(["pdf", "svg", "png"]),
    default="pdf",
    show_default=True,
    help="Of --figures.",
)
@click.option(
    "--figure-width",
    type=click.FloatRange(60, 400),
    default=160,
    show_default=True,
    metavar="MM",
    help="Of --figures; a column of a journal has 88.",
)
@click.option("--no-sweep", is_flag=True, help="Page and figures without a sweep of the cut-off.")
def identify(
    axis: str,
    record: str | None,
    method: str,
    second: str | None,
    reading: Reading,
    covariance: Literal["hac", "robust", "iid"],
    lags: int | None,
    draws: int | None,
    full: bool,
    stream: bool,
    json_file: str | None,
    fix: tuple[str, ...],
    no_native: bool,
    report: str | None,
    figures: str | None,
    figure_format: str,
    figure_width: float,
    no_sweep: bool,
    **settings: Any,
) -> None:
    """Identify AXIS from RECORD, or from its built-in twin if no record is given.

    AXIS is a name of the library (emps2015, emps, pendulum, vertical_screw, belt_axis,
    rotary_table, valve, crank, linear_motor) or a TOML or Python file that declares one.
    RECORD is a log: delimited text of any dialect, MATLAB, Parquet, NumPy .npz, MDF4, TDMS or a
    ROS bag. Values are SI unless the file or --columns says otherwise.
    """
    _prefilter(settings)  # refused before anything is read
    _check_json(json_file, record, axis, second)
    check_output(report, "--report", record, axis, second, json_file)
    _check_folder(figures)
    if stream:
        beyond = {
            "--method": method not in ("all", "idm-ls"),
            "--validate": second,
            "--draws": draws,
            "--lags": lags is not None,
            "--covariance": covariance != "hac",
            "--full": full,
            "--fix": fix,
            "--report": report,
            "--figures": figures,
        }
        _streamed(axis, record, reading, settings, json_file, [o for o, x in beyond.items() if x])
        return

    with ProgressLine(f"reading {record or f'the twin of {axis}'}"):
        generated, data = _axis_and_record(
            axis, record, reading, second, fixed=fix, no_native=no_native
        )

    from axisid.estimation import identify as run
    from axisid.estimation.signals import measured_signals

    prefilter = _prefilter(settings, data.period)
    other = None
    if second is not None:
        other = reading.record(second, generated)
        measured_signals(generated, other, prefilter)  # refused before the long part
    with ProgressLine(f"identifying {generated.axis.name}"):
        result = run(
            generated,
            data,
            prefilter,
            None if method == "all" else [method],
            lags=lags,
            covariance=covariance,
        )
    from axisid.report import Outputs

    outputs = Outputs(
        report=report,
        figures=figures,
        form=figure_format,
        width=figure_width,
        swept=not no_sweep,
        draws=draws or 0,
        command=shlex.join(["axisid", *sys.argv[1:]]),
    )
    _report(result, json_file, other, draws or 0, outputs, full=full)


@cli.command(
    short_help="Rewrite the generated code of axes.", epilog="Example: axisid generate --check"
)
@click.argument("axes", nargs=-1, shell_complete=complete_axis)
@click.option("--check", is_flag=True, help="Write nothing; exit 1 if anything is stale.")
@click.option("-v", "--verbose", is_flag=True, help="Say how long each stage takes.")
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    default="generated",
    show_default=True,
    help="Folder of the generated code.",
)
def generate(axes: tuple[str, ...], check: bool, verbose: bool, output: Path) -> None:
    """Rewrite the generated code of AXES, by default of the whole library.

    Each axis gets a folder with its CasADi functions, its equations and a manifest. AXES are names
    of the library or TOML or Python files that declare an axis.
    """
    from axisid.codegen import check_files, expected_files, stage_times, write_files
    from axisid.modeling import UsageError

    declared = _declared(axes)
    if verbose:
        for axis in declared:
            with ProgressLine(f"timing {axis.name}"):
                times = stage_times(axis)
            stages = ", ".join(f"{stage} {1e3 * s:.0f} ms" for stage, s in times)
            click.echo(f"{axis.name}: {stages}")
    with ProgressLine("generating") as line:
        files = expected_files(declared, line)
    _check_targets({(output / path).resolve() for path in files}, axes)
    if not check:
        written = write_files(output, files)
        for path in written:
            click.echo(f"wrote {output / path}")
        click.echo(f"{len(written)} files written, {len(files) - len(written)} were current.")
        return
    findings = check_files(output, files, orphans=not axes)
    for finding in findings:
        click.echo(f"{finding.state}: {output / finding.path}")
        if finding.state == "stale":
            click.echo(finding.diff)
    if not axes and findings and all(f.state == "missing" for f in findings):
        raise UsageError(
            f"nothing of the library is generated in {output}; name the axes that are meant, as in "
            "axisid generate --check my_axis.toml."
        )
    if findings:
        orphan = any(finding.state == "orphan" for finding in findings)
        command = " ".join(["axisid generate", *axes, *_output_option(output)])
        remove = "; remove the orphans, or name the axes that are meant" if orphan else ""
        click.echo(
            f"not as generated: {len(findings)} of {len(files)}; run: {command}{remove}", err=True
        )
        sys.exit(1)
    click.echo(f"{len(files)} files are current.")


@cli.command(
    short_help="Start a declaration in this folder.",
    epilog="Example: axisid new my_axis && axisid identify my_axis.toml",
)
@click.argument("name")
@click.option("--newton/--lagrange", default=True, help="By forces or by energies.  [newton]")
@click.option("--toml/--python", default=True, help="As data, or as a program.  [toml]")
def new(name: str, newton: bool, toml: bool) -> None:
    """Start a declaration, NAME.toml or NAME.py in this folder, with comments.

    It is complete: a linear stage (a pendulum with --lagrange) with its control law, and an
    experiment whose twin can be identified at once.
    """
    from axisid.scaffold import write_scaffold

    file = write_scaffold(name, newton=newton, toml=toml)
    click.echo(f"wrote {file}; edit it, then (the last line is of its twin; add your log to it):")
    click.echo(f"  axisid show {file}")
    click.echo(f"  axisid identify {file}")


@cli.command(epilog="Example: axisid show emps --format latex > emps.tex")
@click.argument("axis", shell_complete=complete_axis)
@click.option(
    "--format",
    "form",
    type=click.Choice(["text", "latex", "markdown"]),
    default="text",
    show_default=True,
    help="A page for the terminal, a LaTeX document, or Markdown with formulas.",
)
def show(axis: str, form: str) -> None:
    """Print what AXIS declares and what follows from it.

    The equation of motion, the inverse and the direct model with their regressors, the map between
    their parameters, what is identifiable, and the drive, control law and columns.
    """
    from axisid.modeling import derive, load_axis
    from axisid.show import shown

    with ProgressLine(f"deriving {axis}"):
        text = shown(derive(load_axis(axis)), form)
    if form == "text":
        show_text(text)
    else:
        click.echo(text, nl=False)


@cli.command(
    short_help="Identify at many cut-offs; recommend one.",
    epilog="Examples: axisid sweep emps2015 --points 3, or "
    "axisid sweep emps DATA_EMPS.mat --figure sweep.png",
)
@click.argument("axis", shell_complete=complete_axis)
@click.argument("record", required=False, shell_complete=complete_file)
@click.option("--from", "lowest", type=float, metavar="HZ", help="Lowest cut-off.")
@click.option("--to", "highest", type=float, metavar="HZ", help="Highest cut-off.")
@click.option("--points", type=int, default=12, show_default=True, help="How many cut-offs.")
@click.option("--order", type=int, metavar="N", help="Of the Butterworth filter.  [default: 4]")
@click.option("--hold", type=click.Choice(["raw", "zoh"]), help="As in identify.")
@click.option("--reversals", type=click.Choice(["keep", "leave-out"]), help="As in identify.")
@record_options
@click.option("--no-native", is_flag=True, help="As in identify.")
@click.option(
    "--json", "json_file", metavar="FILE", help="Write the results as JSON; - for stdout."
)
@click.option("--figure", metavar="FILE", help="Draw the sweep: .png, .svg or .pdf.")
def sweep(
    axis: str,
    record: str | None,
    lowest: float | None,
    highest: float | None,
    points: int,
    reading: Reading,
    no_native: bool,
    json_file: str | None,
    figure: str | None,
    **settings: Any,
) -> None:
    """Identify AXIS from RECORD (or its twin) at many cut-offs, and recommend one.

    Least squares drifts where noise begins to bias it; instruments stay. The decimation follows the
    cut-off.
    """
    _check_json(json_file, record, axis)
    check_output(figure, "--figure", record, axis, json_file)
    if figure is not None and Path(figure).suffix not in _FIGURES:
        raise click.BadParameter(
            f"{figure!r}: the name must end in {', '.join(_FIGURES)}", param_hint="--figure"
        )
    with ProgressLine(f"reading {record or f'the twin of {axis}'}"):
        generated, data = _axis_and_record(axis, record, reading, no_native=no_native)

    from axisid.estimation import default_cutoffs
    from axisid.estimation import sweep as run

    cutoffs = default_cutoffs(1 / data.period, lowest, highest, points)
    with ProgressLine(f"sweeping {generated.axis.name}") as line:
        result = run(generated, data, cutoffs, _prefilter(settings), progress=line)
    if json_file != "-":
        show_text(result.summary())
    if json_file is not None:
        _put_json(json_file, result.to_dict())
    if figure is not None:
        from axisid.figures import sweep_figure

        _drawn(lambda: sweep_figure(result, Path(figure)), figure)
        click.echo(f"wrote {figure}", err=json_file == "-")


class _ListedAxes(click.Command):
    """A command whose ``--axes`` takes every name up to the next option or record."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Repeat ``--axes`` before each of the names that follow it."""
        return super().parse_args(ctx, list(_repeated(args, "--axes")))


def _repeated(args: list[str], option: str) -> "Iterator[str]":
    listing = False
    for before, arg in zip(["", *args], args, strict=False):
        if before == option and arg.startswith("-"):
            raise click.BadOptionUsage(option, f"{option} names no axis before {arg}.")
        further = listing and before != option
        if arg.startswith("-"):
            listing = arg == option
        elif further and Path(arg).suffix.lower() in LOG_ENDINGS:
            listing = False
        elif further:
            yield option
        yield arg


@cli.command(
    cls=_ListedAxes,
    short_help="Fit several models; recommend one.",
    epilog="Examples: axisid compare --ladder emps2015, or "
    "axisid compare log.csv --axes a.py b.py c.py",
)
@click.argument("record", required=False, shell_complete=complete_file)
@click.option(
    "--axes",
    multiple=True,
    metavar="AXIS...",
    shell_complete=complete_axis,
    help="The candidates, two or more.",
)
@click.option(
    "--ladder",
    metavar="AXIS",
    shell_complete=complete_axis,
    help="One axis under each friction law as candidates.",
)
@click.option("--quadratic", is_flag=True, help="One more rung of the ladder: Fq dq |dq|.")
@click.option(
    "--stribeck",
    type=float,
    metavar="V",
    help="One more rung: Fs exp(-(dq/V)^2) sign(dq), V in m/s or rad/s.",
)
@click.option(
    "--method",
    type=click.Choice(["idm-ls", "idm-iv"]),
    default="idm-ls",
    show_default=True,
    help="Estimator.",
)
@click.option("--cutoff", type=float, metavar="HZ", help="As in identify.")
@click.option("--order", type=int, metavar="N", help="As in identify.")
@click.option("--decimate", type=int, metavar="N", help="As in identify.")
@click.option("--decimation", type=click.Choice(["matlab", "scipy"]), help="As in identify.")
@click.option("--drop", type=int, nargs=2, metavar="START END", help="As in identify.")
@click.option("--hold", type=click.Choice(["raw", "zoh"]), help="As in identify.")
@click.option("--reversals", type=click.Choice(["keep", "leave-out"]), help="As in identify.")
@record_options
@click.option("--no-native", is_flag=True, help="As in identify.")
@click.option(
    "--json", "json_file", metavar="FILE", help="Write the results as JSON; - for stdout."
)
def compare(
    record: str | None,
    axes: tuple[str, ...],
    ladder: str | None,
    quadratic: bool,
    stribeck: float | None,
    method: str,
    reading: Reading,
    no_native: bool,
    json_file: str | None,
    **settings: Any,
) -> None:
    """Fit several models of one axis to RECORD, and recommend one.

    The candidates are the --axes, or one axis under a --ladder of friction laws: viscous; with
    Coulomb; with an offset; and directional, both differing by direction. All are fitted to the
    same rows and judged by the error on rows that are held out. Without RECORD it is the twin of
    the first axis.
    """
    _prefilter(settings)  # refused before anything is read
    named = [*([] if ladder is None else [ladder]), *axes]
    _check_json(json_file, record, *named)
    if not named:
        raise click.UsageError("name the candidates: --axes AXIS AXIS..., or --ladder AXIS.")
    if ladder is None and (quadratic or stribeck is not None):
        raise click.UsageError("--quadratic and --stribeck are rungs of a ladder; add --ladder.")
    with ProgressLine(f"reading {record or f'the twin of {named[0]}'}"):
        first, data = _axis_and_record(named[0], record, reading, no_native=no_native)

    from axisid.codegen import build
    from axisid.estimation import compare as run
    from axisid.modeling import friction_ladder

    candidates: dict[str, Axis] = {}
    if ladder is not None:
        candidates |= friction_ladder(first.declared, quadratic=quadratic, stribeck=stribeck)
    _add_named(candidates, axes)
    with ProgressLine("comparing") as line:
        built = {name: build(axis, native=not no_native) for name, axis in candidates.items()}
        filtered = _prefilter(settings, data.period)
        result = run(built, data, filtered, method, progress=line)
    if json_file is not None:
        _put_json(json_file, result.to_dict())
    if json_file != "-":
        show_text(result.summary())


@cli.command(
    "compare-results",
    short_help="Set two results side by side.",
    epilog="Example: axisid identify emps2015 --json a.json && "
    "axisid identify emps2015 --cutoff 40 --json b.json && axisid compare-results a.json b.json",
)
@click.argument("first", shell_complete=complete_file)
@click.argument("second", shell_complete=complete_file)
@click.option(
    "--json", "json_file", metavar="FILE", help="Write the comparison as JSON; - for stdout."
)
def compare_results(first: str, second: str, json_file: str | None) -> None:
    """Set the results FIRST and SECOND side by side, as identify --json wrote them.

    Parameters with their difference in combined deviations, and the settings and checks that
    differ.
    """
    _check_json(json_file, first, second)

    from axisid.two_results import compare_results as run

    result = run(first, second)
    if json_file is not None:
        _put_json(json_file, result.to_dict())
    if json_file != "-":
        show_text(result.summary())


def _add_named(candidates: "dict[str, Axis]", names: tuple[str, ...]) -> None:
    """Add axes by their own names, or as they were given where two have the same."""
    from axisid.modeling import UsageError, load_axis

    for name in names:
        axis = load_axis(name)
        label = name if axis.name in candidates else axis.name
        if label in candidates:
            raise UsageError(f"the axis {name} is given twice; give each one once.")
        candidates[label] = axis


def _drawn(draw: "Callable[[], None]", figure: str) -> None:
    """Draw a figure; a place or format that does not serve is the user's to mend."""
    from axisid.modeling import UsageError

    try:
        with ProgressLine(f"drawing {figure}"):
            draw()
    except (OSError, ValueError) as error:
        raise UsageError(f"{figure} cannot be drawn: {error}.") from error


def _declared(axes: tuple[str, ...]) -> "list[Axis]":
    """The axes to generate; the library's folders belong to the library's axes."""
    from axisid.modeling import LIBRARY, UsageError, load_axis

    declared = [load_axis(name) for name in axes or LIBRARY]
    for name, axis in zip(axes, declared, strict=False):
        if axis.name in LIBRARY and name not in LIBRARY:
            raise UsageError(
                f"{name} declares an axis named {axis.name!r}, whose folder belongs to the "
                "library; rename the axis."
            )
    return declared


def _check_targets(targets: set[Path], axes: tuple[str, ...]) -> None:
    """Refuse to write over a declaration."""
    from axisid.modeling import UsageError

    if taken := targets & {_file_of(name).resolve() for name in axes}:
        raise UsageError(f"{taken.pop()} declares an axis and would be overwritten; rename it.")


@cli.command(
    short_help="Reproduce the paper's tables on a twin.",
    epilog="Example: axisid paper --output results",
)
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    help="Also write the tables, the figures and the results as JSON into this folder.",
)
def paper(output: Path | None) -> None:
    """Identify the twin of the paper's axis by all four methods under both filters.

    Prints the tables of Brunot et al. (SYSID 2015) beside the twin's, and draws figures 3 and 4.
    """
    from axisid.paper import run_study, study_tables, write_study

    with ProgressLine("the paper's study") as line:
        study = run_study(line)
    show_text(f"{study_tables(study)}\n")
    if output is not None:
        with ProgressLine("drawing figures"):
            written = write_study(study, output)
        for path in written:
            click.echo(f"wrote {path}")


def _axis_and_record(
    axis: str,
    record: str | None,
    reading: Reading,
    second: str | None = None,
    *,
    fixed: tuple[str, ...] = (),
    no_native: bool,
) -> "tuple[GeneratedAxis, Record]":
    """The axis that was named, and its record or its twin's."""
    from axisid.codegen import build
    from axisid.estimation import twin_record
    from axisid.modeling import UsageError, fix, load_axis, read_fixed

    if Path(axis).suffix.lower() in LOG_ENDINGS:
        raise UsageError(f"{axis} is a log by its ending; the axis comes first: AXIS RECORD.")
    generated = build(fix(load_axis(axis), **read_fixed(fixed)), native=not no_native)
    if record is not None:
        return generated, reading.record(record, generated)
    if reading.given and second is None:
        raise UsageError(f"{' and '.join(reading.given)} describe a record; name its file.")
    return generated, twin_record(generated)


def _streamed(
    axis: str,
    record: str | None,
    reading: Reading,
    settings: dict[str, Any],
    json_file: str | None,
    beyond: list[str],
) -> None:
    """Identify from a log that is read in blocks; some options ask for more than that can give."""
    if record is None or beyond:
        raise click.UsageError(
            "--stream identifies a RECORD by idm-ls alone; "
            + (f"leave out {' and '.join(beyond)}." if beyond else "name its file.")
        )
    from axisid.codegen import build
    from axisid.estimation import identify_stream
    from axisid.modeling import load_axis

    with ProgressLine(f"reading {record} in blocks"):
        generated = build(load_axis(axis), native=False)
        blocks = reading.blocks(record, generated)
        result = identify_stream(
            generated,
            blocks,
            lambda period: _prefilter(settings, period),
            sample_period=reading.sample_period,
            provenance=blocks.provenance(),
        )
    if json_file is not None:
        _put_json(json_file, result.to_dict())
    if json_file != "-":
        show_text(result.summary())


def _prefilter(settings: dict[str, Any], period: float | None = None) -> "Prefilter":
    """The filter that the options ask for; what is left open suits the sampling period."""
    from axisid.estimation import Prefilter

    given = {name: value for name, value in settings.items() if value is not None}
    return Prefilter(**given) if period is None else Prefilter.suited(period, **given)


def _check_json(json_file: str | None, *inputs: str | None) -> None:
    """As `check_output`, for ``--json``."""
    check_output(json_file, "--json", *inputs)


def check_output(json_file: str | None, option: str, *inputs: str | None) -> None:
    """Refuse a place that cannot be written to before anything is computed."""
    if json_file is None:
        return
    path = Path(json_file)
    if json_file == "-" and option == "--json":
        problem = "standard output is closed" if sys.stdout is None else ""
    elif json_file in ("", "-") or os.path.isdir(json_file):
        problem = "it is no file; name one"
    elif not os.path.isdir(path.parent):
        problem = "the folder does not exist; make it first"
    elif path.is_symlink() and not _leads_somewhere(path):
        problem = "the link leads to itself; name another file"
    elif path.resolve() in {_file_of(given).resolve() for given in inputs if given}:
        problem = "it is an input of this run; name another file"
    else:
        problem = ""
    if problem:
        raise click.BadParameter(f"{json_file!r}: {problem}", param_hint=option)


def _leads_somewhere(link: Path) -> bool:
    try:
        link.resolve()
        link.stat()
    except FileNotFoundError:
        return True  # a file that can be made
    except (OSError, RuntimeError):
        return False
    return True


def _check_folder(folder: str | None) -> None:
    """Refuse a folder that can neither be used nor made."""
    if folder is None or os.path.isdir(folder):
        return
    if not folder or os.path.exists(folder) or not os.path.isdir(Path(folder).parent):
        raise click.BadParameter(
            f"{folder!r}: it is no folder, nor a new one in a folder; name one",
            param_hint="--figures",
        )


def _file_of(argument: str) -> Path:
    """The file that an argument names, without the variable of an axis file."""
    head, found, _ = argument.partition(".py:")
    return Path(f"{head}.py" if found else argument)


def _report(
    result: "Identification",
    json_file: str | None,
    other: "Record | None",
    draws: int,
    outputs: "Outputs",
    *,
    full: bool,
) -> None:
    """Write the result, then print it, and fail if a method came to nothing."""
    from axisid.estimation import EstimationError, validate
    from axisid.estimation.summary import left_out_notes
    from axisid.modeling import UsageError

    with ProgressLine("judging the estimates"):
        validation = None if other is None else validate(result, other)
        written = None if json_file is None else result.to_dict(draws)
        text = "" if json_file == "-" else result.summary(draws, full=full)
    refused: UsageError | None = None
    if json_file is not None and written is not None:
        added = {} if validation is None else {"validation": validation.to_dict()}
        try:
            _put_json(json_file, {**written, **added})
        except UsageError as error:
            refused = error  # told after the result, which it must not cost
    if json_file == "-":
        for method, reason in result.skipped.items():
            click.echo(f"axisid: without {method}: {reason}", err=True)
    else:
        show_text(text)
        if validation is not None:
            show_text(f"\n{validation.summary()}")

    def say(line: str) -> None:
        click.echo(f"axisid: {line}", err=True)

    for path in outputs.write(result, validation, say):
        click.echo(f"wrote {path}", err=json_file == "-")
    if refused is not None:
        raise refused
    if result.failed:
        raise EstimationError("; ".join(left_out_notes(result.failed)))


def _put_json(file: str, result: dict[str, Any]) -> None:
    """Write a result as JSON into a file, or to standard output for ``-``."""
    write_output(file, json.dumps(result, indent=2, allow_nan=False) + "\n")


def write_output(file: str | None, text: str) -> None:
    """Write a text into a file, or to standard output for ``-`` or None."""
    if file is None or file == "-":
        click.echo(text, nl=False)
    else:
        _write(Path(file), text)


def _write(path: Path, text: str) -> None:
    from axisid.codegen import replace_file
    from axisid.modeling import UsageError

    try:
        replace_file(path, text)
    except OSError as error:
        raise UsageError(f"{path} cannot be written: {error.strerror}.") from error


def _output_option(output: Path) -> list[str]:
    return [] if output == Path("generated") else [f"--output {output}"]
