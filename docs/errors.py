# %% [markdown]
# # Error codes
#
# Every [error](api/errors.md) says in one sentence what was given, what was expected and what to do. Its `code` is for
# programs. There is one code for each kind and stage (`columns`, `time`, `fit`), shared by several sentences. It stays the
# same if a sentence is reworded. The exit code of the command line depends on the class: 2 for a `UsageError`, 3 for a
# `DataError`, 4 for a `ModelError`, 6 for an `EstimationError`.
#
# The table comes from the code. `…` and names stand for inserted text.

# %% tags=["hide-input"]
from IPython.display import Markdown, display

from docs.extensions.error_tables import page

display(Markdown(page()))
