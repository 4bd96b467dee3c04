"""What a model lacks on a record: columns beside it, against twins that lack nothing.

In: an estimate and its record. Out: `Lack`, the name that explains most first, each with its
sentence. Knows nothing of verdicts.
"""

from .scores import RecordScores as RecordScores
from .scores import scores_of as scores_of
from .search import Lack as Lack
from .search import found_beside as found_beside
from .search import lacking as lacking
from .search import scores_at as scores_at
from .sentences import amount as amount
from .sentences import sentence as sentence
from .terms import TERMS as TERMS
from .terms import Along as Along
from .terms import Term as Term
