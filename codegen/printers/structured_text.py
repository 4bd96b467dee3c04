"""The feed-forward as IEC 61131-3 Structured Text: two FUNCTIONs in LREAL.

The text uses only the standard: its operators and functions, typed literals, no loops. Conditions
use SEL, which computes both its values. ATAN2 belongs to the third edition.
"""

import re

from axisid.codegen.lowering import OPERATIONS, FeedForward, Program

from .shared import (
    BooleanText,
    Language,
    comment,
    condition,
    distinct_names,
    print_operations,
)

_ONE, _ZERO, _TWO = "LREAL#1.0", "LREAL#0.0", "LREAL#2.0"
_NUMBER = f"SEL({{}}, {_ZERO}, {_ONE})"
_RENAMED = {"pow": "EXPT", "log": "LN"}
# Identifiers of the language, upper case: keywords, types, operators of all its languages, standard
# functions and function blocks, in both editions and what vendors commonly add.
_RESERVED = frozenset(
    """
    ABS ABSTRACT ACOS ACTION ADD AND ANDN ANY ARRAY ASIN AT ATAN ATAN2 BOOL BY BYTE CAL CALC CALCN
    CASE CEIL CHAR CLASS CONCAT CONFIGURATION CONSTANT CONTINUE COS CTD CTU CTUD D
    DATE DATE_AND_TIME DEC DELETE DINT DIV DO DS DT DWORD ELSE ELSIF EN END_ACTION END_CASE
    END_CLASS END_CONFIGURATION END_FOR END_FUNCTION END_FUNCTION_BLOCK END_IF END_INTERFACE
    END_METHOD END_NAMESPACE END_PROGRAM END_REPEAT END_RESOURCE END_STEP END_STRUCT END_TRANSITION
    END_TYPE END_VAR END_WHILE ENO EQ EXIT EXP EXPT EXTENDS F_EDGE F_TRIG FALSE FINAL FIND FLOOR
    FOR FROM FUNCTION FUNCTION_BLOCK GE GT IF IMPLEMENTS INC INITIAL_STEP INSERT INT INTERFACE
    INTERNAL INTERVAL JMP JMPC JMPCN L LD LDATE LDN LDT LE LEFT LEN LIMIT LINT LN LOG LREAL LT LTIME
    LTOD LWORD MAX METHOD MID MIN MOD MOVE MUL MUX N NAMESPACE NE NIL NON_RETAIN NOT NULL OF ON OR
    ORN OVERLAP OVERRIDE P P0 P1 PRIORITY PRIVATE PROGRAM PROTECTED PUBLIC R
    R_EDGE R_TRIG READ_ONLY READ_WRITE REAL REF REF_TO REFERENCE REPEAT REPLACE RESOURCE RET RETAIN
    RETC RETCN RETURN RIGHT ROL ROR RS RTC S SD SEL SEMA SHL SHR SIN SINGLE SINT SL SQRT SR ST
    STEP STN STRING STRUCT SUB SUPER T TAN TASK THEN THIS TIME TIME_OF_DAY TO TOD TOF TON TP
    TRANSITION TRUE TRUNC TYPE UDINT UINT ULINT UNTIL USING USINT VAR VAR_ACCESS VAR_CONFIG
    VAR_EXTERNAL VAR_GLOBAL VAR_IN_OUT VAR_INPUT VAR_OUTPUT VAR_TEMP WCHAR WHILE WITH WORD WSTRING
    XOR XORN
    """.split()
)


def print_st(export: FeedForward) -> str:
    """Return the text of the functions for force and control; the second calls the first."""
    force, control = map(_legal, export.functions)
    own = (force.lower(), control.lower(), "force")
    names = distinct_names([*export.motion, *(c.name for c in export.constants)], _legal, own)
    inputs = _block(
        "VAR_INPUT", [f"{names[n]} : LREAL; (* {u} *)" for n, u in export.motion.items()]
    )
    constants = [
        f"{names[c.name]} : LREAL := {_literal(repr(c.value))}; (* {comment(c.comment)} *)"
        for c in export.constants
    ]
    language = _language({**names, "tau": "force"})
    passed = ", ".join(names[name] for name in export.motion)
    about = "\n   ".join(map(comment, export.about))
    return "\n".join(
        [
            f"(* {about}\n*)\n\n(* {comment(export.force.summary)} *)\nFUNCTION {force} : LREAL",
            *inputs,
            *_block("VAR CONSTANT", constants),
            *_body(export.force, force, language, []),
            f"END_FUNCTION\n\n(* {comment(export.control.summary)} *)\nFUNCTION {control} : LREAL",
            *inputs,
            *_body(export.control, control, language, [f"force := {force}({passed});"]),
            "END_FUNCTION\n",
        ]
    )


def _body(program: Program, result: str, language: Language, first: list[str]) -> list[str]:
    """Return the lines of a function: declared temporaries, operations and result.

    Parameters
    ----------
    program : Program
    result : str
        Name of the function, to which the result is assigned.
    language : Language
    first : list of str
        Lines before the operations.
    """
    texts, lines = print_operations(program, language)
    lines = [*first, *lines, f"{result} := {texts[program.outputs[0].rows[0][0]]};"]
    temporaries = [line.split(" := ")[0] for line in lines[:-1]]
    return [
        *_block("VAR", [f"{name} : LREAL;" for name in temporaries]),
        *(f"    {line}" for line in lines),
    ]


def _block(keyword: str, declarations: list[str]) -> list[str]:
    """Return the lines of a block of declarations; none without declarations."""
    if not declarations:
        return []
    return [keyword, *(f"    {line}" for line in declarations), "END_VAR"]


def _legal(name: str) -> str:
    """Return a name as an identifier of the language.

    It has no two underscores in a row, does not end with an underscore, and is not a keyword.
    """
    single = re.sub("_+", "_", name).rstrip("_")
    return f"{single}_v" if single.upper() in _RESERVED else single


def _literal(number: str) -> str:
    """Return the text of a number in Python as a literal of type LREAL, which contains a point."""
    mantissa, exponent, power = number.partition("e")
    point = "" if "." in mantissa else ".0"
    return f"LREAL#{mantissa}{point}{exponent.upper()}{power}"


def _language(names: dict[str, str]) -> Language:
    """Return the syntax of Structured Text, with a legal name for each argument."""
    prefix = "tmp"
    while any(name.lower().startswith(prefix) for name in names.values()):
        prefix = f"x{prefix}"
    return Language(
        calls={
            **{name: _RENAMED.get(name, name.upper()) for name in OPERATIONS},
            "sinh": lambda a: f"((EXP({a}) - EXP(-({a}))) / {_TWO})",
            "cosh": lambda a: f"((EXP({a}) + EXP(-({a}))) / {_TWO})",
            # The standard has no tanh. Beyond 20 it rounds to 1, and EXP must not overflow.
            "tanh": lambda a: (
                f"({_ONE} - {_TWO} / (EXP({_TWO} * LIMIT(LREAL#-20.0, {a}, LREAL#20.0)) + {_ONE}))"
            ),
            "sign": lambda a: (
                f"SEL({a} > {_ZERO}, SEL({a} < {_ZERO}, {_ZERO}, LREAL#-1.0), {_ONE})"
            ),
            "lt": lambda a, b: BooleanText(f"{a} < {b}", _NUMBER),
            "le": lambda a, b: BooleanText(f"{a} <= {b}", _NUMBER),
            "eq": lambda a, b: BooleanText(f"{a} = {b}", _NUMBER),
            "not": lambda a: BooleanText(f"NOT ({_if(a)})", _NUMBER),
            "and": lambda a, b: BooleanText(f"({_if(a)}) AND ({_if(b)})", _NUMBER),
            "or": lambda a, b: BooleanText(f"({_if(a)}) OR ({_if(b)})", _NUMBER),
            "select": lambda c, a, b: f"SEL({_if(c)}, {b}, {a})",
        },
        variable=lambda element: names[element],
        name=lambda name, expression: f"{name} := {expression};",
        constant=_literal,
        temporary=prefix,
    )


def _if(text: str) -> str:
    """Return the condition that a number, given as text, is not 0."""
    return condition(text, f"{{}} <> {_ZERO}")
