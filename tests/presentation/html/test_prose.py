"""Sentences of a page: numbers as they are printed, options in one piece."""

from axisid.presentation.html.prose import prose_html


def test_sentences_end_once_and_keep_the_case_of_names() -> None:
    assert prose_html("in the record.") == prose_html("in the record") == "in the record."
    assert prose_html("m = -1.5 kg") == "m = \u22121.5 kg."


def test_options_do_not_break_after_their_hyphens() -> None:
    assert prose_html("leave them out (--reversals leave-out), or <x>") == (
        'leave them out (<span class="option">--reversals leave-out</span>), or &lt;x&gt;.'
    )
    assert prose_html("position mm -> m") == ('position mm <span class="option">-&gt;</span> m.')
    assert '<span class="option">--fix NAME=VALUE+-SD</span>' in prose_html(
        "(--fix NAME=VALUE+-SD)"
    )
