"""Shell completion: ``axisid completion``, and what completes axes and files."""

from importlib.util import find_spec
from pathlib import Path

import click
from click.shell_completion import CompletionItem, get_completion_class

from .groups import Command

_VARIABLE = "_AXISID_COMPLETE"
_DECLARATIONS = (".toml", ".py")


def complete_file(_: click.Context, __: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Let the shell complete a file's name."""
    return [CompletionItem(incomplete, type="file")]


def complete_axis(
    ctx: click.Context, param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Axes of the library and declarations in this folder; elsewhere any file."""
    names = [*library_names(), *(p.name for p in sorted(Path().glob("*")) if _declares(p))]
    found = [CompletionItem(name) for name in names if name.startswith(incomplete)]
    return found or complete_file(ctx, param, incomplete)


def library_names() -> list[str]:
    """The axes that ship, by their files: importing the library would bring SymPy."""
    spec = find_spec("axisid.modeling")
    places = (spec.submodule_search_locations if spec else None) or []
    return sorted(
        file.stem
        for place in places
        for file in Path(place, "library").glob("*.py")
        if not file.stem.startswith("_")
    )


def _declares(path: Path) -> bool:
    return path.suffix in _DECLARATIONS


@click.command(
    cls=Command,
    short_help="Print a completion script for the shell.",
    epilog='Example: axisid completion bash. In ~/.bashrc: eval "$(axisid completion bash)"',
)
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
@click.pass_context
def completion(ctx: click.Context, shell: str) -> None:
    """Print the script that completes commands, options, axes and files in a SHELL.

    In ~/.zshrc it is the same with zsh; for fish write it into
    ~/.config/fish/completions/axisid.fish.
    """
    kind = get_completion_class(shell)
    if kind is None:  # click has lost a shell
        raise click.UsageError(f"there is no completion for {shell}.")
    made = kind(ctx.find_root().command, {}, "axisid", _VARIABLE)
    click.echo(made.source_template % made.source_vars())
