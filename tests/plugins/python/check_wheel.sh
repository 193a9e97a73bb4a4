#!/bin/sh
# `pip wheel .`, into a virtual environment of its own, and tests on what is installed there.
# Usage: check_wheel.sh PYTHON BUILD      PYTHON: of tools/dev/python_tools; BUILD: folder that is kept, so that the next is fast
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../.." && pwd)
python=$1 build=$2
[ -x "$python" ] && "$python" -c "import scikit_build_core" 2>/dev/null ||
  { echo "skipped: scikit-build-core is not installed (tools/dev/python_tools)"; exit 77; }
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
# The name that CMake finds by itself, so that ccache knows the library from the build before: Python has another of its own.
CXX=${CXX:-/usr/bin/c++} "$python" -m pip --disable-pip-version-check wheel --quiet --no-build-isolation --no-deps -w "$out" \
  --config-settings=build-dir="$build" --config-settings=cmake.define.VOLCAUSTIC_WERROR=ON "$root"
/usr/bin/python3 -m venv --system-site-packages "$out/environment"
"$out/environment/bin/pip" --disable-pip-version-check install --quiet --no-deps --no-index "$out"/volcaustic-*.whl
cd "$out"
"$out/environment/bin/python" -c "
import volcaustic
assert volcaustic.__file__.startswith('$out'), volcaustic.__file__
print('volcaustic', volcaustic.__version__)"
"$here/run_pytest.sh" "$out/environment/bin/python" "$here/test_session.py" "$here/test_files.py"
