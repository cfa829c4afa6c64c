"""One kind of claim a file: ``check_<kind>(claim, family, where) -> Claim``, its formula on top.

Each takes the loop from the certificate's model and gains (``family``) and from the claim only the
evidence.  The table of kinds stands in ``takagi.certificates.checker.replay.claim_kinds``.
"""
