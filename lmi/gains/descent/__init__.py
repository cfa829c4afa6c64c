"""Gains by descent on the H-infinity norm itself, from many starts.

gain_loops      loops that are affine in the entries of a gain: norm and gradient
many_starts     stabilise, descend by BFGS, and go on with the best
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.gains.descent.gain_loops import GainLoops as GainLoops
    from takagi.lmi.gains.descent.gain_loops import largest_gain as largest_gain
    from takagi.lmi.gains.descent.gain_loops import response as response
    from takagi.lmi.gains.descent.many_starts import Found as Found
    from takagi.lmi.gains.descent.many_starts import best_gains as best_gains
    from takagi.lmi.gains.descent.many_starts import descend as descend

__getattr__, __dir__ = lazy_names(__name__)
