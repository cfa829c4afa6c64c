"""Gains by descent on the H-infinity norm itself, from many starts.

loop_norm       the largest gain of a loop over frequencies, and where it is
gain_loops      loops that are affine in the entries of a gain: value and gradient
quasi_newton    BFGS with a weak line search, for functions with kinks
many_starts     stabilise, descend, and go on with the best
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.gains.descent.gain_loops import GainLoops as GainLoops
    from takagi.lmi.gains.descent.loop_norm import largest_gain as largest_gain
    from takagi.lmi.gains.descent.loop_norm import response as response
    from takagi.lmi.gains.descent.many_starts import Found as Found
    from takagi.lmi.gains.descent.many_starts import best_gains as best_gains
    from takagi.lmi.gains.descent.quasi_newton import descend as descend

__getattr__, __dir__ = lazy_names(__name__)
