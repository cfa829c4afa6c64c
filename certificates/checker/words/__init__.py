"""Sentences of the verdicts, written after all verdicts are final; one file per kind of claim.

Numbers are rounded in the direction that keeps the sentence true.
"""
