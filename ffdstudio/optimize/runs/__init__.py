"""A study and its run: from level to level, recorded, stopped and resumed."""
