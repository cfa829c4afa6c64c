"""The members of a gain file other than the law, for a new design or an existing file.

content             the gain file of a certificate as plain data, and the two bound together
given_file          the same for gains of a file
plant_members       contents of a plant's file that model and law do not determine
removable_points    the replacement of a premise where it is 0/0
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.controller.content import bound as bound
    from takagi.certificates.controller.content import gain_file_of as gain_file_of

__getattr__, __dir__ = lazy_names(__name__)
