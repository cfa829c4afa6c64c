"""Certificates of conic problems from other programs: a solution, a bound, or a contradiction."""
