#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
# Command lines of NVIDIA's profilers for whitecap. Which of them fits what, and what of this has been run: docs/profiling.md.
#   docs/nsight.sh systems SCENE   a time line of the process: Vulkan calls, passes by their labels, what the GPU does
#   docs/nsight.sh frame SCENE     counters of one submission (Nsight Graphics, GPU Trace)
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
    need nsys "package nsight-systems, of NVIDIA's repository or of Debian's non-free"
    mkdir -p "$out"
    # Up to 2022 the options and reports had other names.
    local help metrics=--gpu-metrics-devices reports=vulkan_marker_sum,vulkan_gpu_marker_sum
    help=$(nsys profile --help)
    [[ $help == *--gpu-metrics-devices=* ]] || metrics=--gpu-metrics-device
    [[ $(nsys stats --help-reports 2>&1) == *vulkan_marker_sum* ]] || reports=vulkanmarkerssum,vulkangpumarkersum
    # vulkan-annotations: the debug labels of passes and pictures, without which both reports are empty. `individual`:
    # each command buffer, not a batch of them. The metrics (SM activity, memory throughput) take a device and a user that
    # are allowed them: METRICS=none leaves them out.
    nsys profile --trace=vulkan,vulkan-annotations,osrt --vulkan-gpu-workload=individual \
        "$metrics=${METRICS:-all}" --force-overwrite=true --output="$out/systems" \
        "$whitecap" run "${1:-fjord}" --frames "${FRAMES:-60}" --no-frames --out "$out/run"
    nsys stats --force-export=true --report "$reports" "$out/systems.nsys-rep"
}

frame() {
    local ngfx
    # Its installer leaves it off the PATH.
    ngfx=$(command -v ngfx || find /opt/nvidia /usr/local -path '*/host/linux-desktop-nomad-x64/ngfx' 2>/dev/null | sort | tail -n 1)
    [[ -n $ngfx ]] || need ngfx "Nsight Graphics, from NVIDIA's site"
    mkdir -p "$out"
    # Nothing is presented, so there are no frames to count: submissions are. A picture is one, where the clock is the GPU's,
    # after a few dozen of the set-up: SUBMIT says which. The window library wants a display, or to be told there is none.
    QT_QPA_PLATFORM=${QT_QPA_PLATFORM:-offscreen} "$ngfx" --activity "GPU Trace Profiler" --exe "$(realpath "$whitecap")" \
        --args "run ${1:-fjord} --frames 120 --no-frames --out $out/run" --dir "$PWD" --output-dir "$out" \
        --start-after-submits "${SUBMIT:-60}" --limit-to-submits 1 --max-duration-ms 9000 --auto-export
}

compute() {
    printf '%s\n' "Nsight Compute (ncu) profiles CUDA and OptiX kernels, not Vulkan's: it finds none in whitecap." \
        "Registers, shared memory and occupancy: whitecap devices --pipelines. Counters by pass: docs/nsight.sh frame."
}

case ${1:-} in
systems | frame | compute) "$@" ;;
*)
    sed -n '3,6s/^# *//p' "$0"
    exit 2
    ;;
esac
