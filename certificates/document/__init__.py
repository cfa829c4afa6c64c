"""The certificate file and its members.

certificate_file     the file: model, law, claims as decimals, hashes, provenance
model_data           a Takagi-Sugeno model and its law
plant_text           a plant's numbers, expressions and tables; a blend of two actuators
plant_embedding      a plant, its model and observer, and the claims that link them
plant_text, plant_tables  a plant's numbers, expressions and tables
"""
