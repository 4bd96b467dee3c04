"""From symbolic models to functions: lower, print, build, store.

`Axis` -> `AxisModel` -> programs -> text -> `GeneratedAxis`. The text is what `generated/` holds,
and the same text is what runs.
"""

from .arguments import by_sample as by_sample
from .artefacts import axis_artefacts as axis_artefacts
from .artefacts import signature as signature
from .feed_forward import FeedForward as FeedForward
from .feed_forward import feed_forward as feed_forward
from .generated_axis import GeneratedAxis as GeneratedAxis
from .generated_axis import Quantity as Quantity
from .generated_axis import as_generated as as_generated
from .generated_axis import build as build
from .generated_axis import stage_times as stage_times
from .loop_settings import PASSED as PASSED
from .loop_settings import RESOLVED as RESOLVED
from .loop_settings import SIGNALS as SIGNALS
from .loop_settings import STATUSES as STATUSES
from .loop_settings import LoopSettings as LoopSettings
from .print_c99 import print_c99 as print_c99
from .print_python import print_python as print_python
from .print_st import print_st as print_st
from .progress import Progress as Progress
from .progress import each as each
from .real_numbers import is_real as is_real
from .real_numbers import is_whole as is_whole
from .real_numbers import real_array as real_array
from .store import Finding as Finding
from .store import check_files as check_files
from .store import expected_files as expected_files
from .store import replace_file as replace_file
from .store import write_files as write_files
from .virtual_loop import VirtualLoop as VirtualLoop
