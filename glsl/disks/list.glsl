// The tutorial's record and lists (Diligent Engine, tutorial 14, "Compute shader"): 48 bytes a disk, which stays where it
// is, and a list for each bin that grows at its head by atomic exchange. Two things are not as there: walls mirror, and a
// pass writes only the fields that are its own, because others read the rest.
#define DIMENSIONS 2
#include "disks/disks.glsl"

struct ListDisk {
    vec2 at_m;
    vec2 new_at_m;
    vec2 velocity_mps;
    vec2 new_velocity_mps;
    float radius_m;
    float temperature;  // 1 when hit, and falls
    uint contacts;
    uint unused;
};
