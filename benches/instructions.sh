#!/usr/bin/env bash
# Counts the instructions of whole commands with callgrind, on one thread, and compares them with
# those recorded in instructions.tsv: a slower program shows here also on a noisy machine.
#
# Usage: benches/instructions.sh [--record] [PROGRAM]
#
# PROGRAM is target/release/raytracer unless told. Prints REGRESSION, and ends with status 1, where a
# count is more than 3% above the recorded one. --record writes the counts down instead.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
tolerance=3

record=false
if [ "${1:-}" = --record ]; then
  record=true
  shift
fi
program=$(realpath "${1:-$here/../target/release/raytracer}")
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT

# A name for each command, and its flags.
commands() {
  cat <<'END'
empty             -size 200 200 -input EMPTY
scene6_04         -size 200 200 -input scene6_04_bunny_mesh_200.txt
scene6_07_shadows -size 200 200 -input scene6_07_bunny_mesh_40k.txt -grid 40 40 33 -shadows
scene6_13_shadows -size 200 200 -input scene6_13_checkerboard.txt -shadows
scene6_14_bounces -size 200 200 -input scene6_14_glass_sphere.txt -shadows -bounces 4
END
}

# Prints the instructions of a command, all threads together.
count() {
  (cd "$here/../scenes" &&
    valgrind --tool=callgrind --callgrind-out-file="$folder/callgrind" \
      "$program" -threads 1 -output "$folder/picture.tga" "$@" 2>&1 >/dev/null) |
    sed -n 's/.*Collected *: *\([0-9]*\).*/\1/p'
}

printf '%s\n' 'OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 5 }' \
  'Group { numObjects 0 }' >"$folder/empty.txt"

commands | while read -r name flags; do
  read -ra words <<<"${flags/EMPTY/$folder/empty.txt}"
  printf '%s\t%s\n' "$name" "$(count "${words[@]}")"
done >"$folder/counts.tsv"

if $record; then
  cp "$folder/counts.tsv" "$here/instructions.tsv"
fi
awk -v tolerance="$tolerance" '
  NR == FNR { recorded[$1] = $2; next }
  FNR == 1 { printf "%-18s %15s %15s %8s\n", "command", "instructions", "recorded", "change" }
  !($1 in recorded) { printf "%-18s %15d %15s\n", $1, $2, "none"; next }
  {
    change = 100 * ($2 / recorded[$1] - 1)
    worse = change > tolerance
    bad += worse
    printf "%-18s %15d %15d %+7.1f%%%s\n", $1, $2, recorded[$1], change, worse ? "  REGRESSION" : ""
  }
  END { exit bad > 0 }
' "$here/instructions.tsv" "$folder/counts.tsv"
