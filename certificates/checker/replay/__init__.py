"""The whole check of one file.

certificate     hashes and given files are compared, each claim is replayed; the whole verdict
claim_kinds     the function that replays each kind of claim
removed_kinds   a file with a claim of a kind that is no longer read is refused
model_loop      the loop of a file's model and gains
containment     a claim about a model needs the claim that the model contains its plant
"""
