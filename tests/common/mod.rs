// SPDX-License-Identifier: MIT OR Apache-2.0
#![allow(dead_code, missing_docs)] // each test binary uses its own part

use std::{
    mem::take,
    ops::Deref,
    sync::{Arc, Condvar, Mutex, MutexGuard},
    thread::available_parallelism,
};
use whitecap::gpu::{Gpu, GpuOptions, Messages};

static POOL: Mutex<Pool> = Mutex::new(Pool { idle: Vec::new(), made: 0, most: 1 });
static RETURNED: Condvar = Condvar::new();

/// The validated devices of a test binary: one, so that nothing runs beside what is timed; on a software driver one a core,
/// as the small grids of most tests keep no more than a core busy.
struct Pool {
    idle: Vec<Gpu>,
    made: usize,
    most: usize,
}

impl Pool {
    fn take(&mut self) -> Option<Gpu> {
        self.idle.pop().or_else(|| (self.made < self.most).then(|| self.make()))
    }

    fn make(&mut self) -> Gpu {
        let gpu = fresh();
        self.made += 1;
        if gpu.adapter().is_software() {
            self.most = available_parallelism().map_or(1, usize::from).min(4);
        }
        gpu
    }
}

fn pool() -> MutexGuard<'static, Pool> {
    POOL.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// A validated device that a test holds alone. When the test lets go, it fails if validation said anything that nobody
/// expected.
pub struct TestGpu {
    gpu: Gpu,
    messages: Arc<Messages>,
}

/// SwiftShader is run without the layer: it is there to show what a small driver does.
pub fn validates() -> bool {
    std::env::var("WHITECAP_TEST_PASS").as_deref() != Ok("swiftshader")
}

/// A device of its own, for tests of what happens when it goes.
pub fn fresh() -> Gpu {
    let device = std::env::var("WHITECAP_TEST_DEVICE").ok();
    Gpu::headless(&GpuOptions { device, validate: validates(), cache: None })
        .expect("a Vulkan 1.3 device and the Khronos validation layer")
}

pub fn gpu() -> TestGpu {
    let mut pool = pool();
    let gpu = loop {
        match pool.take() {
            Some(gpu) => break gpu,
            None => pool = RETURNED.wait(pool).unwrap_or_else(|poisoned| poisoned.into_inner()),
        }
    };
    drop(pool);
    take_messages(&gpu.messages()); // what a test that panicked left behind
    TestGpu { messages: gpu.messages(), gpu }
}

fn take_messages(messages: &Messages) -> Vec<String> {
    take(&mut *messages.lock().unwrap_or_else(|poisoned| poisoned.into_inner()))
}

impl TestGpu {
    /// Takes the messages so far; at least one must contain `part`.
    pub fn expect_message(&self, part: &str) {
        let messages = take_messages(&self.messages);
        assert!(messages.iter().any(|m| m.contains(part)), "no {part} in {messages:?}");
    }

    pub fn take_messages(&self) -> Vec<String> {
        take_messages(&self.messages)
    }

    /// Software drivers round as the CPU does: there the twin in f32 must agree to the bit.
    pub fn is_exact(&self) -> bool {
        self.adapter().kind == "CPU"
    }
}

impl Deref for TestGpu {
    type Target = Gpu;
    fn deref(&self) -> &Gpu {
        &self.gpu
    }
}

impl Drop for TestGpu {
    fn drop(&mut self) {
        let messages = take_messages(&self.messages);
        pool().idle.push(self.gpu.clone());
        RETURNED.notify_one();
        if !std::thread::panicking() {
            assert_eq!(messages, [""; 0], "validation messages");
        }
    }
}

/// How far two results are apart. Refuses to compare nothing with nothing.
#[must_use]
#[derive(Debug, PartialEq)]
pub struct Distance {
    /// Units in the last place of an f32.
    pub ulp: u32,
    /// `sum (a - b)^2 / sum b^2`.
    pub relative_power: f64,
}

pub fn distance<T: Copy + Into<f64>>(got: &[f32], want: &[T]) -> Distance {
    assert_eq!(got.len(), want.len());
    let want: Vec<f64> = want.iter().map(|&v| v.into()).collect();
    assert!(got.iter().all(|v| v.is_finite()) && want.iter().all(|v| v.is_finite()), "not finite");
    let power: f64 = want.iter().map(|v| v * v).sum();
    assert!(power > 0.0, "the reference is all zero: nothing is compared");
    let error: f64 = got.iter().zip(&want).map(|(&a, b)| (f64::from(a) - b).powi(2)).sum();
    let ulp = got.iter().zip(&want).map(|(&a, &b)| line(a).abs_diff(line(b as f32))).max().unwrap_or(0);
    Distance { ulp, relative_power: error / power }
}

/// Floats as integers in the same order, so that neighbours differ by one, across zero too.
fn line(v: f32) -> i32 {
    let bits = v.to_bits() as i32;
    if bits < 0 {
        i32::MIN.wrapping_sub(bits)
    } else {
        bits
    }
}
