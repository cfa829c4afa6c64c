"""The law as C99 without dependencies.

words        names that C and C++ take, and the helper functions that a law may need
expressions  a formula in C
program      one sample of the law in C
source       header and source of a law
companions   self-test, example and README
target       what `takagi export --to c` writes
"""
