#!/bin/sh
# run_pytest.sh PYTHON FILE...: pytest without a cache beside the sources.
set -eu
python=$1
shift
"$python" -c 'import pytest' 2>/dev/null || { echo "skipped: python3-pytest is not installed for $python"; exit 77; }
exec "$python" -m pytest -q -p no:cacheprovider "$@"
