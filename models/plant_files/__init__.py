"""Reading a plant file: from TOML entries to a Plant.

loader             the file as a whole
table_entry        a table that it names
blending_section, design_section    its sections ``[blending]`` and ``[design]``
entry_problem      what is wrong with a field, in words
"""
