"""The law as C99 without dependencies.

words        reserved names of C and C++, and the helper functions that a law may need
expressions  a formula in C
sample       one sample of the law in C
source       header and source of a law
accompanying_files   self-test, example and README
comparison   whether a C file still is the law of a gain file
target       the files that `takagi export --to c` writes
"""
