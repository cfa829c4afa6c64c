"""The certificate file and its members.

certificate_file          the file: model, law, claims as decimals, with hashes
model_data                a Takagi-Sugeno model and its law
plant_text, plant_tables  a plant's numbers, expressions and tables
plant_embedding           a plant, the model derived from it, and the claim that ties them
plant_blend               a plant behind a blend, and the claim that the blend is the plant
provenance                configuration, versions, the solver's messages
"""
