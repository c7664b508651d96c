"""Methods that make a cost small: one file for each; `catalog.methods` lists them.

A method asks the problem for trials and reports each iterate to it. The problem may end it at
a report by an exception (a refinement is due, the budget is spent, the user stops): methods
need no settings for that; by itself it returns why it ended. The memory outlives the
method: it is carried through refinements.
"""
