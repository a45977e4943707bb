#!/usr/bin/env bash
# python_test.sh PYTHON FILE : runs the tests of a file by pytest; exits with 77 where pytest, numpy or all that the file
# asks for is missing, and says what.
set -uo pipefail
python=$1 file=$2
for module in numpy pytest; do
  "$python" -c "import $module" 2>/dev/null || { echo "skipped: $python has no $module (Debian: python3-$module)"; exit 77; }
done
output=$("$python" -m pytest -q -rs -p no:cacheprovider "$file" 2>&1)
status=$?
printf '%s\n' "$output"
last=${output##*$'\n'}
if ((status == 0)) && [[ $last == *skipped* && $last != *passed* ]]; then exit 77; fi
exit "$status"
