"""The command line `takagi VERB`: one file per verb; other packages do the work.

    verbs/              one verb a file
    options/            the options, and their translation into settings
    runs/               a design or a proof run for several verbs
    terminal/           verdicts, summaries and tables as they are printed
    main, verb_table    the dispatcher and its table; neither imports a verb that was not asked for
    errors              error handling: every exception becomes one clear message and an exit status
    command             runs a typer command as a verb, so that all verbs fail and exit alike
    output_place        checks before long work that a result can be written
    progress            progress on standard error, for work that takes over two seconds

To add a verb, write `cli/verbs/<verb>.py` with `run(arguments) -> exit status` and one line in
`cli/main.py`.
"""
