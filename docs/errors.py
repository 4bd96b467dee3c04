# %% [markdown]
# # Error codes
#
# What is refused is refused in one sentence: what was given, what was expected and what to do. A program tells
# errors by their `code`, which stays where a sentence is worded anew: see [errors](api/errors). Of an error without
# a code of its own it is that of its class, which also decides the exit code of the command line: 2 of a
# `UsageError`, 3 of a `DataError`, 4 of a `ModelError`, 6 of an `EstimationError`.
#
# The table is read from the code: `…` and names stand for what is put in.

# %% tags=["hide-input"]
from IPython.display import Markdown, display

from docs.extensions.error_tables import page

display(Markdown(page()))
