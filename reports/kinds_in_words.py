"""Every kind of claim in words, for whoever reads: report, appendix, pages.

A new kind has its table in ``kinds_in_words.toml``, whose head says what each word is, and no
words elsewhere.  What the claim states is the ``sentence`` of its class in the checker.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from takagi.reports.output import read_words

# What both checkers say of a kind for each kind of weights, in the order of docs/blends.md.
Weights = tuple[str, ...]
KINDS_OF_WEIGHTS = 5
OTHER_MODEL: Weights = ("refused: another model",) * KINDS_OF_WEIGHTS


@dataclass(frozen=True, slots=True, kw_only=True)
class KindInWords:
    """The words for one kind of claim, as ``kinds_in_words.toml`` describes them."""

    title: str
    name: str
    why: str
    request: str = ""
    proved: str = ""
    assumed: str = ""
    weights: Weights = ("theorem",) * KINDS_OF_WEIGHTS
    weights_of: Mapping[str, Weights] = field(default_factory=dict)


def _weights(stated: str | list[str]) -> Weights:
    return (stated,) * KINDS_OF_WEIGHTS if isinstance(stated, str) else tuple(stated)


def _kind(stated: Mapping[str, Any]) -> KindInWords:
    words = dict(stated)
    if "weights" in words:
        words["weights"] = _weights(words["weights"])
    variants = words.pop("weights_of", {})
    return KindInWords(**words, weights_of={name: _weights(w) for name, w in variants.items()})


KINDS_IN_WORDS: Mapping[str, KindInWords] = {
    kind: _kind(stated) for kind, stated in read_words("kinds_in_words.toml").items()
}
