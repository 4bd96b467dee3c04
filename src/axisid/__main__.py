"""The command line, as ``axisid`` and ``python -m axisid`` start it.

Its imports take most of a second, in which it may be interrupted like in any other.
"""

import atexit
import gc
import sys

try:
    from axisid.commands.main import main
except KeyboardInterrupt:
    sys.exit(130)

# A process that ends need not search all that it has for cycles: 0.3 s of CPU.
atexit.register(gc.freeze)

if __name__ == "__main__":
    main()
