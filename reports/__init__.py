"""The outputs of takagi: gain files, margins, figures, HTML, LaTeX, and CI formats.

    sections/         the HTML reports: one folder for turbines, one for plants
    page/             the elements of every HTML page
    appendix/         the LaTeX appendix
    figures/          figures from plain arrays
    loops/            a design's loops as numbers, used by all outputs
    margins/          robustness of linear loops
    gains_file/       the gain file
    simulation/       laws in the same winds, a plant from chosen starts
    sweep/            the files of a finished sweep, or of a campaign of random runs
    baseline/         comparison of a certificate with an earlier one
    ci_formats        the results of a check as JUnit, SARIF and Markdown
    design_folder     the folder that ``takagi design`` leaves, and the appendix's
    output            write a file or a folder completely or not at all; tables as CSV

Importing this package imports nothing else.
"""
