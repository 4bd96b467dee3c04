# %% [markdown]
# # Error codes
#
# Every [error](api/errors.md) says in one sentence what was given, what was expected and what to do. Its `code` is for
# programs: one for each kind and stage (`columns`, `time`, `fit`), so that several sentences share one, and it stays where a
# sentence is worded anew. The exit code of the command line goes by the class: 2 of a `UsageError`, 3 of a `DataError`, 4 of
# a `ModelError`, 6 of an `EstimationError`.
#
# The table is read from the code: `…` and names stand for what is put in.

# %% tags=["hide-input"]
from IPython.display import Markdown, display

from docs.extensions.error_tables import page

display(Markdown(page()))
