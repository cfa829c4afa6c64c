"""What leaves the house: gain files, margins, figures, HTML, LaTeX, and CI formats.

    sections/         the HTML reports: one room for turbines, one for plants
    page/             what every HTML page is made of
    appendix/         the LaTeX appendix
    figures/          one figure a file, from plain arrays
    loops/            a design's loops as numbers, for all of these
    margins/          robustness of linear loops
    gains_file/       the gain file
    simulation/       laws in the same winds, a plant from chosen starts
    campaign/         campaigns of random runs as tables, figures and files
    maps/             what a finished sweep leaves
    baseline/         a certificate against an earlier one
    csv_text          tables as CSV
    ci_formats        the results of a check as JUnit, SARIF and Markdown
    design_folder     the folder that ``takagi design`` leaves, and the appendix's
    output            write a file or a folder whole or not at all
    system_errors     what the operating system's refusals mean, and what to do

Importing this package imports nothing else.
"""
