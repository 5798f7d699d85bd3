#!/usr/bin/env bash
# Prints the instructions of a frame on one thread with 8 lanes, in total and stage by stage, as
# valgrind counts them. Takes the arguments of `rtrt render`. Needs valgrind, binutils and
# target/profiling/rtrt (cargo build --profile profiling -p rtrt).
set -euo pipefail
cd "$(dirname "$0")/.."
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
# A string instruction that clears or copies memory counts as one for each byte: have libc do without.
export GLIBC_TUNABLES=glibc.cpu.x86_rep_stosb_threshold=100000000:glibc.cpu.x86_rep_movsb_threshold=100000000
# Counts the frame alone: loading takes far longer.
frame=$(nm target/profiling/rtrt | awk '$3 ~ /^_ZN8rtrt_cpu6Memory5frame17h[0-9a-f]*E$/ { print $3 }')
valgrind --tool=callgrind --demangle=no --toggle-collect="$frame" --callgrind-out-file="$out/calls" \
    target/profiling/rtrt render "$@" --samples 1 --threads 1 --lanes 8 --backend cpu --quiet \
    -o "$out/frame.png" 2>"$out/log" || { cat "$out/log" >&2; exit 1; }
# A function belongs to the last stage whose file has some of its instructions: stages call functions
# of earlier ones. "other" is the rest: lists, and memory that is copied or cleared.
awk '
    BEGIN {
        count = split("prepare bin visibility peel surface detail occlusion penumbra_blocks penumbra_filter ambient light shade resolve", stages)
        for (i = 1; i <= count; i++) place[stages[i]] = i
    }
    function name(text, names, parts) {
        match(text, /^\([0-9]+\)/)
        key = substr(text, 1, RLENGTH)
        if (length(text) > RLENGTH) names[key] = substr(text, RLENGTH + 2)
        return names[key]
    }
    /^fn=/ { fn = name(substr($0, 4), fns); next }
    /^f[lie]=/ { file = name(substr($0, 4), files); next }
    /^cfn=/ { name(substr($0, 5), fns); next }
    /^cf[il]=/ { name(substr($0, 5), files); next }
    /^calls=/ { skip = 1; next }
    /^[0-9+*-]/ {
        # The line after a call has the cost of the called function.
        if (skip) { skip = 0; next }
        total += $2
        all[fn] += $2
        if (match(file, /stage\/[a-z_]+\.rs$/)) {
            at = place[substr(file, RSTART + 6, RLENGTH - 9)]
            if (at > last[fn]) last[fn] = at
        }
    }
    END {
        for (fn in all) sum[last[fn] + 0] += all[fn]
        for (i = 1; i <= count; i++) if (sum[i]) printf "%-15s %8.1f million\n", stages[i], sum[i] / 1e6
        printf "%-15s %8.1f million\n", "other", sum[0] / 1e6
        printf "%-15s %8.1f million\n", "frame", total / 1e6
    }' "$out/calls"
