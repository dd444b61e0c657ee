// SPDX-License-Identifier: MIT OR Apache-2.0
//! Clips: a looping animated PNG of 256 colours, small enough for a web page, and an mp4 beside it where
//! there is an ffmpeg.
//!
//! Frames are not kept in memory. They are spooled to a file, so that the one palette an animated PNG may
//! have is made from the whole clip, and so that its header, which comes first, can say how many frames there
//! are.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{sync_channel, SyncSender, TrySendError};
use std::time::{Duration, Instant};

use super::atomic::{failed, write_atomic, FileError, Pending, Result};
use super::picture::Picture;

/// How long ffmpeg may take no frame, or take to end, before it is given up on.
const PATIENCE: Duration = Duration::from_secs(120);

/// How a clip is written.
#[derive(Clone, Debug)]
pub struct ClipOptions {
    /// Frames in one second.
    pub fps: f64,
    /// The animated PNG is scaled down to this width (pixels). At 480x270, 120 frames of a smooth picture
    /// with a little noise take 6 MB; in true colour they would take 19 MB.
    pub apng_max_width: u32,
    /// The ffmpeg to run, looked for on `PATH` when it is a plain name; `None` for no mp4.
    pub ffmpeg: Option<PathBuf>,
}

impl Default for ClipOptions {
    fn default() -> Self {
        Self { fps: 60.0, apng_max_width: 480, ffmpeg: Some("ffmpeg".into()) }
    }
}

/// What [`Clip::finish`] wrote.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// The animated PNG.
    pub apng: PathBuf,
    /// The mp4, at full size.
    pub mp4: Option<PathBuf>,
    /// Why there is no mp4 although there is an ffmpeg.
    pub warnings: Vec<String>,
}

/// A clip being written, frame by frame. Dropped unfinished, it leaves no file behind.
pub struct Clip {
    width: u32,
    height: u32,
    options: ClipOptions,
    /// Time of one frame (s), as numerator and denominator.
    delay: (u16, u16),
    apng: PathBuf,
    spool: Pending,
    spooled: u32,
    /// The size in the spool (pixels).
    small: (u32, u32),
    histogram: Histogram,
    mp4: Option<Mp4>,
    warnings: Vec<String>,
}

impl Clip {
    /// Begins `path_stem` + `.png` and, where there is an ffmpeg, `path_stem` + `.mp4`.
    pub fn new(path_stem: &Path, width: u32, height: u32, options: ClipOptions) -> Result<Self> {
        let apng = with_suffix(path_stem, ".png");
        let delay = frame_delay(options.fps)
            .ok_or_else(|| invalid(&apng, "time its frames", format!("{} frames per second", options.fps)))?;
        let spool = Pending::new(&apng)?;
        let mut warnings = Vec::new();
        let mp4 = options.ffmpeg.as_deref().and_then(|program| {
            let path = with_suffix(path_stem, ".mp4");
            Mp4::start(program, &path, width, height, delay).unwrap_or_else(|e| {
                warnings.push(e.to_string());
                None
            })
        });
        let (small, histogram) = ((width, height), Histogram::new());
        Ok(Self { width, height, options, delay, apng, spool, spooled: 0, small, histogram, mp4, warnings })
    }

    /// Adds a frame, which must have the clip's size.
    pub fn push(&mut self, frame: &Picture) -> Result<()> {
        if (frame.width, frame.height) != (self.width, self.height) {
            let sizes = format!("{}x{} into {}x{}", frame.width, frame.height, self.width, self.height);
            return Err(invalid(&self.apng, "take a frame of another size", sizes));
        }
        let small = frame.downscale(self.options.apng_max_width);
        let rgb = small.rgb();
        self.histogram.add(&rgb);
        self.spool.file().write_all(&rgb).map_err(failed(&self.apng, "keep a frame for it"))?;
        self.small = (small.width, small.height);
        self.spooled += 1;
        if let Some(mp4) = &mut self.mp4 {
            mp4.push(frame);
        }
        Ok(())
    }

    /// Writes what was pushed, however many frames that is; none at all is an error.
    pub fn finish(mut self) -> Result<Written> {
        if self.spooled == 0 {
            return Err(invalid(&self.apng, "write it", "no frame was drawn".to_owned()));
        }
        write_atomic(&self.apng, |file| self.encode(file).map_err(io::Error::from))?;
        let mp4 =
            self.mp4.take().and_then(|mp4| mp4.finish().map_err(|warning| self.warnings.push(warning)).ok());
        Ok(Written { apng: self.apng, mp4, warnings: self.warnings })
    }

    fn encode(&self, to: &mut dyn Write) -> std::result::Result<(), png::EncodingError> {
        let (width, height) = self.small;
        let palette = Palette::new(&self.histogram);
        let mut encoder = png::Encoder::new(to, width, height);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_palette(palette.colours.concat());
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        // No filter: indices are not amounts, and every filter makes the file of a dithered clip larger.
        encoder.set_filter(png::Filter::NoFilter);
        encoder.set_animated(self.spooled, 0)?;
        encoder.set_frame_delay(self.delay.0, self.delay.1)?;
        let mut writer = encoder.write_header()?;
        let mut spool = BufReader::new(self.spool.file());
        spool.rewind()?;
        let mut rgb = vec![0; 3 * width as usize * height as usize];
        let mut nearest = palette.nearest();
        for _ in 0..self.spooled {
            spool.read_exact(&mut rgb)?;
            writer.write_image_data(&nearest(&rgb, width))?;
        }
        writer.finish()
    }
}

fn with_suffix(stem: &Path, suffix: &str) -> PathBuf {
    let mut name = stem.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

fn invalid(path: &Path, doing: &'static str, why: String) -> FileError {
    failed(path, doing)(io::Error::new(io::ErrorKind::InvalidInput, why))
}

/// `1 / fps` seconds as a fraction of 16-bit numbers: of the nearest ones, that with the smallest terms.
fn frame_delay(fps: f64) -> Option<(u16, u16)> {
    let fractions = (1..=u16::MAX).filter_map(|n| {
        let d = (f64::from(n) * fps).round();
        let error = (d / f64::from(n) / fps - 1.0).abs();
        // Within the rounding of `fps` they are equally exact.
        let error = if error < 1e-12 { 0.0 } else { error };
        (1.0..=f64::from(u16::MAX)).contains(&d).then_some((error, n, d as u16))
    });
    fractions.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, n, d)| (n, d))
}

/// An ffmpeg that is fed frames. It may be missing, fail or hang: the clip goes on without it.
struct Mp4 {
    file: Pending,
    log: Pending,
    path: PathBuf,
    child: Killed,
    frames: Option<SyncSender<Vec<u8>>>,
    trouble: Option<&'static str>,
}

impl Mp4 {
    /// `Ok(None)` when there is no such program.
    fn start(
        program: &Path,
        path: &Path,
        width: u32,
        height: u32,
        delay: (u16, u16),
    ) -> Result<Option<Self>> {
        let (file, log) = (Pending::new(path)?, Pending::new(path)?);
        let messages = log.file().try_clone().map_err(failed(path, "keep ffmpeg's messages"))?;
        let size = format!("{width}x{height}");
        let rate = format!("{}/{}", delay.1, delay.0);
        let raw =
            ["-f", "rawvideo", "-pix_fmt", "rgba", "-video_size", &size, "-framerate", &rate, "-i", "-"];
        // 4:2:0 needs even sizes, and players take untagged video for BT.709.
        let filters =
            "crop=trunc(iw/2)*2:trunc(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p";
        let tags = ["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709"];
        let spawned = Command::new(program)
            .args(["-hide_banner", "-loglevel", "error", "-y"])
            .args(raw)
            .args(["-vf", filters, "-c:v", "libx264", "-crf", "16"])
            .args(tags)
            .args(["-movflags", "+faststart", "-f", "mp4"])
            .arg(file.temporary())
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(messages)
            .spawn();
        let mut child = match spawned {
            Ok(child) => child,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(failed(path, "run ffmpeg")(e)),
        };
        let mut stdin = child.stdin.take().expect("stdin was asked to be a pipe");
        let (frames, queue) = sync_channel::<Vec<u8>>(2);
        // A write to a hung ffmpeg blocks for ever; here it blocks only this thread, until the child is
        // killed.
        std::thread::spawn(move || queue.iter().try_for_each(|frame| stdin.write_all(&frame)));
        let (path, child) = (path.to_owned(), Killed(child));
        Ok(Some(Self { file, log, path, child, frames: Some(frames), trouble: None }))
    }

    fn push(&mut self, frame: &Picture) {
        let Some(frames) = &self.frames else { return };
        let deadline = Instant::now() + PATIENCE;
        let mut frame = frame.rgba.clone();
        loop {
            match frames.try_send(frame) {
                Ok(()) => return,
                Err(TrySendError::Full(back)) if Instant::now() < deadline => frame = back,
                Err(_) => break,
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        self.trouble = Some("took no more frames");
        self.frames = None;
    }

    /// Where the mp4 is, or why there is none.
    fn finish(mut self) -> std::result::Result<PathBuf, String> {
        self.frames = None;
        let deadline = Instant::now() + PATIENCE;
        let failure = loop {
            match self.child.0.try_wait() {
                Ok(None) if Instant::now() < deadline => std::thread::sleep(Duration::from_millis(5)),
                Ok(None) => break Some("did not end".to_owned()),
                Ok(Some(status)) if !status.success() => break Some(format!("failed ({status})")),
                Ok(Some(_)) => break self.trouble.map(str::to_owned),
                Err(e) => break Some(format!("cannot be waited for ({e})")),
            }
        };
        match failure {
            None => self.file.commit().map(|()| self.path).map_err(|e| e.to_string()),
            Some(failure) => {
                let messages = first_bytes(self.log.file()).unwrap_or_default();
                Err(format!("{}: not written: ffmpeg {failure}: {}", self.path.display(), messages.trim()))
            }
        }
    }
}

fn first_bytes(mut file: &File) -> io::Result<String> {
    let mut bytes = Vec::new();
    file.rewind()?;
    file.take(2048).read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Ends the process when dropped, if it has not ended.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Bits of each channel that tell colours apart when the palette is made.
const BITS: u32 = 6;

/// The cell of a colour in a cube of 2^BITS cells a side.
fn cell([r, g, b]: [u8; 3]) -> usize {
    [r, g, b].iter().fold(0, |cell, &v| cell << BITS | usize::from(v >> (8 - BITS)))
}

/// How many pixels fell into each cell of the colour cube, and the sum of their colours.
struct Histogram(Vec<(u64, [u64; 3])>);

impl Histogram {
    fn new() -> Self {
        Self(vec![Default::default(); 1 << (3 * BITS)])
    }

    fn add(&mut self, rgb: &[u8]) {
        for p in rgb.chunks_exact(3) {
            let (count, sum) = &mut self.0[cell([p[0], p[1], p[2]])];
            *count += 1;
            (0..3).for_each(|c| sum[c] += u64::from(p[c]));
        }
    }
}

/// At most 256 colours.
struct Palette {
    colours: Vec<[u8; 3]>,
    /// Half the usual distance between neighbours, by channel: what dithering has to bridge.
    dither: f32,
}

impl Palette {
    /// Median cut by variance: the group of colours with the largest squared error is split at its mean.
    fn new(histogram: &Histogram) -> Self {
        type Weighted = (f64, [f64; 3]);
        struct Group {
            colours: Vec<Weighted>,
            mean: [f64; 3],
            axis: usize,
            error: f64,
        }
        let group = |colours: Vec<Weighted>| {
            let total: f64 = colours.iter().map(|c| c.0).sum();
            let mean = [0, 1, 2].map(|a| colours.iter().map(|(w, c)| w * c[a]).sum::<f64>() / total);
            let errors =
                [0, 1, 2].map(|a| colours.iter().map(|(w, c)| w * (c[a] - mean[a]).powi(2)).sum::<f64>());
            let axis = (0..3).max_by(|&a, &b| errors[a].total_cmp(&errors[b])).expect("there are three axes");
            let error = if colours.len() > 1 { errors[axis] } else { 0.0 };
            Group { colours, mean, axis, error }
        };
        let used = histogram.0.iter().filter(|(count, _)| *count > 0);
        let mut groups =
            vec![group(used.map(|(n, sum)| (*n as f64, sum.map(|s| s as f64 / *n as f64))).collect())];
        while groups.len() < 256 {
            let errors = groups.iter().map(|g| g.error).enumerate();
            let Some((worst, _)) = errors.filter(|e| e.1 > 0.0).max_by(|a, b| a.1.total_cmp(&b.1)) else {
                break;
            };
            let Group { colours, mean, axis, .. } = groups.swap_remove(worst);
            let (dark, light) = colours.into_iter().partition(|(_, c)| c[axis] < mean[axis]);
            groups.extend([group(dark), group(light)]);
        }
        let colours: Vec<[u8; 3]> = groups.iter().map(|g| g.mean.map(|v| v.round() as u8)).collect();
        let gap =
            |a: &[u8; 3]| colours.iter().filter(|b| *b != a).map(|b| distance(*a, *b)).min().unwrap_or(0);
        let gaps: f64 = colours.iter().map(|c| f64::from(gap(c)).sqrt()).sum();
        let dither = (gaps / colours.len() as f64 / 3f64.sqrt() / 2.0) as f32;
        Self { colours, dither }
    }

    /// Turns rows of RGB pixels into indices, with a fixed 4x4 pattern of dithering that does not crawl in
    /// time.
    fn nearest(&self) -> impl FnMut(&[u8], u32) -> Vec<u8> + '_ {
        const BAYER: [[f32; 4]; 4] =
            [[0.0, 8.0, 2.0, 10.0], [12.0, 4.0, 14.0, 6.0], [3.0, 11.0, 1.0, 9.0], [15.0, 7.0, 13.0, 5.0]];
        let offsets = BAYER.map(|row| row.map(|b| ((b - 7.5) / 7.5 * self.dither).round() as i16));
        let mut known: Vec<Option<u8>> = vec![None; 1 << (3 * BITS)];
        move |rgb, width| {
            let indices = rgb.chunks_exact(3).enumerate().map(|(i, p)| {
                let (x, y) = (i % width as usize, i / width as usize);
                let colour =
                    [p[0], p[1], p[2]].map(|v| (i16::from(v) + offsets[y % 4][x % 4]).clamp(0, 255) as u8);
                *known[cell(colour)].get_or_insert_with(|| {
                    let by_distance =
                        (0u8..=255).zip(&self.colours).min_by_key(|(_, c)| distance(**c, colour));
                    by_distance.expect("a palette has a colour").0
                })
            });
            indices.collect()
        }
    }
}

fn distance(a: [u8; 3], b: [u8; 3]) -> u32 {
    a.iter().zip(b).map(|(&a, b)| u32::from(a.abs_diff(b)).pow(2)).sum()
}
