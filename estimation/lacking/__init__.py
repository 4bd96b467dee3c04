"""What a model lacks on a record: terms by name, and parameters that change in time.

In: an estimate and its record, or a motion. Out: `Lack`, the strongest first, each with its
sentence; the `Term` of a motion that may be lacking. Knows nothing of verdicts.
"""

from .examined_rows import ExaminedRows as ExaminedRows
from .examined_rows import examined as examined
from .examined_rows import examined_again as examined_again
from .search import Lack as Lack
from .search import found_on as found_on
from .search import lacking as lacking
from .sentences import change_sentence as change_sentence
from .sentences import is_named as is_named
from .sentences import of_force as of_force
from .sentences import term_sentence as term_sentence
from .signals_apart import SignalApart as SignalApart
from .signals_apart import signals_apart as signals_apart
from .terms import DRIFTS as DRIFTS
from .terms import PLAIN as PLAIN
from .terms import Along as Along
from .terms import Kind as Kind
from .terms import Term as Term
from .terms import said_of as said_of
from .terms import terms_for as terms_for
