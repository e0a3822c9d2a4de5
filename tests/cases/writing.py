"""Writes cases: a folder each with the model's files and `case.json`."""

import json


def write(folder, cases):
    """`cases` are, by name: purpose, files (the main one first), expectations, options, limits."""
    for name, (purpose, files, expect, *settings) in cases.items():
        place = folder / name
        place.mkdir(parents=True, exist_ok=True)
        for file, data in files.items():
            (place / file).write_bytes(data)
        options, limits = (settings + [{}, {}][len(settings) :])[:2]
        case = {"purpose": purpose, "main": next(iter(files)), "options": options, "limits": limits, "expect": expect}
        text = json.dumps(case, indent=1, ensure_ascii=False)
        (place / "case.json").write_text(text + "\n", encoding="utf-8")
