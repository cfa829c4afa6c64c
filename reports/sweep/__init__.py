"""What a finished sweep leaves in its folder: figures, tables, data and a page, one law a file.

    paper_pages       the laws of the paper over the overlaps of their coupling filter
    coherent_pages    the coherent law over its parameters
    table             points as CSV and JSON, with units

Importing this package imports nothing heavy: names are looked up when they are used.
"""
