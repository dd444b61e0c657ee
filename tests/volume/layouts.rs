// SPDX-License-Identifier: MIT OR Apache-2.0
use std::mem::{offset_of, size_of};
use whitecap::{cells::Grid, gpu::reflect::reflect, shaders, volume::VolumeParams};

#[test]
fn push_constants_are_laid_out_alike_in_every_pass() {
    let passes = shaders::ALL.iter().filter(|(name, _)| name.starts_with("volume."));
    let mut count = 0;
    for (name, spv) in passes {
        let interface = reflect(spv, &[]).unwrap();
        if interface.push_bytes == 0 {
            continue;
        }
        let members = &interface.structs["VolumeParams"].members;
        let members: Vec<_> = members.iter().map(|m| (m.name.as_str(), m.offset)).collect();
        let want = [
            ("grid", offset_of!(VolumeParams, grid)),
            ("first", offset_of!(VolumeParams, first)),
            ("triangles", offset_of!(VolumeParams, triangles)),
            ("bits", offset_of!(VolumeParams, bits)),
            ("only_changed", offset_of!(VolumeParams, only_changed)),
            ("rows", offset_of!(VolumeParams, rows)),
            ("way", offset_of!(VolumeParams, way)),
        ];
        assert_eq!(members, want, "{name}");
        assert_eq!(interface.push_bytes, size_of::<VolumeParams>(), "{name}");
        assert_eq!(interface.structs["Grid"].bytes, size_of::<Grid>(), "{name}");
        count += 1;
    }
    assert!(count >= 7, "{count} passes");
}
