"""Presentation of results: text, HTML page, figures, JSON.

In: a result. Out: its document, dictionary, figures and notebook cells, by its row in `views`; a
self-contained HTML page (`page`); figures by Matplotlib, and their files (`matplotlib`). Modules
are imported by name, so that Matplotlib is imported only if a figure is drawn. Knows nothing of the
origin of a result and of the arguments of commands; packages below do not import it.
"""
