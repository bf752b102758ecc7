"""Journals: runs on disk that go on after the end of their process.

runs.py      a run with a journal: begun, driven, resumed
resuming.py  the requests that were under way when the process died
journal.py   what is written during a run, and when
records.py   the kinds of records, and their bytes
folder.py    the files of a journal, and its lock
past.py      the records in the form of a run
opening.py   a journal in the debugger, which asks no world
"""
