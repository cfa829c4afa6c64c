"""Candidates for the coherent loop as it runs, with its observer, at constant winds.

signals     linear signals with uncertain factors, and the matrix of the decay inequality
running     the loop's factors enclosed over a box, and its equations as signals
subject     turbine and law as the checker reads them
candidate   a quadratic function for one cell of winds, with its inequalities in exact arithmetic

No claim is made of these yet: no checker replays them, so nothing here is PROVED.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.claims.turbine.running_loop.candidate import (
        inequality_failure as inequality_failure,
    )
    from takagi.certificates.claims.turbine.running_loop.candidate import (
        running_candidate as running_candidate,
    )
    from takagi.certificates.claims.turbine.running_loop.running import Machine as Machine
    from takagi.certificates.claims.turbine.running_loop.running import Running as Running
    from takagi.certificates.claims.turbine.running_loop.signals import Signals as Signals
    from takagi.certificates.claims.turbine.running_loop.signals import combined as combined
    from takagi.certificates.claims.turbine.running_loop.signals import decay_form as decay_form
    from takagi.certificates.claims.turbine.running_loop.subject import loop_subject as loop_subject

__getattr__, __dir__ = lazy_names(__name__)
