#!/usr/bin/env python3
# SPDX-License-Identifier: MIT OR Apache-2.0
"""Samples of Linux perf, by the pass that ran when they were taken.

A driver on the CPU compiles kernels at run time, and perf cannot name what it has no file of. But the trace of a run says
when each pass ran, by the clock of the samples:

    perf record -k mono -F 999 -o perf.data whitecap run SCENE --trace trace.json
    perf script -i perf.data -F time,ip,dso | docs/perf_by_pass.py trace.json
"""

import bisect
import collections
import json
import re
import sys


def main():
    text = open(sys.argv[1]).read().rstrip()
    events = json.loads(text if text.endswith("]") else text + "]")
    start_ns = next(it["args"]["time_0_monotonic_ns"] for it in events if it["name"] == "about")
    spans = sorted((it["ts"], it["ts"] + it["dur"], it["name"]) for it in events if it.get("cat") == "gpu")
    begins = [begin for begin, _, _ in spans]
    counts = collections.Counter()
    for line in sys.stdin:
        found = re.match(r"\s*(\d+)\.(\d+):.*\((.*)\)", line)
        if not found:
            continue
        at_us = (int(found[1]) * 10**9 + int(found[2].ljust(9, "0")[:9]) - start_ns) / 1e3
        at = bisect.bisect_right(begins, at_us) - 1
        name = spans[at][2] if at >= 0 and at_us < spans[at][1] else "(no pass)"
        file = found[3].rsplit("/", 1)[-1]
        # What perf has no file of: it looks for a map that this driver does not write.
        is_compiled = re.fullmatch(r"perf-\d+\.map|\[?JIT.*|//anon|\[?unknown\]?", file)
        counts[name, "compiled kernels" if is_compiled else file.strip("[]")] += 1
    total = sum(counts.values())
    for (name, where), count in counts.most_common(16):
        print(f"{100 * count / total:6.2f} %  {name:24} {where}")


main()
