#!/usr/bin/env bash
# Builds a wheel for Python 3.10 and later into python/dist. On Linux it runs with the C library of this machine and later
# ones; --zig (pip install ziglang) makes one for older systems: python/wheel.sh --zig --compatibility manylinux2014
set -euo pipefail
cd "$(dirname "$0")"
exec maturin build --release --strip --out dist "$@"
