#!/usr/bin/env bash
# packaging/program.sh TARGET: builds the program for a target and packs it, with manual pages, completions and licences, into dist/.
# Linux programs are linked against glibc 2.17 by zig (pip install ziglang cargo-zigbuild).
set -euo pipefail
cd "$(dirname "$0")/.."
target=$1
version=$(sed -n '/^\[workspace.package\]/,/^version/s/^version = "\(.*\)"/\1/p' Cargo.toml)
name=azimesh-$version-$target
program=target/$target/release/azimesh

case $target in
    *-linux-gnu) cargo zigbuild --release --bin azimesh --target "$target.2.17" ;;
    *) cargo build --release --bin azimesh --target "$target" ;;
esac
if [ -e "$program.exe" ]; then program=$program.exe; fi

rm -rf "dist/$name"
mkdir -p "dist/$name/man" "dist/$name/completions"
cp "$program" README.md CHANGELOG.md LICENSE-APACHE LICENSE-MIT "dist/$name/"
"$program" man -o "dist/$name/man"
for shell in bash zsh fish; do "$program" completions $shell >"dist/$name/completions/azimesh.$shell"; done
# The program works before it is packed.
"$program" deform testdata/naca0012.vtu testdata/naca0012.toml -o "dist/try" --force
rm -r dist/try
tar -C dist -czf "dist/$name.tar.gz" "$name"
rm -r "dist/${name:?}"
(cd dist && { sha256sum "$name.tar.gz" 2>/dev/null || shasum -a 256 "$name.tar.gz"; } >"$name.tar.gz.sha256")
ls -l "dist/$name.tar.gz"
