"""What several verbs run or read.

makers                 one maker of designs for each kind of model, and which one it is
turbine                makes a turbine's design, or says why there is none
plant                  makes a plant's design, or the proof of given gains
earlier_certificate    an earlier certificate to compare with, and a tolerance
"""
