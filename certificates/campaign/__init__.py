"""Thousands of random simulations of a certified loop, inside and outside its certified class.

    loop      plant, law and claim as numbers, from the certificate's document alone
    motion    one run of the nonlinear loop, compared with every bound of the certificate
    runs      many runs, inside or beyond the certified class: ``run_campaigns``

No proof uses this code, and this code uses no result of a proof.
"""
