"""Intervals of one parameter drawn on one scale."""

from axisid.presentation.blocks import Intervals

_WIDTH, _HEIGHT, _EDGE = 170.0, 26.0, 6.0


def intervals_html(drawn: Intervals) -> str:
    """One above the other, in their order, the truth dotted; nothing where they have no width."""
    ends = [end for each in drawn.intervals for end in (each.low, each.high)]
    ends += [] if drawn.truth is None else [drawn.truth]
    low, span = min(ends), max(ends) - min(ends)
    if not 0 < span < float("inf"):
        return ""

    def place(x: float) -> str:
        return f"{_EDGE + (x - low) / span * (_WIDTH - 2 * _EDGE):.1f}"

    marks = ""
    if drawn.truth is not None:
        at = place(drawn.truth)
        marks += f'<line class="truth" x1="{at}" x2="{at}" y1="1" y2="25"/>'
    for i, each in enumerate(drawn.intervals, 1):
        y = f"{_HEIGHT * i / (len(drawn.intervals) + 1):.1f}"
        marks += (
            f'<g class="{each.kind}">'
            f'<line x1="{place(each.low)}" x2="{place(each.high)}" y1="{y}" y2="{y}"/>'
            f'<circle cx="{place(each.centre)}" cy="{y}" r="3"/></g>'
        )
    size = f'viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}"'
    return f'<svg class="interval" {size} role="img" aria-label="intervals">{marks}</svg>'
