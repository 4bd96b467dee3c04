"""Options of what twins are: their true values and their noise."""

from collections.abc import Callable, Mapping
from typing import Any

import click

from axisid.commands.options import stages

#: The noise of the twins, by option: what it is called in Python, its unit, and its help.
NOISE = {
    "--position-noise": ("position", "Deviation of the measured position's noise, in the loop."),
    "--resolution": ("resolution", "Of the encoder, in the loop and in the record; 0 for none."),
    "--velocity-noise": ("velocity", "Of a velocity that is measured beside the loop."),
    "--acceleration-noise": ("acceleration", "Of an acceleration that is measured likewise."),
    "--control-noise": ("control", "Of what the record adds to the control, in the drive's unit."),
    "--disturbance": ("disturbance", "Of what acts beside the control and is not recorded."),
    "--correlation-time": ("correlation_time", "Of the last two, s; 0 for white noise."),
}


def noise_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of the noise; the command takes each as ``noise_`` and its name."""
    for name, (parameter, said) in reversed(NOISE.items()):
        default = "  [default: the experiment's]" * (parameter in ("position", "resolution"))
        own = f"noise_{parameter}"
        command = click.option(name, own, type=float, metavar="X", help=said + default)(command)
    return command


truth_option = click.option(
    "--truth",
    multiple=True,
    metavar="NAME=VALUE",
    help="A true value of the twins, SI, in place of the experiment's; again for each.",
)

anywhere_option = click.option(
    "--anywhere",
    "noise_anywhere",
    is_flag=True,
    help="Begin each motion elsewhere in a count of the encoder, as on a machine.",
)


def given_noise(axis: "stages.GeneratedAxis", noise: Mapping[str, float | None]) -> "stages.Chain":
    """The noise of an axis's twins, the experiment's where it is not given."""
    given: dict[str, Any] = {name.removeprefix("noise_"): each for name, each in noise.items()}
    return stages.declared_chain(stages.Chain.of_experiment(axis.axis), **given)


def truth_of(texts: tuple[str, ...]) -> dict[str, float]:
    """True values by name."""
    return dict(_pair(text, "--truth", "NAME=VALUE, SI, as in M=110", float) for text in texts)


def shares_of(texts: tuple[str, ...], option: str) -> dict[str, float]:
    """Shares of true values by name; that of all of them has the name ``""``."""
    form = "NAME=SHARE, as in Fc=5% or Fc=0.05"
    return dict(_pair(text if "=" in text else f"={text}", option, form, _share) for text in texts)


def _share(text: str) -> float:
    number, percent, _ = text.strip().partition("%")
    return float(number) / 100 if percent else float(number)


def _pair(text: str, option: str, form: str, read: Callable[[str], float]) -> tuple[str, float]:
    name, _, value = text.partition("=")
    try:
        return name.strip(), read(value)
    except ValueError as error:
        raise click.BadParameter(f"{text!r}: write {form}", param_hint=option) from error
