"""How results look: text, page, figures, JSON.

In: a result. Out: its document, dictionary, figures and cells of a notebook, by its row in `views`;
one page of HTML with everything in it, for a colleague; what Matplotlib draws, and its files. Its
modules are imported by name, so that Matplotlib is where something is drawn. Knows nothing of how a
result came to be, and of arguments; nothing below imports it.
"""
