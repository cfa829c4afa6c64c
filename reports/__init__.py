"""What leaves the house: gain files, margins, figures, HTML, LaTeX, and CI formats.

    output         write a file or a folder whole or not at all
    system_errors  what the operating system's refusals mean, and what to do
    ci_formats     the results of a check as JUnit, SARIF and Markdown
    baseline       a certificate against an earlier one

Importing this package imports nothing else.
"""
