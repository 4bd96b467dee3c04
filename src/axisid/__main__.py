"""Entry point of the command line, for ``axisid`` and ``python -m axisid``.

The imports take most of a second. Ctrl-C during the imports ends the program with exit code 130.
"""

import atexit
import gc
import sys

try:
    from axisid.commands.main import main
except KeyboardInterrupt:
    sys.exit(130)

# Objects are not searched for cycles at the end of the process, which would take 0.3 s of CPU.
atexit.register(gc.freeze)

if __name__ == "__main__":
    main()
