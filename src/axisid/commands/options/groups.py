"""Groups of options: frozen dataclasses whose fields are options of the command line.

A field states the option's name, help, default, type and reader in one place. A command receives a
group as one object. Options without effect are refused, because the user expected an effect. Shells
complete commands, axes and files.
"""

import functools
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource
from click.shell_completion import CompletionItem

from axisid.estimation.choices import LOG_KEYS
from axisid.support.settings import settings_typed


def option(
    text: str = "",
    default: Any = None,
    *,
    key: str = "",
    name: str = "",
    read: Callable[[Any], Any] | None = None,
    **how: Any,
) -> Any:
    """Return a dataclass field that is an option of the command line.

    Parameters
    ----------
    text : str
        Help of the option.
    default : optional
        Default value, shown in the help if given; True or False make a flag.
    key : str
        Key of a run.toml, from which name and form of the value are taken, and the help if `text`
        is empty.
    name : str
        Name without dashes, if it differs from the name of the field.
    read : callable, optional
        Returns the value of the field for the value of the option.
    **how
        Further arguments of `click.option`, such as its type.
    """
    if key:
        row = LOG_KEYS[key]
        text, name, how = text or row.said, row.option, {"metavar": row.metavar, **how}
    if read is not None:
        how["callback"] = reading(read)
    shown = (
        {"is_flag": True} if isinstance(default, bool) else {"show_default": default is not None}
    )
    return field(
        default=default,
        metadata={"name": name, "option": {"help": text, "default": default, **shown, **how}},
    )


def reading(read: Callable[[Any], Any]) -> Callable[[click.Context, click.Parameter, Any], Any]:
    """Return the callback of an option: it reads the text, except while a shell completes."""

    def callback(ctx: click.Context, _: click.Parameter, value: Any) -> Any:
        return value if ctx.resilient_parsing else read(value)

    return callback


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """Base of a group of options: a dataclass whose fields are made by `option`."""

    @classmethod
    def names(cls) -> dict[str, str]:
        """Return the spelling of each option, such as ``--skip-bad``, by the name of its field."""
        return {f.name: f"--{f.metadata['name'] or f.name.replace('_', '-')}" for f in fields(cls)}

    def arguments(self) -> dict[str, Any]:
        """Return the values of the options by the name of their field, as arguments."""
        return {name: getattr(self, name) for name in self.names()}


def takes(
    parameter: str, group: type[Options], without: Collection[str] = ()
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Return a decorator that adds the options of a group; the command takes them as one object.

    Parameters
    ----------
    parameter : str
        Parameter of the command that takes the object.
    group : type of Options
    without : collection of str
        Fields that are not options of this command.
    """
    spellings = group.names()
    chosen = [option_field for option_field in fields(group) if option_field.name not in without]

    def add(command: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(command)
        def collected(**values: Any) -> None:
            in_group = {each.name: values.pop(f"{parameter}_{each.name}") for each in chosen}
            command(**{parameter: group(**in_group)}, **values)

        # Click shows the option that is added last first.
        for each in reversed(chosen):
            argument = f"{parameter}_{each.name}"
            added = click.option(spellings[each.name], argument, **each.metadata["option"])
            collected = added(collected)
        return collected

    return add


#: Titles of a command's help, and the options below each title; all other options are first.
_TITLES: Mapping[str, str] = {
    "Options": "",
    "Log": "columns window resample gaps",
    "Filter": "cutoff decimate hold reversals",
    "Estimation": "method loss bounded bootstrap",
    "Parameters": "fix leave-out bound prior free truth",
    "Several records": "local known skip-bad",
    "Second record": "validate validate-like",
    "Output": "all full json report figure figures csv force help",
}
#: Paragraph below the options of a title.
_PARAGRAPHS = {
    "Log": "A run.toml holds all other settings of a log. To use these settings, name the run.toml "
    "instead of the log. To write a first run.toml, run: axisid new --record LOG"
}


#: Option of the command line by the argument in Python, where the two names differ.
_OTHER_NAMES = {"methods": "method", "windows": "window", "lowest": "from", "highest": "to"}


class Command(click.Command):
    """A command that refuses an option given twice, unless it is a list; its help has titles.

    While it runs, messages spell settings as options of the command, ``--gaps split``.
    """

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command, and return its value."""
        with settings_typed(self._options_by_argument(), LOG_KEYS):
            return super().invoke(ctx)

    def _options_by_argument(self) -> dict[str, str]:
        """Return the spelling of each option of this command, by the argument in Python."""
        options = {}
        for parameter in self.params:
            for name in parameter.opts:
                if name.startswith("--"):
                    options[name.removeprefix("--").replace("-", "_")] = name
        for argument, option_name in _OTHER_NAMES.items():
            if option_name in options:
                options[argument] = options[option_name]
        return options

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, each below its title."""
        title_of = {name: title for title, names in _TITLES.items() for name in names.split()}
        rows: dict[str, list[tuple[str, str]]] = {title: [] for title in _TITLES}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if isinstance(parameter, click.Option) and record is not None:
                name = max(parameter.opts, key=len).removeprefix("--")
                rows[title_of.get(name, "Options")].append(record)
        for title, below in rows.items():
            if below:
                with formatter.section(title):
                    formatter.write_dl(below)
                    if title in _PARAGRAPHS:
                        formatter.write_paragraph()
                        formatter.write_text(_PARAGRAPHS[title])

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Refuse an option that is given twice, then parse the arguments as Click does.

        Click would use the last value of a repeated option. A key of a run.toml that is given as an
        option is refused with a message of its own.
        """
        if not ctx.resilient_parsing:
            try:
                given, _, order = self.make_parser(ctx).parse_args(args=[*args])
            except click.NoSuchOption as error:
                key = error.option_name.lstrip("-").replace("-", "_")
                if key not in LOG_KEYS:
                    raise
                raise click.UsageError(
                    f"there is no option {error.option_name}. {key} is a key of a log's run.toml. "
                    "Write a run.toml with axisid new --record LOG, and set the key in it.",
                    ctx,
                ) from error
            for option in dict.fromkeys(order):
                if isinstance(option, click.Option):
                    counts = _times_given(option, order, given[str(option.name)])
                    for spelled, times in counts.items():
                        if times > 1:
                            raise click.UsageError(
                                f"{spelled} is given {times} times. Give it once.", ctx
                            )
        return super().parse_args(ctx, args)


def _times_given(
    option: click.Option, order: Sequence[click.Parameter], values: Any
) -> Counter[str]:
    """Return the number of times that an option is given, by its spelling.

    An option that is a list of ``NAME=VALUE`` is counted separately for each name. Other lists are
    not counted, and a flag without an opposite counts once.

    Parameters
    ----------
    option : click.Option
    order : sequence of click.Parameter
        Options in the order of the command line.
    values : object
        Values of this option.
    """
    spelled = "/".join((*option.opts, *option.secondary_opts))
    if option.multiple:
        form = str(option.metavar)
        if "=" not in form:
            return Counter()
        if not form.startswith("["):  # [NAME=]VALUE may be without a name
            values = [text for text in values if "=" in text]
        return Counter(f"{spelled} {text.rpartition('=')[0].strip()}".strip() for text in values)
    is_plain_flag = option.is_flag and not option.secondary_opts
    return Counter({spelled: 1 if is_plain_flag else order.count(option)})


def given_options() -> list[str]:
    """Return the names of the options on the command line of the command that runs."""
    context = click.get_current_context()
    return [
        parameter.opts[-1]
        for parameter in context.command.params
        if isinstance(parameter, click.Option)
        and parameter.name is not None
        and context.get_parameter_source(parameter.name) is ParameterSource.COMMANDLINE
    ]


def check_needed(*rows: tuple[Sequence[str], Sequence[str]]) -> None:
    """Refuse options that have no effect without other options, if none of these is given.

    Parameters
    ----------
    *rows : (sequence of str, sequence of str)
        Options, and the options of which at least one must be given with them.
    """
    given = given_options()
    for options, needed in rows:
        idle = [option for option in options if option in given]
        if idle and not any(option in given for option in needed):
            asked, condition = " and ".join(idle), " or ".join(needed)
            has = "has" if len(idle) == 1 else "have"
            raise click.UsageError(
                f"{asked} {has} no effect without {condition}. Add {condition}, or omit {asked}."
            )


def check_idle(option: str, why: str) -> None:
    """Refuse an option that has no effect; `why` continues the sentence after its name."""
    if option in given_options():
        raise click.UsageError(f"{option} {why}. Omit one of them.")


def complete_file(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Let the shell complete a file's name."""
    return [CompletionItem(incomplete, type="file")]


def complete_axis(
    ctx: click.Context, param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete axes of the library and declarations in this folder, otherwise any file."""
    # By their files: importing the library would bring SymPy.
    modules = (Path(__file__).parents[2] / "modeling" / "library").glob("[!_]*.py")
    library = sorted(file.stem for file in modules)
    here = (p.name for p in sorted(Path().glob("*")) if p.suffix in (".toml", ".py"))
    found = [CompletionItem(n) for n in (*library, *here) if n.startswith(incomplete)]
    return found or complete_file(ctx, param, incomplete)
