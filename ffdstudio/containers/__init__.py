"""Strict readers of the containers that strangers' files are made of: JSON, TOML, ``.npy``.

Each knows less than the library beneath it, so that there is less to go wrong: no size is
believed, nothing is nested without an end, and whatever is wrong is one `InputError`.
"""
