"""Plants in the checker: equations as text, their identities and their ranges.

    expression, graph   text -> nodes of a graph, by a strict grammar; nothing is executed
    derivative          partial derivatives and substitution in the graph
    polynomial          exact polynomials and quotients over opaque atoms;  atoms: their definitions
    identity            whether two nodes are the same function: sin^2 + cos^2 = 1 and the like
    table               tables as splines
    evaluate            nodes over boxes;  quotient_form: N / x^k where x may vanish
    linear_sum          the same for a sum in place of x
    ranges              bounds and signs over a box, by bisection
    reading             the plant of a certificate as nodes;  trim: the trims of law and plant
    balls               numbers that are no decimals, and rests that were solved for
    vertices            entries that are multi-affine in the premises, and their corners
    sector_embedding, secant_embedding, effort_blend   the claims: the model contains the plant

Only the standard library is used; no code is shared with the derivation of models.
"""
