"""Why there was no answer, and what would help, measured.

explanation            in words; the model on a smaller box; a blend that no gains stabilise
weaker_requests        repeated design with weaker requests
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.explaining.explanation import on_smaller_box as on_smaller_box
    from takagi.lmi.explaining.explanation import with_narrower_premise as with_narrower_premise

__getattr__, __dir__ = lazy_names(__name__)
