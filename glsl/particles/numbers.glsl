// Below 2^127: neither infinite nor no number, and nowhere near NOWHERE_M.
bool are_numbers(vec3 v) { return all(lessThan(floatBitsToUint(v) & 0x7fffffffu, uvec3(0x7f000000u))); }
