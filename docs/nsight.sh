#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
# Command lines of NVIDIA's profilers for whitecap. None of them has been run yet for want of the tools: they are written
# from the manuals of Nsight Systems 2024 and Nsight Graphics 2024. Which of them fits what: docs/profiling.md.
#   docs/nsight.sh systems SCENE   a time line of the process: Vulkan calls, passes by their labels, what the GPU does
#   docs/nsight.sh frame SCENE     one picture's counters by pass (Nsight Graphics, GPU Trace)
#   docs/nsight.sh compute         why there is no command for Nsight Compute
set -euo pipefail

whitecap=${WHITECAP:-target/release/whitecap}
out=${OUT:-out/nsight}

need() {
    command -v "$1" >/dev/null 2>&1 || {
        printf '%s is not installed: %s\n' "$1" "$2" >&2
        exit 3
    }
}

systems() {
    need nsys "package nsight-systems of NVIDIA's repository"
    mkdir -p "$out"
    # vulkan-annotations: the debug labels of passes and pictures. gpu-metrics: SM activity, memory throughput, on devices
    # that allow it. `individual` has one row a submission's work and not one a batch.
    nsys profile --trace=vulkan,vulkan-annotations,osrt --vulkan-gpu-workload=individual --gpu-metrics-devices=all \
        --force-overwrite=true --output="$out/systems" \
        "$whitecap" run "${1:-fjord}" --frames 60 --no-frames --out "$out/run"
    nsys stats --report vulkan_marker_sum,vulkan_gpu_marker_sum "$out/systems.nsys-rep"
}

frame() {
    need ngfx "Nsight Graphics, from NVIDIA's site"
    # The pictures are the frames: nothing is presented, so submissions are counted instead.
    ngfx --activity="GPU Trace Profiler" --platform="Linux ($(uname -m))" --exe="$(realpath "$whitecap")" \
        --args="run ${1:-fjord} --frames 60 --no-frames --out $out/run" --dir="$PWD" --output-dir="$out" \
        --start-after-submits=40 --limit-to-submits=1 --auto-export
}

compute() {
    printf '%s\n' "Nsight Compute (ncu) profiles CUDA and OptiX kernels, not Vulkan's: it finds none in whitecap." \
        "Registers, shared memory and occupancy: whitecap devices --pipelines. Counters by pass: docs/nsight.sh frame."
}

case ${1:-} in
systems | frame | compute) "$@" ;;
*)
    sed -n '3,7s/^# *//p' "$0"
    exit 2
    ;;
esac
