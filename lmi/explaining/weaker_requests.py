"""What would have had an answer: measured, by repeated design with weaker requests."""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np

from takagi.lmi.answer import Answer, Design
from takagi.lmi.argument_checks import number
from takagi.lmi.condition.term import Condition
from takagi.lmi.decision.outcome import Share, binding_shares
from takagi.lmi.explaining.explanation import (
    NAMED,
    Explanation,
    PremiseRelief,
    on_smaller_box,
    uncontrollable_blend,
    with_narrower_premise,
)
from takagi.lmi.sums.relaxations import contains
from takagi.models import TSModel
from takagi.models.errors import ModelError

# What is asked again: ``pdc``, ``common_lyapunov``, or a function that is called like them.
Asker: TypeAlias = Callable[..., Answer | Design]

RICHER = ("tuan", "tanaka-wang", "product", "kim-lee", "polya-1", "liu-zhang", "polya-2")


def explain(
    answer: Answer | Design,
    model: Any,
    *,
    steps: int = 6,
    **options: Any,
) -> Explanation:
    """Return why ``pdc`` or ``common_lyapunov`` had no answer for a model, and what would help.

    It asks again: with the box shrunk, each premise shrunk alone, a lower decay rate, richer
    relaxations.  That takes from ten to some fifty times as long as the answer did.

    Parameters
    ----------
    answer : what was returned for the model.
    model : the same one.
    steps : of each bisection.
    options : as they were given before, e.g. ``input_limit``.

    Raises ModelError: an answer of another question, or options that ``by`` refuses.
    """
    question = _Question.of(answer, model, options)
    answer_now = question.ask_as_given()
    if answer_now is not None:
        return Explanation(asked=question.words(), found=True, asked_again=question.count)
    first_answer = answer.answer if isinstance(answer, Design) else answer
    binding = _binding(first_answer)
    rate, lowest = question.largest_rate(steps)
    box = question.largest_share(lambda share: on_smaller_box(model, share), steps)
    return Explanation(
        asked=question.words(),
        found=False,
        binding=binding,
        rules=_rules(binding, model),
        stuck=uncontrollable_blend(first_answer, model) if question.relaxation else None,
        box=None if box is None else float(box),
        premises=_premises(question, model, steps),
        decay_rate=rate,
        lowest_rate=lowest,
        relaxations=question.richer(),
        asked_again=question.count,
    )


class _Question:
    """What was asked, and how often it has been asked again."""

    def __init__(
        self, model: Any, by: Asker, decay_rate: float, relaxation: str, options: dict[str, Any]
    ) -> None:
        self.model, self.by, self.decay_rate = model, by, decay_rate
        self.relaxation, self.options, self.count = relaxation, options, 0

    @classmethod
    def of(cls, answer: Answer | Design, model: Any, options: dict[str, Any]) -> _Question:
        from takagi.lmi.analysis.common_quadratic import common_lyapunov
        from takagi.lmi.gains.decay.pdc import pdc

        if isinstance(answer, Design):
            return cls(model, pdc, answer.decay_rate, answer.relaxation, options)
        condition = answer.condition
        if condition is None or [u.name for u in condition.unknowns] != ["P"]:
            raise ModelError(
                "explain knows the answers of pdc and of common_lyapunov, and this is the answer "
                "to another question"
            )
        return cls(model, common_lyapunov, _rate_of(condition, model, options), "", options)

    def words(self) -> str:
        request = f"gains by {self.relaxation}" if self.relaxation else "a common P"
        return f"{request} with a decay rate of {self.decay_rate:.4g} 1/s"

    def ask(self, model: Any, decay_rate: float, relaxation: str) -> Answer | Design:
        self.count += 1
        named = {"relaxation": relaxation} if relaxation else {}
        return self.by(model, decay_rate=decay_rate, **named, **self.options)

    def ask_as_given(self) -> Answer | Design | None:
        """Return the answer if there is one now; misuse raises here and is not hidden later."""
        answer = self.ask(self.model, self.decay_rate, self.relaxation)
        return answer if answer.found else None

    def holds(self, model: Any, decay_rate: float | None = None) -> bool:
        rate = self.decay_rate if decay_rate is None else decay_rate
        try:
            return self.ask(model, rate, self.relaxation).found
        except ModelError:
            # E.g. a smaller box has a vertex that no input moves.
            return False

    def largest_share(self, smaller: Callable[[Fraction], Any], steps: int) -> Fraction | None:
        """Return the largest dyadic share below 1 with an answer, by bisection."""
        low, high = Fraction(0), Fraction(1)
        if not self.holds(smaller(low)):
            return None
        for _ in range(steps):
            middle = (low + high) / 2
            low, high = (middle, high) if self.holds(smaller(middle)) else (low, middle)
        return low

    def largest_rate(self, steps: int) -> tuple[float | None, float | None]:
        """Return the largest rate below the one asked for that has an answer, by bisection.

        And the lowest that was tried; None and None where none is below.
        """
        rates = self._lower_rates()
        low = next((rate for rate in rates if self.holds(self.model, rate)), None)
        if low is None:
            return None, (rates[-1] if rates else None)
        lowest, high = low, self.decay_rate
        for _ in range(steps):
            middle = (low + high) / 2
            low, high = (middle, high) if self.holds(self.model, middle) else (low, middle)
        return low, lowest

    def _lower_rates(self) -> list[float]:
        """Return 0 and, for a loop that is given, growths: some quadratic function has one."""
        rates = [0.0] if self.decay_rate > 0 else []
        if not self.relaxation:
            size = float(np.abs(np.asarray(getattr(self.model, "A", self.model))).max()) or 1.0
            rates += [min(self.decay_rate, 0.0) - size * 4.0**k for k in range(20)]
        return rates

    def richer(self) -> tuple[tuple[str, bool | None], ...]:
        """Return relaxations with whether they have gains, up to the first that has."""
        if not self.relaxation:
            return ()
        by_premises = bool(getattr(self.model, "premises", ()))
        names = [
            name
            for name in RICHER
            if not contains(self.relaxation, name) and (by_premises or name != "product")
        ]
        tried: list[tuple[str, bool | None]] = []
        for name in names:
            try:
                tried.append((name, self.ask(self.model, self.decay_rate, name).found))
            except ModelError:
                tried.append((name, None))
            if tried[-1][1]:
                break
        return tuple(tried)


def _rate_of(condition: Condition, model: Any, options: dict[str, Any]) -> float:
    """Return the decay rate in 1/s that a condition asks for."""
    if "contraction" not in condition.parameters:
        return float(condition.parameters.get("alpha", 0.0))
    step = options.get("sample_time") or getattr(model, "sample_time", None)
    step = float(number("sample_time", step, at_least=0.0))
    return float(np.log(1.0 / condition.parameters["contraction"]) / (2.0 * step))


def _binding(answer: Answer) -> tuple[Share, ...]:
    if answer.condition is None:
        return ()
    # The LMI that makes P, or Q, positive binds whatever else does.
    names = [
        lmi.name
        for lmi in answer.condition.lmis
        if lmi.strict and "positive definite" not in lmi.name
    ]
    return binding_shares(answer.condition, answer.multipliers, *names)


def _premises(question: _Question, model: Any, steps: int) -> tuple[PremiseRelief, ...]:
    if not isinstance(model, TSModel):
        return ()
    reliefs = []
    for number_, premise in enumerate(model.premises):
        if premise.lower == premise.upper:
            continue

        def narrower(share: Fraction, number_: int = number_) -> TSModel:
            return with_narrower_premise(model, number_, share)

        share = question.largest_share(narrower, steps)
        middle, half = (premise.lower + premise.upper) / 2, (premise.upper - premise.lower) / 2
        half_width = half * (1 if share is None else share)
        reliefs.append(
            PremiseRelief(
                premise.name,
                premise.unit,
                None if share is None else float(share),
                float(middle - half_width),
                float(middle + half_width),
            )
        )
    # The premise that costs most is the one that has to be narrowed least.
    reliefs.sort(key=lambda relief: -1.0 if relief.share is None else relief.share, reverse=True)
    return tuple(reliefs)


def _rules(binding: tuple[Share, ...], model: Any) -> tuple[str, ...]:
    """Return where the rules lie that the labels of the items name."""
    if not isinstance(model, TSModel) or not model.premises:
        return ()
    text = " ".join(share.label for share in binding[:NAMED])
    named = {int(a or b) for a, b in re.findall(r"(?:rules?|vertex|and) (\d+)|h(\d+)", text)}
    return tuple(
        f"rule {k}: " + ", ".join(_corner(model, k - 1, p) for p in range(len(model.premises)))
        for k in sorted(named)
        if k <= len(model.rules)
    )


def _corner(model: TSModel, rule: int, number: int) -> str:
    premise = model.premises[number]
    unit = "" if premise.unit == "-" else f" {premise.unit}"
    return f"{premise.name} = {float(premise.corners[model.rules[rule][number]]):.4g}{unit}"
