"""The command line: one module per subcommand, imported when it is called.

A subcommand is a module with ``add(parser)``, which declares its arguments on an
`argparse.ArgumentParser`, and ``run(args)``, which returns the exit code; one row in
`ffdstudio.cli.main.COMMANDS` makes it known.
"""
