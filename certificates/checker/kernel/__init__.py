"""Code that every check uses.

reader        strict JSON, numbers as written;  refusal: the exceptions for a bad file
refused_entry at which place of the file a number is refused
definite      definiteness of integer matrices
matrices      exact matrices: integers over one denominator
result        verdicts, and what the check of a claim or of a file returns
"""
