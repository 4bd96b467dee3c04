"""What is read out of a file: its encoding, its table, its end, its clock."""

from axisid.codegen.thresholds.threshold import Threshold

MIN_ZERO_BYTE_SHARE = Threshold(
    0.3,
    "1",
    "share of zeros among every second byte from which a text is UTF-16 without its mark",
    "chosen",
)
MIN_NUMBER_SHARE = Threshold(
    0.5,
    "1",
    "share of numbers among the filled cells of a line from which it is a row of the table",
    "chosen",
)
MIN_TABLE_ROW_SHARE = Threshold(
    0.9,
    "1",
    "share of the rows that the best reading makes a table of, from which a reading is considered",
    "chosen",
)
MAX_INCOMPLETE_LINES = Threshold(
    50,
    "lines",
    "unlike lines at the end of a table that are its incomplete end; more are another table",
    "chosen",
)
MAX_MISSING_END = Threshold(
    0.02,
    "1",
    "share of the span in the head of a TwinCAT export that its samples may lack at the end, with "
    "nothing said",
    "chosen",
)
MAX_FIRST_STAMP = Threshold(
    1000,
    "1",
    "time from a stamp of zero to the next, in typical steps, up to which the clock began at zero; "
    "beyond it there was no stamp",
    "chosen",
)
MIN_ROWS_AT_ONE_TIME = Threshold(
    0.4,
    "1",
    "share of rows that have the time of the row before, from which a table of names and values is "
    "long",
    "chosen: one half with two names, more with more",
)
