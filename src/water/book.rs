// SPDX-License-Identifier: MIT OR Apache-2.0
//! `book`: the scheme of the book, five floats a column, one step a dispatch. Reads `glsl/water/book.comp`.

use super::{check_heights, Error, Params, Surface};
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Result},
    shaders,
};
use glam::UVec2;

/// A column: `Column` in `glsl/water/book.comp`.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Column {
    /// (m above rest).
    pub height_m: f32,
    /// From the right, the lower right, below and the lower left, as rise of the surface (m/s).
    pub flow_mps: [f32; 4],
}

/// The kernel. It holds no basin, so one steps any number of them.
pub struct Book {
    step: Kernel,
    gpu: Gpu,
}

impl Book {
    /// What the state must be visible to before [`BookState::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`BookState::record`] touched it last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// # Errors
    /// If the device cannot build the kernel.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let info = KernelInfo {
            name: c"water.book",
            spv: shaders::WATER_BOOK_COMP,
            blocks: &["Columns", "NewColumns"],
            constants: &[],
        };
        Ok(Self { step: Kernel::new::<Params>(gpu, &info)?, gpu: gpu.clone() })
    }

    /// A basin whose memory is not set yet: [`BookState::upload`].
    ///
    /// # Errors
    /// If the device has no room, or cannot see a buffer of that size.
    pub fn state(&self, cells: UVec2) -> Result<BookState> {
        let bytes = size_of::<Column>() as u64 * cells.as_u64vec2().element_product();
        let buffer = |name: &str| Buffer::new(&self.gpu, name, bytes, Residence::Device);
        let columns = [buffer("water.columns.0")?, buffer("water.columns.1")?];
        let bind = |from: usize| {
            self.step
                .bind(&[("Columns", (&columns[from]).into()), ("NewColumns", (&columns[1 - from]).into())])
        };
        Ok(BookState { steps: [bind(0)?, bind(1)?], columns, current: 0, cells })
    }
}

/// One basin, row by row: column `(x, y)` is at `y * cells.x + x`.
pub struct BookState {
    columns: [Buffer; 2],
    steps: [Bound; 2],
    current: usize,
    cells: UVec2,
}

impl BookState {
    /// Records one step, as [`WavesState::record`](super::WavesState::record) does.
    ///
    /// # Panics
    /// If `params` are of another grid.
    pub fn record(&mut self, rec: &mut Recorder<'_>, params: &Params) {
        assert_eq!(
            (params.cells, params.pitch),
            (self.cells, self.cells.x),
            "grid of the parameters and of the state"
        );
        let threads = [self.cells.x, self.cells.y, 1];
        rec.span(c"water.book", |rec| rec.dispatch(&self.steps[self.current], threads, params));
        self.current = 1 - self.current;
    }

    /// The columns after the steps recorded so far.
    pub fn columns(&self) -> &Buffer {
        &self.columns[self.current]
    }

    /// Columns from one row to the next.
    pub fn pitch(&self) -> u32 {
        self.cells.x
    }

    /// The surface after the steps recorded so far, for drawing and disturbing.
    pub fn surface(&self) -> Surface<'_> {
        self.surfaces()[self.current]
    }

    /// The two between which the steps go to and fro.
    pub fn surfaces(&self) -> [Surface<'_>; 2] {
        [0, 1].map(|i| Surface {
            cells: self.cells,
            height_m: &self.columns[i],
            pitch: self.cells.x,
            stride: 5,
        })
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        2 * self.columns[0].bytes()
    }

    /// Sets heights (m above rest), with all pipes at rest.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a number is not finite or the sizes differ, else the device's.
    pub fn upload(&self, gpu: &Gpu, height_m: &[f32]) -> Result<(), Error> {
        let at_rest = |&height_m: &f32| Column { height_m, flow_mps: [0.0; 4] };
        self.upload_columns(gpu, &height_m.iter().map(at_rest).collect::<Vec<_>>())
    }

    /// Sets heights and flows.
    ///
    /// # Errors
    /// As [`BookState::upload`].
    pub fn upload_columns(&self, gpu: &Gpu, columns: &[Column]) -> Result<(), Error> {
        let heights: Vec<f32> = columns.iter().map(|column| column.height_m).collect();
        check_heights("height_m", &heights, self.cells, false)?;
        for k in 0..4 {
            let flows: Vec<f32> = columns.iter().map(|column| column.flow_mps[k]).collect();
            check_heights("flow_mps", &flows, self.cells, false)?;
        }
        Ok(gpu.upload_to(self.columns(), columns)?)
    }

    /// The columns.
    ///
    /// # Errors
    /// The device's.
    pub fn download(&self, gpu: &Gpu) -> Result<Vec<Column>> {
        gpu.download(self.columns())
    }
}
