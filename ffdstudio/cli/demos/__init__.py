"""The cases of ``ffdstudio demo``, one a file: each writes into a folder and returns figures."""
