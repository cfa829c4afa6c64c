"""Information about a check itself.

trusted_lines    the files and lines of the checker that a verdict used
two_checkers     both checkers on one certificate, and whether they agree
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.audit.trusted_lines import Trusted as Trusted
    from takagi.certificates.audit.trusted_lines import check_counted as check_counted
    from takagi.certificates.audit.trusted_lines import code_lines as code_lines
    from takagi.certificates.audit.two_checkers import VerdictComparison as VerdictComparison
    from takagi.certificates.audit.two_checkers import VerdictRow as VerdictRow
    from takagi.certificates.audit.two_checkers import cross_checked as cross_checked
    from takagi.certificates.audit.two_checkers import (
        cross_checked_document as cross_checked_document,
    )

__getattr__, __dir__ = lazy_names(__name__)
