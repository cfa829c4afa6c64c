"""Rigorous ranges of expressions on boxes, with evidence that can be replayed."""
