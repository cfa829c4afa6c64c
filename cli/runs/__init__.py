"""Work that several verbs share: making designs, and reading earlier certificates.

makers                 a maker of designs for each kind of model, and the choice between them
turbine                makes a turbine's design, or says why there is none
plant                  makes a plant's design, or the proof of given gains
previous_certificate   a previous certificate to compare with, and a tolerance
"""
