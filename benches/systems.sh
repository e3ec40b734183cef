#!/usr/bin/env bash
# Counts the instructions of three commands, on one thread, with AVX2, with what every x86-64 processor has, and on ARM,
# and prints the latter two over the first.
#
# Usage: benches/systems.sh PROGRAM [ARM] [SYSROOT]
#
# PROGRAM is built with the feature `ablation`, which can leave AVX2 out; callgrind counts its instructions.
# ARM is the same program for AArch64, which qemu-aarch64 runs with the libraries in SYSROOT, /usr/aarch64-linux-gnu
# unless told. It writes down each sequence of instructions when it first comes to it, and its address whenever it runs.
set -euo pipefail
scenes=$(cd "$(dirname "$0")/../scenes" && pwd)
program=$(realpath "$1")
arm=${2:+$(realpath "$2")}
sysroot=${3:-/usr/aarch64-linux-gnu}
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
cd "$scenes"

# A name for each command, and its flags.
commands() {
  cat <<'END'
gem         -input scene6_12_faceted_gem.txt -shadows -shade_back -bounces 5 -weight 0.01
rabbit_5k   -input scene6_06_bunny_mesh_5k.txt -grid 20 20 15 -shadows
rabbit_40k  -input scene6_07_bunny_mesh_40k.txt -grid 40 40 33 -shadows
END
}

# Prints the instructions of a command on x86-64.
count() {
  valgrind --tool=callgrind --callgrind-out-file="$folder/callgrind" "$program" "$@" 2>&1 >/dev/null |
    sed -n 's/.*Collected *: *\([0-9]*\).*/\1/p'
}

# The same on ARM.
count_arm() {
  mkfifo "$folder/log"
  qemu-aarch64 -d exec,nochain,in_asm -D "$folder/log" -L "$sysroot" "$arm" "$@" >/dev/null &
  # A sequence is a line `IN:` and one line for each instruction. A run is `Trace 0: ... [flags/address/...]`.
  awk '
    /^Trace/ { split($4, part, "/"); sub(/^0+/, "", part[2]); total += length_of[part[2]]; next }
    /^IN:/ { start = "" }
    /^0x/ && start == "" { start = $1; sub(/^0x0*/, "", start); sub(/:$/, "", start); length_of[start] = 0 }
    /^0x/ { length_of[start]++ }
    END { printf "%.0f\n", total }' "$folder/log"
  wait
  rm "$folder/log"
}

printf '%-12s %12s %12s %6s %12s %6s\n' command AVX2 SSE2 times ARM times
commands | while read -r name flags; do
  read -ra words <<<"$flags -size 200 200 -threads 1 -output $folder/picture.tga"
  counts=("$(count "${words[@]}")" "$(WITHOUT=avx2 count "${words[@]}")" "$(${arm:+count_arm "${words[@]}"})")
  awk -v name="$name" -v a="${counts[0]}" -v b="${counts[1]}" -v c="${counts[2]}" 'BEGIN {
    printf "%-12s %12d %12d %6.2f", name, a, b, b / a
    if (c != "") printf " %12d %6.2f", c, c / a
    print ""
  }'
done
