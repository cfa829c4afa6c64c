"""The front door: `takagi VERB`, one verb a file, thin; the work is done on the floors below.

    main, verbs       the dispatcher and its table; neither imports a verb that was not asked for
    errors            the boundary: every exception becomes one clear message and an exit status
    command           runs a typer command as a verb, so that all verbs fail and exit alike
    progress          what is going on, on standard error, for work that takes over two seconds

To add a verb, write `cli/<verb>.py` with `run(arguments) -> exit status` and one line in `verbs`.
"""
