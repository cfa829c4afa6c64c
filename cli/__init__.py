"""The front door: `takagi VERB`, one verb a file, thin; the work is done on the floors below.

    verbs/              one verb a file
    options/            what may be asked, and its translation into settings
    runs/               a design or a proof run for several verbs
    terminal/           verdicts, summaries and tables as they are printed
    main, verb_table    the dispatcher and its table; neither imports a verb that was not asked for
    errors              the boundary: every exception becomes one clear message and an exit status
    command             runs a typer command as a verb, so that all verbs fail and exit alike
    output_place        whether a result can be written, found out before the long work
    progress            what is going on, on standard error, for work that takes over two seconds

To add a verb, write `cli/verbs/<verb>.py` with `run(arguments) -> exit status` and one line in
`cli/verb_table.py`.
"""
