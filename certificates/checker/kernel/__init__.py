"""Code that every check uses.

reader        strict JSON, numbers as written;  refusal: the exceptions for a bad file
refused_entry, entry_path   at which place of the file a number is refused
definite      definiteness of integer matrices
matrices      exact matrices: integers over one denominator
family        the loop as exact matrices, and the blends that stand for all of it
model_loop    the loop that model and gains of a file make;  blends: those a claim is shown for
claim_kinds   the function that replays each kind of claim
certificate   the whole file: hashes, every claim by its kind, the verdict on all of them
result        verdicts, and what the check of a claim or of a file returns
"""
