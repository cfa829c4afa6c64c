"""Sentences of the verdicts, made when all of them stand: a file for each kind of claim.

Their numbers are rounded to the side on which the sentence stays true.
"""
