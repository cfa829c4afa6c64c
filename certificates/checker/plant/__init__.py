"""Plants in the checker: equations as text, their identities and their ranges.

    expression, graph   text -> nodes of a graph, by a strict grammar; no text is executed as code
    derivative          partial derivatives and substitution in the graph
    polynomial, atoms   exact polynomials and quotients; their variables, called atoms
    identity            whether two nodes are the same function, as sin^2 + cos^2 = 1
    table               tables as splines
    evaluate            ranges of nodes over boxes
    quotient_form       N / x^k where x may vanish;  linear_sum: a sum in place of x
    ranges              bounds and signs over a box, by bisection
    reading             the plant of a certificate as nodes;  trim: the trims of law and plant
    balls               numbers that are not decimals, and rests that were solved for
    vertices            entries that are multi-affine in the premises, and their corners
    sector_embedding, secant_embedding    the claims that the model contains the plant
    blend, effort_blend                   the claim that two actuators share one effort

Only the standard library is used; no code is shared with the derivation of models.
"""
