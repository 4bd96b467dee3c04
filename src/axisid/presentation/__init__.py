"""How results look: text, page, figures, JSON. Nothing below imports it; see `views`."""
