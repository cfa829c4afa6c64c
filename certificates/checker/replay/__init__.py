"""The whole check of one file.

Hashes and given files are compared, and each claim is replayed by the function of its kind.
"""
