"""Rigorous ranges of expressions on boxes."""
