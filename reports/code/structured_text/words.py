"""Keywords and functions of IEC 61131-3 Structured Text, in lower case.

Source: IEC 61131-3:2013, tables of keywords and of standard functions.
"""

from __future__ import annotations

FUNCTIONS = {
    "abs": "ABS",
    "sqrt": "SQRT",
    "exp": "EXP",
    "log": "LN",
    "sin": "SIN",
    "cos": "COS",
    "tan": "TAN",
    "asin": "ASIN",
    "acos": "ACOS",
    "atan": "ATAN",
    "min": "MIN",
    "max": "MAX",
}
"""Word of the gain file's language -> standard function."""

# Functions that the standard lacks, expressed by those that it has: {0} is the argument.
WRITTEN_OUT = {
    "sinh": "((EXP({0}) - EXP(-({0}))) / 2.0)",
    "cosh": "((EXP({0}) + EXP(-({0}))) / 2.0)",
    "tanh": "(1.0 - 2.0 / (EXP(2.0 * ({0})) + 1.0))",
    "asinh": "LN(({0}) + SQRT(({0}) * ({0}) + 1.0))",
    "acosh": "LN(({0}) + SQRT(({0}) * ({0}) - 1.0))",
    "atanh": "(LN((1.0 + ({0})) / (1.0 - ({0}))) / 2.0)",
}

RESERVED = frozenset(
    """
    abstract action and array at begin bool by byte case char class configuration constant
    continue date date_and_time do dt dword else elsif end_action end_case end_class
    end_configuration end_for end_function end_function_block end_if end_interface end_method
    end_namespace end_program end_repeat end_resource end_step end_struct end_transition
    end_type end_var end_while exit extends false final for from function function_block if
    implements initial_step int interface internal interval ldate ldt lint lreal ltime ltod
    lword method mod namespace non_retain not null of on or overlap override priority private
    program protected public read_only read_write real ref ref_to repeat resource retain return
    sint single step string struct super task then this time time_of_day to tod transition true
    type udint uint ulint until using usint var var_access var_config var_external var_global
    var_in_out var_input var_output var_temp while with word wchar wstring xor abs sqrt ln log
    exp sin cos tan asin acos atan atan2 add mul sub div expt move shl shr ror rol sel max min
    limit mux gt ge eq le lt ne len left right mid concat insert delete replace find trunc round
    sr rs r_trig f_trig ctu ctd ctud tp ton tof en eno r_edge
    f_edge reset sample_time status started ready
    """.split()
)
