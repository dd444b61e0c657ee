// Land has this height, bit for bit: `water::LAND_M`. It costs no buffer and no byte: who reads a height sees whether
// there is water.
const float LAND_M = -1.0e30;
