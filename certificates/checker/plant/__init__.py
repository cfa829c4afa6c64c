"""What the checker knows about plants: equations as text, their identities and their ranges.

    expression, graph   text -> nodes of a graph, by a strict grammar; nothing is executed
    derivative          partial derivatives and substitution in the graph
    polynomial          polynomials and quotients over opaque atoms, exact;  atoms: what they are
    identity            whether two nodes are the same function: sin^2 + cos^2 = 1 and the like
    decimal_interval    outward-rounded intervals on integers over 10^36
    elementary, exponential   sin, cos, atan, ...; exp, log, erf, ... on such intervals
    table               tables as splines
    exact_interval      the same without rounding, for bounds that are attained
    evaluate            nodes over boxes;  quotient_form: N / x^k where x may vanish
    linear_sum          the same for a sum in the place of x
    ranges              bounds and signs over a box, by bisection
    reading             the plant of a certificate as nodes;  trim: the law's against the plant's
    plant_file, table_file, plant_units   the plant against the files it is said to come from
    vertices            entries that are multi-affine in the premises, and their corners

Standard library alone; nothing is shared with the floor that derives models.
"""
