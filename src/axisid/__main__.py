"""``python -m axisid`` is the command line."""

from axisid.cli import main

main()
