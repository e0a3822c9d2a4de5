#!/usr/bin/env python3
"""Writes the model files of the hard cases, and for each its case.json: purpose, main file, options, and what
the figures must be whatever expected.json says. Standard library only, the same bytes everywhere:

    python3 tests/hard/make.py [FOLDER]

FOLDER is this script's own where it is left out. expected.json is not written here: it is what conversions
were seen to give (UPDATE_CASES=1 cargo test --release -p meshcolor-tests --test hard). The documents and pictures come
from the scripts of tests/cases.
"""

import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.append(str(Path(__file__).parent.parent / "cases"))

import blocks
import places
import shapes
import values
import writing


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    cases = {}
    for group in (blocks, shapes, places, values):
        group.add(cases)
    writing.write(folder, cases)


main()
