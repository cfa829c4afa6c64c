"""What several verbs run or read.

turbine                a turbine's design; a requirement that none meets is an answer
plant                  a plant's design or the proof of given gains; no gains is an answer
earlier_certificate    an earlier certificate to compare with, and a tolerance
"""
