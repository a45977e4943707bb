"""Checks a JUnit file against the rules of Jenkins' schema for xUnit (junit-10.xsd), which are written down here once more,
independently of the writer, and whether its totals match its content. check_junit.py FILE [tests failures errors]"""
import sys
import xml.etree.ElementTree as ElementTree

ATTRIBUTES = {
    "testsuites": ({"name", "time", "tests", "failures", "disabled", "errors"}, set()),
    "testsuite": ({"name", "tests", "failures", "errors", "group", "time", "skipped", "timestamp", "hostname", "id",
                   "package", "file", "log", "url", "version"}, {"name", "tests"}),
    "testcase": ({"name", "assertions", "time", "classname", "status", "class", "file", "line", "group", "url"}, {"name"}),
    "properties": (set(), set()),
    "property": ({"name", "value"}, {"name", "value"}),
    "skipped": ({"type", "message"}, set()),
    "error": ({"type", "message"}, set()),
    "failure": ({"type", "message"}, set()),
}
CHILDREN = {"testsuites": ["testsuite"], "testsuite": ["properties", "testcase"], "properties": ["property"],
            "testcase": ["skipped", "error", "failure"]}


def check(element):
    allowed, required = ATTRIBUTES[element.tag]
    assert set(element.attrib) <= allowed, (element.tag, set(element.attrib) - allowed)
    assert required <= set(element.attrib), (element.tag, required - set(element.attrib))
    kinds = [child.tag for child in element]
    order = CHILDREN.get(element.tag, [])
    assert all(kind in order for kind in kinds), (element.tag, kinds)
    assert kinds == sorted(kinds, key=order.index), f"{element.tag}: the children are not in the schema's order"
    assert kinds.count("properties") <= 1
    for child in element:
        check(child)


def totals(element):
    cases = element.findall(".//testcase")
    count = {kind: sum(case.find(kind) is not None for case in cases) for kind in ("failure", "error", "skipped")}
    assert element.get("tests") == str(len(cases))
    assert element.get("failures") == str(count["failure"]) and element.get("errors") == str(count["error"])
    assert element.get("skipped", str(count["skipped"])) == str(count["skipped"])
    return len(cases), count["failure"], count["error"]


def main(path, *expected):
    root = ElementTree.parse(path).getroot()
    assert root.tag == "testsuites"
    check(root)
    for suite in root:
        totals(suite)
    found = totals(root)
    assert not expected or found == tuple(map(int, expected)), found
    return root


if __name__ == "__main__":
    main(*sys.argv[1:])
