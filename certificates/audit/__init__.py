"""Information about a check itself.

trusted_lines    the files and lines of the checker that a verdict used
two_checkers     both checkers on one certificate, and whether they agree
"""
