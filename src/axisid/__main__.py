"""``python -m axisid`` is the command line."""

from axisid.commands.main import main

main()
