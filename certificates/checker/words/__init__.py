"""Sentences of the verdicts, written after all verdicts are final; short ones stand in their kind.

Numbers are rounded in the direction that keeps the sentence true.
"""
