#!/usr/bin/env python3
"""Writes the model files of the golden cases, and for each its case.json: purpose, main file, options,
and what the figures must be whatever expected.json says. Needs nothing but Python's standard library,
and writes the same bytes everywhere:

    python3 tests/cases/make.py [FOLDER]

FOLDER is this script's own where it is left out. expected.json is not written here: it is what a
conversion was seen to give (UPDATE_CASES=1 cargo test -p meshcolor-tests --test cases).
"""

import json
import sys
from pathlib import Path

sys.dont_write_bytecode = True

import extremes
import formats
import refusals
import surfaces


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    cases = {}
    for group in (surfaces, formats, extremes, refusals):
        group.add(cases)
    for name, (purpose, files, expect, *settings) in cases.items():
        place = folder / name
        place.mkdir(parents=True, exist_ok=True)
        for file, data in files.items():
            (place / file).write_bytes(data)
        options, limits = (settings + [{}, {}])[:2]
        case = {"purpose": purpose, "main": next(iter(files)), "options": options, "limits": limits, "expect": expect}
        text = json.dumps(case, indent=1, ensure_ascii=False)
        (place / "case.json").write_text(text + "\n", encoding="utf-8")


main()
