#!/usr/bin/env python3
"""Writes the model files of the golden cases, and for each its case.json: purpose, main file, options,
and what the figures must be whatever expected.json says. Needs nothing but Python's standard library,
and writes the same bytes everywhere:

    python3 tests/cases/make.py [FOLDER]

FOLDER is this script's own where it is left out. expected.json is not written here: it is what a
conversion was seen to give (UPDATE_CASES=1 cargo test -p meshcolor-tests --test cases).
"""

import sys
from pathlib import Path

sys.dont_write_bytecode = True

import extremes
import formats
import refusals
import surfaces
import writing


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    cases = {}
    for group in (surfaces, formats, extremes, refusals):
        group.add(cases)
    writing.write(folder, cases)


main()
