"""The files of a finished sweep: figures, tables, data and a page.

    effort_sharing_pages                 the effort-sharing law over its parameters: all its files
    effort_sharing_effects, effort_sharing_trade_off, effort_sharing_rows
                                         its figures, and what they read of a point
    published_pages                      a published law over its overlaps: all its files
    published_overlaps, published_winds, published_rows
                                         its figures, and what they read of a point
    table                                points as CSV and JSON, with units

Importing this package imports nothing heavy: names are looked up when they are used.
"""
