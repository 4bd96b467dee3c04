"""How results look: text, page, figures, JSON.

In: a result. Out: its document, dictionary, figures and cells of a notebook, by its row in `views`.
Nothing below imports it.
"""
