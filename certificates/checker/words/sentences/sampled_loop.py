"""What a proved claim of kind ``sampled-loop`` says."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.loop.box_of_validity import bounded_inputs
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.ellipsoid_size import rounded_size
from takagi.certificates.checker.words.loop_words import deviations, granted, undisturbed
from takagi.certificates.checker.words.rounded import at_least, exactly


def said(
    name: str, loop: PolytopicLoop, step: Fraction, P: Matrix, level: Fraction, alpha: Fraction
) -> tuple[str, str]:
    """Return name and sentence."""
    falls = f"falls as exp(-{at_least(2 * alpha, 6)} t)" if alpha else "falls"
    inputs = f" ({', '.join(loop.inputs)})" if loop.inputs else ""
    gains = f"{len(loop.K)} gains" if len(loop.K) > 1 else "one gain"
    blends = f", along every blend of {loop.rules} rules and of {gains}"
    alone = loop.rules == len(loop.K) == 1
    limited = any(side is not None for side in loop.box) or bool(bounded_inputs(loop))
    start = f"{{x'Px <= {exactly(level)}}}" if limited else "anywhere"
    assumed = granted(loop, disturbances_too=False)
    stays = (
        f"; between samples too the plant stays in the model's box{assumed}"
        f"{rounded_size(P, level, loop.states)}"
        if limited
        else assumed
    )
    return name, (
        f"with a sample every {exactly(step)} s, the command u = -Kx{inputs} held until the next "
        f"and computed in no time: from {start}, V = x'Px {falls} from sample to sample"
        f"{undisturbed(loop)}{'' if alone else blends}{stays}{deviations(loop, 'xu')}"
    )
