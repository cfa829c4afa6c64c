"""The effort-sharing law (``coherent`` on the command line).

law           one effort, divided between generator torque and blade pitch by a ramp
schedule      what it looks up over wind
feedforward   what it feeds forward of its schedule wind's own rate
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.laws.effort_sharing.schedule import frozen_wake_effectiveness

__all__ = [
    "frozen_wake_effectiveness",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
