"""Templates of the LaTeX appendix, one a section; jinja2 with ``\\VAR{}`` and ``\\BLOCK{}``."""
