// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the host pays: recording steps, reading a scene, a step of a twin. Times of the GPU come from `whitecap bench`.
#![allow(missing_docs)]

use criterion::{criterion_group, criterion_main, Criterion};
use glam::UVec2;
use std::hint::black_box;
use whitecap::{
    gpu::{Gpu, GpuOptions, Submitter},
    scene::{builtin, Scene},
    water::{cpu, starts, Tuning, Waves},
};

fn recording(c: &mut Criterion) {
    let gpu = Gpu::headless(&GpuOptions::default()).expect("a Vulkan device");
    let cells = UVec2::splat(16); // the smaller the grid, the more of the time is the host's
    let tuning = Tuning::for_grid(&gpu, cells);
    let mut state = Waves::new(&gpu, tuning, false).and_then(|it| it.state(cells)).expect("a basin");
    let params = starts::model(cells, 0.25).params(state.pitch());
    let mut submitter = Submitter::new(&gpu, 0).expect("a command pool");
    c.bench_function("record 100 steps, submit, wait", |b| {
        b.iter(|| {
            submitter.run(|rec| {
                for _ in 0..100 {
                    state.record(rec, &params);
                    rec.barrier(Waves::EXIT, Waves::ENTRY);
                }
            })
        });
    });
}

fn scenes(c: &mut Criterion) {
    let text = builtin::toml("fjord").expect("a built-in scene");
    c.bench_function("read a scene", |b| b.iter(|| Scene::parse(black_box(text), "fjord.toml", None, &[])));
}

fn twins(c: &mut Criterion) {
    let start = starts::hump(starts::model(UVec2::splat(128), 0.25));
    let mut twin = cpu::Waves::<f64>::at_rest(&start.model, &start.height_m);
    c.bench_function("a step of the f64 twin, 128 x 128", |b| b.iter(|| twin.step()));
}

criterion_group!(host, recording, scenes, twins);
criterion_main!(host);
