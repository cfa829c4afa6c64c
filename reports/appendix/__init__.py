"""The LaTeX appendix of a design: derivation, law, theorem, LMIs, gains, certificate, margins."""
