"""A kind of claim about the loop in one class: theorem, fields, obligations, sentence, figures.

``takagi.certificates.checker.replay.claim_kinds`` lists all kinds.
"""
