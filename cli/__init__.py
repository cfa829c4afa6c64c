"""The command line `takagi VERB`: one file per verb; other packages do the work.

    verbs/              one verb a file
    options/            the options, and their translation into settings
    runs/               a design or a proof run for several verbs
    terminal/           verdicts, summaries and tables as they are printed
    main                the dispatcher and its table; it imports no verb that was not asked for
    command             runs a typer command as a verb: every exception becomes one clear message
    output_place        checks before long work that a result can be written
    progress            progress on standard error, for work that takes over two seconds

To add a verb, write `cli/verbs/<verb>.py` with `run(arguments) -> exit status` and one line in
`cli/main.py`.
"""
