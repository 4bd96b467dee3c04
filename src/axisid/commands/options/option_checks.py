"""Options that would be ignored are refused: the user meant something by them."""

from collections import Counter
from collections.abc import Sequence

import click
from click.core import ParameterSource


class Command(click.Command):
    """A command that takes an option once, unless the option is a list."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Refuse what is given again, of which only the last would count."""
        if not ctx.resilient_parsing:
            *_, order = self.make_parser(ctx).parse_args(args=[*args])
            for parameter, times in Counter(order).items():
                if times > 1 and isinstance(parameter, click.Option) and _counts_once(parameter):
                    names = "/".join((*parameter.opts, *parameter.secondary_opts))
                    raise click.UsageError(f"{names} is given {times} times; give it once.", ctx)
        return super().parse_args(ctx, args)


def _counts_once(option: click.Option) -> bool:
    """Whether it is no list, nor a flag that says the same however often."""
    return not option.multiple and (not option.is_flag or bool(option.secondary_opts))


def given_options() -> list[str]:
    """Names of the options that the command line gives to the command that runs."""
    context = click.get_current_context()
    return [
        parameter.opts[-1]
        for parameter in context.command.params
        if isinstance(parameter, click.Option)
        and parameter.name is not None
        and context.get_parameter_source(parameter.name) is ParameterSource.COMMANDLINE
    ]


def check_needed(options: Sequence[str], needed: Sequence[str]) -> None:
    """Refuse options that say something of what others ask for, where none of these is given."""
    given = given_options()
    idle = [option for option in options if option in given]
    if idle and not any(option in given for option in needed):
        verb = "says" if len(idle) == 1 else "say"
        raise click.UsageError(
            f"{' and '.join(idle)} {verb} nothing without {' or '.join(needed)}; add that, or "
            "leave it out."
        )


def check_idle(option: str, why: str) -> None:
    """Refuse an option that has no effect, for a reason that goes on after its name."""
    if option in given_options():
        raise click.UsageError(f"{option} {why}; leave one of them out.")
