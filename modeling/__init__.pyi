from .declaration import Column as Column
from .declaration import Experiment as Experiment
from .declaration import Move as Move
from .declaration import back_and_forth as back_and_forth
from .derivation import AxisModel as AxisModel
from .library import LIBRARY as LIBRARY
from .wording import describe_determined as describe_determined
from .wording import describe_unidentifiable as describe_unidentifiable
