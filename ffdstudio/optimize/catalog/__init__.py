"""The catalog: one line for each objective, constraint, method, metric and indicator.

The form of the window, the schema of case files, messages, help and the reference page are made
from these rows.
"""
