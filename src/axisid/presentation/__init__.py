"""How results look: text, page, figures, JSON.

In: a result. Out: its document, dictionary, figures and cells of a notebook, by its row in `views`.
Knows nothing of how a result came to be, of files and of arguments; nothing below imports it.
"""
