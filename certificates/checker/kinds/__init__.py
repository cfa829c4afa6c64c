"""One class a kind of claim about the loop of model and gains: theorem, fields, obligations, sentence.

``takagi.certificates.checker.replay.claim_kinds`` lists all kinds.
"""
