"""Make some packages look absent, in this process and in those it starts.

Python imports this file at its start where PYTHONPATH names its folder. Absent are the
packages in the environment variable BLOCKED_MODULES, separated by commas.
"""

import os
import sys
from importlib.abc import MetaPathFinder

BLOCKED = set(os.environ.get("BLOCKED_MODULES", "").split(","))


class Blocker(MetaPathFinder):
    def find_spec(self, fullname, path=None, target=None):
        if fullname.partition(".")[0] in BLOCKED:
            raise ModuleNotFoundError(f"No module named {fullname!r}", name=fullname)


sys.meta_path.insert(0, Blocker())
