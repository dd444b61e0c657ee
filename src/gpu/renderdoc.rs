// SPDX-License-Identifier: MIT OR Apache-2.0
//! Captures by RenderDoc, where it watches this process already: as a layer (`ENABLE_VULKAN_RENDERDOC_CAPTURE=1`) or through
//! `renderdoccmd capture`. Its library is never loaded here, only found (<https://renderdoc.org/docs/in_application_api.html>).

use libloading::Library;
use std::{
    ffi::{c_char, c_int, c_uint, c_void, CStr, CString},
    path::{Path, PathBuf},
    ptr,
};

/// `eRENDERDOC_API_Version_1_1_2`; later versions only add to it.
const VERSION: c_int = 1_01_02;

/// `RENDERDOC_API_1_1_2` as far as it is used here: a table of functions, and that order is its interface.
#[repr(C)]
struct Api {
    /// From `GetAPIVersion` to `SetFocusToggleKeys`.
    others: [*const c_void; 6],
    set_capture_keys: unsafe extern "C" fn(*mut c_int, c_int),
    /// From `GetOverlayBits` to `UnloadCrashHandler`.
    overlay: [*const c_void; 4],
    set_capture_file_path_template: unsafe extern "C" fn(*const c_char),
    get_capture_file_path_template: *const c_void,
    get_num_captures: unsafe extern "C" fn() -> c_uint,
    get_capture: unsafe extern "C" fn(c_uint, *mut c_char, *mut c_uint, *mut u64) -> c_uint,
    /// From `TriggerCapture` to `SetActiveWindow`.
    more: [*const c_void; 4],
    start_frame_capture: unsafe extern "C" fn(*mut c_void, *mut c_void),
    is_frame_capturing: unsafe extern "C" fn() -> c_uint,
    end_frame_capture: unsafe extern "C" fn(*mut c_void, *mut c_void) -> c_uint,
}

/// RenderDoc, watching this process.
pub struct RenderDoc {
    api: *const Api,
    _library: Library, // held, so that the table stays where it is
}

impl RenderDoc {
    /// `None` if it does not watch. As a layer it does from the first instance on.
    pub fn watching() -> Option<Self> {
        let library = already_loaded()?;
        let mut api: *mut c_void = ptr::null_mut();
        // SAFETY: the symbol's type is that of RenderDoc's header, and RenderDoc fills in a table that is never freed.
        let found = unsafe {
            let get =
                library.get::<unsafe extern "C" fn(c_int, *mut *mut c_void) -> c_int>(b"RENDERDOC_GetAPI\0");
            get.ok()?(VERSION, &mut api)
        };
        (found == 1 && !api.is_null()).then_some(Self { api: api as *const Api, _library: library })
    }

    /// RenderDoc captures at no key of its own from now on, which is F12 too: whoever has a key asks by
    /// [`RenderDoc::capture`], and gets one capture.
    pub fn leave_keys(&self) {
        // SAFETY: no keys, as the header says.
        unsafe { (self.api().set_capture_keys)(ptr::null_mut(), 0) };
    }

    /// Captures all that is submitted while `body` runs, to a file whose name begins with `template`; `None` if RenderDoc
    /// could not.
    pub fn capture<T>(&self, template: &Path, body: impl FnOnce() -> T) -> (T, Option<PathBuf>) {
        let api = self.api();
        let template = CString::new(template.to_string_lossy().into_owned()).unwrap_or_default();
        // SAFETY: functions of the table, called as its header says. No device and no window: those that there are.
        unsafe {
            (api.set_capture_file_path_template)(template.as_ptr());
            (api.start_frame_capture)(ptr::null_mut(), ptr::null_mut());
        }
        let made = body();
        let is_captured = unsafe {
            (api.is_frame_capturing)() == 1 && (api.end_frame_capture)(ptr::null_mut(), ptr::null_mut()) == 1
        };
        (made, if is_captured { self.last() } else { None })
    }

    /// The file of the last capture.
    fn last(&self) -> Option<PathBuf> {
        let api = self.api();
        let mut length = 0;
        // SAFETY: asked without a buffer first, for the length with its zero.
        unsafe {
            let index = (api.get_num_captures)().checked_sub(1)?;
            (api.get_capture)(index, ptr::null_mut(), &mut length, ptr::null_mut());
            let mut path = vec![0u8; length as usize + 1];
            let is_there = (api.get_capture)(index, path.as_mut_ptr().cast(), &mut length, ptr::null_mut());
            let path = CStr::from_bytes_until_nul(&path).ok()?;
            (is_there == 1).then(|| PathBuf::from(path.to_string_lossy().into_owned()))
        }
    }

    fn api(&self) -> &Api {
        // SAFETY: not null, and the library that has it is held.
        unsafe { &*self.api }
    }
}

#[cfg(unix)]
fn already_loaded() -> Option<Library> {
    use libloading::os::unix;
    const RTLD_NOLOAD: c_int = if cfg!(target_vendor = "apple") { 0x10 } else { 0x4 };
    let name = if cfg!(target_vendor = "apple") { "librenderdoc.dylib" } else { "librenderdoc.so" };
    // SAFETY: nothing is loaded, so no code of it runs.
    unsafe { unix::Library::open(Some(name), unix::RTLD_NOW | RTLD_NOLOAD) }.ok().map(Library::from)
}

#[cfg(windows)]
fn already_loaded() -> Option<Library> {
    libloading::os::windows::Library::open_already_loaded("renderdoc.dll").ok().map(Library::from)
}
