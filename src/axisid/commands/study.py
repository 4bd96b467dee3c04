"""``axisid study``."""

from pathlib import Path

import click

from axisid.commands.options import (
    Command,
    Filtering,
    Target,
    bootstrap_option,
    check_folder,
    check_idle,
    check_needed,
    check_targets,
    complete_axis,
    force_option,
    json_option,
    leave_out_option,
    loss_option,
    one_or_all,
    put_result,
    reading,
    stages,
    takes,
    write_page,
)
from axisid.estimation.choices import fit_names, fitted_output, method_names
from axisid.presentation.console import ProgressLine

from .twin import (
    anywhere_option,
    given_noise,
    noise_options,
    truth_option,
)


@click.command(
    cls=Command,
    short_help="Identify many twins: bias, intervals, checks.",
    epilog="Examples: axisid study emps2015 --runs 20 --method idm-ls --method idm-iv, or "
    "axisid study emps2015 --truth Fc=30 --runs 20 --report study.html",
)
@click.argument("axis", shell_complete=complete_axis)
@click.option("--runs", type=click.IntRange(min=1), default=200, show_default=True, help="Twins.")
@click.option(
    "--method",
    "methods",
    type=click.Choice([*method_names(), "all", *fit_names()]),
    multiple=True,
    default=("idm-iv",),
    callback=reading(one_or_all),
    show_default="idm-iv",
    help="As in identify, or fit:OUTPUT as in fit; again for each.",
)
@click.option(
    "--twin",
    metavar="AXIS",
    shell_complete=complete_axis,
    help="The axis that is simulated, where the model is to be wrong.  [default: AXIS]",
)
@truth_option
@noise_options
@anywhere_option
@click.option(
    "--checks",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    metavar="N",
    help="Judge the first N runs too: how often each check fails. A verdict costs several times an "
    "estimate.",
)
@takes("filtering", Filtering)
@leave_out_option
@loss_option
@bootstrap_option
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Of all.")
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    metavar="N",
    help="Processes; the numbers are the same for any.",
)
@click.option("--output", metavar="FILE", help="Write the numbers of every run: .npz or .parquet.")
@json_option
@click.option("--report", metavar="FILE", help="Write a page of HTML: tables and figures.")
@click.option("--figures", metavar="DIR", help="Write the figures into a folder.")
@force_option
def study(
    axis: str,
    runs: int,
    methods: tuple[str, ...],
    twin: str | None,
    truth: dict[str, float],
    checks: int,
    filtering: Filtering,
    left_out: tuple[str, ...],
    loss: str,
    seed: int,
    bootstrap: int,
    jobs: int,
    output: str | None,
    json_file: str | None,
    report: str | None,
    figures: str | None,
    force: bool,
    **noise: float | None,
) -> None:
    """Identify many twins of AXIS, each with noise of its own, and tell how far to believe it.

    Bias and scatter of every estimate, how often its intervals hold the truth, and how often each
    check fails: on twins of the axis itself, or of another one (--twin).
    """
    regressions = tuple(method for method in methods if not fitted_output(method))
    for option in () if regressions else ("--loss", "--bootstrap", *Filtering.names().values()):
        check_idle(option, f"is of identify, which --method {' and '.join(methods)} does without")
    check_needed(("--correlation-time",), ("--control-noise", "--disturbance"))
    targets = [
        Target("--output", output, "study-runs"),
        Target("--json", json_file, "study"),
        Target("--report", report, "report"),
    ]
    check_targets(targets, (axis, twin), force=force)
    if output is not None:
        stages.check_output(Path(output))
    drawn = {f"{name}.pdf": "figure" for name in stages.PLOTS}
    check_folder(figures, "--figures", drawn, force=force)
    with ProgressLine(f"deriving {axis}"):
        whole = stages.load_axis(axis)
        identified = stages.build(stages.leave_out(whole, *left_out))
        # What is simulated has every term, as an axis has.
        simulated = identified
        if twin is not None or left_out:
            simulated = stages.build(whole if twin is None else stages.load_axis(twin))

    def keep(partial: stages.MonteCarlo) -> None:
        """Keep what is done of a study that ends early, and say so."""
        done = f"{len(partial)} of {partial.plan.runs} runs are done"
        if output is not None:
            stages.write_runs(partial, output)
        kept = (
            "; --output FILE would have kept them" if output is None else f" and kept in {output}"
        )
        click.echo(f"axisid: {done}{kept}", err=True)

    with ProgressLine("twins") as line:
        result = stages.monte_carlo(
            identified,
            runs,
            methods,
            prefilter=filtering.prefilter(),
            noise=given_noise(simulated, noise),
            twin=simulated,
            truth=truth,
            checks=checks,
            seed=seed,
            bootstrap=bootstrap,
            loss=loss,
            jobs=jobs,
            progress=line,
            keep=keep,
        )
    # Before what is printed, whose reader may have gone.
    written = _written(result, output, report, figures)
    put_result(result, json_file)
    for path in written:
        click.echo(f"wrote {path}", err=json_file == "-")


def _written(
    result: "stages.MonteCarlo", output: str | None, report: str | None, figures: str | None
) -> list[object]:
    """Write what is asked for and return the places."""
    written: list[object] = []
    if output is not None:
        stages.write_runs(result, output)
        written.append(output)
    if report is not None:
        write_page(report, stages.monte_carlo_page, result)
        written.append(report)
    if figures is not None:
        drawn = stages.monte_carlo_plots(result).values()
        plots = [plot for plot in drawn if isinstance(plot, stages.Plot)]
        written += stages.write_figures(plots, Path(figures), "pdf")
    return written
