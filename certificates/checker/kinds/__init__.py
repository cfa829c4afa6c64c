"""One file for each kind of claim, with its formula and ``check_<kind>(claim, loop, where)``.

The loop is read from the certificate's model and gains; the claim has only the
evidence.  The table of all kinds is in ``takagi.certificates.checker.replay.claim_kinds``.
"""
