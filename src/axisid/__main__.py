"""The command line, as ``axisid`` and ``python -m axisid`` start it.

Its imports take most of a second, in which it may be interrupted like in any other.
"""

import sys

try:
    from axisid.commands.main import main
except KeyboardInterrupt:
    sys.exit(130)

if __name__ == "__main__":
    main()
