#!/usr/bin/env python3
"""count_tests.py FOLDER: reads the test results (JUnit XML) below FOLDER, tells what failed and why,
and ends with the line 'N passed, N failed'. Exits 1 when a test failed or none ran."""

import pathlib
import sys
import xml.etree.ElementTree as ElementTree


def text_of(node):
    """Message and contents of a <failure>, <error> or <skipped>."""
    parts = (node.get("message", "").strip(), (node.text or "").strip())
    if parts[1].startswith(parts[0]):
        return parts[1]
    return "\n".join(part for part in parts if part)


def read_cases(path):
    """Yields (name, outcome, text) for each test case of a file."""
    try:
        root = ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        yield path.name, "failed", f"{path}: not a test result: {error}"
        return
    for case in root.iter("testcase"):
        name = f"{case.get('classname', '')}.{case.get('name', '')}"
        problems = case.findall("failure") + case.findall("error")
        skipped = case.find("skipped")
        if problems:
            yield name, "failed", "\n".join(map(text_of, problems))
        elif skipped is not None or case.get("result") == "skipped":
            yield name, "skipped", "" if skipped is None else text_of(skipped)
        elif case.get("status") != "notrun":
            yield name, "passed", ""


def read_results(path):
    """Yields (name, outcome, text) for each test of a file."""
    for name, outcome, text in read_cases(path):
        if path.name.startswith("rostest-"):
            # One case a program, whose own results have a file too; it fails when they have none.
            if outcome != "failed":
                continue
        yield f"{path.parent.name}: {name}", outcome, text


def main(folder):
    paths = sorted(pathlib.Path(folder).rglob("*.xml"))
    results = [result for path in paths for result in read_results(path)]
    counts = {"passed": 0, "failed": 0, "skipped": 0}
    for name, outcome, text in results:
        counts[outcome] += 1
        if outcome != "passed":
            print(f"\n{outcome.upper()} {name}")
            print("".join(f"    {line}\n" for line in text.splitlines()[:40]), end="")
    print()
    if not results:
        print(f"no test ran: there are no results in {folder}")
    skipped = f", {counts['skipped']} skipped" if counts["skipped"] else ""
    print(f"{counts['passed']} passed, {counts['failed']} failed{skipped}", flush=True)
    return 1 if counts["failed"] or not counts["passed"] else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
