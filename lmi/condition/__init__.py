"""A linear matrix inequality as data, and its readers.

term, unknown         sums of L X R with constants, in blocks; what an LMI is solved for
evaluate, exact       values put into it: in floats, in exact numbers
shown_rate            which decay rate given values show
express, typeset      the same terms in cvxpy, in LaTeX or Markdown
region, uncertainty   regions for eigenvalues; norm-bounded uncertainty, as values
item_labels, selected_items    names of items; some of the items
"""
