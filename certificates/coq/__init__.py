"""A certificate's matrices for the proof assistant Coq (Rocq).

definite.v    the decision by computation, and its proof
coq_export    the file: all matrices of a certificate, and shorter numbers that prove them
"""
