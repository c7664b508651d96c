"""Pages of the reference that are made from the program itself, at each build.

``reference/commands.md`` from the parsers of the command line, ``reference/keys.md`` from the
table of actions that menus and shortcuts are made from.
"""

import os
from pathlib import Path

from sphinx.application import Sphinx


def setup(app: Sphinx) -> dict[str, bool]:
    """Have the pages written before Sphinx looks for them."""
    app.connect("builder-inited", write_pages)
    return {"parallel_read_safe": True}


def write_pages(app: Sphinx) -> None:
    """Write the generated pages beside the written ones."""
    folder = Path(app.srcdir) / "reference"
    for name, text in (("commands.md", commands()), ("keys.md", keys())):
        path = folder / name
        if not path.exists() or path.read_text() != text:
            path.write_text(text)


def commands() -> str:
    """Each command with the words of its own ``--help``."""
    os.environ["COLUMNS"] = "96"
    from ffdstudio.cli import main

    parts = ["# Commands\n", "What `ffdstudio COMMAND --help` says.\n"]
    for name in main.COMMANDS:
        parser = main.command_parser(name)
        parts.append(f"## {name}\n\n```text\n{parser.format_help().rstrip()}\n```\n")
    return "\n".join(parts)


def keys() -> str:
    """Everything the window's menus hold, with its keys."""
    from ffdstudio.gui.action_table import ROWS

    rows = ["# Actions and keys\n", "| menu | action | keys | |", "|---|---|---|---|"]
    for row in ROWS:
        menu, pressed = row.menu.replace("&", ""), ", ".join(f"`{key}`" for key in row.keys)
        rows.append(f"| {menu} | {row.plain} | {pressed} | {row.tip.replace('|', '/')} |")
    return "\n".join(rows) + "\n"
