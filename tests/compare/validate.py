"""validate.py [--every-key] SCHEMA FOLDER... : an independent validator (python3-jsonschema) accepts every summary.json below
the folders, and refuses a summary with a key that the schema does not describe, or without a key that it does describe. With
--every-key each key of the schema must have a value in one of them."""
import copy
import json
import sys
from pathlib import Path

import jsonschema

every_key = sys.argv[1] == "--every-key"
schema_file, *folders = sys.argv[2 if every_key else 1:]
schema = json.load(open(schema_file, encoding="utf-8"))
jsonschema.Draft4Validator.check_schema(schema)
validator = jsonschema.Draft4Validator(schema)


def check(holds, message):
    if not holds:
        sys.exit(message)


def parts(node):
    """Every object of a fixed form in the schema."""
    if isinstance(node, dict):
        if "properties" in node and "type" in node:
            yield node
        for value in node.values():
            yield from parts(value)
    elif isinstance(node, list):
        for value in node:
            yield from parts(value)


forms = list(parts(schema))
check(len(forms) >= 8, f"only {len(forms)} forms")
for form in forms:
    check(form["additionalProperties"] is False, f"{form['description']}: allows keys that nobody describes")
    for key, value in form["properties"].items():
        check(value.get("description") or "$ref" in value, f"{key} is not described")

seen = set()
files = [file for folder in folders for file in sorted(Path(folder).glob("**/summary.json"))]
for file in files:
    summary = json.loads(file.read_text("utf-8"))
    for error in validator.iter_errors(summary):
        sys.exit(f"{file}: {list(error.absolute_path)}: {error.message}")
    for key, value in summary.items():
        if value not in ([], {}, "", None):
            seen.add(key)
check(len(files) > 40, f"only {len(files)} summaries")
# A key that no summary has was never validated. The commit may be missing, because the folder may be in no repository.
unseen = set(schema["properties"]) - seen - {"commit"}
check(not (every_key and unseen), f"no summary has a value for {sorted(unseen)}")

good = json.loads(files[0].read_text("utf-8"))
for key in good:
    damaged = copy.deepcopy(good)
    del damaged[key]
    check(not validator.is_valid(damaged), f"a summary without {key} is accepted")
for change in ({"colour": 1}, {"date": "yesterday"}, {"commit": "HEAD"}, {"format": 2}, {"verdict": "maybe"}):
    check(not validator.is_valid({**good, **change}), f"accepted: {change}")
print(f"{len(files)} summaries")
