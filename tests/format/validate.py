"""validate.py SCHEMA FOLDER... : an independent validator (python3-jsonschema) accepts every *.toml below the folders, and
refuses files with mistakes, so that an editor can show them."""
import glob
import json
import sys
import tomllib

try:
    import jsonschema
except ImportError:
    print("skipped: python3-jsonschema is not installed")
    sys.exit(0)

schema = json.load(open(sys.argv[1]))
jsonschema.Draft4Validator.check_schema(schema)
validator = jsonschema.Draft4Validator(schema)
files = [file for folder in sys.argv[2:] for file in sorted(glob.glob(folder + "/**/*.toml", recursive=True))]
refused = 0
for file in files:
    for error in validator.iter_errors(tomllib.load(open(file, "rb"))):
        refused += 1
        deepest = min(error.context or [error], key=lambda e: -len(e.absolute_path))
        print(f"{file}: {list(deepest.absolute_path)}: {deepest.message}")
mistakes = [
    {},  # no format
    {"format": 1, "timing": {"visualization": "11.1 msec"}},
    {"format": 1, "timing": {"vsualization": "11.1 ms"}},
    {"format": 1, "run": {"strategies": ["phase-locked"]}},
    {"format": 1, "expect": [{"metric": "late", "max": 0}]},  # no signal
]
for mistake in mistakes:
    if validator.is_valid(mistake):
        refused += 1
        print("accepted:", mistake)
print(f"{len(files)} files, {refused} errors")
sys.exit(refused > 0 or not files)
