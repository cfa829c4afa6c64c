"""Vertices and gains as a certificate states them, and the loop that they close."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel import reader
from takagi.certificates.checker.kernel.reader import read_stack
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, Stack

SHAPES = {"A": "nn", "B": "nm", "C": "pn", "D": "pm", "E": "nq"}


def vertices(model: Any, where: str) -> PolytopicLoop:
    """Return the model of kind ``takagi-sugeno``; ``PolytopicLoop`` says what may be left out."""
    stacks: dict[str, Any] = {
        x: read_stack(model, x, where) for x in SHAPES if x == "A" or x in model
    }
    axes = [pair for x in stacks for pair in zip(SHAPES[x], stacks[x][0].shape, strict=True)]
    sizes, counts = dict(axes), {len(stack) for stack in stacks.values()} | {1}
    if any(sizes[axis] != size for axis, size in axes) or len(counts) > 2:
        raise CertificateError(f"{where}: {', '.join(stacks)} do not fit together")
    states = _different(model, "state_names", where, sizes["n"])
    members: dict[str, Any] = {x: _single(M) if x in "BD" else M for x, M in stacks.items()}
    if model.get("box", {}) != {}:
        # Imported here, as the next module: few matrices by themselves have a box or premises.
        from takagi.certificates.checker.loop.box_of_validity import read_box

        members["box"], members["other_box"] = read_box(model, states, where)
    if {"premises", "rules"} & model.keys():
        from takagi.certificates.checker.loop.product_weights import read_weights

        members["corners"], members["weights"] = read_weights(model, where, max(counts))
    return PolytopicLoop(
        **members,
        sample_time=_sample_time(model, where),
        states=states,
        inputs=_names(model, "input_names", sizes.get("m", 0), where),
        disturbances=_names(model, "disturbance_names", sizes.get("q", 0), where),
        stated_rules=max(counts),
    )


def closed_by(plain: PolytopicLoop, gains: Any, where: str) -> PolytopicLoop:
    """Return the loop with u = -sum_j g_j K_j x.

    Raises
    ------
    CertificateError : gains for other states, of another shape or sample time.
    """
    K = _single(read_stack(gains, "K", where))
    needed = (plain.B[0].shape[1] if plain.B else 0, plain.order)
    if K[0].shape != needed:
        raise CertificateError(f"{where}.K: {needed[0]} by {needed[1]} is needed, not {K[0].shape}")
    if _sample_time(gains, where) != plain.sample_time:
        raise CertificateError(f"{where}.sample_time is not the model's")
    states = _different(gains, "state_names", where, plain.order)
    inputs = _names(gains, "input_names", needed[0], where) or plain.inputs
    if states != plain.states or (plain.inputs and inputs != plain.inputs):
        raise CertificateError(f"{where}: states or inputs are not the model's, in its order")
    shared = True
    if plain.weights or {"premises", "rules"} & gains.keys():
        # Imported here, as in ``vertices``.
        from takagi.certificates.checker.loop.product_weights import shares_weights

        shared = shares_weights(plain, gains, where, several=len(K) > 1)
    # A law cannot evaluate weights that depend on its own command.
    circular = len(K) > 1 and not set(plain.inputs).isdisjoint(plain.scheduled_by or ())
    has_model_weights = shared and not circular and len(K) in (1, plain.rules)
    return replace(plain, K=K, inputs=inputs, shared_weights=has_model_weights)


def _names(model: Any, key: str, count: int, where: str) -> tuple[str, ...]:
    return _different(model, key, where, count) if count and key in model else ()


def _different(owner: Any, key: str, where: str, count: int) -> tuple[str, ...]:
    """Return this number of different names, each one line of text."""
    values = reader.member(owner, key, where)
    listed = values if isinstance(values, list) else []
    names = tuple(reader.text({key: value}, key, where) for value in listed)
    if len(names) != count or len(set(names)) != count:
        raise CertificateError(f"{where}.{key}: {count} different names are needed")
    return names


def _single(stack: Stack) -> Stack:
    """Return one matrix in the place of equal ones."""
    return stack[:1] if all(matrix == stack[0] for matrix in stack) else stack


def _sample_time(owner: Any, where: str) -> Fraction | None:
    stated = reader.member(owner, "sample_time", where)
    step = None if stated is None else reader.number(owner, "sample_time", where)
    if step is not None and step <= 0:
        raise CertificateError(f"{where}.sample_time: a positive number is needed")
    return step
