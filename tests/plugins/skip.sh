# Sourced by the checks: ends with 77, which ctest reports as skipped, when a host is not installed.
need() {
  command -v "$1" >/dev/null 2>&1 || { echo "skipped: $1 is not installed"; exit 77; }
}
