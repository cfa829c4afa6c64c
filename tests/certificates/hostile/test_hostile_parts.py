"""Parts of a certificate or a model file that have another type than the comparison needs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import CertificateError, check
from tests.certificates.conftest import resealed


@pytest.mark.parametrize("claims", [True, 1, None, "x", {}, [], [1], [None], [{}], [{"kind": 1}]])
@pytest.mark.parametrize("controller", [{}, {"controller": {"version": "1"}}])
def test_claims_of_another_type_beside_a_gain_file(
    claims: Any, controller: dict[str, Any], tmp_path: Path
) -> None:
    """The file is compared before the claims are replayed: what it needs of them is read first."""
    law = {"name": "pdc", "K": [[[1]]]}
    document = {
        "format": "takagi-certificate",
        "version": 1,
        "model": {"kind": "plant"},
        "gains": law,
        "claims": claims,
        **controller,
    }
    (tmp_path / "c.json").write_text(json.dumps(resealed(document)), "utf-8")
    (tmp_path / "gains.json").write_text(json.dumps({"law": law}), "utf-8")

    with pytest.raises(CertificateError, match="claims"):
        check(tmp_path / "c.json", gains=tmp_path / "gains.json")
