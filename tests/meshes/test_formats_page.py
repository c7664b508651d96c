"""The page of formats is what the tests say, and leaves out no format."""

from __future__ import annotations

from pathlib import Path

from ffdstudio.meshes.formats import FORMATS
from tests.meshes import formats_page
from tests.meshes.test_formats import TABLE


def test_the_page_of_formats_is_not_stale():
    stale = "make it anew: python -m tests.meshes.formats_page"
    assert formats_page.PAGE.read_text() == formats_page.page(), stale


def test_every_format_is_checked_or_said_to_be_read_only():
    checked = {*formats_page._by_format(), *formats_page.OWN, *formats_page.READ_ONLY}
    assert {row.name for row in FORMATS} == checked
    for files, _ in formats_page.OWN.values():
        assert all((Path(__file__).parent / file).exists() for file in files)


def test_every_row_of_the_table_counts_in_one_format():
    assert sum(map(len, formats_page._by_format().values())) == len(TABLE)
