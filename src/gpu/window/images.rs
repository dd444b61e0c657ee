// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which image a frame ends in: taken from the window system, given back to it, and made anew where they no longer fit.

use super::{
    frames::{Frames, FRAMES},
    swapchain::Swapchain,
};
use crate::gpu::error::{Error, OrCall, Result};
use ash::{prelude::VkResult, vk};
use std::collections::VecDeque;

/// A window that is covered may get no images for as long as it is: its events are seen to meanwhile.
const PATIENCE_NS: u64 = 100_000_000;

/// What a frame in flight may still use. It goes when that frame is done.
pub struct Retired<T>(VecDeque<(u64, T)>);

impl<T> Default for Retired<T> {
    fn default() -> Self {
        Self(VecDeque::new())
    }
}

impl<T> Retired<T> {
    /// `last_use` is the number of a frame, as [`Frames::number`] gives it.
    pub fn push(&mut self, last_use: u64, thing: T) {
        self.0.push_back((last_use, thing));
    }

    /// Drops what no frame uses any more, what was pushed first before all else; `done` as [`Frames::done`] gives it.
    pub fn free_up_to(&mut self, done: u64) {
        while self.0.front().is_some_and(|(last_use, _)| *last_use <= done) {
            self.0.pop_front();
        }
    }
}

/// What became of asking for an image.
#[derive(Debug, PartialEq)]
pub(super) enum Taken {
    /// Its number. Where it is suboptimal it is shown, and those for later frames are made anew.
    Image { number: u32, is_suboptimal: bool },
    /// Not now: the window is covered.
    Later,
    /// They are no longer of the window's size.
    Stale,
    /// The window system has lost the surface, and with it all of them.
    Lost,
}

/// What vkAcquireNextImageKHR says.
pub(super) fn taken(said: VkResult<(u32, bool)>) -> Result<Taken> {
    match said {
        Ok((number, is_suboptimal)) => Ok(Taken::Image { number, is_suboptimal }),
        Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => Ok(Taken::Later),
        Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => Ok(Taken::Stale),
        Err(vk::Result::ERROR_SURFACE_LOST_KHR) => Ok(Taken::Lost),
        Err(code) => Err(code).or_call("vkAcquireNextImageKHR"),
    }
}

/// Whether the images are to be made anew before the next frame, after what vkQueuePresentKHR says. A surface that was lost
/// is noticed again when they are.
pub(super) fn is_stale_after(said: VkResult<bool>, may_be_bettered: bool) -> Result<bool> {
    match said {
        Ok(is_suboptimal) => Ok(is_suboptimal && may_be_bettered),
        Err(vk::Result::ERROR_OUT_OF_DATE_KHR | vk::Result::ERROR_SURFACE_LOST_KHR) => Ok(true),
        Err(code) => Err(code).or_call("vkQueuePresentKHR"),
    }
}

impl Frames {
    /// Takes an image for the frame that is to be made. `false` if there is none now.
    pub(super) fn acquire(&mut self) -> Result<bool> {
        // A window that is being dragged may be stale again at once; the next call goes on.
        for _ in 0..8 {
            if !self.ready()? {
                return Ok(false);
            }
            let Some(chain) = &self.chain else { return Ok(false) };
            let acquired = self.acquired();
            let none = vk::Fence::null();
            let said = match std::mem::take(&mut self.is_lost) {
                true => Err(vk::Result::ERROR_SURFACE_LOST_KHR),
                false => unsafe { chain.api.acquire_next_image(chain.raw, PATIENCE_NS, acquired, none) },
            };
            match taken(said)? {
                Taken::Image { number, is_suboptimal } => {
                    self.image = number;
                    self.is_stale |= is_suboptimal && chain.may_be_bettered();
                    return Ok(true);
                }
                Taken::Later => return Ok(false),
                Taken::Stale => self.is_stale = true,
                Taken::Lost => self.renew_surface()?,
            }
        }
        Ok(false)
    }

    /// Makes the images anew where they are stale. `false` if there are none.
    pub(super) fn ready(&mut self) -> Result<bool> {
        if !self.is_stale && self.chain.is_some() {
            return Ok(true);
        }
        let made = match Swapchain::new(&self.gpu, &self.surface, self.wanted, self.chain.as_ref()) {
            Err(Error::Vulkan { code: vk::Result::ERROR_SURFACE_LOST_KHR, .. }) => {
                self.renew_surface()?;
                Swapchain::new(&self.gpu, &self.surface, self.wanted, None)?
            }
            other => other?,
        };
        let Some(made) = made else { return Ok(false) };
        self.is_stale = false;
        if let Some(old) = self.chain.replace(made) {
            // Its last image may be on the way to the screen: as long as the next frames take.
            let last_use = self.number() - 1 + FRAMES as u64;
            self.old.push(last_use, old);
        }
        Ok(true)
    }

    fn renew_surface(&mut self) -> Result<()> {
        self.wait_for_all()?;
        (self.chain, self.old, self.is_stale) = (None, Retired::default(), true);
        self.surface.renew()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{cell::RefCell, rc::Rc};

    #[test]
    fn what_is_retired_goes_in_order_and_no_sooner_than_its_frame_is_done() {
        struct Thing(u32, Rc<RefCell<Vec<u32>>>);
        impl Drop for Thing {
            fn drop(&mut self) {
                self.1.borrow_mut().push(self.0);
            }
        }
        let gone = Rc::new(RefCell::new(Vec::new()));
        let mut retired = Retired::default();
        for (last_use, name) in [(3, 1), (3, 2), (5, 3), (4, 4)] {
            retired.push(last_use, Thing(name, gone.clone()));
        }
        let mut free = |done| {
            retired.free_up_to(done);
            gone.borrow().clone()
        };
        assert_eq!(free(0), [0u32; 0]);
        assert_eq!(free(2), [0u32; 0]);
        assert_eq!(free(3), [1, 2]);
        // What comes later in the list may use what comes before it, so it never goes first.
        assert_eq!(free(4), [1, 2]);
        assert_eq!(free(5), [1, 2, 3, 4]);
        retired.push(9, Thing(5, gone.clone()));
        drop(retired); // as when the window closes, after all is done
        assert_eq!(*gone.borrow(), [1, 2, 3, 4, 5]);
    }

    #[test]
    fn what_a_window_system_says_of_images() {
        use vk::Result as R;
        assert_eq!(taken(Ok((2, false))).unwrap(), Taken::Image { number: 2, is_suboptimal: false });
        // Suboptimal is no error: the image is taken, and has to be shown.
        assert_eq!(taken(Ok((1, true))).unwrap(), Taken::Image { number: 1, is_suboptimal: true });
        for code in [R::TIMEOUT, R::NOT_READY] {
            assert_eq!(taken(Err(code)).unwrap(), Taken::Later);
        }
        assert_eq!(taken(Err(R::ERROR_OUT_OF_DATE_KHR)).unwrap(), Taken::Stale);
        assert_eq!(taken(Err(R::ERROR_SURFACE_LOST_KHR)).unwrap(), Taken::Lost);
        assert!(taken(Err(R::ERROR_DEVICE_LOST)).unwrap_err().is_device_lost());

        assert!(!is_stale_after(Ok(false), true).unwrap());
        assert!(is_stale_after(Ok(true), true).unwrap() && !is_stale_after(Ok(true), false).unwrap());
        for code in [R::ERROR_OUT_OF_DATE_KHR, R::ERROR_SURFACE_LOST_KHR] {
            assert!(is_stale_after(Err(code), false).unwrap(), "{code:?}");
        }
        assert!(is_stale_after(Err(R::ERROR_DEVICE_LOST), true).unwrap_err().is_device_lost());
    }
}
