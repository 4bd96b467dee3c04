"""What the search for a control law holds its figures against."""

from axisid.codegen.thresholds.threshold import Threshold

MAX_AS_WELL = Threshold(
    1.1,
    "1",
    "what a law leaves of a control on rows that are held out, by the least that one does, up to "
    "which it explains the control as well",
    "chosen: on the EMPS record four larger laws leave the same 0.234 % as the drive's own",
)
NEGLIGIBLE_LEFT = Threshold(
    1e-5,
    "%",
    "part of a control below which laws leave nothing",
    "chosen: rounding of the runs",
)
MIN_LIMITED_SHARE = Threshold(
    2e-3,
    "1",
    "share of samples at the drive's limit from which laws with anti-windup are tried",
    "chosen",
)
