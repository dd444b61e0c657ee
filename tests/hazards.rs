// SPDX-License-Identifier: MIT OR Apache-2.0
//! Planted mistakes that the validation layer must see: a silent layer would make every clean run worthless.
#![allow(missing_docs)]

mod common;

use common::{fresh, gpu, TestGpu};
use glam::uvec2;
use whitecap::{
    gpu::{Access, Buffer, Residence, Submitter},
    water::{
        starts::{self, Start},
        Tuning, Waves, WavesState,
    },
};

const TUNING: Tuning = Tuning { group: uvec2(8, 8), rows: 4 };

/// Only layers from 1.4 on, asked by their environment, see two passes that both read and write one buffer.
fn sees_read_write_pairs() -> bool {
    std::env::var("WHITECAP_TEST_PASS").as_deref() == Ok("newer-layer")
}

fn start() -> Start {
    starts::hump(starts::model(uvec2(77, 45), 0.25))
}

fn state(gpu: &TestGpu) -> WavesState {
    let start = start();
    let state = Waves::new(gpu, TUNING, false).unwrap().state(start.model.cells).unwrap();
    state.upload(gpu, &start.height_m, &vec![0.0; start.height_m.len()]).unwrap();
    state
}

#[test]
fn two_steps_without_a_barrier_are_seen() {
    let gpu = gpu();
    let mut state = state(&gpu);
    let params = start().model.params(state.pitch());
    gpu.once(|rec| {
        state.record(rec, &params);
        state.record(rec, &params); // reads the heights that the first writes
    })
    .unwrap();
    gpu.expect_message("SYNC-HAZARD-");
}

#[test]
fn the_wrong_barrier_is_seen() {
    let gpu = gpu();
    let mut state = state(&gpu);
    let params = start().model.params(state.pitch());
    gpu.once(|rec| {
        state.record(rec, &params);
        rec.barrier(Access::CopyWrite, Waves::ENTRY);
        state.record(rec, &params);
    })
    .unwrap();
    gpu.expect_message("SYNC-HAZARD-");
}

#[test]
fn a_copy_before_the_step_is_done_is_seen() {
    let gpu = gpu();
    let mut state = state(&gpu);
    let params = start().model.params(state.pitch());
    let readback = Buffer::new(&gpu, "test.readback", state.height().bytes(), Residence::Readback).unwrap();
    gpu.once(|rec| {
        state.record(rec, &params);
        rec.copy(state.height(), &readback);
    })
    .unwrap();
    gpu.expect_message("SYNC-HAZARD-");
}

#[test]
fn a_step_before_the_fill_is_done_is_seen() {
    let gpu = gpu();
    let mut state = state(&gpu);
    let params = start().model.params(state.pitch());
    gpu.once(|rec| {
        rec.fill(state.height(), 0);
        state.record(rec, &params);
    })
    .unwrap();
    gpu.expect_message("SYNC-HAZARD-");
}

#[test]
fn an_overwritten_copy_is_seen() {
    let gpu = gpu();
    let state = state(&gpu);
    gpu.once(|rec| {
        rec.fill(state.height(), 0);
        rec.copy(state.velocity(), state.height());
    })
    .unwrap();
    gpu.expect_message("SYNC-HAZARD-");
}

/// Both passes read and write the velocity only: heights are apart.
#[test]
fn two_passes_that_read_and_write_one_buffer_are_seen_by_newer_layers() {
    let gpu = gpu();
    if !sees_read_write_pairs() {
        println!("SKIP: this layer does not look (Khronos Vulkan-ValidationLayers issue 8277)");
        return;
    }
    let state = state(&gpu);
    let kernels = whitecap::water::Disturb::new(&gpu).unwrap();
    let list = kernels.list(state.surfaces(), Some(state.velocity()), 4).unwrap();
    let model = start().model;
    let params = whitecap::water::DisturbParams {
        cells: model.cells,
        pitch: state.pitch(),
        stride: 1,
        cell_m: model.cell_m as f32,
        limit_m: 10.0,
        has_velocity: 1,
    };
    gpu.once(|rec| {
        list.record(rec, &state.surface(), &params);
        list.record(rec, &state.surface(), &params);
    })
    .unwrap();
    gpu.expect_message("SYNC-HAZARD-");
}

#[test]
fn a_leak_is_seen() {
    let gpu = fresh();
    let messages = gpu.messages();
    unsafe { gpu.device().create_fence(&Default::default(), None) }.unwrap();
    drop(gpu);
    let messages = messages.lock().unwrap();
    assert!(messages.iter().any(|m| m.contains("vkDestroyDevice")), "{messages:?}");
}

#[test]
fn the_device_outlives_its_children_in_any_order() {
    let gpu = fresh();
    let messages = gpu.messages();
    let kernel = Waves::new(&gpu, TUNING, false).unwrap();
    let state = kernel.state(uvec2(64, 64)).unwrap();
    let submitter = Submitter::new(&gpu, 4).unwrap();
    drop(gpu);
    drop(state);
    drop(submitter);
    drop(kernel);
    assert_eq!(*messages.lock().unwrap(), [""; 0]);
}

#[test]
fn passes_are_named_and_timed() {
    let gpu = gpu();
    let mut state = state(&gpu);
    let params = start().model.params(state.pitch());
    let mut submitter = Submitter::new(&gpu, 2).unwrap();
    let times = submitter
        .run(|rec| {
            for _ in 0..3 {
                state.record(rec, &params);
                rec.barrier(Waves::EXIT, Waves::ENTRY);
            }
        })
        .unwrap();
    let names: Vec<_> = times.spans.iter().map(|span| span.name).collect();
    assert_eq!(names, [c"water.waves", c"water.waves"], "room for two of three");
    assert!(times.spans.iter().all(|span| span.ms > 0.0), "{times:?}");
    assert_eq!(times.untimed, 1, "and the third is counted");
}

#[test]
fn who_watches_sees_when_passes_began_and_what_they_did() {
    let gpu = gpu();
    let mut state = state(&gpu);
    let params = start().model.params(state.pitch());
    let mut submitter = Submitter::new(&gpu, 2).unwrap().watching(true).unwrap();
    let before = std::time::Instant::now();
    let times = submitter.run(|rec| state.record(rec, &params)).unwrap();
    let span = &times.spans[0];
    let begin = span.begin.expect("a beginning");
    assert!(
        before <= begin && begin.elapsed() >= std::time::Duration::from_secs_f64(1e-3 * span.ms),
        "{times:?}"
    );
    let names: Vec<_> = times.host.iter().map(|it| it.name).collect();
    assert!(["record", "submit", "wait"].iter().all(|name| names.contains(name)), "{names:?}");
    if gpu.has_statistics() {
        let names: Vec<_> = span.statistics.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["compute_invocations"], "and nothing is drawn: {span:?}");
    } else {
        assert!(span.statistics.is_empty());
    }
}

#[test]
#[should_panic(expected = "grid of the parameters and of the state")]
fn parameters_of_another_grid_are_refused() {
    let gpu = gpu();
    let mut state = state(&gpu);
    let mut params = start().model.params(state.pitch());
    params.cells.x += 1;
    let _ = gpu.once(|rec| state.record(rec, &params));
}
