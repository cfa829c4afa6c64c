"""An entry of the catalogue: a condition, who asks it, how it is posed, and what it costs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from takagi.lmi import Condition
from takagi.models import Premise, TSModel


@dataclass(frozen=True, slots=True)
class Sizes:
    """r rules, n states, m inputs, p outputs, q disturbances.

    The general ones are primes that differ, so that a number in a formula has one letter only.
    """

    r: int
    n: int
    m: int
    p: int
    q: int

    @property
    def letters(self) -> dict[int, str]:
        """Return number -> what a paper would print for it."""
        rules = "r" if self.r == MANY else str(self.r)
        named = {
            self.r: rules,
            self.n: "n",
            self.m: "m",
            self.p: "p",
            self.q: "q",
            2 * self.n: "2n",
            self.r * self.n: f"{rules} n",
        }
        return {number: letter for number, letter in named.items() if number > 2}


# So many rules stand for any number; fewer are printed as the number they are.
MANY = 5
GENERAL = Sizes(r=MANY, n=13, m=11, p=7, q=3)
# Where every rule, or every corner of the rates, has a formula of its own.
FEW = replace(GENERAL, r=2)
# Where the number of rules is a number in the formula.
THREE = replace(GENERAL, r=3, q=2)
# Where every state has a formula of its own.
SMALL = Sizes(r=2, n=2, m=1, p=1, q=1)
# Two premises of two corners each.
SQUARE = replace(GENERAL, r=4)

Pose = Callable[[Sizes], Condition]


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One form of a condition.

    Attributes
    ----------
    title : e.g. "Continuous time".
    pose : builds it at given sizes, solving nothing.
    variables, lmis : how many, as an expression in r, n, m, p, q; checked against what is posed.
        No expression for the LMIs means their number at the printed sizes.
    where : what the letters are that the page does not explain.
    sizes : at which it is printed.
    shown : False for a form that the page names, with its cost, and does not print.
    """

    title: str
    pose: Pose
    variables: str
    lmis: str = ""
    where: str = ""
    sizes: Sizes = GENERAL
    shown: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """One condition of the catalogue.

    Attributes
    ----------
    title : what it is called.
    question : what it answers, as a question in one sentence.
    call : the function that is called.
    builder : the function that poses it; "" where it is called through another.
    use : who may use it when, and what it does not say.
    cases : its forms.
    """

    title: str
    question: str
    call: str
    builder: str
    use: str
    cases: tuple[Case, ...]


def plant(sizes: Sizes, step: float | None = None) -> TSModel:
    """Return any model of these sizes; with two premises when there are four rules.

    Only its shapes show in a formula.
    """
    r, n, m, p, q = sizes.r, sizes.n, sizes.m, sizes.p, sizes.q
    random = np.random.default_rng(0)
    A = random.normal(size=(r, n, n)) / (4 * n) - (0 if step else 1) * np.eye(n)
    premises = [Premise("z1", 0, 1), Premise("z2", 0, 1)] if r == 4 else []
    return TSModel(
        A,
        random.normal(size=(r, n, m)),
        C=random.normal(size=(r, p, n)),
        E=random.normal(size=(r, n, q)),
        premises=premises,
        sample_time=step,
    )
