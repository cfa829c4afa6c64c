"""The members of the claim about the equilibria of a loop."""

from __future__ import annotations

from takagi.certificates.checker.turbine.members import Members, plain

OF: dict[str, Members] = {"equilibrium": {"cells": plain("wind rests")}}
