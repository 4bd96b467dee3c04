"""How far a program may be from what was declared.

In: `Program`, the declared force. Out: a refusal where they differ.
Knows nothing of languages and compilers.
"""

from .declared_check import check_programs as check_programs
from .drive_check import check_drive as check_drive
from .evaluate import evaluate as evaluate
