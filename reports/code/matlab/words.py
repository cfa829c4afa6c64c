"""Keywords of MATLAB and Octave, and functions and variables of the generated code."""

from __future__ import annotations

RESERVED = frozenset(
    """
    break case catch classdef continue do else elseif end end_try_catch end_unwind_protect endfor
    endfunction endif endswitch endwhile for function global if otherwise parfor persistent return
    spmd switch try until unwind_protect unwind_protect_cleanup while
    abs sqrt exp log sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh erf min max pi
    i j e eps inf nan Inf NaN ans isempty isfinite struct numel prod sum true false single double
    limit choose line slope hold mix spline1 spline2 basis interval first last
    state inputs outputs status sample_time T kept next c
    """.split()
)
