# %% [markdown]
# # Command line
#
# Every command explains itself with `--help`, with an example. Errors are one sentence on standard error.
#
# | exit code | meaning |
# |---|---|
# | 0 | done |
# | 1 | `generate --check` found stale code; or an internal fault |
# | 2 | usage: an option or argument, also one that would have no effect, or a place that cannot be written to |
# | 3 | data: the record, a file of results; or not enough memory for it |
# | 4 | model: the axis |
# | 6 | estimation: rank, divergence, no convergence, logs of a fleet without a result; what other methods and logs gave is still reported |
# | 130 | interrupted; a fit has printed and written its best values so far |
#
# On a terminal, results are coloured and fitted to its width (`NO_COLOR` is honoured), and what takes
# longer than a second says so; on a pipe there is plain ASCII. `eval "$(_AXISID_COMPLETE=bash_source axisid)"`
# completes commands, options, axes and files; zsh and fish too.
#
# **What is there already.** Places are checked before anything is computed, and a file is written whole or not
# at all. Every output says in its content which command made it: a result by its schema, a page and figures by
# their creator, exported and generated code by its first lines. The same command writes such a file, or an
# empty one, anew, so a script can run again as it stands; `sweep` does not write over a result of `identify`.
# Any other file, a log or notes, is kept: the command is refused with exit code 2, and `--force` allows it.
# What you change in a file that a command wrote is lost when it runs again.
#
# **Options that would have no effect** are refused, and so is what is said twice, an option or a name in its list:
# `--validate-like` without `--validate`, `--full` without anything printed, repairs of a twin.
#
# **What is not at the keyboard.** What is said of a log beyond four options stands in [its `run.toml`](logs.md#say-what-a-log-is);
# settings of an estimate that are seldom asked for are arguments in Python (`Prefilter`, `identify`, `summary`).

# %% tags=["hide-input"]
import click
from IPython.display import Markdown, display

from axisid.commands.main import cli

for name in sorted(cli.commands):
    command = cli.commands[name]
    context = click.Context(command, info_name=f"axisid {name}", max_content_width=100)
    display(Markdown(f"## {name}\n\n```text\n{command.get_help(context)}\n```"))
