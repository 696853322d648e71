# Commands for development; `just` lists them (https://just.systems).

# Formatting, lints and unit tests
quick:
    scripts/test --quick

# Everything that CI runs
test:
    scripts/test

# One check by another program, such as `just verify quality`
verify *names:
    .venv/bin/python scripts/verify {{names}}

# The pages of docs/ as a book
book:
    mdbook build

# Fuzzes one reader for some seconds, such as `just fuzz cgns 120`
fuzz target seconds="120":
    fuzz/seeds.sh
    cargo +nightly fuzz run {{target}} -- -max_total_time={{seconds}}

# The program for this machine as an archive
archive:
    packaging/program.sh "$(rustc -vV | sed -n 's/^host: //p')"

# The Python wheel for this machine
wheel:
    python/wheel.sh --zig --compatibility manylinux2014
