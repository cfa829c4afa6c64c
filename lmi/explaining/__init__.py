"""Why there was no answer, and what would help, measured.

explanation            the explanation as a value, in words
weaker_requests        repeated design with weaker requests
smaller_box            the model on a smaller box
uncontrollable_blend   a blend that no gains stabilise
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.explaining.smaller_box import on_smaller_box as on_smaller_box
    from takagi.lmi.explaining.smaller_box import with_narrower_premise as with_narrower_premise

__getattr__, __dir__ = lazy_names(__name__)
