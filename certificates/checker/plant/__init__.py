"""What the checker knows about plants: equations as text, their identities and their ranges.

    expression, graph   text -> nodes of a graph, by a strict grammar; nothing is executed
    derivative          partial derivatives and substitution in the graph
    polynomial          polynomials and quotients over opaque atoms, exact;  atoms: what they are
    identity            whether two nodes are the same function: sin^2 + cos^2 = 1 and the like
    table               tables as splines
    evaluate            nodes over boxes;  quotient_form: N / x^k where x may vanish
    linear_sum          the same for a sum in the place of x
    ranges              bounds and signs over a box, by bisection
    reading             the plant of a certificate as nodes;  trim: the law's against the plant's
    vertices            entries that are multi-affine in the premises, and their corners
    sector_embedding, secant_embedding, effort_blend   the claims: the model contains the plant

Standard library alone; nothing is shared with the floor that derives models.
"""
