"""What can be said of a check itself.

trusted_lines    the checker's files and lines of code that a verdict ran through
two_checkers     both checkers on one certificate, and whether they agree
"""
