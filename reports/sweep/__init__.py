"""The files of a finished sweep or campaign: a page with tables, data, and figures.

    maps         a sweep of a law over its parameters
    campaigns    random runs compared with a certificate

Importing this package imports nothing heavy: its modules are imported where they are used.
"""
