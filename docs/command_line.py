# %% [markdown]
# # Command line
#
# `--help` explains every command, with an example. An error is one sentence on standard error.
#
# | exit code | meaning |
# |---|---|
# | 0 | done |
# | 1 | `generate --check` found stale code; or an internal fault |
# | 2 | usage: an option or argument, also one without effect, or an output path that cannot be written |
# | 3 | data: the record, a file of results; or not enough memory for it |
# | 4 | model: the axis |
# | 6 | estimation: rank, divergence, no convergence, logs of a fleet without a result; results of other methods and logs are still reported |
# | 130 | interrupted; a fit has printed and written its best values so far |
#
# On a terminal, results have colours and fit its width (`NO_COLOR` is respected), and steps longer than a second show
# progress. On a pipe, output is plain ASCII. `eval "$(_AXISID_COMPLETE=bash_source axisid)"`
# completes commands, options, axes and files; zsh and fish work too.
#
# **Existing files.** Output paths are checked before the computation. A file is written completely or not at all.
# Every output names the command that made it: a result in its schema, a page and figures in their creator, exported and
# generated code in its first lines. The same command overwrites such a file, or an empty one, so you can run a script
# again; `sweep` does not overwrite a result of `identify`. Any other file, such as a log or notes, is kept: the
# command is refused with exit code 2, unless you add `--force`. Your changes in a file that a command wrote are lost when
# the command runs again.
#
# **Options without effect** are refused: `--validate-like` without `--validate`, `--full` without printed output, repairs
# of a twin. So is an option that is given twice, or a name that occurs twice in its list.
#
# **Settings without an option.** Apart from four options, settings of a log are in [its `run.toml`](logs.md#say-what-a-log-is).
# Less common settings of an estimate are arguments in Python (`Prefilter`, `identify`, `summary`).

# %% tags=["hide-input"]
import click
from IPython.display import Markdown, display

from axisid.commands.main import cli

for name in sorted(cli.commands):
    command = cli.commands[name]
    context = click.Context(command, info_name=f"axisid {name}", max_content_width=100)
    display(Markdown(f"## {name}\n\n```text\n{command.get_help(context)}\n```"))
