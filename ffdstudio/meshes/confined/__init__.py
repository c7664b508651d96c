"""Readers of last resort, each in a process of its own with limits of time and memory.

`asking` starts and watches the process, `child` is what it does, `wire` the messages between.
"""
