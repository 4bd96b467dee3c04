# %% [markdown]
# # Command line
#
# Every command explains itself with `--help`, with an example. Errors are one sentence on standard error.
#
# | exit code | meaning |
# |---|---|
# | 0 | done |
# | 1 | `generate --check` found stale code; or an internal fault |
# | 2 | usage: an option or argument, or a place that cannot be written to |
# | 3 | data: the record |
# | 4 | model: the axis |
# | 6 | estimation: rank, divergence, no convergence; what other methods found is still reported |
# | 130 | interrupted |
#
# On a terminal, results are coloured and fitted to its width (`NO_COLOR` is honoured), and what takes
# longer than a second says so; on a pipe there is plain ASCII. `eval "$(axisid completion bash)"`
# completes commands, options, axes and files; zsh and fish too.

# %% tags=["hide-input"]
import click
from IPython.display import Markdown, display

from axisid.cli import cli

for name in sorted(cli.commands):
    command = cli.commands[name]
    context = click.Context(command, info_name=f"axisid {name}", max_content_width=100)
    display(Markdown(f"## {name}\n\n```text\n{command.get_help(context)}\n```"))
