"""The second checker's claims that a plant is contained in its model.

expression, algebra    expressions as trees; whether two trees are the same function
interval               ranges of trees over boxes
plant                  a plant and its embedding, as trees, with exact vertices; the loop of a model
law_fits               gains go with what the law knows; integrals that a law computes
embedding              claim: the plant is the blend of its vertices
secant                 claim: the plant's deviation from rest is a blend of its vertices
tracking               claim: an output converges to its reference
blend                  claim: two actuators that share one effort give the plant's equations
"""
