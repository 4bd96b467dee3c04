"""Shared parts of the commands: arguments and options, reading, writing, the terminal.

In: words of the command line, documents of blocks. Out: an axis, a record, settings; written files,
terminal output with colours, width and progress. Knows nothing of the commands themselves, nor of
the layout of a result.
"""

from .estimation_options import (
    VALUE as VALUE,
    Filtering as Filtering,
    Fitting as Fitting,
    Inputs as Inputs,
    Reading as Reading,
    Sharing as Sharing,
    axis_and_records as axis_and_records,
    bootstrap_option as bootstrap_option,
    bounded_option as bounded_option,
    by_names as by_names,
    fix_option as fix_option,
    is_log as is_log,
    leave_out_option as leave_out_option,
    loss_option as loss_option,
    method_option as method_option,
    one_or_all as one_or_all,
)
from .groups import (
    Command as Command,
    Options as Options,
    check_idle as check_idle,
    check_needed as check_needed,
    complete_axis as complete_axis,
    complete_file as complete_file,
    option as option,
    reading as reading,
    takes as takes,
)
from .outputs import (
    Target as Target,
    check_folder as check_folder,
    check_replaced as check_replaced,
    check_targets as check_targets,
    command_line as command_line,
    force_option as force_option,
    is_earlier as is_earlier,
    json_option as json_option,
    print_document as print_document,
    print_result as print_result,
    progress_line as progress_line,
    put_out as put_out,
    put_result as put_result,
    write_output as write_output,
    write_page as write_page,
)
